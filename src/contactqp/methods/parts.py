"""Principal submatrices of one symmetric matrix: how each is multiplied by, and solved with, as its size asks for."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..algebra.sparse import DENSE_SIZE
from ..foundation.checks import Mask, Vector
from ..foundation.loading import load_modules
from .factors import Solve, factorised

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_NARROW = 3.0
"""A band of this many times the root of the size is factorised faster than the sparse matrix, up to some thousands."""

_MOST_WORK = 4e9
"""Size times the square of the width of a band that is factorised in a second or so."""

_FEW_NEIGHBOURS = 8
"""Width of a band that is factorised in less time than a few multigrid cycles take."""


class Parts(ABC):
    """A matrix G, symmetric positive definite or an M-matrix, and equations G_FF x = f for sets F of its unknowns.

    The factors of the last set are kept.
    """

    def __init__(self) -> None:
        self._chosen: Mask | None = None
        self._solve: Solve | None = None

    @property
    def in_lines(self) -> bool:
        """Whether unknowns have few neighbours in their order, so that factors take little time at any size."""
        return False

    @property
    def affordable(self) -> bool:
        """Whether factors take a second or so at most, where nothing else will do."""
        return False

    @abstractmethod
    def product(self, vector: Vector) -> Vector:
        """Return G times a vector, shape (n,)."""

    def solver(self, chosen: Mask) -> Solve | None:
        """Return a function that solves G_FF x = f with vectors of F's length; None where G_FF is singular.

        Parameters
        ----------
        chosen : array of bool, shape (n,)
            The set F, which is not empty.
        """
        if self._chosen is None or not np.array_equal(chosen, self._chosen):
            self._chosen, self._solve = chosen.copy(), self._factorised(chosen)
        return self._solve

    @abstractmethod
    def _factorised(self, chosen: Mask) -> Solve | None:
        """Return what `solver` does for a new set."""


class _Dense(Parts):
    def __init__(self, matrix: csr_array) -> None:
        super().__init__()
        self._matrix = matrix.toarray()

    def product(self, vector: Vector) -> Vector:
        return np.asarray(self._matrix @ vector)

    def _factorised(self, chosen: Mask) -> Solve | None:
        part = self._matrix[np.ix_(chosen, chosen)]
        return lambda force: np.asarray(np.linalg.solve(part, force))


class _Sparse(Parts):
    def __init__(self, matrix: csr_array) -> None:
        super().__init__()
        self._matrix = matrix

    def product(self, vector: Vector) -> Vector:
        return np.asarray(self._matrix @ vector)

    def _factorised(self, chosen: Mask) -> Solve | None:
        rows = np.flatnonzero(chosen)
        return factorised(self._matrix[rows][:, rows])


class _Banded(_Sparse):
    """A narrow band, by LAPACK's Cholesky factors: no ordering to be found, no fill to be foreseen."""

    def __init__(self, matrix: csr_array, width: int) -> None:
        super().__init__(matrix)
        self._width = width

    @property
    def in_lines(self) -> bool:
        return self._width <= _FEW_NEIGHBOURS

    @property
    def affordable(self) -> bool:
        return float(self._matrix.shape[0]) * self._width**2 <= _MOST_WORK

    @cached_property
    def _lower_half(self) -> tuple[NDArray[np.int32], NDArray[np.int32], Vector]:
        """Rows, columns and values of the entries on and below the diagonal, found once something is factorised."""
        entries = self._matrix.tocoo()
        below = entries.row >= entries.col
        return entries.row[below], entries.col[below], entries.data[below]

    def _factorised(self, chosen: Mask) -> Solve | None:
        load_modules("scipy.linalg")
        from scipy.linalg import lapack

        rows, columns, values = self._lower_half
        kept = chosen[rows] & chosen[columns]
        number = np.cumsum(chosen) - 1
        column = number[columns[kept]]
        offset = number[rows[kept]] - column
        band = np.zeros((int(offset.max()) + 1, int(number[-1]) + 1), order="F")
        band[offset, column] = values[kept]
        factor, pivot = lapack.dpbtrf(band, lower=1, overwrite_ab=1)
        if pivot:
            return None
        return lambda force: np.asarray(lapack.dpbtrs(factor, force, lower=1)[0])


def parts_of(matrix: csr_array, *, symmetric: bool = True) -> Parts:
    """Return the parts of a matrix.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Symmetric positive definite, with ascending column numbers and each entry once.
    symmetric : bool
        Whether it is; otherwise it is an M-matrix, which needs no exchange of rows either.

    Examples
    --------
    >>> from scipy import sparse
    >>> parts = parts_of(sparse.csr_array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]]))
    >>> solve = parts.solver(np.array([True, False, True]))
    >>> solve(np.array([1.0, 3.0]))
    array([0.5, 1.5])
    """
    size = matrix.shape[0]
    if size <= DENSE_SIZE:
        return _Dense(matrix)
    if not symmetric:
        return _Sparse(matrix)
    width = int((np.arange(size) - matrix.indices[matrix.indptr[:-1]]).max())
    return _Banded(matrix, width) if width <= _NARROW * np.sqrt(size) else _Sparse(matrix)
