"""ObstacleProblem: the gap of a membrane between lattice points as well, its data enclosed on every cell."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..foundation.checks import Vector
from ..foundation.rounding import UNDERFLOW, UNIT_ROUNDOFF
from ..geometry.numbering import Grid
from .cells import Cells, at_corners, extreme_at_corners
from .ghosts import Continuation
from .splines import CellRanges, at_points, excess_along_rim, ranges_on_cells
from .windows import Window, windows_of


@dataclass(frozen=True, eq=False)
class ObstacleProblem:
    r"""The gap u ≥ 0 of a membrane of constant tension over a support of one side: -TΔu + q = ρ ≥ 0, uρ = 0.

    With the deflection w = F - u over the support F it is q = p + TΔF, and on the frame u = γ = F - g. The load is
    known between lattice points, too, as a field that is bilinear on each cell, give or take a range; γ likewise on
    each edge of the rim.

    Where the Laplacian of a support f is not known, F is a spline that is near to it, its *floor*: then the bilinear
    field is p alone, and splines are compared with it by their differences, see `ranges`. u = F - w is then bounded
    from below not by zero but by F - f, which each cell knows a range of.

    Parameters
    ----------
    cells : Cells
    tension : float
        T (force per length), > 0.
    load : array, shape (rows + 2, columns + 2)
        q, or with a floor p, at the points (force per area); finite at the corners of the cells.
    heights : array, shape (rows + 2, columns + 2)
        γ ≥ 0 at the points of the rim (length).
    load_range : pair of arrays, shape (rows + 1, columns + 1), or of numbers
        Least and largest of q, or p, less the bilinear interpolant of ``load`` in each cell.
    height_range : pair of numbers
        Least and largest of γ less its linear interpolant on each edge of the rim (length).
    floor : array, shape (rows + 4, columns + 4), optional
        Coefficients of F (length).
    rest : pair of arrays, shape (rows + 1, columns + 1), or of numbers
        Least and largest of f - F in each cell (length); zero without a floor.
    drive : array, shape (rows + 2, columns + 2), optional
        About q at the points, if that is not ``load``; nothing that is proven depends on it.
    kinks : array, shape (rows + 2, columns + 2), optional
        At points of cells in which a support has a kink, the coefficient of F less f; else zero. Nor on this.
    """

    cells: Cells
    tension: float
    load: Grid
    heights: Grid
    load_range: tuple[Grid | float, Grid | float] = (0.0, 0.0)
    height_range: tuple[float, float] = (0.0, 0.0)
    floor: Grid | None = None
    rest: tuple[Grid | float, Grid | float] = (0.0, 0.0)
    drive: Grid | None = None
    kinks: Grid | None = None
    continuation: Continuation = field(init=False)

    def __post_init__(self) -> None:
        shape = self.cells.nodes.shape
        for name in ("load", "heights"):
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} must have the shape {shape} of the points, got {getattr(self, name).shape}")
        object.__setattr__(self, "continuation", Continuation(self.cells))

    @cached_property
    def windows(self) -> tuple[Window, ...]:
        """The windows about corners that point inwards, in which coefficients are chosen by linear programs."""
        return windows_of(self.cells)

    @property
    def wanted(self) -> Grid:
        """About q at the points (force per area)."""
        return self.load if self.drive is None else self.drive

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
        """The largest modulus of `bend` under the load, away from kinks (length)."""
        even = self.cells.closure
        if self.kinks is not None:
            even = even & ~at_corners(extreme_at_corners(self.kinks != 0.0, np.logical_or))
        return float(np.abs(self.bend(self.wanted)).max(where=even, initial=0.0))

    @property
    def largest_kink(self) -> float:
        """How far a support's kinks stand out of the floor at most, about (length)."""
        return 0.0 if self.kinks is None else float(np.abs(self.kinks).max())

    def with_rim(self, gap: Grid) -> Grid:
        """Return a gap at the points with the frame's in the place of what it has on the rim."""
        return np.where(self.cells.nodes, gap, self.heights)

    def ranges(self, coefficients: Grid) -> CellRanges:
        """Return ranges on the cells, of TΔs - q but for `load_range`, and of s.

        With a floor, s is not the spline of the coefficients c, but F plus the spline of the rounded differences d of c
        and the floor's; TΔs - q is TΔ of the latter less p. As F + d is c but for a unit roundoff of |d|, s differs
        from the spline of c by no more than that of the largest: see `slip`.
        """
        if self.floor is None:
            return ranges_on_cells(self.cells, coefficients, self.tension, self.load)
        bent = ranges_on_cells(self.cells, coefficients - self.floor, self.tension, self.load)
        values, slip = ranges_on_cells(self.cells, coefficients, self.tension, self.load), self.slip(coefficients)
        return CellRanges(bent.least_excess, bent.most_excess, values.least - slip, values.most + slip)

    def slip(self, coefficients: Grid) -> float:
        """Return how far s is from the spline of its coefficients at most (length); see `ranges`."""
        if self.floor is None:
            return 0.0
        return 2 * UNIT_ROUNDOFF * float(np.abs(coefficients).max() + np.abs(self.floor).max())

    def excess_along_rim(self, coefficients: Grid) -> tuple[Vector, Vector]:
        """Return the least and the largest of s - γ on the edges of the rim, but for `height_range`."""
        least, most = excess_along_rim(self.cells, coefficients, self.heights)
        slip = self.slip(coefficients)
        return least - slip, most + slip

    def at_points(self, coefficients: Grid) -> tuple[Grid, float]:
        """Return s at the points, and how far off it may be."""
        values, error = at_points(coefficients)
        return values, error + self.slip(coefficients)
