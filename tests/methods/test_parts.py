"""Principal submatrices: every way to factorise them solves the same equations."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse
from strategies import m_matrices

import contactqp as cq
from contactqp.methods.parts import Parts, _Banded, _Dense, _Sparse, parts_of


def all_parts(matrix):
    return _Dense(matrix), _Sparse(matrix), _Banded(matrix, matrix.shape[0])


@given(m_matrices(max_size=9), st.integers(0, 999))
def test_all_kinds_multiply_and_solve_alike(matrix, seed):
    rng = np.random.default_rng(seed)
    chosen = rng.uniform(size=len(matrix)) < 0.7
    chosen[rng.integers(len(matrix))] = True
    vector, force = rng.normal(size=len(matrix)), rng.normal(size=int(chosen.sum()))
    expected = np.linalg.solve(matrix[np.ix_(chosen, chosen)], force)
    for parts in all_parts(sparse.csr_array(matrix)):
        np.testing.assert_allclose(parts.product(vector), matrix @ vector, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(parts.solver(chosen)(force), expected, rtol=1e-8, atol=1e-12)


def test_a_band_of_three_by_hand():
    """With 0 and 2 chosen nothing couples them: 2x = 1 and 4x = 1."""
    matrix = sparse.csr_array([[2.0, -1.0, 0.0], [-1.0, 3.0, -1.0], [0.0, -1.0, 4.0]])
    for parts in all_parts(matrix):
        np.testing.assert_allclose(parts.solver(np.array([True, False, True]))(np.ones(2)), [0.5, 0.25])
        np.testing.assert_allclose(parts.solver(np.array([False, True, True]))(np.array([2.0, 3.0])), [1.0, 1.0])


def test_the_kind_goes_with_size_and_band():
    assert isinstance(parts_of(cq.gallery.bowl(5).problem.G), _Dense)
    assert isinstance(parts_of(cq.gallery.bowl(30).problem.G), _Banded)
    shuffled = np.random.default_rng(0).permutation(900)
    assert isinstance(parts_of(sparse.csr_array(cq.gallery.bowl(30).problem.G[shuffled][:, shuffled])), _Sparse)


def test_factors_are_kept_for_the_same_set_and_a_set_may_be_changed_afterwards():
    made = []

    class Counting(Parts):
        def product(self, vector):
            return vector

        def _factorised(self, chosen):
            made.append(chosen.copy())
            return lambda force: force

    parts, chosen = Counting(), np.array([True, False])
    parts.solver(chosen)
    parts.solver(chosen.copy())
    assert len(made) == 1
    chosen[1] = True
    parts.solver(chosen)
    assert len(made) == 2


@pytest.mark.parametrize("kind", [1, 2])
def test_a_singular_part_is_none(kind):
    matrix = sparse.csr_array([[1.0, -1.0], [-1.0, 1.0]])
    assert all_parts(matrix)[kind].solver(np.ones(2, dtype=bool)) is None
