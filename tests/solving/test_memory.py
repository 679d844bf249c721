"""What building and solving a large lattice keeps in memory, by numpy's own account, in bytes a node."""

import tracemalloc
from collections.abc import Callable
from typing import Any

import pytest

import contactqp as cq
from contactqp.algebra import stencil
from contactqp.geometry import fields

NODES = 511
"""A side: so many that rows and columns, and what a process takes anyway, hardly count."""


def measured(work: Callable[[], Any]) -> tuple[Any, float, float]:
    """Return what work returns, and what it keeps and takes at most beyond what there was before it (bytes a node)."""
    before, _ = tracemalloc.get_traced_memory()
    tracemalloc.reset_peak()
    result = work()
    kept, peak = tracemalloc.get_traced_memory()
    return result, (kept - before) / NODES**2, (peak - before) / NODES**2


@pytest.fixture
def traced(monkeypatch):
    # What each thread works on at a time counts little on a lattice that is larger.
    monkeypatch.setattr(fields, "_POINTS_OF_STRIP", 1 << 12)
    monkeypatch.setattr(stencil, "_POINTS_AT_ONCE", 1 << 12)
    cq.solve(cq.gallery.bowl(255), "multigrid")  # loads, compiles and keeps what is kept once
    tracemalloc.start()
    yield
    tracemalloc.stop()


def test_a_large_lattice_takes_eighty_bytes_a_node_with_model_and_answer(traced):
    model, model_kept, model_peak = measured(lambda: cq.gallery.bowl(NODES))
    assert model_kept <= 10  # the support, and where the nodes are
    assert model_peak <= 20
    _, problem_kept, problem_peak = measured(lambda: model.problem.gap_scale)
    assert problem_kept <= 10  # the forces
    assert problem_peak <= 34
    solution, answer_kept, solve_peak = measured(lambda: cq.solve(model, "multigrid", tol=1e-6))
    assert solution.status is cq.Status.CERTIFIED
    assert answer_kept <= 27  # the gap, its bounds, and what is certain
    assert model_kept + problem_kept + solve_peak <= 80


def test_a_support_without_arrays_takes_no_memory_for_what_is_the_same_everywhere(traced):
    lattice = cq.Frame.rectangle(1.0, 1.0).lattice(1 / (NODES + 1))
    _, kept, peak = measured(lambda: cq.Membrane(lattice, tension=1.0, load=1.0, support=0.02))
    assert kept <= 1.5
    assert peak <= 4
