"""Ranks: the processes of an MPI communicator, as the strips of a lattice need them."""

from __future__ import annotations

import pickle
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
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
        How many messages this process has sent to others or to all, and how many bytes: what goes to all counts once,
        whatever way MPI takes.

    Raises
    ------
    ImportError
        If mpi4py is not installed.
    """

    def __init__(self, comm: MPI.Comm | None = None) -> None:
        needed("mpi4py", "working in several processes", INSTALL)
        from mpi4py import MPI

        self.comm, self._aside, self._every = _kept(MPI.COMM_WORLD if comm is None else comm)
        self.rank, self.size = self.comm.Get_rank(), self.comm.Get_size()
        self._traffic = _Traffic()

    @property
    def messages(self) -> int:
        """Messages sent so far."""
        return self._traffic.messages

    @property
    def sent(self) -> int:
        """Bytes in them."""
        return self._traffic.sent

    def every(self, step: int) -> Ranks | None:
        """Return every ``step``-th process, ``size // step`` of them, if this is one of them; all must call it."""
        from mpi4py import MPI

        if step not in self._every:
            chosen = self.rank % step == 0 and self.rank // step < self.size // step
            self._every[step] = self.comm.Split(0 if chosen else MPI.UNDEFINED, self.rank)
        if self._every[step] == MPI.COMM_NULL:
            return None
        found = Ranks(self._every[step])
        found._traffic = self._traffic
        return found

    def everyones(self, found: list[_Found]) -> list[_Found]:
        """Return what all have found, one after the other: by one message where that is little, else by two."""
        if self.size == 1:
            return found
        told = np.frombuffer(pickle.dumps(found), dtype=np.uint8)
        own, all_told = np.zeros(_LITTLE, np.uint8), np.empty((self.size, _LITTLE), np.uint8)
        own[:8] = np.array([told.size]).view(np.uint8)
        if told.size <= _LITTLE - 8:
            own[8 : 8 + told.size] = told
        self._wait([self.comm.Iallgather(own, all_told)], 1, _LITTLE)
        sizes = all_told[:, :8].copy().view(np.int64).ravel()
        if sizes.max() <= _LITTLE - 8:
            parts = [all_told[k, 8 : 8 + size] for k, size in enumerate(sizes)]
        else:
            ends = np.cumsum(sizes)
            together = np.empty(ends[-1], np.uint8)
            places = sizes.tolist(), (ends - sizes).tolist()
            self._wait([self.comm.Iallgatherv(told, [together, places])], 1, told.size)
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

    def exchange(self, given: list[tuple[int, NDArray[Any]]], wanted: list[tuple[int, NDArray[Any]]]) -> None:
        """Send arrays to some of the others, and write what some of the others send; these must call it, too."""
        left = [(other, np.ascontiguousarray(array)) for other, array in given]
        come = [(other, np.empty(array.shape, array.dtype)) for other, array in wanted]
        requests = [self.comm.Irecv(_as_bytes(array), other) for other, array in come]
        requests += [self.comm.Isend(_as_bytes(array), other) for other, array in left]
        self._wait(requests, len(left), sum(array.nbytes for _, array in left))
        for (_, array), (_, found) in zip(wanted, come, strict=True):
            array[...] = found

    def _wait(self, requests: list[MPI.Request], messages: int, sent: int) -> None:
        """Wait for messages, and count those that are sent.

        MPI's own waiting takes a whole core, which others may need where there are more processes than cores, and does
        not answer Ctrl-C. Between two questions a tenth of the time goes by that has gone by before.
        """
        from mpi4py import MPI

        self._traffic.messages += messages
        self._traffic.sent += sent
        began = time.perf_counter()
        while not MPI.Request.Testall(requests):
            if (waited := time.perf_counter() - began) > _SPINNING:
                time.sleep(min(waited / 10, _LONGEST_NAP))


@dataclass
class _Traffic:
    """What a process has sent, by whichever communicator."""

    messages: int = 0
    sent: int = 0


def _kept(comm: MPI.Comm) -> tuple[MPI.Comm, MPI.Comm, dict[int, MPI.Comm]]:
    """Return two duplicates of a communicator, and those of every second process, and so on, by their step.

    The same ones whenever they are asked for: MPI has few to give.
    """
    key = _key()
    known: Any = comm.Get_attr(key)
    if known is None:
        known = comm.Dup(), comm.Dup(), {}
        comm.Set_attr(key, known)
    return cast("tuple[MPI.Comm, MPI.Comm, dict[int, MPI.Comm]]", known)


@cache
def _key() -> int:
    from mpi4py import MPI

    return MPI.Comm.Create_keyval()


def _as_bytes(rows: NDArray[Any]) -> NDArray[np.uint8]:
    """Return rows as bytes, which every MPI takes, whatever their numbers are."""
    return rows.reshape(-1).view(np.uint8)
