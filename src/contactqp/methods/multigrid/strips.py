"""Strips: the rows of a lattice divided among processes, each of which holds one strip and some rows beside it.

A strip begins where a block of `rows.BLOCK` rows does, on each level that is divided, and on the level below it begins
at the row that lies on its first one. So what a kernel computes of a node is the same sum of the same numbers whoever
computes it, and so is what is summed over rows. Where a level has few rows for each process, neighbours' strips are
merged: every second process (every fourth, ...) holds them, and the others wait, until a single one holds the level.
"""

from __future__ import annotations

from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...foundation.together import Together
from .rows import BLOCK, DIRECT, HALO, Rows

LEAST_ROWS = 64
"""Rows for each process below which strips of a coarse level are merged."""

_Found = TypeVar("_Found")


class Peers(Together, Protocol):
    """The processes that share a lattice, in the order of their strips, as one of them sees them."""

    def exchange(self, given: list[tuple[int, NDArray[Any]]], wanted: list[tuple[int, NDArray[Any]]]) -> None:
        """Send arrays to some of the others, and write what some of the others send; all of them must call it."""

    def every(self, step: int) -> Peers | None:
        """Return the processes 0, ``step``, ..., ``size // step`` of them, as one of them sees them; else None."""


class Strip(Rows):
    """The rows of one process, and its halo.

    Parameters
    ----------
    peers : Peers
    edges : tuple of int
        The first row of each process, and one past the last row.
    least : int
        See `LEAST_ROWS`.
    """

    def __init__(self, peers: Peers, edges: tuple[int, ...], least: int = LEAST_ROWS) -> None:
        super().__init__(edges[-1] - 1)
        self._peers, self._edges, self._least = peers, edges, least
        self.own = edges[peers.rank], edges[peers.rank + 1]
        self.offset, above = held(edges, peers.rank, HALO)
        self.height = above - self.offset
        self.first, self.last = (row - self.offset for row in self.own)

    def coarser(self, count: int, columns: int, coarsening: int) -> Rows:
        """See `Rows.coarser`."""
        if self._peers.size == 1:
            return Rows(count)
        edges = (1, *(edge // coarsening for edge in self._edges[1:-1]), count + 1)
        step = self._peers.size if count * columns <= DIRECT else merging(edges, self._least)
        return Strip(self._peers, edges, self._least) if step == 1 else Merged(self._peers, edges, step, self._least)

    def share(self, *arrays: NDArray[Any], reach: int = HALO, axis: int = 0) -> None:
        """See `Rows.share`: neighbours exchange so many rows."""
        first, last, peers = self.first, self.last, self._peers
        for array in arrays:
            rows = np.moveaxis(array, axis, 0)
            given, wanted = [], []
            if peers.rank > 0:
                given.append((peers.rank - 1, rows[first : first + reach]))
                wanted.append((peers.rank - 1, rows[first - reach : first]))
            if peers.rank < peers.size - 1:
                given.append((peers.rank + 1, rows[last - reach : last]))
                wanted.append((peers.rank + 1, rows[last : last + reach]))
            peers.exchange(given, wanted)

    def everyones(self, found: list[_Found]) -> list[_Found]:
        """See `Rows.everyones`."""
        return self._peers.everyones(found)


class Merged(Rows):
    """The rows of a level whose strips are merged, as the processes see them that divide the level above it.

    Each computes, from the level above, its own strip of it, which goes to the process that holds it: the first of
    those whose strips are merged with it. That one's arrays have all their rows, the others' their own strip, and what
    the level above needs beside it.

    Parameters
    ----------
    peers : Peers
    edges : tuple of int
        The first row of each process's strip, and one past the last row.
    step : int
        How many strips make one; those that are left over belong to the last.
    least : int
        See `LEAST_ROWS`.
    """

    def __init__(self, peers: Peers, edges: tuple[int, ...], step: int, least: int) -> None:
        super().__init__(edges[-1] - 1)
        self._peers, self._edges, self._step = peers, edges, step
        self._merged = merged(edges, step)
        self._strips = len(self._merged) - 1
        self._strip = min(peers.rank // step, self._strips - 1)
        self._holder = self._strip * step
        holders = peers.every(step)
        self._alone: Rows
        if holders is None:
            self._alone = Idle(self.count, *held(edges, peers.rank, HALO))
        else:
            self._alone = Strip(holders, self._merged, least) if holders.size > 1 else Rows(self.count)
        self.offset, self.height = self._alone.offset, self._alone.height
        self.own = edges[peers.rank], edges[peers.rank + 1]
        self.first, self.last = (row - self.offset for row in self.own)

    @property
    def alone(self) -> Rows:
        """See `Rows.alone`."""
        return self._alone

    def everyones(self, found: list[_Found]) -> list[_Found]:
        """See `Rows.everyones`."""
        return self._peers.everyones(found)

    def share(self, *arrays: NDArray[Any], reach: int = HALO, axis: int = 0) -> None:
        """See `Rows.share`: who holds a strip gets its rows, and so many beside them."""
        rank, near = self._peers.rank, range(max(0, self._strip - 1), min(self._strips, self._strip + 2))
        given = [(strip * self._step, *self._both(rank, strip, reach)) for strip in near]
        wanted = [(other, *self._both(other, self._strip, reach)) for other in self._members(1) if rank == self._holder]
        self._exchange(arrays, given, wanted, axis)

    def hand_back(self, array: NDArray[Any], reach: int) -> None:
        """See `Rows.hand_back`."""
        rank = self._peers.rank
        given = [(other, *held(self._edges, other, reach)) for other in self._members(0) if rank == self._holder]
        self._exchange((array,), given, [(self._holder, *held(self._edges, rank, reach))], 0)

    def _members(self, beyond: int) -> range:
        """Return the processes whose strips are merged into this one, and so many on either side."""
        last = self._peers.size if self._strip == self._strips - 1 else self._holder + self._step
        return range(max(0, self._holder - beyond), min(self._peers.size, last + beyond))

    def _both(self, rank: int, strip: int, reach: int) -> tuple[int, int]:
        """Return the rows that a process finds and that are wanted of a strip: its own, and so many beside it."""
        found, wanted = held(self._edges, rank, 0), held(self._merged, strip, reach)
        return max(found[0], wanted[0]), min(found[1], wanted[1])

    def _exchange(
        self,
        arrays: tuple[NDArray[Any], ...],
        given: list[tuple[int, int, int]],
        wanted: list[tuple[int, int, int]],
        axis: int,
    ) -> None:
        for array in arrays:
            rows = np.moveaxis(array, axis, 0)
            both = (
                [
                    (other, rows[first - self.offset : last - self.offset])
                    for other, first, last in some
                    if other != self._peers.rank and first < last
                ]
                for some in (given, wanted)
            )
            self._peers.exchange(*both)


class Idle(Rows):
    """Rows that others work on, as a process sees them that waits for these: it holds what it hands to them, or gets.

    Parameters
    ----------
    count : int
        Rows of nodes of the whole lattice.
    first, last : int
        It holds the rows [first, last) of the whole.
    """

    idle = True

    def __init__(self, count: int, first: int, last: int) -> None:
        super().__init__(count)
        self.offset, self.height = first, last - first
        self.first, self.last = 1, self.height - 1
        self.own = first + 1, last - 1

    def near(self, reach: int) -> tuple[int, int]:
        """See `Rows.near`: none."""
        return 1, 1


def held(edges: tuple[int, ...], k: int, reach: int) -> tuple[int, int]:
    """Return the rows [first, last) of the k-th strip and so many beside it, the frame's included.

    Parameters
    ----------
    edges : tuple of int
        The first row of each strip, and one past the last row.
    k, reach : int

    Examples
    --------
    >>> held((1, 160, 320, 512), 2, 8)
    (312, 513)
    """
    return 0 if k == 0 else edges[k] - reach, edges[k + 1] + (1 if k == len(edges) - 2 else reach)


def merged(edges: tuple[int, ...], step: int) -> tuple[int, ...]:
    """Return the edges of strips of which each joins so many; those that are left over belong to the last.

    Examples
    --------
    >>> merged((1, 16, 32, 48, 64, 81), 2)
    (1, 32, 81)
    """
    return (*edges[: (len(edges) - 1) // step * step : step], edges[-1])


def merging(edges: tuple[int, ...], least: int = LEAST_ROWS) -> int:
    """Return how many strips of a level are to be merged into one: a power of two; 1 if they can stay as they are.

    Parameters
    ----------
    edges : tuple of int
        The first row of each strip, and one past the last row.
    least : int
        See `LEAST_ROWS`.

    Examples
    --------
    >>> [merging((1, 16, 32, 48, 65), least) for least in (16, 32)]
    [1, 2]
    """
    step = 1
    while not _in_blocks(merged(edges, step), least):
        step *= 2
    return step


def _in_blocks(edges: tuple[int, ...], least: int) -> bool:
    """Whether strips begin where blocks do, none has fewer rows than a block, and all together have enough."""
    if len(edges) == 2:
        return True
    rows = edges[-1] - 1
    aligned = not any(edge % BLOCK for edge in edges[1:-1])
    return aligned and divisible(rows, len(edges) - 1, least) and edges[-1] - edges[-2] >= BLOCK


def divisible(rows: int, processes: int, least: int = LEAST_ROWS) -> bool:
    """Whether a level has enough rows to be divided."""
    return rows >= max(least, BLOCK) * processes


def divided(rows: int, processes: int, least: int = LEAST_ROWS) -> list[int]:
    """Return the first row of each process, and one past the last row, in strips of about equal height.

    They can be divided on every level that has enough rows for all of them, however often columns are coarsened alone
    before that; then by half of the processes, and so on. So the edge that is left when strips have been merged s times
    lies on a block of the level whose rows are so many times coarser, and is placed before those that lie beside it.

    Parameters
    ----------
    rows : int
        Rows of nodes.
    processes : int
    least : int
        See `LEAST_ROWS`.

    Raises
    ------
    ValueError
        If there are fewer than `rows.BLOCK` rows for each of several processes.

    Examples
    --------
    >>> divided(511, 3)
    [1, 160, 352, 512]
    >>> divided(2047, 2)
    [1, 1024, 2048]
    """
    if processes > 1 and rows < BLOCK * processes:
        most = max(1, rows // BLOCK)
        raise ValueError(
            f"{rows} rows of nodes are too few for {processes} processes, each of which takes at least {BLOCK}; "
            f"start at most {most}"
        )
    unit = BLOCK
    while divisible(rows * BLOCK // (2 * unit), processes, least):
        unit *= 2
    edges = {0: 0, processes: rows + 1}
    step = 1 << processes.bit_length() - 1
    while step:
        own = unit * step
        for k in range(step, processes // step * step, step):
            if k not in edges:
                beyond = next(other for other in range(k + 1, processes + 1) if other in edges)
                before, room = edges[k - step] // own, edges[beyond] - edges[k - step]
                nearest = before + round(room * step / ((beyond - k + step) * own))
                edges[k] = own * min(max(nearest, before + 1), (edges[beyond] - unit * (beyond - k)) // own)
        step //= 2
    return [1, *(edges[k] for k in range(1, processes + 1))]
