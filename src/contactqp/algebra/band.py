"""Cholesky factors of a sparse symmetric matrix in a band, its unknowns ordered so that the band is narrow.

The order is that of Cuthill and McKee, reversed. The factors have no entries outside the band, so that their memory and
time are known before the work begins.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Vector
from ..foundation.loading import load_modules
from ..foundation.rounding import UNDERFLOW, UNIT_ROUNDOFF, gamma

if TYPE_CHECKING:
    from scipy.sparse import csr_array

MOST_ENTRIES = 30_000_000
"""Entries of a band that are held in memory: 240 MB."""

MOST_WORK = 2e10
"""Size times the square of the width: some seconds on one core."""

_LITTLE_WORK = 1e8
"""Multiplications that take LAPACK less time than loading compiled code takes."""

_NEARLY_DENSE = 0.3
"""Part of all entries from which no order makes the band much narrower, and a dense factorisation is the faster one."""

_GROW = 1 + 16 * UNIT_ROUNDOFF

_POWER_STEPS, _SETTLED = 8, 1e-3
"""Steps of inverse iteration at most, and the relative change of the estimate at which they end."""


class Band:
    """A symmetric matrix as a band.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Symmetric, with a positive diagonal.

    Attributes
    ----------
    width : int
        Entries beside the diagonal of a row, on one side.

    Examples
    --------
    >>> from scipy import sparse
    >>> line = sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(20, 20)).tocsr()
    >>> order = np.random.default_rng(0).permutation(20)
    >>> band = Band(line[order][:, order])
    >>> band.width, band.affordable
    (1, True)
    >>> band.factors().solve(np.ones(20)).max().round(12)
    np.float64(55.0)
    """

    def __init__(self, matrix: csr_array) -> None:
        load_modules("scipy.sparse", "scipy.sparse.csgraph")
        from scipy import sparse
        from scipy.sparse import csgraph

        self._matrix, self.size = matrix, int(matrix.shape[0])
        given = matrix.tocoo()
        self._rows, self._columns = (coordinate.astype(np.int64) for coordinate in given.coords)
        self._values = given.data
        self._place: NDArray[np.int64] = np.arange(self.size)
        self.width = self._width_as_given = self._width()
        narrowest = int(np.diff(matrix.indptr).max()) // 2  # a row has no more entries on either side than its width
        if self.width > narrowest and given.nnz < _NEARLY_DENSE * self.size**2:
            pattern = (np.ones(matrix.nnz, dtype=np.int8), matrix.indices, matrix.indptr)
            order = csgraph.reverse_cuthill_mckee(sparse.csr_matrix(pattern, shape=matrix.shape), symmetric_mode=True)
            as_given, self._place = self._place, np.empty(self.size, dtype=np.int64)
            self._place[order] = np.arange(self.size)
            width = self._width()
            if width < self.width:
                self.width = width
            else:
                self._place = as_given

    @property
    def place(self) -> NDArray[np.int64]:
        """Where each unknown stands in the band, shape (n,)."""
        return self._place

    def inwards(self, vector: Vector) -> Vector:
        """Return a vector in the order of the band."""
        ordered = np.empty_like(vector)
        ordered[self._place] = vector
        return ordered

    @cached_property
    def lower_half(self) -> tuple[NDArray[np.int64], NDArray[np.int64], Vector]:
        """Rows and columns in the band, and values, of the entries on and below the diagonal."""
        row, column = self._place[self._rows], self._place[self._columns]
        below = row >= column
        return row[below], column[below], self._values[below]

    def _width(self) -> int:
        return int(np.abs(self._place[self._rows] - self._place[self._columns]).max())

    @property
    def affordable(self) -> bool:
        """Whether memory and time of a factorisation are within `MOST_ENTRIES` and `MOST_WORK`."""
        entries = self.size * (self.width + 1)
        return entries <= MOST_ENTRIES and float(entries) * (self.width + 1) <= MOST_WORK

    @property
    def _nearly_dense(self) -> bool:
        return self.width > _NEARLY_DENSE * self.size

    def factors(self, shift: float = 0.0) -> Factors | None:
        """Return the Cholesky factors of the matrix less ``shift`` on its diagonal; None where they do not exist."""
        load_modules("scipy.linalg.lapack")
        from scipy.linalg import lapack

        if self._nearly_dense:
            return self._dense_factors(shift)
        row, column, values = self.lower_half
        if float(self.size) * self.width**2 > _LITTLE_WORK:
            return self._wide_factors(row, column, values, shift)
        band = np.zeros((self.width + 1, self.size), order="F")
        band[row - column, column] = values
        band[0] -= shift
        factor, pivot = lapack.dpbtrf(band, lower=1, overwrite_ab=1)
        if pivot or not np.isfinite(factor[0]).all():
            return None
        return Factors(factor, self._place)

    def _wide_factors(
        self, row: NDArray[np.int64], column: NDArray[np.int64], values: Vector, shift: float
    ) -> Factors | None:
        """Return the factors by compiled code: LAPACK holds the interpreter, and stalls on a busy machine."""
        load_modules("contactqp.algebra.band_kernels", kernels="factors in a band")
        from .band_kernels import PANEL, factorise

        band = np.zeros((self.size, self.width + PANEL))
        band[column, row - column] = values
        band[:, 0] -= shift
        return None if factorise(band, self.width) else Factors(band.T, self._place)

    def _dense_factors(self, shift: float) -> Factors | None:
        dense = self._matrix.toarray()
        dense[np.diag_indices(self.size)] -= shift
        try:
            factor = np.linalg.cholesky(dense)
        except np.linalg.LinAlgError:
            return None
        return Factors(np.asfortranarray(factor), None) if np.isfinite(factor.diagonal()).all() else None

    def proven_least_eigenvalue(self, shift: float) -> float:
        r"""Return a lower bound of the smallest eigenvalue that is close to ``shift``, and 0 where that is not proven.

        If a Cholesky factorisation of A - σI runs to completion in floating point, its factors are the exact ones of a
        matrix that differs from it by ΔA with \|ΔA_ij\| ≤ g √(a_ii a_jj), g = γ_{b+2}/(1 - γ_{b+2}), where b is the
        width of the band, because no entry of the factors is a sum of more than b products and there are none outside
        the band (Higham, *Accuracy and Stability of Numerical Algorithms*, 2002, theorems 10.3 and 10.5; Rump,
        *Verification of positive definiteness*, BIT 46, 2006). Dense factors are those of the matrix as given, so that
        b is its width before the unknowns were ordered. So ‖ΔA‖ is at most g times the trace, and at most
        g (2b + 1) times the largest a_ii, and A has no eigenvalue below σ less that.
        """
        diagonal = np.abs(self._matrix.diagonal())
        width = self._width_as_given if self._nearly_dense else self.width
        growth = gamma(width + 2)
        spread = min(float(diagonal.sum()) * (1 + gamma(self.size)), (2 * width + 1) * float(diagonal.max()))
        # The diagonal was rounded when it was shifted.
        rounded = 2 * UNIT_ROUNDOFF * (float(diagonal.max()) + shift)
        lost = growth / (1 - growth) * spread + rounded + self.size * UNDERFLOW
        bound = float((shift - 1.01 * lost) / _GROW)
        return bound if bound > 0 and self.factors(shift) is not None else 0.0


class Factors:
    """Cholesky factors in a band, or dense ones.

    Parameters
    ----------
    factor : array, shape (width + 1, n) or (n, n)
        The lower factor; that of a band has its diagonal in the first row.
    place : array of int, shape (n,), or None
        Where each unknown stands in the band; None for dense factors.
    """

    def __init__(self, factor: NDArray[np.float64], place: NDArray[np.int64] | None) -> None:
        self._factor, self._place = factor, place

    @property
    def pivots(self) -> Vector:
        """The factor's diagonal, shape (n,)."""
        return np.asarray(self._factor.diagonal() if self._place is None else self._factor[0])

    def estimated_least_eigenvalue(self) -> float:
        """Return an estimate of the matrix's smallest eigenvalue; it is no bound."""
        return estimated_least_eigenvalue(self.solve, self.pivots.size)

    def solve(self, force: Vector) -> Vector:
        """Return the solution x of Gx = f."""
        load_modules("scipy.linalg.lapack")
        from scipy.linalg import lapack

        if self._place is None:
            return np.asarray(lapack.dpotrs(self._factor, force, lower=1)[0])
        ordered = np.empty_like(force)
        ordered[self._place] = force
        return np.asarray(lapack.dpbtrs(self._factor, ordered, lower=1)[0])[self._place]


def estimated_least_eigenvalue(solve: Callable[[Vector], Vector], size: int) -> float:
    """Return an estimate of the smallest eigenvalue: the Rayleigh quotient after some steps of inverse iteration.

    Parameters
    ----------
    solve : callable
        Returns the solution x of Gx = f.
    size : int
        Unknowns.
    """
    vector, last, estimate = np.random.default_rng(0).uniform(-1, 1, size), np.inf, np.inf
    for _ in range(_POWER_STEPS):
        before = vector / np.sqrt((vector * vector).sum())
        vector = solve(before)
        last, estimate = estimate, float((before * vector).sum() / (vector * vector).sum())
        if abs(estimate - last) <= _SETTLED * estimate:
            break
    return estimate
