"""Plan: the region that a lattice's nodes cover, cut into squares of its lines, and how the frame bounds it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask
from ..foundation.intervals import Interval
from ..geometry.lattice import Lattice
from ..geometry.numbering import Grid
from .contour import Contour
from .half_squares import CORNERS as CORNERS
from .half_squares import HalfSquares, half_squares

_STEPS = ((0, 1), (1, 0), (0, -1), (-1, 0))
"""Rows and columns from a point to its neighbours, counterclockwise from the one along x."""


class FrameQuarter(NamedTuple):
    """The quarter of a square that belongs to a frame point, or the half of it if the square is halved.

    Attributes
    ----------
    row, column : int
        Place of the square.
    corner : int
        Which of its `CORNERS` the frame point is.
    node : int or None
        At which corner of a square that is halved the node is. It then is a triangle, see `HalfSquares`: the first
        quarter of a chain, or the last.
    """

    row: int
    column: int
    corner: int
    node: int | None = None

    @property
    def halved(self) -> bool:
        """Whether it is a triangle."""
        return self.node is not None


class Chain(NamedTuple):
    """Quarters about a frame point that follow each other counterclockwise from one edge of the frame to another.

    The edges run along lines of the lattice, or along the diagonal of a square that is halved.

    Attributes
    ----------
    row, column : int
        Place of the frame point.
    first : int
        The direction, of ``east, north, west, south``, of the edge where it begins, or before a diagonal.
    quarters : tuple of FrameQuarter
    """

    row: int
    column: int
    first: int
    quarters: tuple[FrameQuarter, ...]


@dataclass(frozen=True, eq=False)
class Plan:
    """The squares between the lines of a lattice that have a node at a corner: the region of the membrane.

    Its frame consists of the edges that join two points which are no nodes. Of squares with one node those that are
    `halved` belong to it up to the diagonal that faces the node, which is a part of the frame; their fourth corner
    lies beyond. Arrays of points have the lattice's shape with a ring about it, (rows + 2, columns + 2), and those of
    squares one row and one column less.

    Attributes
    ----------
    lattice : Lattice

    Raises
    ------
    ValueError
        If a frame point stands alone among nodes: a point holds no membrane, whatever a lattice says.

    Examples
    --------
    >>> plan = Plan(Lattice.from_mask(np.ones((2, 3), dtype=bool), spacing=0.5))
    >>> plan.squares.shape, plan.sides
    ((3, 4), (2.0, 1.5))
    """

    lattice: Lattice

    @property
    def spacing(self) -> float:
        """Side h of a square (length)."""
        return self.lattice.spacing

    @property
    def on_lattice(self) -> bool:
        """Whether its frame consists of edges and diagonals of squares."""
        return True

    @cached_property
    def nodes(self) -> Mask:
        """Which points are nodes."""
        return np.pad(self.lattice.mask, 1)

    @cached_property
    def squares(self) -> Mask:
        """Which squares belong to the membrane."""
        return np.asarray(np.logical_or.reduce([self.at_corner(self.nodes, corner) for corner in range(4)]))

    @cached_property
    def halved(self) -> Mask:
        """Which of these squares slanted sides halve, so that the half at their node belongs to the membrane."""
        halved = self.lattice.halved
        return np.zeros_like(self.squares) if halved is None else halved

    @cached_property
    def whole(self) -> Mask:
        """Which squares belong to the membrane as a whole."""
        return self.squares & ~self.halved

    @cached_property
    def halves(self) -> tuple[HalfSquares, ...]:
        """The squares that are halved, by the corner at which their node is."""
        return half_squares(self.halved, self.nodes)

    def beyond(self, corner: int) -> Mask:
        """Return which squares are halved so that one of their corners lies beyond the frame."""
        return np.asarray(self.halved & self.at_corner(self.nodes, corner - 2))

    def having(self, corner: int) -> Mask:
        """Return which of the membrane's squares have one of their corners in it, or on its frame."""
        return self.squares & ~self.beyond(corner) if self.halves else self.squares

    @cached_property
    def points(self) -> Mask:
        """Which points are nodes, or on the frame: corners of the membrane's squares and halves of squares."""
        found = np.zeros_like(self.nodes)
        for corner in range(4):
            self.at_corner(found, corner)[...] |= self.having(corner)
        return found

    @cached_property
    def asked(self) -> Mask:
        """Which points functions are asked at: those, and the corners beyond the frame of squares that are halved."""
        found = np.zeros_like(self.nodes)
        for corner in range(4):
            self.at_corner(found, corner)[...] |= self.squares
        return found

    @cached_property
    def frame(self) -> Mask:
        """Which points lie on the frame."""
        return self.points & ~self.nodes

    @cached_property
    def sides(self) -> tuple[float, float]:
        """Width and height of the smallest rectangle that holds the membrane (length)."""
        rows, columns = (int(np.ptp(np.flatnonzero(self.squares.any(axis=axis)))) + 1 for axis in (1, 0))
        return columns * self.spacing, rows * self.spacing

    @cached_property
    def slanted_sides(self) -> tuple[float, float]:
        """Sides of the smallest rectangle along diagonals of squares that holds the membrane (length)."""
        row, column = np.nonzero(self.points)
        rising, falling = (int(np.ptp(places)) for places in (row + column, row - column))
        return rising * self.spacing * np.sqrt(0.5), falling * self.spacing * np.sqrt(0.5)

    @cached_property
    def frame_corners(self) -> NDArray[np.int64]:
        """How many corners of each of the membrane's squares, or of the half of one, lie on the frame."""
        on_frame = [self.at_corner(self.frame, corner) & self.having(corner) for corner in range(4)]
        return np.asarray(np.add.reduce([each.astype(np.int64) for each in on_frame]))

    @cached_property
    def frame_edges(self) -> NDArray[np.int64]:
        """How many edges of each whole square of the membrane belong to the frame: those between two points of it."""
        corners = [self.at_corner(self.frame, corner) for corner in range(4)]
        edges = np.add.reduce([(corners[k] & corners[k - 1]).astype(np.int64) for k in range(4)])
        return np.where(self.whole, edges, 0)

    def beside_halves(self, corner: int) -> Mask:
        """Return which squares meet one that is halved along a side that begins at one of their corners."""
        beside, (down, right), (rows, columns) = np.pad(self.halved, 1), CORNERS[corner], self.squares.shape
        below_or_above = beside[2 * down : 2 * down + rows, 1:-1]
        return np.asarray(below_or_above | beside[1:-1, 2 * right : 2 * right + columns])

    @staticmethod
    def at_corner(points: Any, corner: int) -> Any:
        """Return a view of what an array of points has at one of the corners of each square."""
        down, right = CORNERS[corner]
        rows, columns = points.shape[0] - 1, points.shape[1] - 1
        return points[down : down + rows, right : right + columns]

    def at_corners(self, points: Any) -> list[Any]:
        """Return what an array of points has at the corners of each square, of a half again that of its node."""
        found = [self.at_corner(points, corner) for corner in range(4)]
        if not self.halves:
            return found
        return [np.where(self.beyond(corner), found[corner - 2], found[corner]) for corner in range(4)]

    def quarters(self, corner: int, values: Grid) -> Grid:
        """Return what squares have in their quarters at a corner, zero where the frame leaves a triangle or nothing."""
        return np.where(self._quartered[corner], values, 0.0) if self.halves else values

    @cached_property
    def _quartered(self) -> tuple[Mask, ...]:
        return tuple(self.whole | (self.halved & self.at_corner(self.nodes, corner)) for corner in range(4))

    @cached_property
    def places(self) -> tuple[Grid, Grid]:
        """Return x and y of all points, shapes (1, columns + 2) and (rows + 2, 1), length."""
        rows, columns = self.nodes.shape
        x, y = self.lattice.ring_coordinates(np.arange(rows), np.arange(columns))
        return x[None, :], y[:, None]

    @cached_property
    def around_points(self) -> tuple[Interval, Interval]:
        """What holds x and y of each point, however they are rounded."""
        x, y = (Interval.around(each, 4 * np.spacing(np.abs(each).max())) for each in self.places)
        return x, y

    @cached_property
    def around_squares(self) -> tuple[Interval, Interval]:
        """What holds x and y in each square, shapes (1, columns + 1) and (rows + 1, 1), length."""
        x, y = self.around_points
        columns, rows = (np.flatnonzero(self.asked.any(axis=axis)) for axis in (0, 1))
        first, last = (columns[0], rows[0]), (columns[-1], rows[-1])

        def within(ends: Interval, axis: int) -> Interval:
            # A function need not be defined in squares that are no part of the membrane.
            least, most = ends.lower.ravel()[first[axis]], ends.upper.ravel()[last[axis]]
            return Interval(np.clip(ends.lower, least, most), np.clip(ends.upper, least, most))

        along_x = within(x, 0)
        along_y = within(y, 1)
        return Interval(along_x.lower[:, :-1], along_x.upper[:, 1:]), Interval(along_y.lower[:-1], along_y.upper[1:])

    @cached_property
    def chains(self) -> tuple[Chain, ...]:
        """How the quarters of squares that belong to frame points follow each other about them."""
        return tuple(
            chain for row, column in np.argwhere(self.frame) for chain in self._chains_at(int(row), int(column))
        )

    def _chains_at(self, row: int, column: int) -> Iterator[Chain]:
        rows, columns = self.nodes.shape

        def open_towards(direction: int) -> bool:
            down, right = _STEPS[direction % 4]
            i, j = row + down, column + right
            return 0 <= i < rows and 0 <= j < columns and bool(self.nodes[i, j])

        walls = [direction for direction in range(4) if not open_towards(direction)]
        if not walls:
            x, y = self.lattice.ring_coordinates(np.array([row]), np.array([column]))
            raise ValueError(
                f"the frame point at x={x[0]:g}, y={y[0]:g} stands alone among nodes: a membrane, unlike its lattice, "
                "is not held by a point; give a frame of several points that follow each other along the lattice"
            )
        for first in walls:
            quarters = []
            direction = first
            while True:
                square = self._square_after(row, column, direction % 4)
                if square is None:
                    break
                quarters.append(square)
                direction += 1
                if not open_towards(direction):
                    break
            if quarters:
                yield Chain(row, column, first, tuple(quarters))

    def _square_after(self, row: int, column: int, direction: int) -> FrameQuarter | None:
        """Return the quarter that follows a direction counterclockwise, None where there is no membrane."""
        corner = direction  # the square east-north of a point has it at its first corner, and so on
        down, right = CORNERS[corner]
        i, j = row - down, column - right
        if not (0 <= i < self.squares.shape[0] and 0 <= j < self.squares.shape[1] and self._having[corner][i, j]):
            return None
        found = FrameQuarter(i, j, corner)
        if not self.halved[i, j]:
            return found
        ahead, behind = (corner + 1) % 4, (corner - 1) % 4
        return found._replace(node=ahead if self.at_corner(self.nodes, ahead)[i, j] else behind)

    @cached_property
    def _having(self) -> tuple[Mask, ...]:
        return tuple(self.having(corner) for corner in range(4))


@dataclass(frozen=True, eq=False)
class ContourPlan(Plan):
    """The squares that a region has a part of, whose contour a lattice is fitted to."""

    @property
    def on_lattice(self) -> bool:
        """Whether its frame consists of edges and diagonals of squares: it may cut them anywhere."""
        return False

    @cached_property
    def contour(self) -> Contour:
        """The contour on the lattice."""
        outline = self.lattice.outline
        assert outline is not None
        return Contour.of(self.lattice, outline)

    @cached_property
    def squares(self) -> Mask:
        """Which squares the region has a part of."""
        return self.contour.inside
