"""Ranks: the processes of an MPI communicator, as the strips of a lattice need them."""

from __future__ import annotations

import time
from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from ..foundation.loading import needed

if TYPE_CHECKING:
    from mpi4py import MPI

INSTALL = "contactqp[mpi]"

_PATIENCE = 3.0
"""Seconds that a process which has failed waits for the others to do so, too."""

_KINDS = {kind.__name__: kind for kind in (ValueError, TypeError, OSError, ImportError, MemoryError, ArithmeticError)}

_Found = TypeVar("_Found")


class Ranks:
    """What `contactqp.methods.multigrid.strips.Peers` asks for, by messages.

    Parameters
    ----------
    comm : mpi4py.MPI.Comm, optional
        By default all processes that were started together. Messages go over a duplicate of it, so that none is taken
        for one of the caller's.

    Attributes
    ----------
    rank, size : int
    messages, sent : int
        How many messages this process has sent to neighbours or to all, and how many bytes: what is collected counts
        once, whatever way MPI takes.

    Raises
    ------
    ImportError
        If mpi4py is not installed.
    """

    def __init__(self, comm: MPI.Comm | None = None) -> None:
        needed("mpi4py", "working in several processes", INSTALL)
        from mpi4py import MPI

        self.comm: MPI.Comm = (MPI.COMM_WORLD if comm is None else comm).Dup()
        self._aside = self.comm.Dup()
        self.rank, self.size = self.comm.Get_rank(), self.comm.Get_size()
        self.messages = self.sent = 0

    def everyones(self, found: list[_Found]) -> list[_Found]:
        """Return what all have found, one after the other."""
        self._count(8 * len(found))
        return [one for part in self.comm.allgather(found) for one in part]

    def agreed(self, work: Callable[[], _Found]) -> _Found:
        """Do a process's part of some work, which asks nothing of the others; what one cannot do is an error in all.

        Raises
        ------
        Exception
            The first process's that failed; in the others of the same kind, where that is built in.
        """
        done, trouble = None, None
        try:
            done = work()
        except Exception as error:
            trouble = error
        told = self.everyones([None if trouble is None else (type(trouble).__name__, str(trouble))])
        failed = next((one for one in told if one is not None), None)
        if failed is None:
            return cast("_Found", done)
        if trouble is not None:
            raise trouble
        kind = _KINDS.get(failed[0], RuntimeError)
        raise kind(failed[1])

    def failed_alike(self) -> bool:
        """Whether all processes have come here, as after an error that all of them have met."""
        deadline, here = time.monotonic() + _PATIENCE, self._aside.Ibarrier()
        while not here.Test():
            if time.monotonic() > deadline:
                return False
            time.sleep(0.01)
        return True

    def exchange(
        self, down: NDArray[Any], up: NDArray[Any], from_below: NDArray[Any], from_above: NDArray[Any]
    ) -> None:
        """Send rows to the process before and to the one behind, where there is one, and write what these send."""
        self._pass_on(up, self.rank + 1, from_below, self.rank - 1)
        self._pass_on(down, self.rank - 1, from_above, self.rank + 1)

    def _pass_on(self, rows: NDArray[Any], to: int, written: NDArray[Any], source: int) -> None:
        from mpi4py import MPI

        sends, receives = 0 <= to < self.size, 0 <= source < self.size
        got = np.empty(written.shape, written.dtype) if receives else None
        self.comm.Sendrecv(
            _message(np.ascontiguousarray(rows) if sends else None),
            to if sends else MPI.PROC_NULL,
            recvbuf=_message(got),
            source=source if receives else MPI.PROC_NULL,
        )
        if sends:
            self._count(rows.nbytes)
        if got is not None:
            written[...] = got

    def collect(self, array: NDArray[Any], edges: list[int]) -> None:
        """Write everyone's rows: process k has those from ``edges[k]`` to ``edges[k + 1]``."""
        from mpi4py import MPI

        row = array[:1].size
        counts = [row * (last - first) for first, last in pairwise(edges)]
        places = [row * first for first in edges[:-1]]
        self.comm.Allgatherv(MPI.IN_PLACE, [array, (counts, places)])
        self._count(counts[self.rank] * array.itemsize)

    def _count(self, size: int) -> None:
        self.messages += 1
        self.sent += size


def _message(rows: NDArray[Any] | None) -> Any:
    """Return rows as bytes, which every MPI takes, whatever their numbers are."""
    return None if rows is None else rows.view(np.uint8).reshape(-1) if rows.size else rows
