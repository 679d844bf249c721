"""Predictions from earlier answers: exact where they can be, close where contact moves, and never more than a start."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import m_matrices

import contactqp as cq
from contactqp.models.varied import with_load
from contactqp.solving.prediction import Trail

FREE = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, -1.0])
BOWL = cq.gallery.bowl(63)


def trail_of(problem, *forces):
    trail = Trail()
    for q in forces:
        varied = problem.with_forces(q)
        trail.add(varied, cq.solve(varied, "active-set").gap)
    return trail


@given(m_matrices(max_size=6), st.floats(-0.99, 1.99).filter(lambda steps: abs(steps) > 1e-3), st.integers(0, 99))
def test_gaps_without_contact_are_extrapolated_exactly(matrix, steps, seed):
    first, change = np.random.default_rng(seed).uniform(0.5, 1.0, (2, len(matrix)))
    problem = cq.ContactQP(matrix, -first - 3 * change)
    trail = trail_of(problem, problem.q, problem.q - change)
    goal = problem.with_forces(problem.q - (1 + steps) * change)
    gap, foresees = trail.predicted(goal)
    assert foresees
    np.testing.assert_allclose(gap, np.linalg.solve(matrix, -goal.q), rtol=1e-7)


def test_nothing_is_predicted_from_one_answer_or_from_forces_that_turn():
    one = trail_of(FREE, [-1.0, -1.0])
    assert one.predicted(FREE.with_forces([-2.0, -2.0])) is None
    two = trail_of(FREE, [-1.0, -1.0], [-2.0, -2.0])
    assert two.predicted(FREE.with_forces([-3.0, -3.1])) is None
    assert two.predicted(FREE.with_forces([-3.0, -3.0])) is not None
    assert two.predicted(FREE.with_forces([-2.0, -2.0])) is None
    assert two.predicted(FREE.with_forces([-9.0, -9.0])) is None


def test_a_turn_begins_a_new_trail_at_the_last_answer():
    trail = trail_of(FREE, [-1.0, -1.0], [-2.0, -2.0], [-2.0, -1.0])
    assert trail.predicted(FREE.with_forces([-3.0, -1.0])) is None
    gap, _ = trail.predicted(FREE.with_forces([-2.0, -0.5]))
    np.testing.assert_allclose(gap, np.linalg.solve(FREE.G.toarray(), [2.0, 0.5]))


def test_an_answer_for_the_same_forces_replaces_the_one_before():
    trail = trail_of(FREE, [-1.0, -1.0], [-2.0, -2.0], [-2.0, -2.0])
    gap, _ = trail.predicted(FREE.with_forces([-3.0, -3.0]))
    np.testing.assert_allclose(gap, [3.0, 3.0])
    again = trail_of(FREE, [-1.0, -1.0], [-1.0, -1.0])
    assert again.predicted(FREE.with_forces([-2.0, -2.0])) is None


def test_other_bounds_end_a_trail():
    trail = trail_of(FREE, [-1.0, -1.0], [-2.0, -2.0])
    bounded = cq.ContactQP(FREE.G, [-3.0, -3.0], upper=1.0)
    assert trail.predicted(bounded) is None
    trail.add(bounded, np.ones(2))
    assert trail.predicted(FREE.with_forces([-3.0, -3.0])) is None


def predicted_bowl(loads, goal):
    trail = Trail()
    for load in loads:
        model = with_load(BOWL, load)
        trail.add(model.problem, cq.solve(model, "active-set").gap)
    model = with_load(BOWL, goal)
    return trail.predicted(model.problem), cq.solve(model, "active-set").gap


@pytest.mark.parametrize(("loads", "error"), [((0.5, 0.55), 1e-3), ((0.45, 0.5, 0.55), 2e-4)])
def test_where_contact_grows_the_free_boundary_moves_on(loads, error):
    (gap, foresees), exact = predicted_bowl(loads, 0.6)
    last = cq.solve(with_load(BOWL, loads[-1]), "active-set").gap
    moved = np.count_nonzero((last > 0) != (exact > 0))
    assert foresees
    assert moved > 50
    assert np.count_nonzero((gap > 0) != (exact > 0)) < 0.5 * moved  # a straight line: more than moved
    assert np.abs(gap - exact).max() < error


def test_where_contact_shrinks_it_is_said_that_nothing_foresees_it():
    (gap, foresees), exact = predicted_bowl((0.6, 0.55), 0.5)
    assert not foresees
    assert (gap >= 0).all()
    assert np.abs(gap - exact).max() < 0.05


def test_bounds_of_all_kinds_are_kept():
    lower, upper = np.array([-1.0, -np.inf, 0.5, 0.0]), np.array([2.0, np.inf, 3.0, np.inf])
    matrix = 2 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1)
    problem = cq.ContactQP(matrix, np.zeros(4), lower=lower, upper=upper)
    # Loads that push the first unknown from its lower bound to its upper one.
    trail = trail_of(problem, [1.0, 0.0, 0.0, 0.5], [-1.0, 0.0, 0.0, 0.5])
    gap, _ = trail.predicted(problem.with_forces([-3.0, 0.0, 0.0, 0.5]))
    assert ((lower <= gap) & (gap <= upper)).all()


@pytest.mark.parametrize("backend", ["multigrid", "active-set", "osqp", "psor", "clarabel"])
def test_sessions_answer_as_cold_solves_do_up_and_down(backend):
    loads = [0.3, 0.4, 0.5, 0.6, 0.5, 0.4, 0.45, 0.45, 0.9]
    model = cq.gallery.bowl(31)
    solver = cq.Solver(model, backend)
    for load in loads:
        warm = solver.solve_varied(with_load(model, load))
        cold = cq.solve(with_load(model, load), backend)
        assert warm.status == cold.status == "certified"
        assert np.abs(warm.gap - cold.gap).max() <= warm.certificate.gap_bound + cold.certificate.gap_bound


@pytest.mark.slow
def test_a_path_takes_fewer_cycles_than_cold_solves():
    model = cq.gallery.bowl(255)
    loads = np.linspace(0.5, 1.0, 11)
    path = cq.trace(model, loads=loads, backend="multigrid", cold=True)
    warm, cold = (np.sum(count[3:]) for count in (path.to_frame()["iterations"], path.to_frame()["cold_iterations"]))
    assert warm < cold


def test_a_step_that_is_lost_in_rounding_does_not_end_a_session():
    q = np.array([-1.0, 3.0])
    solver = cq.Solver(cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], q))
    for factor in (1.0, 0.0, 1e-17, 1.0):
        solution = solver.solve(q=factor * q)
        np.testing.assert_allclose(solution.gap, [0.5 * factor, 0.0], rtol=1e-12)


def test_a_way_there_and_back_has_no_parabola():
    base = np.linspace(-1.0, 3.0, 40)
    problem = cq.ContactQP(np.eye(40), -base)
    trail = trail_of(problem, *(-base - factor for factor in (1.0, 2.0, 1.0)))
    gap, _ = trail.predicted(problem.with_forces(-base - 0.5))
    assert np.abs(gap - np.maximum(base + 0.5, 0.0)).max() < 1.0
