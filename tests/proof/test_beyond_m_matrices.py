"""Enclosures beyond M-matrices."""

from fractions import Fraction

import numpy as np
import pytest
from rational import adversarial_answer, assert_certificate_holds, exact_solution, is_positive_definite

import contactqp as cq
from contactqp.algebra.sparse import checked_matrix
from contactqp.problem.eigenvalue import proven_least_eigenvalue
from contactqp.proof.judge import judge

FULL = np.array([[1.0, 0.9, 0.9], [0.9, 1.0, 0.9], [0.9, 0.9, 1.0]])
"""Its eigenvalues are 2.8, 0.1, 0.1; its comparison matrix is indefinite."""


def definite_matrix(rng, size):
    """Return a symmetric positive definite matrix with entries of both signs, at times of scales far apart."""
    root = rng.normal(size=(size, size))
    matrix = root @ root.T + 10.0 ** rng.uniform(-6, 1) * np.eye(size)
    if rng.uniform() < 0.5:
        matrix += np.diag(np.abs(matrix).sum(axis=1)) * rng.uniform(0.3, 1.2)
    scale = 10.0 ** rng.uniform(-3, 3, size) if rng.uniform() < 0.5 else np.ones(size)
    matrix = scale[:, None] * matrix * scale
    return (matrix + matrix.T) / 2


@pytest.mark.slow
@pytest.mark.parametrize("share", range(4))
def test_no_claim_is_violated_in_rational_arithmetic(share):
    kinds = set()
    for case in range(share, 1000, 4):
        rng = np.random.default_rng([1970, case])
        matrix = definite_matrix(rng, rng.integers(2, 6))
        size = len(matrix)
        supported = rng.uniform(size=size) < 0.7 if rng.uniform() < 0.3 else None
        q = rng.normal(size=size) * np.sqrt(np.diag(matrix)) * 10.0 ** rng.uniform(-3, 3)
        try:
            problem = cq.ContactQP(matrix, q, supported=supported)
        except ValueError:
            continue  # indefinite to rounding
        if problem.is_m_matrix:
            continue
        gap, reaction = exact_solution(problem)
        answer = adversarial_answer(rng, problem, gap)
        try:
            certificate = cq.certify(problem, answer)
        except cq.UnsuitableProblemError:
            continue
        assert certificate.weaker
        assert_certificate_holds(certificate, gap, reaction, answer)
        kinds.add(certificate.barrier)
    assert kinds == {"comparison matrix", "smallest eigenvalue"}


def test_a_positive_off_diagonal_that_the_diagonal_dominates():
    problem = cq.ContactQP(np.array([[1.0, 2.0], [2.0, 5.0]]), [-1.0, -1.0])
    certificate = cq.certify(problem, [1.0, 0.0])
    assert certificate.barrier == "comparison matrix"
    assert certificate.gap_bound < 1e-13
    assert certificate.contact.tolist() == [False, True]
    assert certificate.clear.tolist() == [True, False]
    assert repr(certificate).endswith("comparison matrix, weaker than for an M-matrix)")
    assert judge(problem, np.array([1.0, 0.0]), tol=1e-6).status == cq.Status.CERTIFIED
    wrong = judge(problem, np.array([0.0, 0.5]), tol=1e-6)
    assert wrong.status == cq.Status.INACCURATE
    assert wrong.certificate.gap_bound >= 1.0


def test_the_comparison_bound_by_hand():
    """⟨G⟩ = [[4, -1], [-1, 4]], v = (1/3, 1/3), s = (1, 1): ω = (0.5, 0.5) has R = (1.5, 1.5), so τ = 1.5."""
    problem = cq.ContactQP(np.array([[4.0, 1.0], [1.0, 4.0]]), [-1.0, -1.0])
    certificate = cq.certify(problem, [0.5, 0.5], effort="fast")
    np.testing.assert_allclose(certificate.lower, 0.0)
    np.testing.assert_allclose(certificate.upper, 1.0, rtol=1e-12)
    assert certificate.gap_bound == pytest.approx(0.5)


def test_the_eigenvalue_bound_by_hand():
    """G = FULL, q = (-1, 0, 0): ω* = (1, 0, 0), R* = (0, 0.9, 0.9). At ω = (1.1, 0, 0) it is ρ = (0.1, 0, 0)."""
    problem = cq.ContactQP(FULL, [-1.0, 0.0, 0.0])
    certificate = cq.certify(problem, [1.1, 0.0, 0.0], effort="fast")
    assert certificate.barrier == "smallest eigenvalue"
    assert cq.certify(problem, [1.1, 0.0, 0.0]).gap_bound == pytest.approx(0.1)
    assert 1.0 <= certificate.gap_bound / (0.1 / 0.1) < 1.2
    exact = cq.certify(problem, [1.0, 0.0, 0.0])
    assert exact.gap_bound < 1e-13
    assert exact.contact.tolist() == [False, True, True]


