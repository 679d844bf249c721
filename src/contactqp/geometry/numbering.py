"""Layout: the nodes of a lattice laid out on its rows, for compiled passes over them."""

from __future__ import annotations

from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector

Grid: TypeAlias = NDArray[np.float64]


class Layout:
    """Where the nodes are within the smallest rectangle that holds them all, ring of frame points about it.

    Parameters
    ----------
    mask : array of bool, shape (rows, columns)
        True = node.
    supported : array of bool, shape (rows, columns), or None
        False at nodes without a support; None where all have one.

    Attributes
    ----------
    runs : array of int, shape (runs, 5)
        Row, first column, one past the last, number of the first node, 1 if supported, of nodes that follow each other
        in a row; rows and columns count from the ring.
    row_start : array of int, shape (rows + 3,)
        The first run of each row.
    """

    def __init__(self, mask: Mask, supported: Mask | None = None) -> None:
        self.mask, self.supported = mask, supported
        self.rows, self.columns = mask.shape
        self.runs = _runs(mask, supported)
        self.row_start = np.searchsorted(self.runs[:, 0], np.arange(self.rows + 3)).astype(np.int64)

    @cached_property
    def size(self) -> int:
        """Number of nodes."""
        return int((self.runs[:, 2] - self.runs[:, 1]).sum())

    def zeros(self, dtype: Any = np.float64) -> NDArray[Any]:
        """Return zeros on the rectangle with the ring about it."""
        return np.zeros((self.rows + 2, self.columns + 2), dtype=dtype)

    def grid(self, vector: Vector) -> Grid:
        """Lay a vector in node order out, zero elsewhere."""
        from .numbering_kernels import lay_out

        grid = self.zeros()
        lay_out(vector, grid, self.runs)
        return grid

    def vector(self, grid: Grid) -> Vector:
        """Return the nodes' values, in node order."""
        from .numbering_kernels import take_nodes

        vector = np.empty(self.size)
        take_nodes(grid, vector, self.runs)
        return vector


def bounding_box(mask: Mask) -> tuple[slice, slice]:
    """Return the rows and columns of the smallest rectangle that holds all nodes."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


class Nodes:
    """The nodes of a mask, for moving values between vectors in node order and arrays on the net.

    Where the nodes fill a rectangle, as they often do, slices take the place of a mask and are several times faster.

    Parameters
    ----------
    mask : array of bool, shape (rows, columns)
    """

    def __init__(self, mask: Mask) -> None:
        self._mask = mask
        box = bounding_box(mask)
        self._box = box if mask[box].all() else None

    def take(self, grid: NDArray[Any]) -> NDArray[Any]:
        """Return a new vector of the nodes' values, in node order."""
        return grid[self._mask] if self._box is None else grid[self._box].flatten()

    def put(self, grid: NDArray[Any], vector: NDArray[Any]) -> None:
        """Write a vector in node order to the nodes' places."""
        if self._box is None:
            grid[self._mask] = vector
        else:
            place = grid[self._box]
            place[...] = vector.reshape(place.shape)


def _runs(mask: Mask, supported: Mask | None) -> NDArray[np.int64]:
    kind = np.zeros((mask.shape[0], mask.shape[1] + 2), dtype=np.int8)
    kind[:, 1:-1] = mask
    if supported is not None:
        kind[:, 1:-1] += mask & supported
    rows, edges = np.nonzero(kind[:, 1:] != kind[:, :-1])
    first = np.flatnonzero(kind[rows, edges + 1])
    rows, start, stop = rows[first], edges[first], edges[first + 1]
    held = kind[rows, start + 1] == 2 if supported is not None else np.ones(len(rows), dtype=np.bool_)
    length = stop - start
    node = np.cumsum(length) - length
    return np.ascontiguousarray(np.column_stack([rows + 1, start + 1, stop + 1, node, held]).astype(np.int64))
