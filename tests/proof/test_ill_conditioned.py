"""Matrices that are nearly singular are told to be so, with a figure, and not to be something else."""

from fractions import Fraction

import numpy as np
import pytest
from rational import exact_matrix, exact_solution, is_positive_definite

import contactqp as cq
from contactqp.algebra.conditioning import estimated_condition
from contactqp.algebra.stencil import Stencil
from contactqp.problem.eigenvalue import proven_least_eigenvalue


def full(condition, size=4):
    rng = np.random.default_rng(0)
    vectors, _ = np.linalg.qr(rng.normal(size=(size, size)))
    matrix = (vectors * np.logspace(0, -np.log10(condition), size)) @ vectors.T
    return (matrix + matrix.T) / 2


def pair(beyond):
    return np.array([[1.0, beyond - 1.0], [beyond - 1.0, 1.0]])


def chain(spring, size=50):
    """Return the stiffness of segments in a row, one end of which a weak spring holds."""
    matrix = 2 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1)
    matrix[0, 0], matrix[-1, -1] = 1 + spring, 1
    return matrix


def test_a_small_matrix_is_not_called_too_large():
    with pytest.raises(cq.UnsuitableProblemError) as told:
        cq.certify(cq.ContactQP(full(1e16), np.ones(4)), np.zeros(4))
    assert "too large" not in str(told.value)
    assert "too ill-conditioned for a proof: its condition number is a" in str(told.value)


def test_what_is_an_m_matrix_but_for_rounding_is_not_called_none():
    problem = cq.ContactQP(pair(1e-15), -np.ones(2))
    with pytest.warns(cq.ContactWarning, match=r"G is ill-conditioned, its condition number is about [24]e\+15"):
        solution = cq.solve(problem)
    assert "no M-matrix" not in repr(solution)
    assert solution.backend == "active-set"
    assert "auto: G is too ill-conditioned to be proven an M-matrix, its condition number is about" in solution.note
    assert "double precision keeps 0 digits of an answer" in repr(solution)


def test_a_line_that_double_precision_takes_for_singular_is_proven_in_twice_the_precision():
    problem = cq.ContactQP(chain(1e-13), -np.ones(50))
    solution = cq.solve(problem)
    assert solution.status == cq.Status.CERTIFIED
    assert "no M-matrix" not in repr(solution)
    assert solution.certificate.least_eigenvalue.proof == "factors in twice the precision"
    exact, _ = exact_solution(problem, np.ones(50, dtype=bool))
    error = max(abs(Fraction(float(found)) - gap) for found, gap in zip(solution.gap, exact, strict=True))
    assert error <= Fraction(solution.certificate.gap_bound)
    assert error < 1e-6 * max(exact)


def test_a_well_conditioned_matrix_has_nothing_of_that_in_its_messages():
    problem = cq.ContactQP(full(1e3), np.ones(4) * [1, -1, 1, -1])
    with pytest.warns(cq.ContactWarning) as told:
        cq.solve(problem, "psor", max_iter=1)
    assert "condition" not in str(told[0].message)


@pytest.mark.parametrize("matrix", [pair(2.0**-53), pair(3e-16), chain(0.0)])
def test_a_singular_matrix_is_told_from_an_indefinite_one(matrix):
    with pytest.raises(ValueError, match=r"singular, or too ill-conditioned|is not below the geometric mean"):
        cq.ContactQP(matrix, -np.ones(len(matrix)))
    with pytest.raises(ValueError, match="a factorisation finds 1 pivot <= 0"):
        cq.ContactQP([[1.0, 0.9, 0.0], [0.9, 1.0, 0.9], [0.0, 0.9, 1.0]], np.ones(3))


def test_the_smallest_eigenvalue_of_a_lattice_is_that_of_the_exact_sums_of_its_arms():
    """Where rounding hides a barrier from double precision, its factors are those of a rounded diagonal."""
    found = 0
    for seed in range(100):
        rng = np.random.default_rng(seed)
        arms = rng.uniform(0.5, 2.0, (1, 4))
        arms[0, [0, -1]] = 10.0 ** rng.uniform(-15, -14, 2)
        stencil = Stencil(np.ones((1, 3), dtype=bool), arms, np.zeros((2, 3)))
        problem = cq.ContactQP(stencil, np.zeros(3))
        try:
            least = None if problem.barrier is not None else problem.least_eigenvalue
        except ValueError:  # singular in double precision
            continue
        if least is None:
            continue
        found += 1
        units = [Fraction(float(unit)) for unit in least.units]
        exact = exact_matrix(problem)
        scaled = [
            [units[i] * exact[i][j] * units[j] - (i == j) * Fraction(least.bound) for j in range(3)] for i in range(3)
        ]
        assert is_positive_definite(scaled)
        assembled = proven_least_eigenvalue(problem.G)
        # A sum of four arms is rounded twice.
        rounded = 2 * 2.0**-53 * (stencil.diagonal() * least.units**2).max()
        assert least.bound <= assembled.bound - rounded
    assert found > 5


@pytest.mark.parametrize("condition", [1e2, 1e8, 1e13])
@pytest.mark.parametrize("size", [4, 60])
def test_the_condition_number_is_right_to_a_factor_of_three(condition, size):
    from scipy.sparse import csr_array

    matrix = full(condition, size)
    root = np.sqrt(matrix.diagonal())
    exact = np.linalg.cond(matrix / root / root[:, None])
    assert exact / 3 < estimated_condition(csr_array(matrix)) < 3 * exact
