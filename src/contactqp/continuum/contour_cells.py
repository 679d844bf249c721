"""ContourCells: the squares of a lattice that a region has a part of, whose contour cuts them anywhere."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..foundation.checks import Mask
from ..geometry.lattice import Lattice
from ..geometry.numbering import Grid
from ..geometry.outline import Outline
from .cells import Cells
from .contour import Contour


@dataclass(frozen=True, eq=False, kw_only=True)
class ContourCells(Cells):
    """The squares that the region within a contour has a part of.

    They cover it, so that what holds in all of them holds in the region. A square that the contour cuts counts as if it
    belonged to the region as a whole where an area is bounded from above, and not at all where it is from below.

    Attributes
    ----------
    outline : Outline
    contour : Contour
        The outline on the lattice.
    """

    outline: Outline
    contour: Contour

    @classmethod
    def of(cls, lattice: Lattice, outline: Outline, contour: Contour, halved: Mask | None = None) -> ContourCells:
        """Return the cells of a lattice within an outline, which halves some of them along diagonals, if any."""
        return cls(lattice.mask, lattice.spacing, halved, outline=outline, contour=contour)

    def __post_init__(self) -> None:
        pass

    @cached_property
    def inside(self) -> Mask:
        """The squares that the region has a part of."""
        return self.contour.inside

    @cached_property
    def whole(self) -> Mask:
        """The squares that lie in the region as a whole."""
        return self.contour.inside & ~self.contour.cut

    @cached_property
    def shares(self) -> Grid:
        """No less than the part of each square that belongs to the region."""
        return np.where(self.cut, 0.5, self.inside.astype(np.float64))

    @property
    def closure(self) -> Mask:
        """The points at which the membrane is wanted: the nodes."""
        return self.nodes

    @property
    def convex(self) -> bool:
        """Whether the region is convex."""
        return self.outline.convex

    @property
    def rectangular(self) -> bool:
        """Whether the region is a rectangle along lines of the lattice."""
        return self.convex and not self.contour.cut.any()


_Point = tuple[int, int]


def outline_of(cells: Cells, lattice: Lattice) -> Outline:
    """Return the outline of cells that are bounded by lines and diagonals of a lattice.

    Where the region touches itself at a point, either part has a ring of its own through it.

    Examples
    --------
    >>> lattice = Lattice.from_mask(np.ones((2, 3), dtype=bool), spacing=0.5)
    >>> outline_of(Cells(lattice.mask, lattice.spacing), lattice).rings
    (array([[-0.5, -0.5],
           [ 1.5, -0.5],
           [ 1.5,  1. ],
           [-0.5,  1. ]]),)
    """
    after: dict[_Point, list[_Point]] = {}
    for start, end in _edges_with_region_left(cells):
        after.setdefault(start, []).append(end)
    rings = []
    while after:
        ring = [next(iter(after))]
        while True:
            ends = after[ring[-1]]
            chosen = min(ends, key=lambda end: _right_turn(ring, end))
            ends.remove(chosen)
            if not ends:
                del after[ring[-1]]
            if chosen == ring[0]:
                break
            ring.append(chosen)
        rings.append(
            np.array([place for place, before, behind in _with_neighbours(ring) if _bent(before, place, behind)])
        )
    places = [lattice.ring_coordinates(ring[:, 0], ring[:, 1]) for ring in rings]
    return Outline(tuple(np.column_stack(place) for place in places))


def _edges_with_region_left(cells: Cells) -> Iterator[tuple[_Point, _Point]]:
    """Yield both ends of the edges of the rim, as rows and columns, so that the region lies to the left."""
    padded, nodes = np.pad(cells.whole, 1), cells.nodes
    for edges in cells.rim:
        down, right = edges.step
        row, column = edges.row, edges.column
        if (down, right) == (0, 1):
            left = padded[row + 1, column + 1]
        elif (down, right) == (1, 0):
            left = padded[row + 1, column]
        else:
            left = nodes[row + 1, column] if right > 0 else nodes[row, column - 1]
        for i, j, forwards in zip(row.tolist(), column.tolist(), left.tolist(), strict=True):
            ends = (i, j), (i + down, j + right)
            yield ends if forwards else ends[::-1]


def _right_turn(ring: list[_Point], end: _Point) -> float:
    """Return by what angle the way turns to the right that goes on from the last point of a ring."""
    if len(ring) < 2:
        return 0.0
    before, place = ring[-2:]
    way = place[1] - before[1], place[0] - before[0]
    then = end[1] - place[1], end[0] - place[0]
    return -math.atan2(way[0] * then[1] - way[1] * then[0], way[0] * then[0] + way[1] * then[1])


def _with_neighbours(ring: list[_Point]) -> Iterator[tuple[_Point, _Point, _Point]]:
    yield from zip(ring, ring[-1:] + ring[:-1], ring[1:] + ring[:1], strict=True)


def _bent(before: _Point, place: _Point, behind: _Point) -> bool:
    """Whether the way turns at a place."""
    return (place[0] - before[0]) * (behind[1] - place[1]) != (place[1] - before[1]) * (behind[0] - place[0])
