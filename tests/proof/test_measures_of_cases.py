"""Measures and certificates of many cases at once: each is what it is by itself, and holds in rational numbers."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from rational import (
    adversarial_answer,
    adversarial_bounds,
    adversarial_problem,
    assert_certificate_holds,
    exact_solution,
    lattice_stencil,
    m_matrix,
)

import contactqp as cq
from contactqp.problem.load_cases import LoadCases
from contactqp.proof.measure import measure, measures_of_cases


def some_cases(rng, problem, count=5):
    """Return problems with other forces, and an answer of any quality to each."""
    problems = [problem, *(problem.with_forces(problem.q * rng.normal(size=problem.size)) for _ in range(count - 1))]
    exact = [exact_solution(one) for one in problems]
    answers = np.array([adversarial_answer(rng, one, gap) for one, (gap, _) in zip(problems, exact, strict=True)])
    return problems, exact, answers


def assert_each_holds(problems, exact, answers):
    measured = measures_of_cases(LoadCases.of(problems), problems, answers)
    for problem, (gap, reaction), answer, measures in zip(problems, exact, answers, measured, strict=True):
        assert_certificate_holds(measures.certificate(), gap, reaction, answer)
        alone = measure(problem, answer)
        # Sums in another order have other roundings, and where an answer is exact the bound is made of nothing else.
        assert alone.gap_bound / 4 <= measures.gap_bound <= 4 * alone.gap_bound
        assert measures.scale == alone.scale


@given(st.integers(0, 2**32 - 1))
def test_certificates_hold_in_rational_numbers(seed):
    rng = np.random.default_rng(seed)
    assert_each_holds(*some_cases(rng, adversarial_problem(rng, largest=4)))


@given(st.integers(0, 2**32 - 1))
def test_certificates_hold_in_rational_numbers_between_two_bounds(seed):
    rng = np.random.default_rng(seed)
    stiffness = m_matrix(rng, rng.integers(1, 4)) if rng.uniform() < 0.6 else lattice_stencil(rng)
    problem = adversarial_bounds(rng, stiffness)
    if problem.size <= 5:
        assert_each_holds(*some_cases(rng, problem, count=3))


def test_numbers_of_a_lattice_are_the_same_to_the_bit():
    """Each case takes the very operations that it takes by itself, and none with another's numbers."""
    rng = np.random.default_rng(3)
    lattice = cq.Frame.disk(1.0).lattice(spacing=0.125)
    first = cq.Membrane(lattice, 1.0, load=3.0, support=0.2).problem
    problems = [first.with_forces(rng.normal(size=first.size) - 0.5) for _ in range(7)]
    gaps = np.maximum(rng.normal(size=(7, first.size)), 0.0)
    gaps[3] *= 1e100
    for problem, gap, together in zip(
        problems, gaps, measures_of_cases(LoadCases.of(problems), problems, gaps), strict=True
    ):
        alone = measure(problem, gap)
        assert together.residuals == alone.residuals
        assert together.gap_bound == alone.gap_bound
        one, other = together.certificate(), alone.certificate()
        for name in ("lower", "upper", "contact", "clear", "contact_upper"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
        assert one.gap_bound == other.gap_bound


def test_a_case_whose_numbers_overflow_spoils_no_other():
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0], upper=5.0)
    problems = [problem, problem.with_forces([-2.0, 3.0])]
    huge, good = measures_of_cases(LoadCases.of(problems), problems, np.array([[1e308, -1e308], [1.0, 0.0]]))
    assert huge.certificate().gap_bound == np.inf or huge.certificate().gap_bound > 1e307
    assert good.certificate().gap_bound < 1e-14
    assert good.certificate().clear.tolist() == [True, False]
