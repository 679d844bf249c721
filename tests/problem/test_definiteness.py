"""Large matrices are checked without a factorisation whose fill nobody knows before."""

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse import linalg

import contactqp as cq
from contactqp.algebra.definiteness import ritz_value

SIDE = 70


@pytest.fixture
def no_fill(monkeypatch):
    factorise = linalg.splu

    def small_only(matrix, **options):
        assert matrix.shape[0] <= 4000, "factorised with unknown fill"
        return factorise(matrix, **options)

    monkeypatch.setattr(linalg, "splu", small_only)


def graph(nodes, degree, seed=1):
    """Return Q = aI + (1-a)/2 (I - D^-½ A D^-½) of a random graph, a = 0.1: an M-matrix, not dominant by rows."""
    half = sparse.random_array((nodes, nodes), density=degree / nodes, rng=np.random.default_rng(seed), format="csr")
    joined = ((half + half.T) > 0).astype(float).tocsr()
    joined.setdiag(0.0)
    joined.eliminate_zeros()
    root = sparse.diags_array(1 / np.sqrt(np.maximum(joined.sum(axis=1), 1.0)))
    one = sparse.eye_array(nodes)
    return (0.1 * one + 0.45 * (one - root @ joined @ root)).tocsr()


def line_of_lines(diagonal):
    line = sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(SIDE, SIDE))
    one = sparse.eye_array(SIDE)
    laplacian = sparse.kron(line, one) + sparse.kron(one, line)
    return (laplacian + sparse.diags_array(diagonal)).tocsr()


def test_a_graph_that_is_not_dominant_is_proven_by_a_barrier(no_fill):
    matrix = graph(6000, 10)
    rng = np.random.default_rng(0)
    problem = cq.ContactQP(matrix, rng.normal(size=6000))
    assert problem.is_m_matrix
    assert (matrix @ problem.barrier.v > 0.9 * problem.barrier.s).all()
    assert problem.barrier.s.min() > 0


@pytest.mark.parametrize("shift", [-0.5, -0.02])
def test_an_indefinite_matrix_of_many_unknowns_is_refused(no_fill, shift):
    with pytest.raises(ValueError, match="G must be positive definite, but numerically it is not"):
        cq.ContactQP(line_of_lines(np.full(SIDE**2, shift)), np.zeros(SIDE**2))


@pytest.mark.parametrize("entries", [30_000_000, 0])
def test_a_singular_matrix_of_many_unknowns_is_refused(no_fill, monkeypatch, entries):
    """The Laplacian of a torus annihilates constants; whether a band is affordable or not."""
    monkeypatch.setattr("contactqp.algebra.band.MOST_ENTRIES", entries)
    around = sparse.diags_array(
        [-1.0, -1.0, 2.0, -1.0, -1.0], offsets=[1 - SIDE, -1, 0, 1, SIDE - 1], shape=(SIDE, SIDE)
    )
    one = sparse.eye_array(SIDE)
    with pytest.raises(ValueError, match="G must be positive definite, but numerically it is not"):
        cq.ContactQP((sparse.kron(around, one) + sparse.kron(one, around)).tocsr(), np.zeros(SIDE**2))


def test_a_large_matrix_with_positive_entries_is_proven_in_a_band(no_fill):
    matrix = line_of_lines(np.zeros(SIDE**2)).tolil()
    middle = SIDE * (SIDE + 1) // 2
    matrix[middle, middle + SIDE + 1] = matrix[middle + SIDE + 1, middle] = 1.9
    problem = cq.ContactQP(matrix.tocsr(), np.ones(SIDE**2))
    assert problem.comparison_barrier is None
    least = problem.least_eigenvalue.bound
    exact = linalg.eigsh(problem.G, k=1, sigma=None, which="SA", return_eigenvectors=False, tol=1e-3)[0] / 4
    assert 0 < least < exact * 1.01


def test_a_ritz_value_is_above_the_smallest_eigenvalue():
    matrix = line_of_lines(np.zeros(SIDE**2))
    exact = 2 * (1 - np.cos(np.pi / (SIDE + 1))) / 2
    assert exact * (1 - 1e-9) <= ritz_value(matrix) < 10 * exact
