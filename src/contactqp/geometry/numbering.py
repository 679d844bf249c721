"""Numbering: the nodes of a mask in their order, and where they lie on arrays.

Vectors hold one value a node, in the order of the nodes: row by row, and along each row. Arrays have the shape of the
mask, or that of the mask with a ring of frame points about it.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..foundation.loading import load_modules
from .runs import FIRST, KINDS, LAST, ROW, SUPPORTED

Grid: TypeAlias = NDArray[np.float64]


class Numbering:
    """The nodes of a mask, for moving values between vectors in node order and arrays.

    Where the nodes fill a rectangle, as they often do, slices take the place of a mask and are several times faster.

    Parameters
    ----------
    mask : array of bool, shape (rows, columns)
        True = node.
    whole : bool
        Whether all rows and columns count as the nodes' box, though some at its sides hold none.

    Examples
    --------
    >>> numbering = Numbering(np.array([[True, True, False], [False, True, True]]))
    >>> numbering.to_grid(np.array([1.0, 2.0, 3.0, 4.0]))
    array([[1., 2., 0.],
           [0., 3., 4.]])
    >>> numbering.to_vector(np.array([[5, 6, 7], [8, 9, 10]]))
    array([ 5,  6,  9, 10])
    """

    def __init__(self, mask: Mask, *, whole: bool = False) -> None:
        self.mask = mask
        self.rows, self.columns = mask.shape
        if whole:
            self.box = slice(0, self.rows), slice(0, self.columns)

    @cached_property
    def size(self) -> int:
        """Number of nodes."""
        return int(np.count_nonzero(self.mask))

    @cached_property
    def box(self) -> tuple[slice, slice]:
        """Rows and columns of the smallest rectangle that holds all nodes."""
        rows, columns = np.flatnonzero(self.mask.any(axis=1)), np.flatnonzero(self.mask.any(axis=0))
        return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)

    @cached_property
    def layout(self) -> Layout:
        """The nodes within their box, for compiled passes; all of them have the lower bound 0 alone."""
        return Layout(np.ascontiguousarray(self.mask[self.box]))

    @cached_property
    def _fills_box(self) -> bool:
        return bool(self.mask[self.box].all())

    def to_grid(self, vector: NDArray[Any], *, ring: int = 0, fill: float = 0.0) -> NDArray[Any]:
        """Lay a vector out on a new array.

        Parameters
        ----------
        vector : array, shape (..., size)
        ring : int
            How many rows and columns of frame points to leave on each side of the mask.
        fill : float
            Value of the points that are no nodes.

        Returns
        -------
        array, shape (..., rows + 2 ring, columns + 2 ring)
        """
        rows, columns = self.rows + 2 * ring, self.columns + 2 * ring
        shape = *vector.shape[:-1], rows, columns
        grid = np.full(shape, fill, dtype=np.result_type(vector.dtype, type(fill)))
        inner = grid[..., ring : rows - ring, ring : columns - ring]
        if self._fills_box:
            place = inner[..., *self.box]
            place[...] = vector.reshape(place.shape)
        else:
            inner[..., self.mask] = vector
        return grid

    def to_vector(self, grid: NDArray[Any], *, ring: int = 0) -> NDArray[Any]:
        """Return a new vector of the nodes' values on an array that has such a ring about the mask.

        Parameters
        ----------
        grid : array, shape (..., rows + 2 ring, columns + 2 ring)

        Returns
        -------
        array, shape (..., size)
        """
        rows, columns = grid.shape[-2:]
        inner = grid[..., ring : rows - ring, ring : columns - ring]
        if not self._fills_box:
            return np.ascontiguousarray(inner[..., self.mask])
        return inner[..., *self.box].flatten().reshape(*grid.shape[:-2], self.size)


class Layout(Numbering):
    """A numbering whose mask is as small as its nodes allow, laid out for compiled passes along its rows.

    Arrays have a ring of frame points about the mask, so that no neighbour needs a test.

    Parameters
    ----------
    mask : array of bool, shape (rows, columns)
        True = node.
    kinds : array of uint8, shape (rows, columns), or None
        Of each node, see `contactqp.geometry.runs`; None where all are `SUPPORTED`.
    holds : array of uint8, shape (rows, columns), or None
        How each node is held, see `contactqp.geometry.runs`; None where all are `LOOSE`.
    """

    def __init__(
        self, mask: Mask, kinds: NDArray[np.uint8] | None = None, holds: NDArray[np.uint8] | None = None
    ) -> None:
        super().__init__(mask)
        self.kinds, self.holds = kinds, holds

    @cached_property
    def runs(self) -> NDArray[np.int64]:
        """Nodes alike in kind and hold that follow each other in a row, shape (runs, 6).

        Row, first column, one past the last, number of the first node, kind and hold; rows and columns count from the
        ring.
        """
        return _runs(self.mask, self.kinds, self.holds)

    @cached_property
    def row_start(self) -> NDArray[np.int64]:
        """The first run of each row, shape (rows + 3,)."""
        return np.searchsorted(self.runs[:, ROW], np.arange(self.rows + 3)).astype(np.int64)

    @cached_property
    def size(self) -> int:
        """Number of nodes."""
        return int((self.runs[:, LAST] - self.runs[:, FIRST]).sum())

    def with_kind(self, kind: int) -> Layout:
        """Return the layout of the same nodes, all of one kind."""
        return Layout(self.mask, np.full(self.mask.shape, kind, dtype=np.uint8))

    def with_holds(self, holds: NDArray[np.uint8]) -> Layout:
        """Return the layout of the same nodes, told how each is held."""
        return Layout(self.mask, self.kinds, holds)

    def zeros(self, dtype: Any = np.float64) -> NDArray[Any]:
        """Return zeros on the rectangle with the ring about it."""
        return np.zeros((self.rows + 2, self.columns + 2), dtype=dtype)

    def grid(self, vector: Vector, out: Grid | None = None) -> Grid:
        """Lay a vector in node order out, with the ring about it; zero elsewhere, or what ``out`` holds there."""
        load_modules("contactqp.geometry.numbering_kernels", kernels="lattices")
        from .numbering_kernels import lay_out

        grid = self.zeros() if out is None else out
        lay_out(vector, grid, self.runs)
        return grid

    def vector(self, grid: Grid) -> Vector:
        """Return the nodes' values on an array with the ring about it, in node order."""
        load_modules("contactqp.geometry.numbering_kernels", kernels="lattices")
        from .numbering_kernels import take_nodes

        vector = np.empty(self.size)
        take_nodes(grid, vector, self.runs)
        return vector


def _runs(mask: Mask, kinds: NDArray[np.uint8] | None, holds: NDArray[np.uint8] | None) -> NDArray[np.int64]:
    # Points that are no nodes are told from every node by a zero.
    marks = np.zeros((mask.shape[0], mask.shape[1] + 2), dtype=np.uint8)
    told = np.uint8(1 + SUPPORTED) if kinds is None else kinds + np.uint8(1)
    if holds is not None:
        told = told + np.uint8(KINDS) * holds
    marks[:, 1:-1] = np.where(mask, told, np.uint8(0))
    rows, edges = np.nonzero(marks[:, 1:] != marks[:, :-1])
    first = np.flatnonzero(marks[rows, edges + 1])
    rows, start, stop = rows[first], edges[first], edges[first + 1]
    hold, kind = np.divmod(marks[rows, start + 1] - np.uint8(1), np.uint8(KINDS))
    length = stop - start
    node = np.cumsum(length) - length
    return np.ascontiguousarray(np.column_stack([rows + 1, start + 1, stop + 1, node, kind, hold]).astype(np.int64))
