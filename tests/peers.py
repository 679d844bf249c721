"""Threads of one process in the place of processes, for tests of what is divided among them."""

import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from functools import cached_property

from contactqp.geometry.on_contour import FrameFit
from contactqp.mpi.answer import AnswerByRows
from contactqp.mpi.barriers import PartOfParabola
from contactqp.mpi.posed import PosedByRows
from contactqp.mpi.ranks import Ranks


class _Party:
    def __init__(self, size):
        self.size, self.barrier, self.told = size, threading.Barrier(size, timeout=60), [None] * size
        self.parts = []

    def abort(self):
        self.barrier.abort()
        for part in self.parts:
            part.abort()


class Peer:
    """One of them: what `contactqp.mpi.ranks.Ranks` is among processes."""

    agreed, messages, sent = Ranks.agreed, 0, 0

    def __init__(self, party, rank):
        self._party, self.rank, self.size = party, rank, party.size

    def _everyone_tells(self, what):
        party = self._party
        party.told[self.rank] = what
        party.barrier.wait()
        told = list(party.told)
        party.barrier.wait()
        return told

    def everyones(self, found):
        return [one for part in self._everyone_tells(list(found)) for one in part]

    def exchange(self, given, wanted):
        told = self._everyone_tells({other: array.copy() for other, array in given})
        for other, array in wanted:
            array[...] = told[other].pop(self.rank)
        assert not any(self.rank in left for left in told)

    def every(self, step):
        count = self.size // step
        part = self._everyone_tells(_Party(count) if self.rank == 0 else None)[0]
        self._party.parts.append(part)
        chosen = self.rank % step == 0 and self.rank // step < count
        return Peer(part, self.rank // step) if chosen else None


def by_peers(size, work):
    """Return what ``work(peer)`` returns for each of ``size`` peers, which work at the same time."""
    party = _Party(size)

    def one(rank):
        try:
            return work(Peer(party, rank))
        except BaseException:
            party.abort()
            raise

    with ThreadPoolExecutor(size) as pool:
        return [found.result() for found in [pool.submit(one, rank) for rank in range(size)]]


def alone():
    """Return the only peer of its party."""
    return by_peers(1, lambda peer: peer)[0]


def in_the_place_of_ranks(monkeypatch):
    """Let `contactqp.mpi` take a peer for the communicator that it is given."""
    for module in ("cases", "solve", "solver"):  # as modules: functions have taken their names
        monkeypatch.setattr(sys.modules[f"contactqp.mpi.{module}"], "Ranks", lambda peer: peer)
    without_locks(monkeypatch, AnswerByRows, PosedByRows, PartOfParabola, FrameFit)


def without_locks(monkeypatch, *kinds):
    """Let threads that wait for each other ask for properties: before Python 3.12 there is one lock for all objects."""
    for kind in kinds:
        for each in vars(kind).values():
            if isinstance(each, cached_property):
                monkeypatch.setattr(each, "lock", nullcontext(), raising=False)
