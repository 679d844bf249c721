"""Cells: the region that a frame along lattice lines bounds, as squares between lattice points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask
from ..geometry.numbering import Grid

Places: TypeAlias = tuple[NDArray[np.intp], ...]


@dataclass(frozen=True, eq=False)
class Cells:
    """The squares between lattice points that a frame along lattice lines encloses.

    Arrays of points have the lattice's shape with a ring of frame points about it, (rows + 2, columns + 2); those of
    cells lie between the points, (rows + 1, columns + 1): cell [i, j] has the corners [i, j] to [i + 1, j + 1].

    Parameters
    ----------
    mask : array of bool, shape (rows, columns)
        The nodes: lattice points within the frame.
    spacing : float
        Side h of a cell (length).

    Raises
    ------
    ValueError
        If the frame is more than the rim of the cells about the nodes: a pin, a slit, or a passage without nodes.

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

    def __post_init__(self) -> None:
        within = _about_points(self.inside)
        buried = within & ~self.nodes
        level, upright = _beside_edges(self.inside)
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
        """The cells of the region: those with a node at a corner."""
        nodes = self.nodes
        return np.asarray(nodes[:-1, :-1] | nodes[1:, :-1] | nodes[:-1, 1:] | nodes[1:, 1:])

    @cached_property
    def closure(self) -> Mask:
        """The points of the closed region: nodes and points of the rim."""
        return at_corners(self.inside)

    @cached_property
    def rim(self) -> tuple[Places, Places]:
        """Rows i and columns j of the edges of the rim: from point [i, j] to [i, j + 1]; from [i, j] to [i + 1, j]."""
        level, upright = _beside_edges(self.inside)
        return np.nonzero(level[0] ^ level[1]), np.nonzero(upright[0] ^ upright[1])

    @cached_property
    def inward_corners(self) -> Places:
        """Rows and columns of the points of the rim that have three cells of the region about them."""
        padded = np.pad(self.inside.astype(np.int64), 1)
        count = padded[:-1, :-1] + padded[1:, :-1] + padded[:-1, 1:] + padded[1:, 1:]
        return np.nonzero((count == 3) & self.closure & ~self.nodes)

    @cached_property
    def convex(self) -> bool:
        """Whether the region is a rectangle."""
        rows, columns = np.flatnonzero(self.inside.any(axis=1)), np.flatnonzero(self.inside.any(axis=0))
        return bool(self.inside[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1].all())

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


def at_corners(cells: Mask) -> Mask:
    """Return the points that are corners of any of some cells."""
    padded = np.pad(cells, 1)
    return np.asarray(padded[:-1, :-1] | padded[1:, :-1] | padded[:-1, 1:] | padded[1:, 1:])


def largest_at_corners(cells: Grid) -> Grid:
    """Return at each point the largest of the numbers, none of them negative, in the cells about it."""
    padded = np.pad(cells, 1)
    rows = np.maximum(padded[:-1], padded[1:])
    return np.maximum(rows[:, :-1], rows[:, 1:])


def extreme_at_corners(points: Grid, extreme: np.ufunc) -> Grid:
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
