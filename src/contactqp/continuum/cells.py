"""Cells: the region that a frame along lines and diagonals of a lattice bounds, as squares between its points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask
from ..foundation.loading import load_modules
from ..geometry.numbering import Grid

Places: TypeAlias = tuple[NDArray[np.intp], ...]


class Edges(NamedTuple):
    """Edges of a rim that all run the same way, along sides of cells or along a diagonal of theirs.

    Attributes
    ----------
    row, column : array
        The point where each begins.
    step : (int, int)
        Rows and columns from there to its end: (0, 1), (1, 0), (1, 1) or (1, -1).
    """

    row: NDArray[np.intp]
    column: NDArray[np.intp]
    step: tuple[int, int]

    @classmethod
    def where(cls, begins: Mask, step: tuple[int, int]) -> Edges:
        """Return the edges that begin at some points."""
        row, column = np.nonzero(begins)
        return cls(row, column, step)

    @property
    def ends(self) -> tuple[Places, Places]:
        """Rows and columns of the points where each begins and where it ends."""
        return (self.row, self.column), (self.row + self.step[0], self.column + self.step[1])


@dataclass(frozen=True, eq=False)
class Cells:
    """The squares between lattice points that a frame along lattice lines and diagonals encloses, or halves.

    Arrays of points have the lattice's shape with a ring of frame points about it, (rows + 2, columns + 2); those of
    cells lie between the points, (rows + 1, columns + 1): cell [i, j] has the corners [i, j] to [i + 1, j + 1].

    Parameters
    ----------
    mask : array of bool, shape (rows, columns)
        The nodes: lattice points within the frame.
    spacing : float
        Side h of a cell (length).
    halved : array of bool, shape (rows + 1, columns + 1), optional
        Cells that the frame halves along a diagonal, so that the half at their only node belongs to the region.

    Raises
    ------
    ValueError
        If the frame is more than the rim of the cells about the nodes: a pin, a slit, or a passage without nodes.
        If a halved cell has not one node.

    Examples
    --------
    >>> cells = Cells(np.ones((2, 3), dtype=bool), 0.25)
    >>> cells.inside.shape, int(cells.inside.sum()), cells.convex
    ((3, 4), 12, True)
    >>> Cells(np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]], dtype=bool), 0.25)
    Traceback (most recent call last):
    ...
    ValueError: the frame must bound a region along lattice lines, but has a pin, a slit or a passage without nodes ...
    """

    mask: Mask
    spacing: float
    halved: Mask | None = None

    def __post_init__(self) -> None:
        if not (self._count(self.nodes)[self.cut] == 1).all():
            raise ValueError("a frame halves cells that have one node each, but some have none or several")
        within = _about_points(self.whole)
        buried = within & ~self.nodes
        level, upright = _beside_edges(self.whole)
        passages = (level[0] & level[1] & ~self.nodes[:, :-1] & ~self.nodes[:, 1:]).any() or (
            upright[0] & upright[1] & ~self.nodes[:-1] & ~self.nodes[1:]
        ).any()
        if buried.any() or passages:
            at = np.argwhere(buried)
            where = f" at row {at[0, 0] - 1}, column {at[0, 1] - 1} of the lattice" if len(at) else ""
            raise ValueError(
                "the frame must bound a region along lattice lines, but has a pin, a slit or a passage without "
                f"nodes{where}; take a finer lattice"
            )

    @cached_property
    def nodes(self) -> Mask:
        """Where the nodes are among the points."""
        return np.pad(self.mask, 1)

    @cached_property
    def inside(self) -> Mask:
        """The cells of the region, halved ones among them: those with a node at a corner."""
        return self._count(self.nodes) > 0

    @cached_property
    def cut(self) -> Mask:
        """The cells that the frame halves."""
        shape = self.mask.shape[0] + 1, self.mask.shape[1] + 1
        return np.zeros(shape, dtype=np.bool_) if self.halved is None else self.halved

    @cached_property
    def whole(self) -> Mask:
        """The cells that belong to the region as a whole."""
        return self.inside & ~self.cut

    @cached_property
    def shares(self) -> Grid:
        """Which part of each cell belongs to the region: 0, 1/2 or 1."""
        return np.where(self.cut, 0.5, np.where(self.inside, 1.0, 0.0))

    @cached_property
    def corners(self) -> Mask:
        """The points at corners of the cells: those of the closed region, and those of halved cells beyond it."""
        return at_corners(self.inside)

    @property
    def closure(self) -> Mask:
        """The points at which the membrane is wanted: those of the closed region."""
        return self.points

    @cached_property
    def points(self) -> Mask:
        """The points of the closed region: nodes and points of the rim."""
        found = at_corners(self.whole) | self.nodes
        for edges in self.slanted:
            for end in edges.ends:
                found[end] = True
        return found

    @cached_property
    def rim(self) -> tuple[Edges, ...]:
        """The edges of the rim: along rows, along columns, and along either diagonal."""
        level, upright = _beside_edges(self.whole)
        open_ends = ~self.nodes  # two that bound a halved cell's half have its node at an end
        level_rim = (level[0] ^ level[1]) & open_ends[:, :-1] & open_ends[:, 1:]
        upright_rim = (upright[0] ^ upright[1]) & open_ends[:-1] & open_ends[1:]
        return Edges.where(level_rim, (0, 1)), Edges.where(upright_rim, (1, 0)), *self.slanted

    @cached_property
    def slanted(self) -> tuple[Edges, Edges]:
        """The edges of the rim along diagonals of halved cells."""
        nodes = self.nodes
        rising = self.cut & (nodes[:-1, 1:] | nodes[1:, :-1])
        rows, columns = np.nonzero(self.cut & ~rising)
        return Edges.where(rising, (1, 1)), Edges(rows, columns + 1, (1, -1))

    @cached_property
    def _angle(self) -> NDArray[np.int64]:
        """Angle of the region at each point of its rim, in units of 45°; zero elsewhere."""
        padded = np.pad(2 * self.whole.astype(np.int64), 1)
        count = padded[:-1, :-1] + padded[1:, :-1] + padded[:-1, 1:] + padded[1:, 1:]
        for edges in self.slanted:
            for end in edges.ends:
                np.add.at(count, end, 1)
        return np.where(self.closure & ~self.nodes, count, 0)

    @cached_property
    def inward_corners(self) -> Places:
        """Rows and columns of the points of the rim about which the region has more than half of a small disk."""
        return np.nonzero(self._angle > 4)

    @cached_property
    def convex(self) -> bool:
        """Whether the region is convex: in one part, no corner of which points inwards."""
        if self.inward_corners[0].size:
            return False
        load_modules("scipy.ndimage")
        from scipy.ndimage import label

        return bool(label(self.inside)[1] == 1)

    @property
    def rectangular(self) -> bool:
        """Whether the region is a rectangle."""
        return self.convex and not self.cut.any()

    @cached_property
    def strip(self) -> tuple[int, int, int]:
        """The narrower strip of lattice lines about the region: axis across it, its first line, and its width in cells.

        Axis 0 counts rows, axis 1 columns.
        """
        found = []
        for axis in (0, 1):
            lines = np.flatnonzero(self.inside.any(axis=1 - axis))
            found.append((int(lines[-1] + 1 - lines[0]), axis, int(lines[0])))
        width, axis, first = min(found)
        return axis, first, width

    @staticmethod
    def _count(points: Mask) -> NDArray[np.int64]:
        """Return how many corners of each cell are among some points."""
        of = points.astype(np.int64)
        return np.asarray(of[:-1, :-1] + of[1:, :-1] + of[:-1, 1:] + of[1:, 1:])


def at_corners(cells: Mask) -> Mask:
    """Return the points that are corners of any of some cells."""
    padded = np.pad(cells, 1)
    return np.asarray(padded[:-1, :-1] | padded[1:, :-1] | padded[:-1, 1:] | padded[1:, 1:])


def largest_at_corners(cells: Grid) -> Grid:
    """Return at each point the largest of the numbers, none of them negative, in the cells about it."""
    padded = np.pad(cells, 1)
    rows = np.maximum(padded[:-1], padded[1:])
    return np.maximum(rows[:, :-1], rows[:, 1:])


def extreme_at_corners(points: Any, extreme: np.ufunc) -> Any:
    """Return the extreme over the four corners of each cell."""
    rows = extreme(points[:-1], points[1:])
    return np.asarray(extreme(rows[:, :-1], rows[:, 1:]))


def _about_points(cells: Mask) -> Mask:
    """Return the points whose four cells are all among some."""
    padded = np.pad(cells, 1)
    return np.asarray(padded[:-1, :-1] & padded[1:, :-1] & padded[:-1, 1:] & padded[1:, 1:])


def _beside_edges(cells: Mask) -> tuple[tuple[Mask, Mask], tuple[Mask, Mask]]:
    """Return whether the cells on either side of each edge along a row, and of each along a column, are among some."""
    rows, columns = np.pad(cells, ((1, 1), (0, 0))), np.pad(cells, ((0, 0), (1, 1)))
    return (rows[:-1], rows[1:]), (columns[:, :-1], columns[:, 1:])
