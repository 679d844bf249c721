"""Many problems in one call: each answer as if solved alone, and one session for a matrix."""

import numpy as np
import pytest

import contactqp as cq
from contactqp.backends.active_set import ActiveSetBackend

G = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]])


class Counting(ActiveSetBackend):
    prepared = 0

    def prepare(self, problem, task, *, history=False):
        Counting.prepared += 1
        return super().prepare(problem, task, history=history)


@pytest.fixture
def counting(monkeypatch):
    monkeypatch.setattr(Counting, "prepared", 0)
    return Counting()


def forces(count, seed=1):
    return np.random.default_rng(seed).normal(size=(count, 3))


def test_each_answer_is_the_problems_own():
    problems = [cq.ContactQP(G, q) for q in forces(20)]
    for problem, solution in zip(problems, cq.solve_many(problems), strict=True):
        assert solution.subject is problem
        assert solution.status is cq.Status.CERTIFIED
        np.testing.assert_allclose(solution.gap, cq.solve(problem).gap, atol=1e-12)


def test_equal_matrices_share_a_session_wherever_they_stand(counting):
    other = 2 * np.eye(3)
    problems = [cq.ContactQP(matrix, q) for q in forces(5) for matrix in (G, other)]
    solutions = cq.solve_many(problems, counting)
    assert counting.prepared == 2
    assert all(solution.status.ok for solution in solutions)
    for problem, solution in zip(problems[1::2], solutions[1::2], strict=True):
        np.testing.assert_allclose(solution.gap, np.maximum(-problem.q / 2, 0.0), atol=1e-12)


def test_other_kinds_of_bounds_are_prepared_for_and_answered(counting):
    problems = [cq.ContactQP(G, [-1.0, 3.0, -1.0], upper=[upper, 1.0, np.inf]) for upper in (0.1, 0.2)]
    problems.append(cq.ContactQP(G, [-1.0, 3.0, -1.0]))
    gaps = [solution.gap for solution in cq.solve_many(problems, counting)]
    assert counting.prepared == 2
    np.testing.assert_allclose(gaps, [[0.1, 0.0, 0.5], [0.2, 0.0, 0.5], [0.5, 0.0, 0.5]], atol=1e-12)


def test_models_made_one_by_one_share_a_session(counting):
    lattice = cq.Frame.rectangle(4, 4).lattice(spacing=1.0)
    models = [cq.Membrane(lattice, tension=1.0, load=load, support=0.9) for load in (0.2, 1.0, 3.0)]
    solutions = cq.solve_many(models, counting)
    assert counting.prepared == 1
    assert [solution.model for solution in solutions] == models
    alone = [int(cq.solve(model).contact.sum()) for model in models]
    assert [int(solution.contact.sum()) for solution in solutions] == alone


def test_another_tension_is_another_matrix(counting):
    lattice = cq.Frame.rectangle(4, 4).lattice(spacing=1.0)
    models = [cq.Membrane(lattice, tension=tension, load=1.0, support=9.0) for tension in (1.0, 2.0)]
    soft, stiff = (solution.deflection.max() for solution in cq.solve_many(models, counting))
    assert counting.prepared == 2
    assert soft == pytest.approx(2 * stiff)


def test_nothing_is_solved_of_nothing():
    assert cq.solve_many([]) == []


def test_one_problem_is_no_list():
    with pytest.raises(TypeError, match="iterable of problems"):
        cq.solve_many(cq.ContactQP(G, np.ones(3)))


def test_an_item_that_is_no_problem_is_named():
    with pytest.raises(TypeError, match="got str"):
        cq.solve_many(["G"])


def test_failures_are_raised_where_that_is_asked_for():
    problems = [cq.ContactQP(G, -np.ones(3))]
    with pytest.raises(cq.NotCertifiedError):
        cq.solve_many(problems, "psor", max_iter=1, tol=1e-12, on_failure="raise")


def test_facts_are_shared_with_an_equal_matrix_only():
    one, other = cq.ContactQP(G, np.ones(3)), cq.ContactQP(G + np.diag([1e-15, 0, 0]) * 4, np.ones(3))
    assert not other.share_facts(one)
    assert other.facts is not one.facts
    assert cq.ContactQP(G, -np.ones(3)).share_facts(one)
