"""Rim: the arms of a lattice that the frame's contour cuts short."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..geometry.lattice import Lattice
from ..geometry.numbering import Grid


@dataclass(frozen=True)
class Rim:
    """The arms that end on a frame to which the lattice is fitted.

    An arm of stiffness a that is cut at θ times its length has the stiffness a/θ: the part a is one of the lattice's
    arms, and the rest, a(1/θ - 1), a spring beside it.

    Attributes
    ----------
    node : array of int, shape (k,)
        Number of the node of each arm.
    row, column : array of int, shape (k,)
        The frame point in its direction, on the array with a ring.
    arm_row, arm_column : array of int, shape (k,)
        Place of each arm on the array of those along rows, or of those along columns.
    along_x : array of bool, shape (k,)
        Whether it is the first of these.
    length : array, shape (k,)
        θ: in spacings.
    arms, springs : array, shape (k,)
        The two parts of the stiffness (force per length).
    heights : array, shape (k,), or None
        Depths at which the frame holds them (length); None for zero.
    """

    node: NDArray[np.int64]
    row: NDArray[np.intp]
    column: NDArray[np.intp]
    arm_row: NDArray[np.intp]
    arm_column: NDArray[np.intp]
    along_x: Mask
    length: Vector
    arms: Vector
    springs: Vector
    heights: Vector | None

    @classmethod
    def of(cls, lattice: Lattice, arms: tuple[Any, Any], heights: Vector | None) -> Rim:
        """Return the rim of a fitted lattice with the stiffness of its arms along rows and along columns."""
        rows, columns = lattice.shape
        ends = lattice.frame_arms
        number = lattice.numbering.to_grid(np.arange(lattice.size), ring=1, fill=-1)
        across = np.broadcast_to(arms[0], (rows, columns + 1))
        along = np.broadcast_to(arms[1], (rows + 1, columns))
        x = ends.along_x
        row, column = np.minimum(ends.node_row, ends.row) - x, np.minimum(ends.node_column, ends.column) - ~x
        stiffness = np.empty(ends.length.size)
        stiffness[x], stiffness[~x] = across[row[x], column[x]], along[row[~x], column[~x]]
        node = number[ends.node_row, ends.node_column].astype(np.int64)
        springs = stiffness * (1 / ends.length - 1)
        return cls(node, ends.row, ends.column, row, column, x, ends.length, stiffness, springs, heights)

    def times(self, factor: float) -> Rim:
        """Return the rim whose arms are ``factor`` times as stiff."""
        return replace(self, arms=self.arms * factor, springs=self.springs * factor)

    def at_nodes(self, size: int) -> Vector:
        """Return the stiffness of the springs at each node, shape (n,)."""
        return np.asarray(np.bincount(self.node, weights=self.springs, minlength=size), dtype=np.float64)

    def pull(self, depths: Vector, frame: Grid | None) -> Vector:
        """Return what the springs add to the force with which a lattice's arms pull each node upwards, shape (n,).

        Parameters
        ----------
        depths : array, shape (n,)
        frame : array, shape (rows + 2, columns + 2), or None
            Depths of the frame points at which the arms are taken to end.
        """
        force = self.arms * self._more(depths, frame)
        return np.asarray(np.bincount(self.node, weights=force, minlength=depths.size), dtype=np.float64)

    def _more(self, depths: Vector, frame: Grid | None) -> Vector:
        """Return what each arm pulls more than one that ends on the lattice, over its stiffness there (length)."""
        own, more = depths[self.node], 1 / self.length - 1
        if self.heights is None or frame is None:
            return np.asarray(more * own)
        return np.asarray(more * (own - self.heights) + (frame[self.row, self.column] - self.heights))

    def pull_along(self, axis: int, depths: Vector, frame: Grid | None, stiffness: Grid) -> Vector:
        """Return what `pull` does, of the arms along an axis alone, if all these had other stiffnesses, shape (n,)."""
        own = self.along_x if axis == 1 else ~self.along_x
        arms = stiffness[self.arm_row[own], self.arm_column[own]]
        force = arms * self._more(depths, frame)[own]
        return np.asarray(np.bincount(self.node[own], weights=force, minlength=depths.size), dtype=np.float64)

    def add_share(self, axis: int, depths: Vector, frame: Grid | None, weights: Vector, total: Grid) -> None:
        """Add the derivatives of Σ weights times `pull_along` by the stiffnesses, in place."""
        own = self.along_x if axis == 1 else ~self.along_x
        place = self.arm_row[own], self.arm_column[own]
        total[place] += (self._more(depths, frame) * weights[self.node])[own]

    def force_of(self, frame: Grid, size: int) -> Vector:
        """Return the forces on the nodes, downwards, by which springs follow a frame that moves so, shape (n,)."""
        force = self.springs * frame[self.row, self.column]
        return np.asarray(np.bincount(self.node, weights=force, minlength=size), dtype=np.float64)

    def steepest(self, depths: Vector) -> float:
        """Return the largest difference of depths along an arm over its length in spacings (length)."""
        heights = 0.0 if self.heights is None else self.heights
        return float((np.abs(depths[self.node] - heights) / self.length).max())
