"""Rim: the arms of a lattice that the frame's contour cuts short."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Vector
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
        row, column = np.minimum(ends.node_row, ends.row), np.minimum(ends.node_column, ends.column)
        stiffness = np.empty(ends.length.size)
        x, y = ends.along_x, ~ends.along_x
        stiffness[x] = across[row[x] - 1, column[x]]
        stiffness[y] = along[row[y], column[y] - 1]
        node = number[ends.node_row, ends.node_column].astype(np.int64)
        springs = stiffness * (1 / ends.length - 1)
        return cls(node, ends.row, ends.column, ends.length, stiffness, springs, heights)

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
        own = depths[self.node]
        if self.heights is None or frame is None:
            force = self.springs * own
        else:
            beyond = frame[self.row, self.column] - self.heights
            force = self.springs * (own - self.heights) + self.arms * beyond
        return np.asarray(np.bincount(self.node, weights=force, minlength=depths.size), dtype=np.float64)

    def steepest(self, depths: Vector) -> float:
        """Return the largest difference of depths along an arm over its length in spacings (length)."""
        heights = 0.0 if self.heights is None else self.heights
        return float((np.abs(depths[self.node] - heights) / self.length).max())
