"""Ranks: the processes of an MPI communicator, as the strips of a lattice need them."""

from __future__ import annotations

import pickle
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from ..errors import CaseFileError
from ..foundation.interrupts import INTERRUPTED
from ..foundation.loading import needed

if TYPE_CHECKING:
    from mpi4py import MPI

INSTALL = "contactqp[mpi]"

_PATIENCE = 3.0
"""Seconds that a process which has failed waits for the others to do so, too."""

_LITTLE = 128
"""Bytes that everyone tells everyone at once, among them eight that say how many there are."""

_SPINNING, _LONGEST_NAP = 2e-4, 5e-3
"""Seconds for which messages are waited for by asking again and again, and at most between two questions afterwards."""

_KINDS = {
    kind.__name__: kind
    for kind in (CaseFileError, ValueError, TypeError, OSError, ImportError, MemoryError, ArithmeticError)
}

_Found = TypeVar("_Found")


class Ranks:
    """What `contactqp.methods.multigrid.strips.Peers` asks for, by messages.

    Parameters
    ----------
    comm : mpi4py.MPI.Comm, optional
        By default all processes that were started together. Messages go over a duplicate of it, so that none is taken
        for one of the caller's; it is made once, and kept with the communicator.

    Attributes
    ----------
    rank, size : int
    messages, sent : int
        How many messages this process has sent to neighbours or to all, and how many bytes: what goes to all counts
        once, whatever way MPI takes.

    Raises
    ------
    ImportError
        If mpi4py is not installed.
    """

    def __init__(self, comm: MPI.Comm | None = None) -> None:
        needed("mpi4py", "working in several processes", INSTALL)
        from mpi4py import MPI

        self.comm, self._aside = _duplicates(MPI.COMM_WORLD if comm is None else comm)
        self.rank, self.size = self.comm.Get_rank(), self.comm.Get_size()
        self.messages = self.sent = 0

    def everyones(self, found: list[_Found]) -> list[_Found]:
        """Return what all have found, one after the other: by one message where that is little, else by two."""
        if self.size == 1:
            return found
        told = np.frombuffer(pickle.dumps(found), dtype=np.uint8)
        own, all_told = np.zeros(_LITTLE, np.uint8), np.empty((self.size, _LITTLE), np.uint8)
        own[:8] = np.array([told.size]).view(np.uint8)
        if told.size <= _LITTLE - 8:
            own[8 : 8 + told.size] = told
        self._wait([self.comm.Iallgather(own, all_told)], _LITTLE)
        sizes = all_told[:, :8].copy().view(np.int64).ravel()
        if sizes.max() <= _LITTLE - 8:
            parts = [all_told[k, 8 : 8 + size] for k, size in enumerate(sizes)]
        else:
            ends = np.cumsum(sizes)
            together = np.empty(ends[-1], np.uint8)
            places = sizes.tolist(), (ends - sizes).tolist()
            self._wait([self.comm.Iallgatherv(told, [together, places])], told.size)
            parts = np.split(together, ends[:-1])
        return [one for part in parts for one in pickle.loads(part.tobytes())]

    def agreed(self, work: Callable[[], _Found]) -> _Found:
        """Do a process's part of some work, which asks nothing of the others; what one cannot do is an error in all.

        Raises
        ------
        Exception
            The first process's that failed; in the others one in the same words, of the same kind where that is built
            in or tells of a case file.
        """
        done, trouble = None, None
        try:
            done = work()
        except Exception as error:
            trouble = error
        told = self.everyones([None if trouble is None else (type(trouble).__name__, str(trouble))])
        failed = next((rank for rank, one in enumerate(told) if one is not None), None)
        if failed is None:
            return cast("_Found", done)
        if trouble is not None and failed == self.rank:
            raise trouble
        kind, words = cast("tuple[str, str]", told[failed])
        raise _KINDS.get(kind, RuntimeError)(words) from trouble

    @contextmanager
    def ended_together(self) -> Iterator[None]:
        """Do work that all processes take part in, and let none of them wait for one that has left it.

        An error that all meet with is raised in all. After one that a single process meets with, or Ctrl-C, which those
        cannot hear that wait within MPI, all of them end at once, and the process says why.
        """
        try:
            yield
        except KeyboardInterrupt:
            sys.stderr.write("contactqp: interrupted\n")
            sys.stderr.flush()
            self.comm.Abort(INTERRUPTED)
        except Exception:
            if not self._all_come_here():
                traceback.print_exc()
                sys.stderr.flush()
                self.comm.Abort(1)
            raise

    def _all_come_here(self) -> bool:
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
        rows, requests, sent = [], [], 0
        for other, given, wanted in ((self.rank - 1, down, from_below), (self.rank + 1, up, from_above)):
            if not 0 <= other < self.size:
                continue
            rows.append((wanted, np.empty(wanted.shape, wanted.dtype), np.ascontiguousarray(given)))
            requests.append(self.comm.Irecv(_as_bytes(rows[-1][1]), other))
            requests.append(self.comm.Isend(_as_bytes(rows[-1][2]), other))
            sent += given.nbytes
        self._wait(requests, sent)
        for wanted, got, _ in rows:
            wanted[...] = got

    def collect(self, array: NDArray[Any], edges: list[int]) -> None:
        """Write everyone's rows: process k has those from ``edges[k]`` to ``edges[k + 1]``."""
        from mpi4py import MPI

        if self.size == 1:
            return
        row = array[:1].size
        counts = [row * (last - first) for first, last in pairwise(edges)]
        places = [row * first for first in edges[:-1]]
        request = self.comm.Iallgatherv(MPI.IN_PLACE, [array, (counts, places)])
        self._wait([request], counts[self.rank] * array.itemsize)

    def _wait(self, requests: list[MPI.Request], sent: int) -> None:
        """Wait for messages, and count them.

        MPI's own waiting takes a whole core, which others may need where there are more processes than cores, and does
        not answer Ctrl-C. Between two questions a tenth of the time goes by that has gone by before.
        """
        from mpi4py import MPI

        if not requests:
            return
        self.messages += max(1, len(requests) // 2)
        self.sent += sent
        began = time.perf_counter()
        while not MPI.Request.Testall(requests):
            if (waited := time.perf_counter() - began) > _SPINNING:
                time.sleep(min(waited / 10, _LONGEST_NAP))


def _duplicates(comm: MPI.Comm) -> tuple[MPI.Comm, MPI.Comm]:
    """Return two duplicates of a communicator, the same ones whenever they are asked for: MPI has few to give."""
    key = _key()
    known: Any = comm.Get_attr(key)
    if known is None:
        known = comm.Dup(), comm.Dup()
        comm.Set_attr(key, known)
    return cast("tuple[MPI.Comm, MPI.Comm]", known)


@cache
def _key() -> int:
    from mpi4py import MPI

    return MPI.Comm.Create_keyval()


def _as_bytes(rows: NDArray[Any]) -> NDArray[np.uint8]:
    """Return rows as bytes, which every MPI takes, whatever their numbers are."""
    return rows.reshape(-1).view(np.uint8)
