"""Extremum properties of the solution."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rational import adversarial_answer, adversarial_bounds, adversarial_problem, exact_solution, m_matrix, shares
from strategies import enumerate_solution, problems

import contactqp as cq
from contactqp.algebra.stencil import Stencil


@given(problem=problems(max_size=7), seed=st.integers(0, 2**32 - 1))
def test_energies_bracket_that_of_the_solution(problem, seed):
    exact = enumerate_solution(problem)
    reaction = np.where(problem.supported, np.maximum(problem.reaction(exact), 0.0), 0.0)
    energy = cq.potential_energy(problem, exact)
    size = 1e-9 * (1 + abs(energy))
    assert cq.complementary_energy(problem, reaction) == pytest.approx(-energy, abs=size)
    rng = np.random.default_rng(seed)
    gap = np.where(problem.supported, np.abs(exact + rng.normal(size=exact.size)), rng.normal(size=exact.size))
    force = np.where(problem.supported, np.abs(reaction + rng.normal(size=exact.size)), 0.0)
    assert cq.potential_energy(problem, gap) >= energy - size
    assert -cq.complementary_energy(problem, force) <= energy + size
    low, high = cq.energy_bracket(problem, exact + rng.normal(size=exact.size))
    assert low - size <= energy <= high + size


def test_the_duality_gap_is_the_work_of_gap_and_reaction():
    """E(ω) + E_c(R) = ωᵀR where R = Gω + q."""
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
    gap = np.array([1.0, 0.25])
    reaction = problem.reaction(gap)
    total = cq.potential_energy(problem, gap) + cq.complementary_energy(problem, reaction)
    assert total == pytest.approx(gap @ reaction)


@pytest.mark.parametrize("model", [cq.gallery.paper_hexagon(), cq.gallery.bowl(70)], ids=repr)
def test_energies_of_models(model):
    """Small ones by factors, large ones by multigrid."""
    solution = cq.solve(model, tol=1e-9)
    low, high = cq.energy_bracket(model, solution.gap)
    assert high == pytest.approx(solution.residuals.objective, rel=1e-12)
    assert 0 <= high - low + 1e-9 * abs(high) <= 1e-8 * abs(high)
    rough = cq.energy_bracket(model, solution.gap * 1.01)
    assert rough.lower < low + 1e-9 * abs(low)
    assert rough.upper > high


@given(problem=problems(max_size=7), seed=st.integers(0, 2**32 - 1))
def test_the_solution_is_the_least_feasible_gap(problem, seed):
    """Feasible gaps are made from the barrier; the least of two of them is feasible as well."""
    exact = enumerate_solution(problem)
    rng = np.random.default_rng(seed)
    room = 1e-9 * (1 + np.abs(exact).max())
    assert cq.feasible(problem, exact, room).all()
    v = problem.barrier.v
    shifts = [exact + v * rng.exponential() for _ in range(2)]
    for gap in shifts:
        assert cq.feasible(problem, gap, room).all()
    assert cq.feasible(problem, np.minimum(*shifts), room).all()
    below = exact.copy()
    below[rng.integers(exact.size)] -= 1e-3 * (1 + np.abs(exact).max())
    assert not cq.feasible(problem, below).all()


@given(problem=problems(max_size=6), seed=st.integers(0, 2**32 - 1))
def test_every_positive_cost_finds_the_solution_of_the_quadratic_program(problem, seed):
    exact = enumerate_solution(problem)
    cost = np.random.default_rng(seed).uniform(0.1, 10.0, problem.size)
    found = cq.solve(problem, "mangasarian", cost=cost, on_failure="ignore").gap
    np.testing.assert_allclose(found, exact, atol=1e-5 * (1 + np.abs(exact).max()))


def test_the_deflection_is_the_largest_among_subsolutions():
    """Of all w ≤ f with Gw ≤ P: any other than the solution's lies below it, and another load's does not pass."""
    membrane = cq.gallery.paper_hexagon(0.03)
    solution = cq.solve(membrane, tol=1e-10)
    lighter = cq.solve(cq.gallery.paper_hexagon(0.02), tol=1e-10)
    heavier = cq.solve(cq.gallery.paper_hexagon(0.04), tol=1e-10)
    assert cq.feasible(membrane, lighter.gap, 1e-9).all()
    assert (lighter.deflection <= solution.deflection + 1e-9).all()
    assert not cq.feasible(membrane, heavier.gap, 1e-9).all()


def test_arguments_are_checked():
    problem = cq.ContactQP([[2.0]], [-1.0])
    with pytest.raises(ValueError, match=r"gap must have shape \(1,\)"):
        cq.potential_energy(problem, [1.0, 2.0])
    with pytest.raises(ValueError, match="reaction must be finite"):
        cq.complementary_energy(problem, [np.inf])
    with pytest.raises(TypeError, match="problem must be a Membrane, a Cable, a CableNet, a ContactQP or a ContactLCP"):
        cq.energy_bracket(3, [1.0])


@pytest.mark.parametrize("size", [1e-300, 1e-200, 1e-162, 1e-160, 1e-100, 1.0])
def test_the_bracket_holds_the_energy_where_it_underflows(size):
    """E(ω*) = -size²/4 for G = [[2, -1], [-1, 2]], q = size (-1, 3)."""
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-size, 3 * size])
    low, high = cq.energy_bracket(problem, [0.5 * size, 0.0])
    exact = -(Fraction(size) ** 2) / 4
    assert Fraction(low) <= exact * (1 - Fraction(1, 10**12))
    assert exact * (1 + Fraction(1, 10**12)) <= Fraction(high)


def test_the_bracket_holds_where_a_residual_over_the_stiffness_underflows():
    """A string of stiffness 4e307 is lifted by 0.01 at each node: w_i = q i(n + 1 - i)/(2 arm), E = -qᵀw/2."""
    arm, nodes = 4e307, 100
    for share in range(40):
        force = 0.01 * (1 + 0.01 * share)
        problem = cq.ContactQP(Stencil(np.ones((1, nodes), dtype=bool), arm, 0.0), np.full(nodes, -force))
        low, high = cq.energy_bracket(problem, np.zeros(nodes))
        exact = -(Fraction(force) ** 2) / Fraction(arm) * sum(i * (nodes + 1 - i) for i in range(1, nodes + 1)) / 4
        assert Fraction(low) <= exact <= Fraction(high)


@pytest.mark.parametrize("stiffness", [[[2.0, -1.0], [-1.0, 2.0]], Stencil(np.ones((2, 2), dtype=bool), 1.0, 1.0)])
def test_where_numbers_overflow_nothing_is_known_of_the_energy(stiffness):
    """Without a warning, for an infinite bracket says as much."""
    problem = cq.ContactQP(stiffness, -np.ones(getattr(stiffness, "size", 2)))
    gap = np.full(problem.size, -1e308)
    gap[0] = 1e308
    assert cq.energy_bracket(problem, gap) == (-np.inf, np.inf)


def test_the_energy_of_a_shut_gap_is_zero_exactly():
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [0.0, 0.0])
    assert cq.energy_bracket(problem, [0.0, 0.0]) == (0.0, 0.0)


def nearly_singular(rng, size):
    """Return an M-matrix whose condition number is up to 1e15, or one of another kind with one as large."""
    beyond = 10.0 ** rng.uniform(-15, -6)
    if rng.uniform() < 0.3:
        vectors, _ = np.linalg.qr(rng.normal(size=(size, size)))
        matrix = (vectors * np.r_[beyond, np.ones(size - 1)]) @ vectors.T
    else:
        weights = np.triu(rng.integers(1, 4, (size, size)).astype(float), 1)
        weights += weights.T
        matrix = np.diag(weights.sum(axis=1)) - weights
        matrix[0, 0] += beyond * matrix[0, 0] + (size == 1)
    return (matrix + matrix.T) / 2


def exact_energy(problem, gap, reaction):
    force = [Fraction(float(entry)) for entry in problem.q]
    return sum((r + q) * w for r, q, w in zip(reaction, force, gap, strict=True)) / 2


def check_the_bracket_in_rational_numbers(seed, cases, make):
    rng = np.random.default_rng(seed)
    finite = 0
    for _ in range(cases):
        problem = make(rng)
        if problem is None:
            continue
        exact, reaction = exact_solution(problem)
        energy = exact_energy(problem, exact, reaction)
        for answer in (np.array([float(x) for x in exact]), adversarial_answer(rng, problem, exact)):
            low, high = cq.energy_bracket(problem, answer)
            assert low <= high
            assert low == -np.inf or Fraction(low) <= energy
            assert high == np.inf or energy <= Fraction(high)
            finite += int(np.isfinite([low, high]).all())
    return finite


def near_singular_problem(rng):
    matrix = nearly_singular(rng, int(rng.integers(1, 5)))
    q = rng.normal(size=len(matrix)) * 10.0 ** rng.uniform(-3, 3)
    try:
        return cq.ContactQP(matrix, q, lower=rng.choice([0.0, -1.0]), supported=None)
    except ValueError:  # singular in double precision
        return None


@pytest.mark.parametrize("seed", range(3))
def test_the_bracket_holds_in_rational_numbers_for_nearly_singular_matrices(seed):
    assert check_the_bracket_in_rational_numbers(seed, 150, near_singular_problem) > 150


@pytest.mark.parametrize("seed", range(2))
def test_the_bracket_holds_in_rational_numbers_for_adversarial_problems(seed):
    assert check_the_bracket_in_rational_numbers(seed, 100, lambda rng: adversarial_problem(rng, 4)) > 150
    bounded = check_the_bracket_in_rational_numbers(seed, 50, lambda rng: adversarial_bounds(rng, m_matrix(rng, 3)))
    assert bounded > 60


@pytest.mark.slow
@pytest.mark.parametrize("seed", shares(3))
def test_the_bracket_holds_in_rational_numbers_thousands_of_times(seed):
    seed += 10
    check_the_bracket_in_rational_numbers(seed, 1000, near_singular_problem)
    check_the_bracket_in_rational_numbers(seed, 500, lambda rng: adversarial_problem(rng, 4))
    check_the_bracket_in_rational_numbers(seed, 300, lambda rng: adversarial_bounds(rng, m_matrix(rng, 3)))


def test_the_bracket_of_an_exact_answer_is_narrow_although_the_matrix_is_nearly_singular():
    rng = np.random.default_rng(0)
    for _ in range(50):
        problem = near_singular_problem(rng)
        if problem is None or problem.barrier is None:
            continue
        exact, reaction = exact_solution(problem)
        energy = float(exact_energy(problem, exact, reaction))
        low, high = cq.energy_bracket(problem, np.array([float(x) for x in exact]))
        assert high - low <= 1e-2 * abs(energy) + 1e-300


def test_where_nothing_is_known_of_the_matrix_there_is_no_lower_bound(monkeypatch):
    monkeypatch.setattr("contactqp.algebra.band.MOST_ENTRIES", 2)
    full = np.array([[2.0, 1.5, 1.5], [1.5, 2.0, 1.5], [1.5, 1.5, 2.0]])
    low, high = cq.energy_bracket(cq.ContactQP(full, [-1.0, 0.0, 0.0]), [0.4, 0.1, 0.0])
    assert low == -np.inf
    assert np.isfinite(high)


def test_positive_entries_that_count_as_zero_are_in_the_bracket():
    matrix = np.array([[2.0, -1.0, 1e-15], [-1.0, 2.0, -1.0], [1e-15, -1.0, 2.0]])
    problem = cq.ContactQP(matrix, [-1.0, 0.5, -1.0])
    assert problem.stiffness.surplus is not None
    exact, reaction = exact_solution(problem)
    low, high = cq.energy_bracket(problem, np.array([float(x) for x in exact]))
    assert Fraction(low) <= exact_energy(problem, exact, reaction) <= Fraction(high)
    assert high - low < 1e-13
