"""Touchdown: the loads between which each node certainly comes into contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ._checks import Vector, positive_number
from .model import ContactModel
from .progress import Progress
from .solution import Solution
from .solve import solve
from .variation import with_load

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from .path import LoadPath

_MOST_SOLVES = 10_000

_PARTS = (0.5, 0.375, 0.625)
"""Where a bracket is divided; the later ones if a node that settles just at the earlier ones is undecided there."""


@dataclass(frozen=True, eq=False)
class Touchdown:
    """Brackets of the load factor at which each node settles, for a load under which nodes only settle.

    Attributes
    ----------
    model : Membrane, Cable or CableNet
        Its load is multiplied by the factors below.
    clear, contact : array, shape (n,)
        Largest load factor at which the node is certainly clear, -inf if there is none, and least one at which it
        is certainly in contact, inf if there is none: it touches down between the two.
    loads : array
        The load factors that were solved for, ascending.
    """

    model: ContactModel
    clear: Vector
    contact: Vector
    loads: Vector

    @property
    def width(self) -> float:
        """Largest width of the brackets that are closed on both sides; 0 if there is none."""
        closed = np.isfinite(self.clear) & np.isfinite(self.contact)
        return float((self.contact - self.clear)[closed].max(initial=0.0))

    @property
    def load(self) -> Vector:
        """Middle of each closed bracket, shape (n,); nan where the node settles outside the loads solved for."""
        with np.errstate(invalid="ignore"):
            middle = 0.5 * (self.clear + self.contact)
        return np.where(np.isfinite(middle), middle, np.nan)

    def to_dataset(self) -> xr.Dataset:
        """Return clear, contact and load as an xarray.Dataset with dims y and x (a cable: x, a net of cables: node)."""
        import xarray as xr

        from .datasets import placed, places

        model = self.model
        variables = {name: placed(model, getattr(self, name)) for name in ("clear", "contact", "load")}
        return xr.Dataset(variables, places(model))

    def plot(self) -> Figure:
        """Draw at which load each node settles."""
        from .plotting_path import plot_touchdown

        return plot_touchdown(self)

    def __repr__(self) -> str:
        closed = int(np.count_nonzero(np.isfinite(self.load)))
        return (
            f"Touchdown({self.model!r}, {self.loads.size} load factors from {self.loads[0]:g} to {self.loads[-1]:g}: "
            f"{closed} nodes settle between them, known to {self.width:.2g})"
        )


def touchdown_of(path: LoadPath, width: float | None) -> Touchdown:
    """Return the touchdown loads of a path, see `LoadPath.touchdown`."""
    if path.parameter != "load":
        raise ValueError(f"touchdown loads need a path of loads, this one's parameter is the {path.parameter}")
    if not path.promised:
        raise ValueError("touchdown loads need a load that nowhere pulls upwards: else nodes may lift off again")
    if path.findings:
        raise ValueError(f"touchdown loads need a monotone path, but {path.findings[0]}")
    order = np.argsort(path.values)
    found = _Brackets(path.model)
    starts: dict[float, Vector] = {}
    for k in order:
        found.add(float(path.values[k]), path.solutions[k])
        if path.solutions[k].residuals is not None:
            starts[float(path.values[k])] = path.solutions[k].gap
    if width is not None:
        _bisect(path, found, starts, positive_number(width, "width"))
    return Touchdown(path.model, found.clear, found.contact, np.array(sorted(starts)))


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


def _bisect(path: LoadPath, found: _Brackets, starts: dict[float, Vector], width: float) -> None:
    """Solve for loads in the middle of the widest bracket until all are narrow enough.

    Loads at which a node is undecided, because gap and reaction are zero to rounding, halve nothing; then the bracket
    is left as it is.
    """
    backend, tol = path.solutions[0].backend, path.solutions[0].tol
    given_up: set[tuple[float, float]] = set()
    solved = {float(load) for load in path.values}
    with Progress(f"touchdown · {path.model.size} nodes") as progress:
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
            solution = solve(with_load(path.model, middle), backend, tol=tol, warm_start=start, on_failure="ignore")
            found.add(middle, solution)
            solved.add(middle)
            if solution.residuals is not None:
                starts[middle] = solution.gap
