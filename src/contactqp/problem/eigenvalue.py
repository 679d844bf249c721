"""A proven lower bound of the smallest eigenvalue of a symmetric matrix, see `Band.proven_least_eigenvalue`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..algebra.band import Band, Factors
from ..foundation.checks import Vector

if TYPE_CHECKING:
    from scipy.sparse import csr_array


_TRIALS = (0.9, 0.5, 0.1, 1e-2, 1e-4)
"""Parts of an estimate of the smallest eigenvalue that are tried as a proven bound, in turn."""

_POWER_STEPS = 8


def proven_least_eigenvalue(matrix: csr_array) -> tuple[float, Vector] | None:
    """Return a proven lower bound > 0 of the smallest eigenvalue of DGD, and the powers of two D; or None.

    None stands for a matrix that is not proven positive definite: because it is not, to rounding, or because its
    factorisation would take too long.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Symmetric; D brings its diagonal into [1/2, 2).

    Examples
    --------
    >>> from scipy.sparse import csr_array
    >>> least, units = proven_least_eigenvalue(csr_array([[1.0, 0.5], [0.5, 1.0]]))
    >>> 0.4 < least < 0.5, units.tolist()
    (True, [1.0, 1.0])
    """
    exponents = np.round(-0.5 * np.log2(matrix.diagonal()))
    units = np.ldexp(1.0, exponents.astype(int))
    scaled = _scaled(matrix, units)
    if scaled is None:
        return None
    band = Band(scaled)
    factors = band.factors() if band.affordable else None
    if factors is None:
        return None
    estimate = _estimated_least_eigenvalue(factors, band.size)
    for part in _TRIALS:
        bound = band.proven_least_eigenvalue(part * estimate)
        if bound > 0:
            return bound, units
    return None


def affordable(matrix: csr_array) -> bool:
    """Whether the factorisation that the proof needs does not take too long."""
    return Band(matrix).affordable


def _scaled(matrix: csr_array, units: Vector) -> csr_array | None:
    """Return DGD for powers of two D; None where an entry is rounded by it."""
    rows = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
    scaled = matrix.copy()
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        # One factor after the other: their product alone may leave the range.
        scaled.data = scaled.data * units[rows] * units[matrix.indices]
        exact = np.array_equal(scaled.data / units[rows] / units[matrix.indices], matrix.data)
    return scaled if exact and np.isfinite(scaled.data).all() and np.isfinite(units).all() else None


def _estimated_least_eigenvalue(factors: Factors, size: int) -> float:
    """Return an estimate: the Rayleigh quotient after some steps of inverse iteration."""
    before = vector = np.random.default_rng(0).uniform(-1, 1, size)
    for _ in range(_POWER_STEPS):
        before = vector / np.sqrt((vector * vector).sum())
        vector = factors.solve(before)
    return float((before * vector).sum() / (vector * vector).sum())
