"""Strips: the rows of a lattice divided among processes, each of which holds one strip and some rows beside it.

A strip begins where a block of `rows.BLOCK` rows does, on each level that is divided, and on the level below it begins
at the row that lies on its first one. So what a kernel computes of a node is the same sum of the same numbers whoever
computes it, and so is what is summed over rows. Levels of few rows are held whole by every process, which all do the
same work on them: to send them about would take longer.
"""

from __future__ import annotations

from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from .rows import BLOCK, DIRECT, HALO, Rows

LEAST_ROWS = 64
"""Rows for each process below which a coarse level is held whole by every one."""

_Found = TypeVar("_Found")


class Peers(Protocol):
    """The processes that share a lattice, in the order of their strips, as one of them sees them.

    Attributes
    ----------
    rank, size : int
        Which of them it is, from 0 on, and how many they are.
    """

    rank: int
    size: int

    def everyones(self, found: list[_Found]) -> list[_Found]:
        """Return what all have found, one after the other."""

    def exchange(
        self,
        down: NDArray[Any],
        up: NDArray[Any],
        from_below: NDArray[Any],
        from_above: NDArray[Any],
    ) -> None:
        """Send rows to the process before and to the one behind, where there is one, and write what these send."""

    def collect(self, array: NDArray[Any], edges: list[int]) -> None:
        """Write everyone's rows: process k has those from ``edges[k]`` to ``edges[k + 1]``."""


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
        self.offset = 0 if peers.rank == 0 else self.own[0] - HALO
        above = self.count + 2 if peers.rank == peers.size - 1 else self.own[1] + HALO
        self.height = above - self.offset
        self.first, self.last = (row - self.offset for row in self.own)

    def coarser(self, count: int, columns: int, coarsening: int) -> Rows:
        """See `Rows.coarser`."""
        edges = (1, *(edge // coarsening for edge in self._edges[1:-1]), count + 1)
        if divisible(count, self._peers.size, self._least) and count * columns > DIRECT:
            return Strip(self._peers, edges, self._least)
        return Gathered(self._peers, edges)

    def share(self, *arrays: NDArray[Any], reach: int = HALO, axis: int = 0) -> None:
        """See `Rows.share`: neighbours exchange so many rows."""
        first, last = self.first, self.last
        for array in arrays:
            rows = np.moveaxis(array, axis, 0)
            own = rows[first : first + reach], rows[last - reach : last]
            self._peers.exchange(*own, rows[max(0, first - reach) : first], rows[last : last + reach])

    def everyones(self, found: list[_Found]) -> list[_Found]:
        """See `Rows.everyones`."""
        return self._peers.everyones(found)


class Gathered(Rows):
    """The rows of a level that every process holds whole, while the level above it is divided.

    Parameters
    ----------
    peers, edges
        See `Strip`.
    """

    def __init__(self, peers: Peers, edges: tuple[int, ...]) -> None:
        super().__init__(edges[-1] - 1)
        self._peers = peers
        self._edges_with_ring = [0, *edges[1:-1], edges[-1] + 1]
        self.own = edges[peers.rank], edges[peers.rank + 1]

    @property
    def alone(self) -> Rows:
        """See `Rows.alone`."""
        return Rows(self.count)

    def share(self, *arrays: NDArray[Any], reach: int = HALO, axis: int = 0) -> None:
        """See `Rows.share`: everyone gets all rows."""
        for array in arrays:
            for rows in [array] if axis == 0 else np.moveaxis(array, axis, 0).swapaxes(0, 1):
                self._peers.collect(rows, self._edges_with_ring)


def divisible(rows: int, processes: int, least: int = LEAST_ROWS) -> bool:
    """Whether a level has enough rows to be divided."""
    return rows >= max(least, BLOCK) * processes


def divided(rows: int, processes: int, least: int = LEAST_ROWS) -> list[int]:
    """Return the first row of each process, and one past the last row, in strips of about equal height.

    They can be divided on every level that is, however often columns are coarsened alone before that.

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
    factor = 1
    while divisible(rows // (2 * factor), processes, least):
        factor *= 2
    blocks = rows // factor // BLOCK
    # The row that comes nearest, but so that each of the processes behind it has a block as well.
    nearest = [((rows + 1) // factor * k / (BLOCK * processes) + 0.5) // 1 for k in range(1, processes)]
    inner = [factor * BLOCK * min(int(near), blocks - processes + k) for k, near in enumerate(nearest, start=1)]
    return [1, *inner, rows + 1]
