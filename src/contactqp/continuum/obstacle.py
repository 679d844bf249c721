"""ObstacleProblem: the gap of a membrane between lattice points as well, its data enclosed on every cell."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar, TypeAlias

import numpy as np

from ..foundation.checks import Vector
from ..foundation.rounding import UNDERFLOW, UNIT_ROUNDOFF
from ..geometry.numbering import Grid
from .cells import Cells, at_corners, extreme_at_corners
from .ghosts import Continuation
from .splines import CellRanges, at_points, excess_along_rim, ranges_on_cells
from .windows import Window, windows_of

Resolve: TypeAlias = Callable[[Grid], Grid]
"""Returns the lattice's gap after its load changes at the points; both arrays have shape (rows + 2, columns + 2)."""

Range: TypeAlias = tuple[Grid | float, Grid | float]
"""The least and the largest of a field in each cell, or everywhere."""


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
    load_range: Range = (0.0, 0.0)
    height_range: tuple[float, float] = (0.0, 0.0)
    floor: Grid | None = None
    rest: Range = (0.0, 0.0)
    drive: Grid | None = None
    kinks: Grid | None = None
    continuation: Continuation = field(init=False)

    patience: ClassVar[int] = 9
    """Rounds of sharpening that are made in any case where corners point inwards or sides are slanted."""

    near: ClassVar[float] = 3.0
    """Where a gap is larger, in units of what a membrane bends on a cell, a lower bound is always mended."""

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

    @property
    def highest(self) -> float | None:
        """About the largest γ (length); None where no spline is the same everywhere."""
        return float(self.heights.max()) + self.height_range[1]

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

    def upper_coefficients(self, values: Grid, bend: Grid) -> Grid:
        """Return coefficients of a spline that lies above a membrane's values at the points of the closed region.

        Parameters
        ----------
        values, bend : array, shape (rows + 2, columns + 2)
            The latter are the wanted sums of second differences (length).
        """
        return self.continuation(values, bend, "less")

    def lower_coefficients(self, values: Grid, bend: Grid) -> Grid:
        """Return coefficients of a spline that goes through such values nearly, and keeps below them at corners."""
        wide = self.continuation(self._eased(values, bend), bend, "more")
        inner = wide[1:-1, 1:-1]
        around = (wide[:-2, 1:-1] + wide[2:, 1:-1]) + (wide[1:-1, :-2] + wide[1:-1, 2:])
        return self.continuation(self._eased(inner - (around - 4.0 * inner) / 6.0, bend), bend, "more")

    def _eased(self, values: Grid, bend: Grid) -> Grid:
        """Return values, lowered at corners that point inwards to where a membrane were in balance there.

        Of a corner with a neighbour beyond the frame this says nothing, and where there are windows it is left to them.
        """
        row, column = self.cells.inward_corners
        if self.windows or not row.size:
            return values
        neighbours = (row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1)
        around = sum(values[place] for place in neighbours)
        known = np.logical_and.reduce([self.cells.closure[place] for place in neighbours])
        eased = values.copy()
        lowered = np.minimum(values[row, column], (around - bend[row, column]) / 4.0)
        eased[row, column] = np.where(known, lowered, values[row, column])
        return eased

    def moved_at_rim(self, wanted: Vector) -> Grid:
        """Return changes of coefficients by which a spline moves so far, about, along each edge of the rim."""
        moved = np.zeros(tuple(np.array(self.cells.nodes.shape) + 2))
        first = 0
        for edges in self.cells.rim:
            for row, column in edges.ends:
                np.maximum.at(moved, (row + 1, column + 1), wanted[first : first + edges.row.size])
            first += edges.row.size
        return moved

    def depth_spline(self, coefficients: Grid) -> tuple[Grid, Grid | float]:
        """Return coefficients of a spline near what these stand for, and how far in each cell that may be from it."""
        return coefficients, 0.0

    def settled(self, gap: Grid, resolve: Resolve) -> tuple[ObstacleProblem, Grid, Resolve] | None:
        """Return a problem, the lattice's gap, and how the lattice is solved again, that fit to the frame.

        None if they do not come to fit.

        Parameters
        ----------
        gap : array, shape (rows + 2, columns + 2)
        resolve : Resolve
        """
        return self, self.with_rim(gap), resolve

    def least_in_region(self, coefficients: Grid, ranges: CellRanges, missing: float) -> Grid:
        """Return no more than the least of a spline in the part of each cell that belongs to the region.

        Parameters
        ----------
        coefficients : array, shape (rows + 4, columns + 4)
        ranges : CellRanges
            Of that spline.
        missing : float
            How far it lies below γ along the rim at most (length).
        """
        return ranges.least

    def at_points(self, coefficients: Grid) -> tuple[Grid, float | Grid]:
        """Return s at the points, and how far off it may be."""
        values, error = at_points(coefficients)
        return values, error + self.slip(coefficients)
