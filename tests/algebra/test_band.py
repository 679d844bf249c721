"""Factors in a band: by LAPACK, by compiled code and dense ones, and what they prove."""

import numpy as np
import pytest
from scipy import sparse

from contactqp.algebra.band import Band


def banded(rng, size, width):
    """Return a symmetric positive definite matrix whose rows reach ``width`` to either side."""
    lower = np.tril(np.triu(rng.normal(size=(size, size)), -width))
    return lower @ lower.T + 0.1 * np.eye(size)


@pytest.fixture(params=["lapack", "compiled"])
def way(request, monkeypatch):
    monkeypatch.setattr("contactqp.algebra.band._LITTLE_WORK", np.inf if request.param == "lapack" else -1.0)
    monkeypatch.setattr("contactqp.algebra.band._NEARLY_DENSE", 2.0)


@pytest.mark.parametrize("size", [1, 2, 3, 4, 5, 7, 8, 9, 33])
@pytest.mark.parametrize("width", [0, 1, 2, 3, 4, 5, 8, 20])
def test_factors_solve(way, size, width):
    rng = np.random.default_rng([size, width])
    matrix = banded(rng, size, width)
    order = rng.permutation(size)
    shuffled = matrix[np.ix_(order, order)]
    force = rng.normal(size=size)
    factors = Band(sparse.csr_array(shuffled)).factors()
    np.testing.assert_allclose(shuffled @ factors.solve(force), force, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(np.log(factors.pivots).sum() * 2, np.linalg.slogdet(matrix)[1], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(("size", "width"), [(5, 1), (9, 4), (40, 7)])
def test_a_shift_beyond_the_smallest_eigenvalue_has_no_factors(way, size, width):
    matrix = banded(np.random.default_rng(size), size, width)
    least = np.linalg.eigvalsh(matrix).min()
    band = Band(sparse.csr_array(matrix))
    assert band.factors(1.001 * least) is None
    assert band.proven_least_eigenvalue(1.001 * least) == 0.0
    assert 0.99 * least < band.proven_least_eigenvalue(0.999 * least) < least


def test_dense_factors():
    rng = np.random.default_rng(1)
    root = rng.normal(size=(30, 30))
    matrix = root @ root.T + np.eye(30)
    band = Band(sparse.csr_array(matrix))
    force = rng.normal(size=30)
    np.testing.assert_allclose(matrix @ band.factors().solve(force), force, atol=1e-10)
    assert band.factors(1.001 * np.linalg.eigvalsh(matrix).min()) is None


def test_what_is_too_wide_is_not_affordable(monkeypatch):
    line = sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(20, 20)).tocsr()
    assert Band(line).affordable
    monkeypatch.setattr("contactqp.algebra.band.MOST_WORK", 79.0)
    assert not Band(line).affordable


def test_dense_factors_are_told_by_the_width_of_the_matrix_as_given():
    """They are not reordered: their rows are as long as those of the matrix, which its band makes shorter."""
    size = 80
    joined = np.triu(np.random.default_rng(0).uniform(size=(size, size)) < 0.05, 1)
    matrix = 8.0 * np.eye(size) + 0.1 * (joined + joined.T)
    band = Band(sparse.csr_array(matrix))
    assert 0.3 * size < band.width < 0.5 * size
    reach = np.abs(np.subtract(*np.nonzero(matrix))).max()
    assert reach > 1.5 * band.width
    shift = 1.0
    assert shift - band.proven_least_eigenvalue(shift) > (reach + 2) * 2.0**-53 * np.trace(matrix)
