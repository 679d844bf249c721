"""Arms: the nodes of a lattice laid out for compiled passes, and its coarser versions."""

from __future__ import annotations

from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...algebra.stiffness import LatticeStiffness
from ...foundation.checks import Mask
from ...geometry.numbering import Grid, Layout

ArmStiffness: TypeAlias = "float | Grid"

_ANISOTROPY = 3.0
"""A direction with arms this many times stiffer than the other's is coarsened alone (semicoarsening)."""

_SMALLEST = 9
"""Lattices of up to this many points are not coarsened."""


class Arms:
    """Where the nodes are, and how stiff the arms between them.

    Parameters
    ----------
    layout : Layout
    across, along : float or array
        Stiffness of the arms along rows, shape (rows, columns + 1), and along columns, shape (rows + 1, columns).
    ground : float or array, shape (rows, columns)
        Stiffness of the arms between the nodes and the ground; the number 0 where all other arms are equal.
    """

    def __init__(self, layout: Layout, across: ArmStiffness, along: ArmStiffness, ground: ArmStiffness = 0.0) -> None:
        self.layout = layout
        self.rows, self.columns = layout.rows, layout.columns
        self.across, self.along, self.ground = across, along, ground
        self.typical_arms = _typical(across), _typical(along)
        self.row_coarsening, self.column_coarsening = coarsening(self.rows, self.columns, *self.typical_arms)

    @cached_property
    def reach(self) -> float:
        """Bound of the gap's error per unit of force out of balance: that of the best parabola on a rectangle."""
        across, along = _least(self.across), _least(self.along)
        square_x, square_y = (self.columns + 1) ** 2, (self.rows + 1) ** 2
        candidates = [(square_x + square_y, across + along), (square_x, across), (square_y, along)]
        return float(min(square / (8 * arms) for square, arms in candidates if arms > 0))

    @cached_property
    def stiffest(self) -> float:
        """Bound of the diagonal of G."""
        return float(sum(2.0 * np.max(arms) for arms in (self.across, self.along))) + float(np.max(self.ground))

    @property
    def stiffnesses(self) -> tuple[ArmStiffness, ArmStiffness, ArmStiffness]:
        """Stiffness of the arms along rows, along columns and to the ground, as kernels take them."""
        return self.across, self.along, self.ground

    @property
    def varying(self) -> bool:
        """Whether the arms differ."""
        return not isinstance(self.across, float)

    def resistance(self, grid: Grid) -> Grid:
        """Return G times a vector on the lattice, shape (rows, columns); to be used at nodes only."""
        own = grid[1:-1, 1:-1]
        across, along = self.across, self.along
        west, east = (across, across) if isinstance(across, float) else (across[:, :-1], across[:, 1:])
        south, north = (along, along) if isinstance(along, float) else (along[:-1], along[1:])
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
        rows, columns = self.coarse_shape()
        mask = self.layout.mask[down - 1 :: down, right - 1 :: right][:rows, :columns]
        kinds = self.layout.kinds
        if kinds is not None:
            kinds = np.ascontiguousarray(kinds[down - 1 :: down, right - 1 :: right][:rows, :columns])
        across, along = self.across, self.along
        if isinstance(across, float) and isinstance(along, float):
            return Arms(Layout(mask, kinds), across * down / right, along * right / down) if mask.any() else None
        return _coarser_varying(self, mask, kinds)


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


def _typical(arms: ArmStiffness) -> float:
    if isinstance(arms, float):
        return arms
    used = np.count_nonzero(arms)
    return float(arms.sum() / used) if used else 0.0


def _least(arms: ArmStiffness) -> float:
    if isinstance(arms, float):
        return arms
    positive = arms[arms > 0]
    return float(positive.min()) if positive.size else 0.0


def _coarser_varying(lattice: Arms, mask: Mask, kinds: NDArray[np.uint8] | None) -> Arms | None:
    """Join the arms between two coarse nodes in series, and count them once for each row they stand for."""
    across, along = np.asarray(lattice.across), np.asarray(lattice.along)
    down, right = lattice.row_coarsening, lattice.column_coarsening
    rows, columns = mask.shape
    own_rows = across[down - 1 :: down][:rows]
    own_columns = along[:, right - 1 :: right][:, :columns]
    coarse_across = down * _series(own_rows.T, right, columns + 1).T
    coarse_along = right * _series(own_columns, down, rows + 1)
    ground = _gathered(_gathered(np.asarray(lattice.ground), down).T, right).T
    held = (coarse_across[:, :-1] + coarse_across[:, 1:]) + (coarse_along[:-1] + coarse_along[1:]) + ground
    mask = mask & (held > 0)
    if not mask.any():
        return None
    return Arms(Layout(mask, kinds), *map(np.ascontiguousarray, (coarse_across, coarse_along, ground)))


def _gathered(grid: Grid, coarsening: int) -> Grid:
    """Return for each coarse row what the fine rows about it have, half of that of the rows between two."""
    if coarsening == 1:
        return grid
    rows = len(grid) // 2
    between = np.vstack([grid, np.zeros((1, grid.shape[1]))])[0::2][: rows + 1]
    return np.asarray(grid[1::2][:rows] + 0.5 * (between[:-1] + between[1:]))


def _series(arms: Grid, count: int, wanted: int) -> Grid:
    """Return the stiffness of ``count`` successive arms (rows of the array) in series, ``wanted`` of them."""
    if count == 1:
        return arms[:wanted].copy()
    padded = np.vstack([arms, arms[-1:]])[: 2 * wanted]
    first, second = padded[0::2], padded[1::2]
    total = first + second
    return np.asarray(first * np.divide(second, total, out=np.zeros_like(total), where=total > 0))


def arms_of(stencil: LatticeStiffness, layout: Layout) -> Arms:
    """Return the lattice of a lattice's arms."""
    if stencil.uniform:
        return Arms(layout, float(stencil.horizontal), float(stencil.vertical))
    box_rows, box_columns = stencil.numbering.box
    across = np.broadcast_to(stencil.horizontal, (stencil.mask.shape[0], stencil.mask.shape[1] + 1))
    along = np.broadcast_to(stencil.vertical, (stencil.mask.shape[0] + 1, stencil.mask.shape[1]))
    across = across[box_rows, box_columns.start : box_columns.stop + 1]
    along = along[box_rows.start : box_rows.stop + 1, box_columns]
    ground = np.broadcast_to(stencil.ground, stencil.mask.shape)[box_rows, box_columns]
    return Arms(layout, *_joined_to_nodes(layout, across, along), np.where(layout.mask, ground, 0.0))


def _joined_to_nodes(layout: Layout, across: Grid, along: Grid) -> tuple[Grid, Grid]:
    """Return the arms with those between two frame points set to zero, so that they do not count for anything."""
    point = np.pad(layout.mask, 1)
    used_across = point[1:-1, :-1] | point[1:-1, 1:]
    used_along = point[:-1, 1:-1] | point[1:, 1:-1]
    return np.where(used_across, across, 0.0), np.where(used_along, along, 0.0)