@pytest.mark.parametrize("size", [1, 2, 40, 300])
def test_the_smallest_eigenvalue_is_bounded_from_below_and_closely(size):
    rng = np.random.default_rng(size)
    matrix = definite_matrix(rng, size)
    least = proven_least_eigenvalue(cq.ContactQP(matrix, np.zeros(size)).G)
    exact = np.linalg.eigvalsh(least.units[:, None] * matrix * least.units).min()
    assert 0.05 * exact < least.bound < exact


def nearly_singular_or_indefinite(rng, size):
    """Return a symmetric matrix whose smallest eigenvalue is about zero, or one of edges that others may pay."""
    if rng.uniform() < 0.5:
        vectors, _ = np.linalg.qr(rng.normal(size=(size, size)))
        matrix = (vectors * np.r_[rng.choice([-1, 1]) * 10.0 ** rng.uniform(-17, -12), np.ones(size - 1)]) @ vectors.T
    else:
        edges = np.tril(10.0 ** rng.uniform(-8, 0, (size, size)), -1) * rng.choice([-1, -1, 1], (size, size))
        matrix = edges + edges.T
        matrix += np.diag(np.abs(matrix).sum(axis=1) if rng.uniform() < 0.3 else -matrix.sum(axis=1))
        matrix[0, 0] += 10.0 ** rng.uniform(-16, -8)
    unit = (
        2.0 ** rng.integers(-200, 200, size) if rng.uniform() < 0.3 else np.full(size, 10.0 ** rng.uniform(-150, 150))
    )
    matrix = np.tril(unit[:, None] * matrix * unit)
    return matrix + np.tril(matrix, -1).T


@pytest.mark.parametrize("proof", ["factors", "an M-matrix below"])
def test_the_smallest_eigenvalue_is_bounded_in_rational_arithmetic(proof, monkeypatch):
    if proof != "factors":
        monkeypatch.setattr("contactqp.algebra.band.MOST_ENTRIES", 0)
    proven = 0
    for case in range(600):
        rng = np.random.default_rng([1975, case])
        size = int(rng.integers(2, 6))
        try:
            matrix = checked_matrix(nearly_singular_or_indefinite(rng, size))
        except ValueError:  # a diagonal entry <= 0
            continue
        least = proven_least_eigenvalue(matrix)
        if least is None:
            continue
        proven += 1
        assert least.proof == proof
        units = [Fraction(unit) for unit in least.units]
        scaled = [[Fraction(x) * u for x, u in zip(row, units, strict=True)] for row in matrix.toarray()]
        rows = [[x * u for x in row] for row, u in zip(scaled, units, strict=True)]
        for i in range(size):
            rows[i][i] -= Fraction(least.bound) * (1 - Fraction(1, 10**30))
        assert is_positive_definite(rows)
    assert proven > 50


def test_what_is_not_positive_definite_has_no_eigenvalue_bound():
    from scipy.sparse import csr_array

    assert proven_least_eigenvalue(csr_array([[1.0, 2.0], [2.0, 1.0]])) is None
    assert proven_least_eigenvalue(csr_array([[1.0, 1.0], [1.0, 1.0]])) is None
    nearly = np.array([[1.0, 1.0 - 1e-16], [1.0 - 1e-16, 1.0]])
    assert proven_least_eigenvalue(csr_array(nearly)) is None


@pytest.mark.parametrize("size", [1e-322, 1e-310, 1e-300, 1e300, 1e307])
def test_the_smallest_eigenvalue_is_bounded_in_any_unit(size, monkeypatch):
    """Both units of a matrix of subnormal numbers are so large that their product overflows."""
    from scipy.sparse import csr_array

    indefinite = np.array([[1.0, 1.5], [1.5, 1.0]])
    assert proven_least_eigenvalue(csr_array(size * indefinite)) is None
    monkeypatch.setattr("contactqp.algebra.band.MOST_ENTRIES", 0)
    triangle = size * np.array([[3.0, 0.5, -2.0], [0.5, 3.0, -2.0], [-2.0, -2.0, 5.0]])
    least = proven_least_eigenvalue(csr_array(triangle))
    assert least.proof == "an M-matrix below"
    exact = np.linalg.eigvalsh(triangle * least.units * least.units[:, None]).min()
    assert 0.5 * exact < least.bound < exact


