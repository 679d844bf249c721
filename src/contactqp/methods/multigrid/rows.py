"""Rows: which rows of a lattice, or of a coarse level, a process holds, and which of them it works on.

Arrays have a ring of frame points about the nodes: row 0 and row ``count + 1`` of the whole array are the frame's. A
process that holds a part of the rows has arrays of these alone, whose first row is row ``offset`` of the whole; about
its own rows it holds some of its neighbours', the halo, and computes with them as if they were its own.

All sums go over blocks of rows that are the same however many processes or threads there are, and the blocks' sums are
added in the order of the rows; so no number depends on how the rows are divided.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

BLOCK = 16
"""Rows over which kernels sum; a process's own rows begin where a block does."""

DIRECT = 300
"""Points of a level that one process solves at once: it holds levels of so few whole."""

HALO = 8
"""Rows that a process holds of each neighbour: more than six half-sweeps reach, and half of them on the next level."""

_Found = TypeVar("_Found")


class Rows:
    """All rows, held by one process.

    Parameters
    ----------
    count : int
        Rows of nodes of the whole lattice.

    Attributes
    ----------
    count : int
    offset, height : int
        First row of its arrays, counted on the whole, and how many they have.
    first, last : int
        It works on the rows [first, last) of its arrays.
    own : (int, int)
        The rows [first, last) of the whole that no other process hands it.
    idle : bool
        Whether others work on the rows, and the process waits for them.

    Examples
    --------
    >>> rows = Rows(40)
    >>> rows.near(5), rows.blocks
    ((1, 41), [(1, 16), (16, 32), (32, 41)])
    """

    idle = False

    def __init__(self, count: int) -> None:
        self.count, self.offset, self.height = count, 0, count + 2
        self.first, self.last = 1, count + 1
        self.own = 1, count + 1

    @property
    def alone(self) -> Rows:
        """The same rows for those who work on them, without those who only hand rows to them, and get them back."""
        return self

    def coarser(self, count: int, columns: int, coarsening: int) -> Rows:
        """Return the rows of the next coarser level, every second one or every one.

        Parameters
        ----------
        count, columns : int
            Its rows and columns of nodes.
        coarsening : int
            How many of these rows one of its rows stands for.
        """
        return Rows(count)

    def share(self, *arrays: NDArray[Any], reach: int = HALO, axis: int = 0) -> None:
        """Give others what they hold of these rows, and take theirs, so far away as the reach is.

        Parameters
        ----------
        arrays : array
            Rows along ``axis``.
        """

    def hand_back(self, array: NDArray[Any], reach: int) -> None:
        """Give those who divide the level above what they own of these rows, and so far beside it, if others hold it.

        Parameters
        ----------
        array : array
        reach : int
            No farther than the array is known beside the rows that are worked on.
        """

    def everyones(self, found: list[_Found]) -> list[_Found]:
        """Return what all processes have found in their own rows, in the order of the rows."""
        return found

    def near(self, reach: int) -> tuple[int, int]:
        """Return the rows [first, last) of its arrays that lie no farther from those that it works on."""
        return max(1, self.first - reach), min(self.height - 1, self.last + reach)

    @property
    def blocks(self) -> list[tuple[int, int]]:
        """The rows that it works on in blocks that begin at the same rows for any number of processes."""
        first, last = self.first + self.offset, self.last + self.offset
        edges = [first, *range(first // BLOCK * BLOCK + BLOCK, last, BLOCK), last]
        return [(a - self.offset, b - self.offset) for a, b in pairwise(edges)]

    def sums(self, found: Sequence[tuple[float, ...]]) -> list[float]:
        """Return the sums of what kernels have found in all blocks of all processes, added in the order of the rows."""
        return [float(sum(part)) for part in zip(*self.everyones(list(found)), strict=True)]

    @property
    def own_with_ring(self) -> tuple[int, int]:
        """Its own rows of the whole, with the frame's beside them."""
        first, last = self.own
        return 0 if first == 1 else first, self.count + 2 if last == self.count + 1 else last

    def picked(self, grid: NDArray[Any], finer: Rows, coarsening: int) -> NDArray[Any]:
        """Return the rows of a finer level's array that lie on these, the frame's included, on an array of these.

        Parameters
        ----------
        grid : array, shape (finer.height, ...)
        finer : Rows
        coarsening : int
            How many of its rows one of these stands for.
        """
        places = np.minimum(coarsening * np.arange(*self.own_with_ring), finer.count + 1)
        return self._shared(grid[places - finer.offset])

    def laid_out(self, grid: NDArray[Any], offset: int) -> NDArray[Any]:
        """Return the own rows of an array, with the frame's beside them, on an array of these rows, and share them.

        Parameters
        ----------
        grid : array, shape (rows, ...)
            Its first row is row ``offset`` of the whole.
        offset : int
        """
        first, last = self.own_with_ring
        return self._shared(grid[first - offset : last - offset])

    def _shared(self, own: NDArray[Any]) -> NDArray[Any]:
        first, last = self.own_with_ring
        found = np.zeros((self.height, *own.shape[1:]), dtype=own.dtype)
        found[first - self.offset : last - self.offset] = own
        self.share(found)
        return found
