"""Warm starts that have outlived their forces, and subjects that are none of a session's."""

import numpy as np
import pytest

import contactqp as cq
from contactqp.solving.starts import useful_start

HEXAGON = cq.gallery.paper_hexagon().problem
BARE = cq.ContactQP(HEXAGON.G, HEXAGON.q)
ON_LATTICE = cq.ContactQP(HEXAGON.stiffness, HEXAGON.q)


def after_a_fall(problem, backend, factor):
    """Return what a session and a cold solve find once forces have fallen."""
    session = cq.Solver(problem, backend)
    session.solve()
    fallen = problem.with_forces(problem.q * factor)
    return session.solve_varied(fallen), cq.solve(fallen, backend)


@pytest.mark.parametrize("factor", [1e-3, 1e-60])
@pytest.mark.parametrize("backend", ["osqp", "clarabel", "psor", "active-set"])
def test_after_forces_have_fallen_a_session_is_no_worse_than_a_cold_solve(backend, factor):
    warm, cold = after_a_fall(BARE, backend, factor)
    assert warm.status == "certified"
    assert warm.iterations <= cold.iterations


@pytest.mark.parametrize("backend", ["osqp", "psor", "multigrid", "active-set"])
def test_neither_is_it_on_a_lattice(backend):
    warm, cold = after_a_fall(ON_LATTICE, backend, 1e-60)
    assert warm.status == "certified"
    assert warm.iterations <= cold.iterations


def test_one_rule_drops_starts_for_all_backends(monkeypatch):
    """What a backend is told to start from, go on from and foresee is decided before it is asked."""
    told = []

    def told_of(self, problem, units, bound, **given):
        told.append(tuple(given.get(name) for name in ("warm_start", "resumes", "predicted")))
        return original(self, problem, units, bound, **given)

    original = cq.solving.request.Request.task
    monkeypatch.setattr(cq.solving.request.Request, "task", told_of)
    session = cq.Solver(BARE, "active-set")
    for factor in (1.0, 0.9, 0.8, 1e-9):
        session.solve(q=factor * BARE.q)
    start, *rest = told[-1]
    assert start is None
    assert rest == [False, False]


def test_a_start_is_measured_from_the_admissible_gap_nearest_to_zero():
    scaled, units = cq.ContactQP(np.eye(2), [0.0, -3.0], lower=[2.0, 0.0]).scaled()
    assert useful_start(np.array([2.0, 0.0]), scaled, units) is not None
    assert useful_start(np.array([2.0, 5.9]), scaled, units) is not None
    assert useful_start(np.array([2.0, 6.1]), scaled, units) is None
    assert useful_start(np.array([-9.0, 3.0]), scaled, units) is not None  # projected before it is measured
    assert useful_start(np.array([2.0, 1e300]), scaled, units) is None


def test_forces_of_a_session_keep_the_gap_scale_that_the_problem_was_given():
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0], gap_scale=0.25)
    found = cq.Solver(problem).solve(q=[-2.0, 3.0]).problem
    assert found.gap_scale == found.own_gap_scale == 0.25
    anew = cq.Solver(problem.with_forces(problem.q)).solve(q=[-2.0, 3.0]).problem
    assert anew.own_gap_scale is None
    assert anew.gap_scale == cq.ContactQP(problem.G, [-2.0, 3.0]).gap_scale


def cable(count):
    return cq.Cable(nodes=count, spacing=1.0, tension=1.0, load=1.0, support=1.0)


def square(side, shift=0.0):
    frame = cq.Frame.rectangle(side, side, center=(shift, 0.0))
    return cq.Membrane(frame.lattice(spacing=1.0), tension=1.0, load=1.0, support=0.9)


def net(length):
    positions = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0 + length, 0.0)]
    return cq.CableNet(positions, [(0, 1), (1, 2), (2, 3)], 1.0, load=1.0, support=0.1, fixed=[0, 3])


@pytest.mark.parametrize(
    ("own", "other", "told"),
    [
        (BARE, cq.ContactQP(np.eye(3), np.ones(3)), r"1857 of ContactQP\(1857 .*has 3: ContactQP\(3 unknowns"),
        (cable(9), cable(8), r"9 of Cable\(9 nodes.*has 8: Cable\(8 nodes"),
        (square(4), cable(9), r"9 of Membrane\(9 nodes.*has 9, at other places: Cable\(9 nodes"),
        (net(1.0), cq.CableNet([(0, 0), (1, 1), (2, 1), (3, 0)], [(0, 1), (1, 2), (2, 3)], 1.0, load=1.0, support=0.1,
                               fixed=[0, 3]), r"2 of CableNet.*has 2, at other places: CableNet"),
    ],
)  # fmt: skip
def test_a_subject_of_other_unknowns_is_refused(own, other, told):
    session = cq.Solver(own)
    with pytest.raises(ValueError, match=f"subject must have the unknowns.*{told}.*; make a Solver for it"):
        session.solve_varied(other)


@pytest.mark.parametrize(
    ("own", "other"),
    [
        (square(4), square(4, shift=64.0)),
        (cable(9), cq.Cable(nodes=9, spacing=1.0, tension=2.0, load=1.0, support=1.0)),
        (net(1.0), net(2.0)),
        (cable(3), cq.ContactQP(cable(3).problem.G, [1.0, -1.0, 1.0])),
    ],
)
def test_a_subject_of_the_same_unknowns_is_not(own, other):
    assert cq.Solver(own).solve_varied(other).status == "certified"