def test_the_rounding_of_a_reaction_that_presses_is_not_out_of_balance():
    """A beam of 120 nodes, condition 1e8: all numbers are whole, and so is the solution."""
    size = 120
    beam = 6 * np.eye(size) - 4 * np.eye(size, k=1) - 4 * np.eye(size, k=-1) + np.eye(size, k=2) + np.eye(size, k=-2)
    gap = np.where(np.arange(size) % 9 == 4, 0.0, np.arange(size) * 7 % 11 + 1.0)
    for upper in (np.inf, 12.0):
        problem = cq.ContactQP(beam, np.where(gap == 0, 0.7, 0.0) - beam @ gap, upper=upper)
        certificate = cq.certify(problem, gap)
        assert certificate.barrier == "smallest eigenvalue"
        assert certificate.gap_bound < 1e-13
        assert not certificate.undecided.any()


def test_nothing_is_claimed_where_nothing_is_known(monkeypatch):
    monkeypatch.setattr("contactqp.algebra.band.MOST_ENTRIES", 2)
    problem = cq.ContactQP(FULL, [-1.0, 0.0, 0.0])
    with pytest.raises(cq.UnsuitableProblemError, match="no enclosure is known"):
        cq.certify(problem, [1.0, 0.0, 0.0])
    with pytest.warns(cq.ContactWarning, match=r"is not proven: no bound is known, natural residual .* wanted 1e-06"):
        solution = cq.solve(problem, "clarabel")
    assert solution.status == cq.Status.UNPROVEN
    assert not solution.status.ok
    assert solution.relative_bound == np.inf
    assert solution.relative_residual < 1e-6
    with pytest.raises(cq.NotCertifiedError, match="is not proven"):
        cq.solve(problem, "clarabel", on_failure="raise")
    assert solution.certificate is None
    assert "no enclosure is known for this matrix" in repr(solution)
    with pytest.raises(AttributeError, match="total_reaction needs a certificate"):
        _ = solution.total_reaction
    assert judge(problem, np.array([0.0, 0.5, 0.0]), tol=1e-6).status == cq.Status.INACCURATE


def test_a_good_residual_under_a_weak_bound_is_unproven(monkeypatch):
    near = np.array([[1.0, 1.0 - 1e-4], [1.0 - 1e-4, 1.0]])
    problem = cq.ContactQP(near, [-1.0, -1.0])
    exact = 1 / (2 - 1e-4)
    off = np.array([exact + 1e-7, exact])
    assert judge(problem, off, tol=1e-6).status == cq.Status.CERTIFIED
    # So that the bound cannot be laid about a better base.
    monkeypatch.setattr("contactqp.algebra.band.MOST_ENTRIES", 0)
    monkeypatch.setattr("contactqp.proof.beyond_m_matrices.free_set_solver", lambda stiffness, free: None)
    verdict = judge(problem, off, tol=1e-6)
    assert verdict.status == cq.Status.UNPROVEN
    assert verdict.certificate.weaker
    assert verdict.relative_bound > 1e-6 > verdict.relative_residual


def test_what_is_proven_wrong_is_not_called_unproven():
    """Two nearly parallel columns: (1.62, 0.38) has a residual of 1e-8, and (1, 1) is the solution."""
    c = 1 - 1e-7
    problem = cq.ContactQP([[1.0, c], [c, 1.0]], [-1.0 - c, -1.0 - c])
    verdict = judge(problem, np.array([1.62, 0.38]), tol=1e-6)
    assert verdict.residuals.natural_residual < 1e-6
    assert verdict.status == cq.Status.INACCURATE
    assert 0.619 < verdict.certificate.gap_bound < 0.621


def test_the_earlier_name_of_unproven_is_the_same_status():
    assert cq.Status.SOLVED is cq.Status.UNPROVEN


@pytest.mark.parametrize("size", [1e-320, 1e-200, 1e-160, 1.0, 1e160, 1e200, 1e300])
def test_the_eigenvalue_bound_holds_to_the_edge_of_the_range(size):
    """Squares of small residuals vanish, those of large ones overflow."""
    problem = cq.ContactQP(FULL, [-size, 0.0, 0.0])
    certificate = cq.certify(problem, [1.1 * size, 0.0, 0.0])
    assert certificate.lower[0] <= size <= certificate.upper[0]
    assert certificate.gap_bound >= 0.0999 * size
    assert certificate.gap_bound < 2 * size + 1e-290
