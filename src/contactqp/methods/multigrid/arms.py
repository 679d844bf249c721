"""Arms: the nodes of a lattice laid out for compiled passes, and its coarser versions."""

from __future__ import annotations

from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...algebra.stiffness import LatticeStiffness
from ...foundation.checks import Mask
from ...foundation.loading import load_modules
from ...geometry.numbering import Grid, Layout
from ...geometry.runs import STIFF
from .lattice_kernels import ArmKind
from .rows import Rows

ArmStiffness: TypeAlias = "float | Grid"

_ANISOTROPY = 3.0
"""A direction with arms this many times stiffer than the other's is coarsened alone (semicoarsening)."""

_STIFF = 0.75
"""So many times as stiff as its arms together must be what else holds a node to go without coarse corrections."""

_SMALLEST = 9
"""Lattices of up to this many points are not coarsened."""


class Arms:
    """Where the nodes are, and how stiff the arms between them.

    Parameters
    ----------
    layout : Layout
    across, along : float or array
        Stiffness of the arms along rows, shape (rows, columns + 1), and along columns, shape (rows + 1, columns); both
        numbers where all are equal, or both arrays.
    ground : float or array, shape (rows, columns)
        Stiffness of the arms between the nodes and the ground; the number 0 where all other arms are equal, and there
        are none of these.
    rim : bool
        Whether the ground is known to hold nodes beside the frame alone.
    part : Rows, optional
        The rows that layout and arrays hold; by default all.
    typical : (float, float), optional
        What `typical_arms` are to be; by default the means of the arms that join something.

    Attributes
    ----------
    rows, columns, size : int
        Rows, columns and nodes of the whole lattice.
    layout : Layout
        It tells how each node is held (see `contactqp.geometry.runs`): stiff is one beside the frame whose arm to the
        ground, as where the contour cuts its arms short, outweighs the others; the coarse levels take it for frame.
    typical_arms : (float, float)
        How stiff the arms along rows and along columns are, which tells how to coarsen.
    """

    def __init__(
        self,
        layout: Layout,
        across: ArmStiffness,
        along: ArmStiffness,
        ground: ArmStiffness = 0.0,
        *,
        rim: bool = False,
        part: Rows | None = None,
        typical: tuple[float, float] | None = None,
    ) -> None:
        self.part = Rows(layout.rows) if part is None else part
        self.rows, self.columns = self.part.count, layout.columns
        self.across, self.along, self.ground, self._rim = across, along, ground, rim
        self.layout = layout if isinstance(ground, float) else layout.with_holds(self._holds(layout.mask, ground))
        self._take_stock()
        self.typical_arms = self._typical() if typical is None else typical
        self.row_coarsening, self.column_coarsening = coarsening(self.rows, self.columns, *self.typical_arms)

    def _take_stock(self) -> None:
        """Count the nodes of all processes, and find their least and their stiffest arms."""
        first, last = self.part.first - 1, self.part.last - 1
        across, along = _rows(self.across, first, last), _rows(self.along, first, last + 1)
        ground, held = _rows(self.ground, first, last), self.layout.holds
        corrected = 0.0 if held is None else float(ground.max(where=held[first:last] != STIFF, initial=0.0))
        stiffest = (float(across.max()), float(along.max()), float(ground.max()), corrected)
        size = int(np.count_nonzero(self.layout.mask[first:last]))
        found = self.part.everyones([(size, _least(across), _least(along), *stiffest)])
        sizes, *least, across_most, along_most, ground_most, corrected_most = zip(*found, strict=True)
        self.size = int(sum(sizes))
        self._least_arms = tuple(0.0 if np.isinf(min(arms)) else float(min(arms)) for arms in least)
        self._stiffest_arms = float(max(across_most)), float(max(along_most))
        self._stiffest_ground, self._stiffest_corrected = float(max(ground_most)), float(max(corrected_most))

    def _typical(self) -> tuple[float, float]:
        """Return the mean stiffness of arms in either direction, of those that have any, summed block by block."""
        if isinstance(self.across, float) and isinstance(self.along, float):
            return self.across, self.along
        part, found = self.part, []
        for low, high in part.blocks:
            # An arm along a column is counted with the row above it; those beyond the last row, with that.
            beyond = high + part.offset == self.rows + 1
            both = _rows(self.across, low - 1, high - 1), _rows(self.along, low - 1, high - 1 + beyond)
            found.append(tuple(float(count) for arms in both for count in (arms.sum(), np.count_nonzero(arms))))
        across, across_used, along, along_used = part.sums(found)
        return across / max(1.0, across_used), along / max(1.0, along_used)

    def _holds(self, mask: Mask, ground: Grid) -> NDArray[np.uint8]:
        west, east, south, north = self._arms_of_points()
        stiff = ground > _STIFF * ((west + east) + (south + north))
        if not self._rim:
            stiff &= _beside_frame(mask)
        if self.varying:  # its interpolation follows the arms
            stiff[:] = False
        holds = (ground > 0).astype(np.uint8)
        holds[stiff] = STIFF
        return holds

    def _arms_of_points(self) -> tuple[ArmStiffness, ArmStiffness, ArmStiffness, ArmStiffness]:
        """Return the west, east, south and north arm of every point."""
        across, along = self.across, self.along
        west, east = (across, across) if isinstance(across, float) else (across[:, :-1], across[:, 1:])
        south, north = (along, along) if isinstance(along, float) else (along[:-1], along[1:])
        return west, east, south, north

    @cached_property
    def kind(self) -> ArmKind:
        """See `lattice_kernels.ArmKind`."""
        if not isinstance(self.across, float):
            return "varying"
        return "equal" if isinstance(self.ground, float) else "rimmed"

    @cached_property
    def reach(self) -> float:
        """Bound of the gap's error per unit of force out of balance: that of the best parabola on a rectangle."""
        across, along = self._least_arms
        square_x, square_y = (self.columns + 1) ** 2, (self.rows + 1) ** 2
        candidates = [(square_x + square_y, across + along), (square_x, across), (square_y, along)]
        return float(min(square / (8 * arms) for square, arms in candidates if arms > 0))

    @cached_property
    def stiffest(self) -> float:
        """Bound of the diagonal of G."""
        return sum(2.0 * arms for arms in self._stiffest_arms) + self._stiffest_ground

    @cached_property
    def stiffest_corrected(self) -> float:
        """Bound of the diagonal of G at the nodes that the coarse levels correct."""
        return sum(2.0 * arms for arms in self._stiffest_arms) + self._stiffest_corrected

    def marks(self) -> NDArray[np.uint8]:
        """Return for each point what `Hierarchy.free` has where there is no contact."""
        layout = self.layout
        if layout.holds is None:
            return layout.mask.astype(np.uint8)
        return np.where(layout.mask, np.array([1, 2, 0], dtype=np.uint8)[layout.holds], np.uint8(0))

    @property
    def stiffnesses(self) -> tuple[ArmStiffness, ArmStiffness, ArmStiffness]:
        """Stiffness of the arms along rows, along columns and to the ground, as kernels take them."""
        return self.across, self.along, self.ground

    @cached_property
    def varying(self) -> bool:
        """Whether the arms differ."""
        return self.kind == "varying"

    def resistance(self, grid: Grid) -> Grid:
        """Return G times a vector on the lattice, shape (rows, columns); to be used at nodes only."""
        own = grid[1:-1, 1:-1]
        west, east, south, north = self._arms_of_points()
        force = west * (own - grid[1:-1, :-2]) + east * (own - grid[1:-1, 2:])
        force = force + (south * (own - grid[:-2, 1:-1]) + north * (own - grid[2:, 1:-1]))
        return np.asarray(force if isinstance(self.ground, float) else force + self.ground * own)

    def coarse_shape(self) -> tuple[int, int]:
        """Return rows and columns of the next coarser lattice."""
        return self.rows // self.row_coarsening, self.columns // self.column_coarsening

    def coarser(self) -> Arms | None:
        """Return the lattice of every second node (see `coarsening`); None if that is no coarser or holds no node."""
        if self.row_coarsening * self.column_coarsening == 1:
            return None
        down, right = self.row_coarsening, self.column_coarsening
        part = self.part.coarser(*self.coarse_shape(), down)
        typical = self.typical_arms[0] * down / right, self.typical_arms[1] * right / down
        mask = self._picked(self.layout.mask, part)
        kinds = None if self.layout.kinds is None else self._picked(self.layout.kinds, part)
        if not any(part.everyones([bool(mask.any())])):
            return None
        across, along = self.across, self.along
        if isinstance(across, float) and isinstance(along, float):
            if isinstance(self.ground, float):
                return Arms(Layout(mask, kinds), *typical, part=part.alone)
            held = self._coarse_rim(self._own_coarse(self.layout.mask))
            if not self._rim:
                springs = np.where(self.layout.mask & ~_beside_frame(self.layout.mask), self.ground, 0.0)
                held += _gathered(_gathered(springs, down).T, right).T
            held = self._handed_on(held, part)[1:-1]
            return Arms(Layout(mask, kinds), *typical, held, rim=self._rim, part=part.alone)
        return self._coarser_varying(mask, kinds, part, typical)

    def _own_coarse(self, points: NDArray[Any]) -> NDArray[Any]:
        """Return what holds at the coarse points on the rows of its own arrays."""
        down, right = self.row_coarsening, self.column_coarsening
        return np.ascontiguousarray(points[down - 1 :: down, right - 1 :: right])

    def _handed_on(self, own: Grid, part: Rows, ring: int = 1) -> Grid:
        """Return what is known of coarse rows of its own arrays on the rows of the next coarser lattice, and a ring."""
        return part.laid_out(np.pad(own, ((1, ring), (0, 0))), self.part.offset // self.row_coarsening)

    def _picked(self, points: NDArray[Any], part: Rows) -> NDArray[Any]:
        """Return what holds at the points of the next coarser lattice, whose rows a part holds."""
        grid = np.pad(points[:, self.column_coarsening - 1 :: self.column_coarsening], ((1, 1), (0, 0)))
        picked = part.picked(grid, self.part, self.row_coarsening)
        return np.ascontiguousarray(picked[1:-1, : self.coarse_shape()[1]])

    def _coarse_rim(self, mask: Mask) -> Grid:
        """Return by how much coarse nodes' arms to the frame are stiffer than the equal ones, for each coarse node."""
        load_modules("contactqp.methods.multigrid.rim_kernels", kernels="multigrid")
        from .rim_kernels import hold_coarse_rim

        held, coarsened = np.zeros(mask.shape), (self.row_coarsening, self.column_coarsening)
        fine, ground = map(np.ascontiguousarray, (self.layout.mask, self.ground))
        hold_coarse_rim(fine, ground, mask, held, self.across, self.along, *coarsened)
        return held

    def _coarser_varying(
        self, mask: Mask, kinds: NDArray[np.uint8] | None, part: Rows, typical: tuple[float, float]
    ) -> Arms | None:
        """Return the coarser lattice of arms that vary.

        The arms between two coarse nodes are joined in series, and count once for each row they stand for. What the
        ground adds beside the frame makes the arms that end there stiffer, as if they were shorter.
        """
        nodes, down, right = self.layout.mask, self.row_coarsening, self.column_coarsening
        own_mask = self._own_coarse(nodes)
        rows, columns = own_mask.shape
        own_rows, own_columns = slice(down - 1, down * rows, down), slice(right - 1, right * columns, right)

        def joined(arms_across: Grid, arms_along: Grid) -> tuple[Grid, Grid]:
            return (
                down * _series(arms_across[own_rows].T, nodes[own_rows].T, right, columns + 1).T,
                right * _series(arms_along[:, own_columns], nodes[:, own_columns], down, rows + 1),
            )

        beside = _beside_frame(nodes)
        ground = np.where(nodes, self.ground, 0.0)
        fine_across, fine_along = np.asarray(self.across), np.asarray(self.along)
        cut_across, cut_along = joined(*_cut_short(nodes, fine_across, fine_along, np.where(beside, ground, 0.0)))
        across, along = joined(fine_across, fine_along)
        springs = _gathered(_gathered(np.where(beside, 0.0, ground), down).T, right).T
        springs = springs + _excess(cut_across, own_mask, 1, across) + _excess(cut_along, own_mask, 0, along)
        across, springs = self._handed_on(across, part)[1:-1], self._handed_on(springs, part)[1:-1]
        along = self._handed_on(along, part, ring=0)[1:]
        held = springs + ((across[:, :-1] + across[:, 1:]) + (along[:-1] + along[1:]))
        mask = mask & (held > 0)
        if not any(part.everyones([bool(mask.any())])):
            return None
        return Arms(Layout(mask, kinds), across, along, springs, part=part.alone, typical=typical)


def coarsening(rows: int, columns: int, across: float, along: float) -> tuple[int, int]:
    """Return by how much to coarsen rows and columns: 2, or 1 in the direction of far weaker arms.

    Both are 1 for a lattice that is small enough.
    """
    if rows * columns <= _SMALLEST:
        return 1, 1
    down = 2 if rows > 1 and along * _ANISOTROPY >= across else 1
    right = 2 if columns > 1 and across * _ANISOTROPY >= along else 1
    if down * right == 1:
        return (2, 1) if rows > 1 else (1, 2)
    return down, right


def _rows(arms: ArmStiffness, first: int, last: int) -> Grid:
    """Return some rows of arms; where all are equal, one."""
    return np.full((1, 1), arms) if isinstance(arms, float) else arms[first:last]


def _least(arms: Grid) -> float:
    """Return the least of the arms that join something, infinite where none does."""
    return float(arms.min(where=arms > 0, initial=np.inf))


def _gathered(grid: Grid, coarsening: int) -> Grid:
    """Return for each coarse row what the fine rows about it have, half of that of the rows between two."""
    if coarsening == 1:
        return grid
    rows = len(grid) // 2
    between = np.vstack([grid, np.zeros((1, grid.shape[1]))])[0::2][: rows + 1]
    return np.asarray(grid[1::2][:rows] + 0.5 * (between[:-1] + between[1:]))


def _series(arms: Grid, nodes: Mask, count: int, wanted: int) -> Grid:
    """Return the stiffness of ``count`` successive arms (rows of the array) in series, ``wanted`` of them.

    A node's arm ends at a frame point in the middle.
    """
    if count == 1:
        return arms[:wanted].copy()
    padded = np.vstack([arms, arms[-1:]])[: 2 * wanted]
    first, second = padded[0::2], padded[1::2]
    total = first + second
    joined = np.asarray(first * np.divide(second, total, out=np.zeros_like(total), where=total > 0))
    point = np.vstack([np.zeros_like(nodes[:1]), nodes, np.zeros_like(nodes[:1]), np.zeros_like(nodes[:1])])
    before, middle, after = (point[k : k + 2 * wanted - 1 : 2] for k in range(3))
    joined = np.where(before & ~middle & ~after, first, joined)
    return np.where(after & ~middle & ~before, second, joined)


def _neighbours(mask: Mask, axis: int) -> tuple[Mask, Mask]:
    """Return which points have a node before them along an axis, and which behind them."""
    points = np.pad(mask, 1)
    return (points[1:-1, :-2], points[1:-1, 2:]) if axis == 1 else (points[:-2, 1:-1], points[2:, 1:-1])


def _beside_frame(mask: Mask) -> Mask:
    """Return which nodes have a neighbour that is none."""
    (west, east), (south, north) = _neighbours(mask, 1), _neighbours(mask, 0)
    return mask & ~(west & east & south & north)


def _cut_short(mask: Mask, across: Grid, along: Grid, more: Grid) -> tuple[Grid, Grid]:
    """Return arms of which those that end on the frame are stiffer: a node's by ``more``, which they share."""
    found = []
    ends = [tuple(mask & ~there for there in _neighbours(mask, axis)) for axis in (1, 0)]
    share = more / np.maximum(1, sum(end.astype(np.int64) for pair in ends for end in pair))
    for arms, (first, second), axis in zip((across, along), ends, (1, 0), strict=True):
        stiffer = np.array(arms)
        before, after = (stiffer[:, :-1], stiffer[:, 1:]) if axis == 1 else (stiffer[:-1], stiffer[1:])
        before[first] += share[first]
        after[second] += share[second]
        found.append(stiffer)
    return found[0], found[1]


def _excess(arms: Grid, mask: Mask, axis: int, plain: Grid) -> Grid:
    """Return by how much a node's arms that end on the frame are stiffer than plain ones together."""
    more = np.maximum(arms - plain, 0.0)
    before, after = (more[:, :-1], more[:, 1:]) if axis == 1 else (more[:-1], more[1:])
    first, second = (mask & ~there for there in _neighbours(mask, axis))
    return np.where(first, before, 0.0) + np.where(second, after, 0.0)


def arms_of(stencil: LatticeStiffness, layout: Layout) -> Arms:
    """Return the lattice of a lattice's arms."""
    if stencil.uniform:
        return Arms(layout, float(stencil.horizontal), float(stencil.vertical))
    box_rows, box_columns = stencil.numbering.box
    ground = np.broadcast_to(stencil.ground, stencil.mask.shape)[box_rows, box_columns]
    ground = np.where(layout.mask, ground, 0.0)
    if stencil.even:
        return Arms(layout, float(stencil.horizontal), float(stencil.vertical), ground, rim=stencil.rimmed)
    across = np.broadcast_to(stencil.horizontal, (stencil.mask.shape[0], stencil.mask.shape[1] + 1))
    along = np.broadcast_to(stencil.vertical, (stencil.mask.shape[0] + 1, stencil.mask.shape[1]))
    across = across[box_rows, box_columns.start : box_columns.stop + 1]
    along = along[box_rows.start : box_rows.stop + 1, box_columns]
    return Arms(layout, *joined_to_nodes(layout, across, along), ground)


def joined_to_nodes(layout: Layout, across: Grid, along: Grid) -> tuple[Grid, Grid]:
    """Return the arms with those between two frame points set to zero, so that they do not count for anything."""
    point = np.pad(layout.mask, 1)
    used_across = point[1:-1, :-1] | point[1:-1, 1:]
    used_along = point[:-1, 1:-1] | point[1:, 1:-1]
    return np.where(used_across, across, 0.0), np.where(used_along, along, 0.0)
