"""A proven lower bound of the smallest eigenvalue of a symmetric matrix.

That σ minus a small number is one is proven by a Cholesky factorisation of G - σI that runs to completion in floating
point: then the smallest eigenvalue of G - σI is at least -γ_{n+1}/(1 - γ_{n+1}) times its trace (Rump, *Verification of
positive definiteness*, BIT 46, 2006; Higham, *Accuracy and Stability of Numerical Algorithms*, 2002, theorem 10.3).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..foundation.checks import Vector
from ..foundation.loading import load_modules
from ..foundation.rounding import UNDERFLOW, UNIT_ROUNDOFF, gamma

if TYPE_CHECKING:
    from scipy.sparse import csr_array


DENSE_SIZE = 3000
"""Up to this many unknowns a dense factorisation is affordable."""

_TRIALS = (0.9, 0.5, 0.1, 1e-2, 1e-4)
"""Parts of an estimate of the smallest eigenvalue that are tried as a proven bound, in turn."""

_POWER_STEPS = 8


def proven_least_eigenvalue(matrix: csr_array) -> tuple[float, Vector] | None:
    """Return a proven lower bound > 0 of the smallest eigenvalue of DGD, and the powers of two D; or None.

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
    size = matrix.shape[0]
    if size > DENSE_SIZE:
        return None
    exponents = np.round(-0.5 * np.log2(matrix.diagonal()))
    units = np.ldexp(1.0, exponents.astype(int))
    with np.errstate(over="ignore", under="ignore"):
        scaled = units[:, None] * matrix.toarray() * units[None, :]
        exact = np.array_equal(scaled / units[:, None] / units[None, :], matrix.toarray())
    if not (exact and np.isfinite(scaled).all() and np.isfinite(units).all()):
        return None
    estimate = _estimated_least_eigenvalue(scaled)
    for part in _TRIALS if estimate > 0 else ():
        bound = _proven_above(scaled, part * estimate)
        if bound > 0:
            return bound, units
    return None


def _estimated_least_eigenvalue(scaled: np.ndarray) -> float:
    """Return a rough estimate, by inverse iteration."""
    load_modules("scipy.linalg")
    from scipy import linalg

    try:
        factors = linalg.cho_factor(scaled, lower=True, check_finite=False)
    except linalg.LinAlgError:
        return 0.0
    vector = np.random.default_rng(0).uniform(-1, 1, scaled.shape[0])
    length = 1.0
    for _ in range(_POWER_STEPS):
        vector = linalg.cho_solve(factors, vector / np.linalg.norm(vector), check_finite=False)
        length = float(np.linalg.norm(vector))
    return 1 / length


def _proven_above(scaled: np.ndarray, shift: float) -> float:
    """Return a lower bound of the smallest eigenvalue close to ``shift``, and 0 where that is not proven."""
    size = scaled.shape[0]
    shifted = scaled.copy()
    shifted[np.diag_indices(size)] -= shift
    try:
        np.linalg.cholesky(shifted)
    except np.linalg.LinAlgError:
        return 0.0
    growth = gamma(size + 1)
    trace = float(np.trace(scaled)) * (1 + gamma(size))
    # The diagonal, below 2, was rounded when it was shifted.
    lost = growth / (1 - growth) * trace + 4 * UNIT_ROUNDOFF + size * UNDERFLOW
    return float(max(0.0, shift - 1.01 * lost))
