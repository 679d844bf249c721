"""Bisection of the load factors between which each node comes into contact."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..foundation.checks import Vector
from ..foundation.progress import Progress
from ..models.base import ContactModel
from ..models.varied import with_load
from ..solving.solution import Solution
from ..solving.solve import solve
from .touchdown import Touchdown

_MOST_SOLVES = 10_000

_PARTS = (0.5, 0.375, 0.625)
"""Where a bracket is divided; the later ones if a node that settles just at the earlier ones is undecided there."""


def touchdown_of(model: ContactModel, values: Vector, solutions: Sequence[Solution], width: float | None) -> Touchdown:
    """Return the touchdown loads of a monotone path of loads, see `LoadPath.touchdown`."""
    found = _Brackets(model)
    starts: dict[float, Vector] = {}
    for k in np.argsort(values):
        found.add(float(values[k]), solutions[k])
        if solutions[k].finite:
            starts[float(values[k])] = solutions[k].gap
    if width is not None:
        _bisect(model, values, solutions[0], found, starts, width)
    return Touchdown(model, found.clear, found.contact, np.array(sorted(starts)))


class _Brackets:
    def __init__(self, model: ContactModel) -> None:
        self.supported = model.supported
        self.clear, self.contact = np.full(model.size, -np.inf), np.full(model.size, np.inf)

    def add(self, load: float, solution: Solution) -> None:
        """Take note of what a certificate proves at a load."""
        certificate = solution.certificate
        if certificate is None:
            return
        clear = certificate.clear & self.supported
        self.clear[clear] = np.maximum(self.clear[clear], load)
        self.contact[certificate.contact] = np.minimum(self.contact[certificate.contact], load)

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
    values: Vector,
    example: Solution,
    found: _Brackets,
    starts: dict[float, Vector],
    width: float,
) -> None:
    """Solve for loads in the middle of the widest bracket until all are narrow enough.

    Loads at which a node is undecided, because gap and reaction are zero to rounding, halve nothing; then the bracket
    is left as it is.
    """
    backend, tol = example.backend, example.tol
    given_up: set[tuple[float, float]] = set()
    solved = {float(load) for load in values}
    with Progress(f"touchdown · {model.size} nodes") as progress:
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
            start = starts[min(starts, key=lambda load: abs(load - middle))] if starts else None
            solution = solve(with_load(model, middle), backend, tol=tol, warm_start=start, on_failure="ignore")
            found.add(middle, solution)
            solved.add(middle)
            if solution.finite:
                starts[middle] = solution.gap
