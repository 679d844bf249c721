"""Brackets of the load factors at which each node comes into contact, as narrow as is wanted.

The solution is followed exactly from event to event, where that is practical, and certified at load factors between
them; what is left too wide, or everything where it is not, is bisected by solving.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..foundation.checks import Vector
from ..foundation.progress import Progress
from ..models.base import ContactModel
from ..models.varied import with_load
from ..proof.certificate import Certificate
from ..proof.measure import measure
from ..solving.solution import Solution
from ..solving.solver import Solver
from .follower import Follower
from .touchdown import Touchdown

_MOST_SOLVES = 10_000

_WORTH_FOLLOWING = 10_000
"""Nodes up to which following the solution exactly is practical."""

_CLOSE = 1 - 1e-6
"""A bracket is made narrower than is wanted by this factor, so that rounding does not make it wider."""

_AWAY = 1e-3
"""Part of a linear piece that is kept away from its ends, where gaps and reactions vanish."""

_PARTS = (0.5, 0.375, 0.625)
"""Where a bracket is divided; the later ones if a node that settles just at the earlier ones is undecided there."""


def touchdown_of(model: ContactModel, values: Vector, solutions: Sequence[Solution], width: float | None) -> Touchdown:
    """Return the touchdown loads of a monotone path of loads, see `LoadPath.touchdown`."""
    found = _Brackets(model)
    starts: dict[float, Vector] = {}
    for k in np.argsort(values):
        found.add(float(values[k]), solutions[k].certificate)
        if solutions[k].finite:
            starts[float(values[k])] = solutions[k].gap
    if width is not None:
        with Progress(f"touchdown · {model.size} nodes") as progress:
            if model.size <= _WORTH_FOLLOWING and model.problem.is_z_matrix and model.problem.one_sided:
                _follow(model, found, starts, width, progress)
            _bisect(model, solutions[0], found, starts, width, progress)
    return Touchdown(model, found.clear, found.contact, np.array(sorted(starts)))


def _follow(
    model: ContactModel, found: _Brackets, starts: dict[float, Vector], width: float, progress: Progress
) -> None:
    """Certify the exact solution at load factors that bracket every event within ``width``.

    Between two events the solution is linear in the load, so that its gap at any load factor costs no solve. Where
    rounding errors hide an event, nothing more is followed.
    """
    last, stop = min(starts, default=np.inf), max(starts, default=-np.inf)
    if not last < stop:
        return
    follower = Follower.of(model, last, stop)
    piece, pending = last, False

    def look(load: float) -> None:
        gap = follower.gap(load)
        certificate = measure(with_load(model, load).problem, gap).certificate()
        found.add(load, certificate)
        starts[load] = gap
        progress.update(f"{len(starts)} loads, load factor {load:.4g}")

    try:
        while True:
            event, nodes = follower.next_event()
            end = min(event, stop)
            if pending and end > last + width:
                last = _inside(piece, last + _CLOSE * width, end)
                look(last)
                pending = False
            if not event <= stop:
                return
            if event > last + width:
                last = _inside(piece, event - 0.5 * width, event)
                look(last)
            follower.pass_event(event, nodes)
            piece, pending = event, True
    except RuntimeError:
        return


def _inside(start: float, wanted: float, end: float) -> float:
    """Return a load factor near a wanted one, away from the events that begin and end a linear piece."""
    return wanted if start + _AWAY * (end - start) < wanted < end - _AWAY * (end - start) else 0.5 * (start + end)


class _Brackets:
    def __init__(self, model: ContactModel) -> None:
        self.supported = model.supported
        self.clear, self.contact = np.full(model.size, -np.inf), np.full(model.size, np.inf)

    def add(self, load: float, certificate: Certificate | None) -> None:
        """Take note of what a certificate proves at a load."""
        if certificate is None:
            return
        clear = (certificate.clear | certificate.contact_upper) & self.supported
        self.clear[clear] = np.maximum(self.clear[clear], load)
        contact = certificate.contact_lower
        self.contact[contact] = np.minimum(self.contact[contact], load)

    def widest(self, limit: float, given_up: set[tuple[float, float]]) -> tuple[float, float] | None:
        """Return the widest closed bracket that is wider than a limit and not given up."""
        closed = np.isfinite(self.clear) & np.isfinite(self.contact)
        width = np.where(closed, self.contact - self.clear, 0.0)
        for node in np.argsort(-width, kind="stable").tolist():
            if width[node] <= limit:
                return None
            bracket = float(self.clear[node]), float(self.contact[node])
            if bracket not in given_up:
                return bracket
        return None


def _bisect(
    model: ContactModel,
    example: Solution,
    found: _Brackets,
    starts: dict[float, Vector],
    width: float,
    progress: Progress,
) -> None:
    """Solve for loads in the middle of the widest bracket until all are narrow enough.

    Loads at which a node is undecided, because gap and reaction are zero to rounding, halve nothing; then the bracket
    is left as it is.
    """
    session = Solver(model, example.backend, tol=example.tol)
    given_up: set[tuple[float, float]] = set()
    solved = set(starts)
    for _ in range(_MOST_SOLVES):
        bracket = found.widest(width, given_up)
        if bracket is None:
            return
        low, high = bracket
        divisions = [low + part * (high - low) for part in _PARTS]
        middle = next((load for load in divisions if low < load < high and load not in solved), None)
        if middle is None:
            given_up.add(bracket)
            continue
        progress.update(f"{len(starts)} loads, widest bracket {high - low:.2g}")
        start = starts[min(starts, key=lambda load: abs(load - middle))] if starts else False
        solution = session.solve_varied(with_load(model, middle), start)
        found.add(middle, solution.certificate)
        solved.add(middle)
        if solution.finite:
            starts[middle] = solution.gap
