"""SparseStiffness: a stiffness G that the user brings as a matrix, and the checks of it."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.checks import Vector, real_array

if TYPE_CHECKING:
    from scipy.sparse import csr_array


_ASYMMETRY = 1e-12
"""Relative difference of G_ij and G_ji that is taken for rounding and averaged away."""


class SparseStiffness:
    """G held as a sparse array.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Must come from `checked_matrix`.
    """

    def __init__(self, matrix: csr_array) -> None:
        self._matrix = matrix

    @property
    def size(self) -> int:
        """Number of rows."""
        return int(self._matrix.shape[0])

    @property
    def nonzeros(self) -> int:
        """Number of stored entries."""
        return int(self._matrix.nnz)

    def matvec(self, vector: Vector) -> Vector:
        """Return G times ``vector``."""
        return np.asarray(self._matrix @ vector)

    def diagonal(self) -> Vector:
        """Return the diagonal."""
        return np.asarray(self._matrix.diagonal())

    def modulus_matvec(self, vector: Vector) -> Vector:
        """Return |G| times ``vector``."""
        return np.asarray(self._modulus @ vector)

    @cached_property
    def _modulus(self) -> csr_array:
        return abs(self._matrix)

    def comparison(self) -> SparseStiffness:
        """Return the comparison matrix: the diagonal of G, and -|G_ij| beside it."""
        from scipy import sparse

        return SparseStiffness((sparse.diags_array(2 * self.diagonal()) - self._modulus).tocsr())

    @property
    def finite(self) -> bool:
        """Whether all entries are finite."""
        return bool(np.isfinite(self._matrix.data).all())

    def balanced(self, weights: Vector) -> SparseStiffness:
        """Return the matrix with the entries weights_i G_ij weights_j."""
        rows = np.repeat(np.arange(self.size), np.diff(self._matrix.indptr))
        matrix = self._matrix.copy()
        matrix.data *= weights[rows] * weights[matrix.indices]
        return SparseStiffness(matrix)

    def tocsr(self) -> csr_array:
        """Return the sparse array itself."""
        return self._matrix


def checked_matrix(value: Any) -> csr_array:
    """Return ``value`` as a new symmetric CSR array of floats, or say what is wrong with it.

    Parameters
    ----------
    value : sparse array, sparse matrix or dense array, shape (n, n)
        The stiffness G. Differences of G_ij and G_ji below 1e-12 are taken for rounding and averaged.

    Raises
    ------
    TypeError
        If it is complex or not numeric.
    ValueError
        If it is empty, not square, not finite, not symmetric, or has a diagonal entry <= 0.
    """
    from scipy import sparse

    if sparse.issparse(value):
        if value.ndim != 2:
            raise ValueError(f"G must be a square matrix, got shape {value.shape}")
        if value.dtype.kind not in "iuf":
            raise TypeError(f"G must hold real numbers, got dtype {value.dtype}")
        matrix = sparse.csr_array(value, dtype=np.float64, copy=True)
    else:
        dense = real_array(value, "G")
        if dense.ndim != 2:
            raise ValueError(f"G must be a square matrix, got shape {dense.shape}")
        matrix = sparse.csr_array(dense)
    if matrix.shape[0] != matrix.shape[1]:
        raise ValueError(f"G must be square, got shape {matrix.shape}")
    if matrix.shape[0] == 0:
        raise ValueError("G must have at least one row, got shape (0, 0)")
    matrix.sum_duplicates()
    bad = np.flatnonzero(~np.isfinite(matrix.data))
    if bad.size:
        row = int(np.searchsorted(matrix.indptr, bad[0], side="right")) - 1
        raise ValueError(f"G must be finite, but G[{row}, {matrix.indices[bad[0]]}] is {matrix.data[bad[0]]}")
    matrix.eliminate_zeros()
    diagonal = matrix.diagonal()
    worst = int(np.argmin(diagonal))
    if not diagonal[worst] > 0:
        raise ValueError(
            f"G must be positive definite, but G[{worst}, {worst}] is {diagonal[worst]:g}; "
            "every diagonal entry must be > 0"
        )
    return _symmetric(matrix)


def _symmetric(matrix: csr_array) -> csr_array:
    difference = (matrix - matrix.T).tocoo()
    if not difference.nnz or not np.abs(difference.data).max():
        matrix.sort_indices()
        return matrix
    diagonal = np.sqrt(matrix.diagonal())
    scale = diagonal[difference.coords[0]] * diagonal[difference.coords[1]]
    worst = int(np.argmax(np.abs(difference.data) / scale))
    if abs(difference.data[worst]) > _ASYMMETRY * scale[worst]:
        i, j = (int(coordinate[worst]) for coordinate in difference.coords)
        raise ValueError(
            f"G must be symmetric, but G[{i}, {j}] = {matrix[i, j]:g} and G[{j}, {i}] = {matrix[j, i]:g}; "
            "pass (G + G.T) / 2 if that is what you mean"
        )
    average = (matrix / 2 + matrix.T / 2).tocsr()
    average.sort_indices()
    return average
