"""An M-matrix below a matrix: what is taken away is positive semidefinite, in exact arithmetic."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from meshes import plate_over_bowl, triangles
from scipy import sparse

from contactqp.algebra import conductances
from contactqp.algebra.conductances import m_matrix_below, pay_in_python


def is_semidefinite(matrix):
    """Whether an exact symmetric matrix is positive semidefinite, by its LDLᵀ factors."""
    rows = [list(row) for row in matrix]
    for k, row in enumerate(rows):
        if row[k] < 0 or (row[k] == 0 and any(row[k:])):
            return False
        if row[k] == 0:
            continue
        for other in rows[k + 1 :]:
            factor = other[k] / row[k]
            for j in range(k, len(row)):
                other[j] -= factor * row[j]
    return True


def exact_difference(matrix, below):
    first, second = matrix.toarray(), below.toarray()
    return [[Fraction(a) - Fraction(b) for a, b in zip(*rows, strict=True)] for rows in zip(first, second, strict=True)]


def assert_below(matrix, below):
    dense = below.toarray()
    assert (dense == dense.T).all()
    assert (dense[~np.eye(len(dense), dtype=bool)] <= 0).all()
    assert (dense.diagonal() > 0).all()
    assert is_semidefinite(exact_difference(matrix, below))


@given(st.integers(2, 4), st.floats(0.0, 0.3), st.integers(0, 10**6), st.integers(-300, 300))
def test_it_lies_below_the_stiffness_of_any_mesh(nodes, moved, seed, exponent):
    matrix, _, _ = triangles(nodes, moved, np.random.default_rng(seed))
    matrix = sparse.csr_array(np.ldexp(matrix.toarray(), exponent // 10))
    below = m_matrix_below(matrix)
    if below is not None:
        assert_below(matrix, below)


@pytest.mark.slow
def test_it_lies_below_in_thousands_of_cases():
    paid = 0
    for seed in range(5000):
        rng = np.random.default_rng(seed)
        size = int(rng.integers(3, 7))
        lower = np.tril(rng.normal(-1.0, 1.0, (size, size)) * 10.0 ** rng.uniform(-3, 3, (size, size)), -1)
        lower[rng.uniform(size=lower.shape) < 0.2] = 0.0
        matrix = lower + lower.T
        matrix += np.diag(np.abs(matrix).sum(axis=1) * rng.uniform(0.5, 1.5) + 10.0 ** rng.uniform(-12, 0))
        below = m_matrix_below(sparse.csr_array(matrix))
        if below is not None:
            assert_below(sparse.csr_array(matrix), below)
            paid += bool((lower > 0).any())
    assert paid > 500


def test_an_edge_that_nothing_can_pay_has_none_below():
    assert m_matrix_below(sparse.csr_array([[2.0, 1.0], [1.0, 2.0]])) is None
    plate, _ = plate_over_bowl(5)
    plate.sort_indices()
    assert m_matrix_below(plate) is None


def test_a_positive_edge_of_half_its_capacity_by_hand():
    """Conductances a = b = 2 in series carry 1, so g = 1/2 takes half of both, and the row sums stay."""
    matrix = sparse.csr_array([[3.0, 0.5, -2.0], [0.5, 3.0, -2.0], [-2.0, -2.0, 5.0]])
    expected = [[2.5, 0.0, -1.0], [0.0, 2.5, -1.0], [-1.0, -1.0, 3.0]]
    np.testing.assert_allclose(m_matrix_below(matrix).toarray(), expected, rtol=1e-12)


@given(st.integers(2, 12), st.integers(0, 10**6))
def test_the_kernel_pays_what_plain_python_pays(nodes, seed):
    from contactqp.algebra.conductance_kernels import pay

    matrix, _, _ = triangles(nodes, 0.28, np.random.default_rng(seed))
    indptr, indices = matrix.indptr.astype(np.int64), matrix.indices.astype(np.int64)
    rows = np.repeat(np.arange(matrix.shape[0]), np.diff(indptr))
    given_conductances = np.where(rows == indices, 0.0, -matrix.data)
    owed = np.flatnonzero((given_conductances < 0) & (rows < indices))
    mirrored = np.lexsort((rows, indices))
    results = []
    for work in (pay, pay_in_python):
        left, unpaid = given_conductances.copy(), np.zeros(owed.size, dtype=bool)
        work(indptr, indices, rows, left, mirrored, owed, unpaid, 0.999, 1e-280)
        results.append((unpaid, left))
    np.testing.assert_array_equal(results[0][0], results[1][0])
    np.testing.assert_allclose(results[0][1], results[1][1], rtol=1e-13)


@pytest.mark.parametrize(("nodes", "moved", "seed"), [(4, 0.3, 63), (4, 0.32, 37), (4, 0.32, 182), (5, 0.32, 12)])
def test_an_entry_for_which_too_little_is_left_is_paid_first_another_time(monkeypatch, nodes, moved, seed):
    matrix, _, _ = triangles(nodes, moved, np.random.default_rng(seed))
    assert_below(matrix, m_matrix_below(matrix))
    monkeypatch.setattr(conductances, "_ROUNDS", 1)
    assert m_matrix_below(matrix) is None


def test_many_payments_are_made_in_chunks(monkeypatch):
    matrix, _, _ = triangles(70, 0.2, np.random.default_rng(3))
    whole = m_matrix_below(matrix)
    monkeypatch.setattr(conductances, "_CHUNK", 100)
    assert (m_matrix_below(matrix) != whole).nnz == 0
