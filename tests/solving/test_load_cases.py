"""Many loads of one matrix at once: each answer, status and bound as if it were solved by itself."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rational import adversarial_problem, assert_certificate_holds, exact_solution, m_matrix
from strategies import bounds, m_matrices

import contactqp as cq
from contactqp.backends.active_set import ActiveSetBackend
from contactqp.backends.base import CaseAnswers, State
from contactqp.solving.solver import Solver

pytest.importorskip("contactqp.methods.active_set.case_kernels")  # once loaded, few loads are worth it, too


def assert_as_alone(solutions, problems, **options):
    for solution, problem in zip(solutions, problems, strict=True):
        alone = cq.solve(problem, on_failure="ignore", **options)
        assert solution.status is alone.status
        assert solution.backend == alone.backend
        assert solution.note == alone.note
        bound = solution.certificate.gap_bound + alone.certificate.gap_bound
        np.testing.assert_allclose(solution.gap, alone.gap, rtol=0, atol=bound * (1 + 1e-12))
        assert solution.certificate.intersects(alone.certificate)
        first, other = solution.verdict, alone.verdict
        # Both are exact to rounding, and so are their bounds: neither is worth much less than the other.
        assert first.scale == pytest.approx(other.scale, rel=1e-6)
        assert (solution.run.gap == solution.gap).all()


@pytest.fixture
def alone(monkeypatch):
    """Count the problems that are solved each by itself."""
    counted = []
    solve_varied = Solver.solve_varied

    def counting(self, subject, *arguments):
        counted.append(subject)
        return solve_varied(self, subject, *arguments)

    monkeypatch.setattr(Solver, "solve_varied", counting)
    return counted


def forces_of(rng, matrix, count):
    """Return forces of all kinds: random, of sizes far apart, biactive, pressing alone, none."""
    size = len(matrix)
    gap = np.maximum(rng.normal(size=(count, size)), 0.0)
    press = np.where(gap == 0, np.maximum(rng.normal(size=(count, size)), 0.0), 0.0)
    kind = rng.integers(0, 6, count)
    return np.select(
        [kind[:, None] == k for k in range(5)],
        [
            rng.normal(size=(count, size)),
            rng.normal(size=(count, size)) * 10.0 ** rng.uniform(-8, 8, (count, 1)),
            press - gap @ matrix,
            np.abs(rng.normal(size=(count, size))),
            -np.abs(rng.normal(size=(count, size))),
        ],
        np.zeros((count, size)),
    )


@given(m_matrices(max_size=12), st.integers(0, 2**32 - 1))
def test_each_is_answered_as_by_itself(matrix, seed):
    rng = np.random.default_rng(seed)
    problems = [cq.ContactQP(matrix, q) for q in forces_of(rng, matrix, 12)]
    assert_as_alone(cq.solve_many(problems, on_failure="ignore"), problems)


@given(m_matrices(max_size=12), st.integers(0, 2**32 - 1))
def test_each_is_answered_as_by_itself_with_nodes_without_support(matrix, seed):
    rng = np.random.default_rng(seed)
    supported = rng.uniform(size=len(matrix)) < 0.6
    first = cq.ContactQP(matrix, np.zeros(len(matrix)), supported=supported)
    problems = [first.with_forces(q) for q in forces_of(rng, matrix, 12)]
    assert_as_alone(cq.solve_many(problems, on_failure="ignore"), problems)


@given(st.data())
def test_each_is_answered_as_by_itself_between_two_bounds(data):
    matrix = data.draw(m_matrices(max_size=8))
    lower, upper = data.draw(bounds(len(matrix)))
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    problems = [cq.ContactQP(matrix, q, lower, upper) for q in forces_of(rng, matrix, 12)]
    assert_as_alone(cq.solve_many(problems, on_failure="ignore"), problems)


@given(st.integers(0, 2**32 - 1))
def test_bounds_hold_in_rational_numbers(seed):
    rng = np.random.default_rng(seed)
    first = adversarial_problem(rng, largest=4)
    problems = [first, *(first.with_forces(first.q * rng.choice([0.0, 1.0, -1.0, 2.0**-30])) for _ in range(3))]
    problems += [first.with_forces(rng.normal(size=first.size)) for _ in range(4)]
    for problem, solution in zip(problems, cq.solve_many(problems, on_failure="ignore"), strict=True):
        gap, reaction = exact_solution(problem, solution.gap > 0)
        judged = solution.verdict.certificate
        if solution.finite and judged is not None:
            assert_certificate_holds(judged, gap, reaction, solution.gap)
        error = max(abs(Fraction(float(own)) - true) for own, true in zip(solution.gap, gap, strict=True))
        if solution.status.ok:
            assert error <= Fraction(solution.tol) * Fraction(solution.verdict.scale)


@given(st.integers(0, 2**32 - 1))
def test_bounds_hold_in_rational_numbers_between_two_bounds(seed):
    rng = np.random.default_rng(seed)
    matrix = m_matrix(rng, rng.integers(1, 4))
    low = rng.choice([0.0, -1.0, 1.0, -np.inf], len(matrix))
    high = np.where(np.isfinite(low), low, 0.0) + rng.choice([0.0, 0.5, 2.0, np.inf], len(matrix))
    problems = [cq.ContactQP(matrix, q, low, high) for q in rng.normal(size=(6, len(matrix)))]
    for problem, solution in zip(problems, cq.solve_many(problems, on_failure="ignore"), strict=True):
        gap, reaction = exact_solution(problem)
        if solution.verdict.certificate is not None:
            assert_certificate_holds(solution.verdict.certificate, gap, reaction, solution.gap)


def test_they_are_answered_together(alone):
    problem = cq.ContactQP(np.array([[2.0, -1.0], [-1.0, 2.0]]), np.ones(2))
    forces = np.random.default_rng(0).normal(size=(50, 2))
    forces[:, 0] = -np.abs(forces[:, 0])  # a gap opens
    solutions = cq.solve_many([problem.with_forces(q) for q in forces])
    assert not alone
    assert all(solution.status.ok and solution.iterations >= 1 for solution in solutions)


def test_a_lattice_is_answered_together(alone):
    lattice = cq.Frame.disk(1.0).lattice(spacing=0.2)
    loads = np.random.default_rng(0).normal(1.0, 3.0, (12, lattice.size))
    models = [cq.Membrane(lattice, 1.0, load=lattice.scatter(load), support=0.1) for load in loads]
    solutions = cq.solve_many(models)
    assert not alone
    assert [solution.model for solution in solutions] == models
    assert_as_alone(solutions, models)
    for solution, model in zip(solutions, models, strict=True):
        assert solution.certificate.model is model
        assert solution.contact_area.lower <= cq.solve(model).contact_area.upper


def test_limits_and_options_are_those_of_one_problem(alone):
    problem = cq.ContactQP(np.array([[2.0, -1.0], [-1.0, 2.0]]), np.ones(2))
    problems = [problem.with_forces(q) for q in ([-1.0, 3.0], [-2.0, 3.0], [-1.0, -1.0], [-3.0, 1.0])]
    solutions = cq.solve_many(problems, "active-set", history=True)
    assert len(alone) == len(problems)
    assert all("energy" in solution.history for solution in solutions)
    alone.clear()
    cq.solve_many(problems, max_iter=100)
    assert len(alone) == len(problems)


def test_other_backends_answer_one_by_one(alone):
    problem = cq.ContactQP(np.array([[2.0, -1.0], [-1.0, 2.0]]), np.ones(2))
    problems = [problem.with_forces(q) for q in ([-1.0, 3.0], [-2.0, 3.0], [-1.0, -1.0], [-3.0, 1.0])]
    assert {solution.backend for solution in cq.solve_many(problems, "psor")} == {"psor"}
    assert len(alone) == len(problems)


def test_answers_are_the_callers_own():
    problem = cq.ContactQP(np.array([[2.0, -1.0], [-1.0, 2.0]]), np.ones(2))
    first, second, *_ = cq.solve_many([problem.with_forces([-1.0, force]) for force in (1.0, 2.0, 3.0, 4.0)])
    assert not np.shares_memory(first.gap, second.gap)
    assert first.gap.base is None
    before = second.certificate.lower.copy()
    first.gap[:] = 7.0
    np.testing.assert_array_equal(second.certificate.lower, before)


def test_numbers_that_overflow_are_answered_as_by_themselves():
    problem = cq.ContactQP(np.array([[2.0, -1.0], [-1.0, 2.0]]), np.ones(2))
    forces = [-1.0, 1.0], [-1e308, -1e308], [-2.0, 1.0], [-1e-308, 1e-310], [-1e200, 1.0], [-1e-200, 1.0]
    problems = [problem.with_forces(q) for q in forces]
    statuses = [solution.status for solution in cq.solve_many(problems, on_failure="ignore")]
    assert statuses == [cq.solve(one, on_failure="ignore").status for one in problems]


class Answering(ActiveSetBackend):
    """Answers load cases by a function."""

    def __init__(self, answers):
        self.answers_by = answers

    def prepare(self, problem, task, *, history=False):
        inner, answers = super().prepare(problem, task, history=history), self.answers_by

        class Own(State):
            def solve(self, q, task, problem=None):
                return inner.solve(q, task, problem)

            def answers(self, cases, asked):
                return answers(cases)

        return Own()


def diagonal_problems(count=5):
    first = cq.ContactQP(4 * np.eye(3), -np.ones(3))
    return [first.with_forces(q) for q in np.random.default_rng(0).normal(size=(count, 3)) - 0.2]


def closed_form(cases):
    gaps = np.maximum(-cases.q, 0.0)  # the dimensionless matrix is that of ones
    return CaseAnswers(gaps, np.ones(len(gaps), dtype=np.int64), "written down", "step", 0.0)


def test_a_backend_of_ones_own_answers_many_cases(alone):
    problems = diagonal_problems()
    solutions = cq.solve_many(problems, Answering(closed_form))
    assert not alone
    assert all(solution.status.ok for solution in solutions)
    assert "written down after 1 steps" in {solution.termination for solution in solutions}


def test_wrong_and_missing_answers_are_not_taken(alone):
    def poor(cases):
        found = closed_form(cases)
        found.gaps[0] += 1.0
        found.gaps[1] = np.nan
        found.iterations[2] = 0
        return found

    problems = diagonal_problems()
    opened = [problem for problem in problems if not problem.shut]
    solutions = cq.solve_many(problems, Answering(poor))
    assert alone == opened[:3]
    for problem, solution in zip(problems, solutions, strict=True):
        assert solution.status.ok
        np.testing.assert_allclose(solution.gap, np.maximum(-problem.q / 4, 0.0), atol=1e-12)


@pytest.mark.parametrize(
    ("answers", "error", "words"),
    [
        (lambda cases: closed_form(cases).gaps, TypeError, "CaseAnswers are needed"),
        (
            lambda cases: CaseAnswers(np.zeros((1, 3)), np.ones(1, dtype=np.int64), "", "step", 0.0),
            ValueError,
            "shapes",
        ),
    ],
)
def test_answers_of_the_wrong_kind_are_refused(answers, error, words):
    with pytest.raises(error, match=words):
        cq.solve_many(diagonal_problems(), Answering(answers))
