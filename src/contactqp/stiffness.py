"""What the algebra needs of a stiffness G, and its realisation for a matrix that the user brings."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ._checks import Vector, real_array

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_ASYMMETRY = 1e-12
"""Relative difference of G_ij and G_ji that is taken for rounding and averaged away."""


class Stiffness(Protocol):
    """A symmetric matrix G known by what it does: a `Stencil`, or a `SparseStiffness`."""

    @property
    def size(self) -> int:
        """Number of rows."""
        ...

    @property
    def nonzeros(self) -> int:
        """Number of stored entries."""
        ...

    def matvec(self, vector: Vector) -> Vector:
        """Return G times ``vector``."""
        ...

    def diagonal(self) -> Vector:
        """Return the diagonal."""
        ...

    def tocsr(self) -> csr_array:
        """Return G as a sparse array with sorted column numbers."""
        ...


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


def weakly_dominant(matrix: csr_array) -> bool:
    """Whether a Z-matrix is diagonally dominant to rounding, strictly in a row of each connected part.

    Then it is positive definite up to rounding (Taussky 1949). That is enough to put off the proof to the barrier,
    which every use of the matrix needs anyway.
    """
    from scipy.sparse import csgraph

    entries = matrix.tocoo()
    i, j = entries.coords
    off = i != j
    if (entries.data[off] > 0).any():
        return False
    diagonal = matrix.diagonal()
    radius = np.bincount(i[off], weights=-entries.data[off], minlength=matrix.shape[0])
    if not (radius <= diagonal * (1 + 1e-13)).all():
        return False
    strict = radius < diagonal * (1 - 1e-10)
    count, part = csgraph.connected_components(matrix, directed=False)
    return bool(np.bincount(part, weights=strict, minlength=count).all())


def refuse_indefinite(matrix: csr_array) -> None:
    """Raise a ValueError unless the symmetric ``matrix`` is numerically positive definite.

    The signs of the pivots of a symmetric factorisation are counted (Sylvester's law of inertia); an exchange of rows,
    which only a zero pivot makes necessary, also tells against it.
    """
    entries = matrix.tocoo()
    i, j = entries.coords
    root = np.sqrt(matrix.diagonal())
    off = i != j
    excess = np.abs(entries.data[off]) / root[i[off]] / root[j[off]]
    if excess.size and excess.max() >= 1:
        worst = int(np.argmax(excess))
        row, column, value = int(i[off][worst]), int(j[off][worst]), entries.data[off][worst]
        raise ValueError(
            f"G must be positive definite, but |G[{row}, {column}]| = {abs(value):g} is not below the geometric mean "
            f"of G[{row}, {row}] = {root[row] ** 2:g} and G[{column}, {column}] = {root[column] ** 2:g}"
        )
    negative = _negative_pivots(matrix, 1 / root)
    if negative:
        raise ValueError(
            f"G must be positive definite, but numerically it is not: a factorisation finds {negative} pivot(s) <= 0"
        )


def _negative_pivots(matrix: csr_array, balance: Vector) -> int:
    from scipy import sparse
    from scipy.sparse import linalg

    scaling = sparse.diags_array(balance)
    unit = (scaling @ matrix @ scaling).tocsc()
    try:
        factors = linalg.splu(unit, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:
        return 1
    if not np.array_equal(factors.perm_r, factors.perm_c):
        return 1
    rounding = 4 * np.finfo(float).eps * matrix.shape[0]
    return int(np.count_nonzero(factors.U.diagonal() <= rounding))
