"""ObstacleProblem: the gap of a membrane between lattice points as well, its data enclosed on every cell."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..foundation.rounding import UNDERFLOW, UNIT_ROUNDOFF
from ..geometry.numbering import Grid
from .cells import Cells
from .ghosts import Continuation


@dataclass(frozen=True, eq=False)
class ObstacleProblem:
    r"""The gap u ≥ 0 of a membrane of constant tension over a support of one side: -TΔu + q = ρ ≥ 0, uρ = 0.

    With the deflection w = f - u over the support f it is q = p + TΔf, and on the frame u = γ = f - g. The load is
    known between lattice points, too, as a field that is bilinear on each cell, give or take a range; γ likewise on
    each edge of the rim.

    Parameters
    ----------
    cells : Cells
    tension : float
        T (force per length), > 0.
    load : array, shape (rows + 2, columns + 2)
        q at the points (force per area), finite at the corners of the cells.
    load_range : pair of arrays, shape (rows + 1, columns + 1), or of numbers
        Least and largest of q less the bilinear interpolant of ``load`` in each cell.
    heights : array, shape (rows + 2, columns + 2)
        γ ≥ 0 at the points of the rim (length).
    height_range : pair of numbers
        Least and largest of γ less its linear interpolant on each edge of the rim (length).
    """

    cells: Cells
    tension: float
    load: Grid
    heights: Grid
    load_range: tuple[Grid | float, Grid | float] = (0.0, 0.0)
    height_range: tuple[float, float] = (0.0, 0.0)
    continuation: Continuation = field(init=False)

    def __post_init__(self) -> None:
        shape = self.cells.nodes.shape
        for name in ("load", "heights"):
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} must have the shape {shape} of the points, got {getattr(self, name).shape}")
        object.__setattr__(self, "continuation", Continuation(self.cells))

    @property
    def largest_height(self) -> float:
        """d²/8T, rounded up: how far a strip of width d about the region bends under a load of one (length³/force)."""
        width = self.cells.strip[2] * self.cells.spacing
        return width**2 / (8.0 * self.tension) * (1 + 8 * UNIT_ROUNDOFF) + UNDERFLOW

    def bend(self, load: Grid) -> Grid:
        """Return the sum of the second differences of a free membrane under a load at the points (length)."""
        return np.asarray(load * (self.cells.spacing**2 / self.tension))

    @cached_property
    def largest_bend(self) -> float:
        """The largest modulus of `bend` under the load (length)."""
        return float(np.abs(self.bend(self.load)).max(where=self.cells.closure, initial=0.0))

    def with_rim(self, gap: Grid) -> Grid:
        """Return a gap at the points with the frame's in the place of what it has on the rim."""
        return np.where(self.cells.nodes, gap, self.heights)
