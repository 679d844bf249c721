"""What processes send in a cycle, as it is counted on paper, against what they send."""

import importlib.util
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import peers
import pytest

import contactqp as cq
from contactqp.methods.multigrid.contact import ContactMultigrid
from contactqp.methods.multigrid.strips import Strip

ROOT = Path(__file__).resolve().parents[2]


def loaded():
    """Return the module of the tool."""
    spec = importlib.util.spec_from_file_location("scaling", ROOT / "tools" / "scaling.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["scaling"] = module
    spec.loader.exec_module(module)
    return module


scaling = loaded()


class CountingPeer(peers.Peer):
    """A peer that counts as `contactqp.mpi.ranks.Ranks` does."""

    def _count(self, messages, sent):
        self.messages += messages
        self.sent += sent

    def everyones(self, found):
        if self.size > 1:
            self._count(1, scaling.TOLD)
        return super().everyones(found)

    def exchange(self, given, wanted):
        self._count(len(given), sum(array.nbytes for _, array in given))
        super().exchange(given, wanted)

    def every(self, step):
        found = super().every(step)
        if found is not None:
            found._count = self._count
        return found


@pytest.fixture
def counted(monkeypatch):
    """Return what each process sends in the cycles of a lattice in which no node comes into contact or leaves it."""
    peers.in_the_place_of_ranks(monkeypatch)
    monkeypatch.setattr(peers, "Peer", CountingPeer)
    corrected = ContactMultigrid.correct
    seen: dict[tuple[int, int], list[tuple[int, int, int]]] = {}

    def correct(self):
        part = self.lattice.part
        if isinstance(part, Strip):
            peer: Any = part._peers
            key = peer.rank, self.lattice.layout.mask.shape[1]
            seen.setdefault(key, []).append((peer.messages, peer.sent, int(self.changes)))
        corrected(self)

    monkeypatch.setattr(ContactMultigrid, "correct", correct)

    def run(rows, columns, ranks, least):
        membrane = cq.mpi.MembraneByRows((rows, columns), 1 / 256, 1.0, load=1.0, support=0.05)
        # So small a tolerance that the judge is not asked in these cycles.
        peers.by_peers(ranks, lambda peer: cq.mpi.solve(membrane, peer, tol=1e-15, least_rows=least, max_iter=14))
        found = []
        for rank in range(ranks):
            told = seen[rank, columns]
            steps = pairwise(told)
            found.append({(after[0] - before[0], after[1] - before[1]) for before, after in steps if not before[2]})
        return found

    return run


@pytest.mark.parametrize(
    ("rows", "columns", "ranks", "least"),
    [(255, 255, 2, 16), (511, 255, 3, 16), (255, 127, 2, 64), (160, 40, 9, 16), (200, 63, 7, 64)],
)
def test_what_is_counted_on_paper_is_what_is_sent(counted, rows, columns, ranks, least):
    for rank, cycles in enumerate(counted(rows, columns, ranks, least)):
        paper = scaling.cycle(rows, columns, ranks, rank, least)
        messages, sent = paper.messages + paper.tellings, paper.sent + scaling.TOLD * paper.tellings
        assert (messages, sent) in cycles
        assert min(cycles) == (messages, sent)  # others were judged as well


def test_one_process_sends_nothing():
    paper = scaling.cycle(255, 255, 1, 0)
    assert (paper.messages, paper.sent, paper.tellings) == (0, 0, 0)


def test_the_tables_of_the_page_are_those_of_the_tool():
    page = (ROOT / "docs" / "howto" / "cluster.md").read_text(encoding="utf-8")
    assert all(table in page for table in scaling.tables().values())


def test_by_hand():
    """Two processes and one divided level; below, the first has 32 rows of the residual and gives the correction back.

    Two exchanges on the lattice; one of two rows and two more on the level; two times to the first, and two times back.
    """
    first, second = (scaling.cycle(127, 127, 2, rank, 16) for rank in (0, 1))
    assert (first.messages, second.messages) == (2 + 3 + 2, 2 + 3 + 2)
    on_lattice, on_level = 2 * 6 * 129 * 8, 3 * 2 * 65 * 4
    assert second.sent == on_lattice + on_level + 2 * (32 + 1 - 16) * 33 * 4
    assert first.sent == on_lattice + on_level + 2 * (32 + 1 - 16 + 2) * 33 * 4
