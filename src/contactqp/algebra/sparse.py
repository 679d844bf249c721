"""SparseStiffness: a stiffness G that the user brings as a matrix, and the checks of it."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector, read_only, real_array
from ..foundation.loading import load_modules
from .compensated import Chain, two_product
from .definiteness import positive_beyond_rounding
from .stiffness import Stiffness

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from .stencil import Stencil


DENSE_SIZE = 50
"""Up to so many unknowns a dense matrix is multiplied and solved with in less time than a sparse one is looked at."""

_ASYMMETRY = 1e-12
"""Relative difference of G_ij and G_ji that is taken for rounding and averaged away."""


class SparseStiffness(Stiffness):
    """G held as a sparse array.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Symmetric, with a positive diagonal and sorted column numbers; `of` checks that.
    """

    def __init__(self, matrix: csr_array) -> None:
        self._matrix = matrix

    @classmethod
    def of(cls, value: Any) -> Self:
        """Return a matrix that the user brings, checked to be symmetric, with a positive diagonal.

        Parameters
        ----------
        value : sparse array, sparse matrix or dense array, shape (n, n)

        Raises
        ------
        TypeError, ValueError
            See `checked_matrix`.
        """
        matrix = checked_matrix(value)
        matrix.data.setflags(write=False)
        return cls(matrix)

    @property
    def size(self) -> int:
        """Number of rows."""
        return int(self._matrix.shape[0])

    @property
    def nonzeros(self) -> int:
        """Number of stored entries."""
        return int(self._matrix.nnz)

    @property
    def finite(self) -> bool:
        """Whether all entries are finite."""
        return bool(np.isfinite(self._matrix.data).all())

    @cached_property
    def longest_row(self) -> int:
        """Largest number of entries in a row."""
        return int(np.diff(self._matrix.indptr).max())

    @cached_property
    def positive_off_diagonal(self) -> tuple[int, int, float] | None:
        """Row, column and value of the largest positive off-diagonal entry, or None for a Z-matrix.

        Entries that are no more than rounding count as zero, see `surplus`.
        """
        entries = self._matrix.tocoo()
        i, j = entries.coords
        off = np.where(positive_beyond_rounding(self._matrix), entries.data, 0.0)
        worst = int(np.argmax(off))
        return (int(i[worst]), int(j[worst]), float(off[worst])) if off[worst] > 0 else None

    @cached_property
    def surplus(self) -> csr_array | None:
        """See `Stiffness.surplus`."""
        load_modules("scipy.sparse")
        from scipy import sparse

        if self.positive_off_diagonal is not None:
            return None
        entries = self._matrix.tocoo()
        i, j = entries.coords
        kept = np.flatnonzero((i != j) & (entries.data > 0))
        if not kept.size:
            return None
        return sparse.csr_array((entries.data[kept], (i[kept], j[kept])), shape=entries.shape)

    def recognised_lattice(self) -> Stencil | None:
        """Return the lattice whose five-point matrix this is, up to rounding, or None."""
        from .recognition import lattice_of

        return lattice_of(self._matrix)

    def matvec(self, vector: Vector) -> Vector:
        """See `Stiffness.matvec`."""
        # Zeros of a small dense matrix add no rounding errors, and it is multiplied before a sparse one is looked at.
        # For many vectors BLAS would call its threads, which stall on a busy machine.
        one = vector.ndim == 1 and self._small is not None
        return _times(self._small if one else self._matrix, vector)

    @cached_property
    def _small(self) -> NDArray[np.float64] | None:
        return np.asarray(self._matrix.toarray()) if self.size <= DENSE_SIZE else None

    def modulus_matvec(self, vector: Vector) -> Vector:
        """See `Stiffness.modulus_matvec`; for a Z-matrix without a second matrix."""
        if self.positive_off_diagonal is None and self.surplus is None:
            return np.asarray(self.diagonal() * (2 * vector) - self.matvec(vector))
        return _times(self._modulus, vector)

    def _moduli(self, vector: Vector, product: Vector) -> Vector:
        if self.positive_off_diagonal is None and self.surplus is None and vector.min() >= 0:
            return np.asarray(self.diagonal() * (2 * vector) - product)
        return self.modulus_matvec(np.abs(vector))

    def diagonal(self) -> Vector:
        """Return the diagonal, read-only."""
        return self._diagonal

    @cached_property
    def _diagonal(self) -> Vector:
        return read_only(np.asarray(self._matrix.diagonal()))

    @cached_property
    def _modulus(self) -> csr_array:
        return self._with_entries(np.abs(self._matrix.data))

    def accurate_product(self, high: Vector, low: Vector, force: Vector) -> tuple[Vector, Vector]:
        """Add entry times gap, the first entry of every row, then the second of those that have one, and so on."""
        matrix = self._matrix
        length = np.diff(matrix.indptr)
        order = np.argsort(-length, kind="stable")
        starts = matrix.indptr[:-1][order]
        ascending = np.sort(length)
        with np.errstate(over="ignore", invalid="ignore"):
            chain = Chain(force[order])
            for k in range(int(ascending[-1])):
                count = int(length.size - np.searchsorted(ascending, k, side="right"))
                places = starts[:count] + k
                entry, column = matrix.data[places], matrix.indices[places]
                product, error = two_product(entry, high[column])
                chain.add(product, error, entry * low[column])
            total, error_bound = chain.result(int(ascending[-1]) + 1)
        result, bound = np.empty_like(total), np.empty_like(total)
        result[order], bound[order] = total, error_bound
        return result, bound

    def restricted(self, free: Mask) -> Self:
        """Return the rows and columns of some unknowns."""
        chosen = np.flatnonzero(free)
        if chosen.size == free.size:
            return self
        return type(self)(self._matrix[chosen][:, chosen])

    def comparison(self) -> SparseStiffness:
        """Return the comparison matrix: the diagonal of G, and -|G_ij| beside it."""
        load_modules("scipy.sparse")
        from scipy import sparse

        return SparseStiffness((sparse.diags_array(2 * self.diagonal()) - self._modulus).tocsr())

    def dimensionless(self) -> tuple[Self, Vector, float]:
        """Return the matrix with a diagonal of about ones, the units of its unknowns, and a largest diagonal entry.

        All of them are powers of two, and the scaled diagonal lies between 1/2 and 2: so nothing is rounded, which an
        ill-conditioned matrix would not forgive.
        """
        exponents = np.round(-0.5 * np.log2(self.diagonal())).astype(int)
        least = int(exponents.min())
        units = np.ldexp(1.0, exponents - least)
        return self.balanced(np.ldexp(1.0, exponents)), units, float(np.ldexp(1.0, -2 * least))

    def in_units(self, units: float | Vector) -> Self:
        """See `Stiffness.in_units`."""
        return self.balanced(np.broadcast_to(units, (self.size,)))

    def balanced(self, weights: Vector) -> Self:
        """Return the matrix with the entries weights_i G_ij weights_j, for weights > 0, which leave signs alone."""
        rows = np.repeat(np.arange(self.size), np.diff(self._matrix.indptr))
        factors = weights[rows]
        factors *= weights[self._matrix.indices]
        factors *= self._matrix.data
        found = type(self)(self._with_entries(factors))
        if self.positive_off_diagonal is None:
            found.positive_off_diagonal = None
        return found

    def _with_entries(self, entries: Vector) -> csr_array:
        """Return the matrix with other entries at the same places, whose numbers the two share."""
        load_modules("scipy.sparse")
        from scipy import sparse

        return sparse.csr_array((entries, self._matrix.indices, self._matrix.indptr), shape=self._matrix.shape)

    @property
    def _arrays(self) -> tuple[NDArray[Any], ...]:
        return _parts(self._matrix)

    def tocsr(self) -> csr_array:
        """Return the sparse array itself."""
        return self._matrix


def _parts(matrix: csr_array) -> tuple[NDArray[Any], ...]:
    return matrix.indptr, matrix.indices, matrix.data


def _times(matrix: Any, vector: Vector) -> Vector:
    """Return a matrix times a vector, or times each of the rows of an array; in the order of memory in either case."""
    return np.ascontiguousarray((matrix @ vector.T).T)


def square_matrix(value: Any, name: str) -> csr_array:
    """Return ``value`` as a new CSR array of floats with each entry once, or say what is wrong with it.

    Parameters
    ----------
    value : sparse array, sparse matrix or dense array, shape (n, n)
    name : str
        The argument's name, for messages.

    Raises
    ------
    TypeError
        If it is complex or not numeric.
    ValueError
        If it is empty, not square, or not finite.
    """
    load_modules("scipy.sparse")
    from scipy import sparse

    if sparse.issparse(value):
        if value.ndim != 2:
            raise ValueError(f"{name} must be a square matrix, got shape {value.shape}")
        if value.dtype.kind not in "iuf":
            raise TypeError(f"{name} must hold real numbers, got dtype {value.dtype}")
        matrix = sparse.csr_array(value, dtype=np.float64, copy=True)
    else:
        dense = real_array(value, name)
        if dense.ndim != 2:
            raise ValueError(f"{name} must be a square matrix, got shape {dense.shape}")
        matrix = sparse.csr_array(dense)
    if matrix.shape[0] != matrix.shape[1]:
        raise ValueError(f"{name} must be square, got shape {matrix.shape}")
    if matrix.shape[0] == 0:
        raise ValueError(f"{name} must have at least one row, got shape (0, 0)")
    matrix.sum_duplicates()
    bad = np.flatnonzero(~np.isfinite(matrix.data))
    if bad.size:
        row = int(np.searchsorted(matrix.indptr, bad[0], side="right")) - 1
        raise ValueError(f"{name} must be finite, but {name}[{row}, {matrix.indices[bad[0]]}] is {matrix.data[bad[0]]}")
    matrix.eliminate_zeros()
    if max(matrix.nnz, *matrix.shape) <= np.iinfo(np.int32).max:
        matrix.indptr, matrix.indices = (numbers.astype(np.int32) for numbers in (matrix.indptr, matrix.indices))
    return matrix


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
    matrix = square_matrix(value, "G")
    diagonal = matrix.diagonal()
    worst = int(np.argmin(diagonal))
    if not diagonal[worst] > 0:
        raise ValueError(
            f"G must be positive definite, but G[{worst}, {worst}] is {diagonal[worst]:g}; "
            "every diagonal entry must be > 0"
        )
    return _symmetric(matrix)


def _symmetric(matrix: csr_array) -> csr_array:
    matrix.sort_indices()
    transposed = matrix.T.tocsr()
    if all(np.array_equal(*pair) for pair in zip(_parts(matrix), _parts(transposed), strict=True)):
        return matrix
    difference = (matrix - matrix.T).tocoo()
    if not difference.nnz or not np.abs(difference.data).max():
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
