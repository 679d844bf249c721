"""Certificates taken block by block of rows: to the bit those of passes over all rows, in less memory."""

import tracemalloc

import numpy as np
import pytest
from membranes_by_rows import CASES
from peers import alone, by_peers, in_the_place_of_ranks

import contactqp as cq
from contactqp.proof.enclosure import Base, enclosure_about, multiples, proven


@pytest.fixture(autouse=True)
def threads_in_the_place_of_processes(monkeypatch):
    in_the_place_of_ranks(monkeypatch)


def tension(x, y):
    return 1.0 + 0.5 * np.sin(7 * x) * np.cos(5 * y)


def parted():
    """Two islands with more rows between them than a block has, under a ceiling that only the first one has."""

    def ceiling(x, y):
        return np.where(y < 0.5, -0.001, -np.inf)

    def islands(x, y):
        return np.abs(y - 0.6) > 0.25

    def load(x, y):
        return np.where(y < 0.4, -1.0, 1.0)

    return cq.mpi.MembraneByRows(
        (120, 30), 0.01, tension, load=load, support=lambda x, y: 0.0 * x + 0.001, ceiling=ceiling, mask=islands
    )


def below():
    """Between two surfaces, of which the upper one covers the first rows alone."""
    membrane = CASES["between"]()
    fields = {name: field for name, field in membrane.given.items() if name not in ("mask", "foundation")}
    return cq.mpi.MembraneByRows(membrane.shape, membrane.spacing, tension, **fields)


MADE = {"patched": CASES["patched"], "woven": CASES["woven"], "parted": parted, "below": below}


@pytest.mark.parametrize("name", MADE)
def test_blocks_enclose_what_passes_over_all_rows_enclose(name):
    answer = cq.mpi.solve(MADE[name](), alone(), tol=1e-8)
    problem, gap, barrier = answer.posed.problem, answer.measures.gap, answer.posed.barrier
    base = Base.of(problem, gap)
    found = multiples(problem, base, barrier.v, barrier.s)
    enclosure = enclosure_about(gap, problem.bounds, base, barrier.v, found, barrier.kind)
    whole, certificate = proven(problem, enclosure), answer.certificate
    assert certificate.gap_bound == float(whole.error_bound)
    for own, wanted in (
        (certificate.lower, whole.lower),
        (certificate.upper, whole.upper),
        (certificate.contact, whole.contact),
        (certificate.clear, whole.clear),
    ):
        np.testing.assert_array_equal(own, wanted)
    assert answer.node_counts[0] > 0


@pytest.mark.parametrize("name", ["parted", "below"])
def test_bounds_do_not_depend_on_who_has_a_ceiling(name):
    """Where one process has a ceiling in its rows, and another has none."""

    def one(peer):
        answer = cq.mpi.solve(MADE[name](), peer, tol=1e-8, least_rows=16)
        return [field.tobytes() for field in (answer.gap, *answer.gap_bounds, answer.contact_state)], answer.gap_bound

    (whole,), parts = by_peers(1, one), by_peers(3, one)
    assert [b"".join(fields) for fields in zip(*(fields for fields, _ in parts), strict=True)] == whole[0]
    assert {bound for _, bound in parts} == {whole[1]}


def test_a_certificate_needs_little_memory_beside_itself():
    membrane = cq.mpi.MembraneByRows((400, 300), 0.01, tension, load=1.0, support=0.05)
    answer = cq.mpi.solve(membrane, alone())
    posed, gap = answer.posed, answer.measures.gap

    def peak(work):
        tracemalloc.start()
        try:
            kept = work()
            return tracemalloc.get_traced_memory()[1] / gap.size, kept
        finally:
            tracemalloc.stop()

    measuring, measures = peak(lambda: posed.measures(gap, 1))
    enclosing, _ = peak(measures.certificate)
    assert measuring < 20  # bytes a node, of blocks that have four in a hundred of the nodes
    assert enclosing < 20 + 40  # of the enclosure itself 19
