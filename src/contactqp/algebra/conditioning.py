"""How nearly singular a symmetric positive definite matrix is: an estimate, and what it means, in words."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..foundation.checks import Vector
from ..foundation.loading import load_modules
from .definiteness import ritz_value

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_FEW = 4000
"""Up to this many unknowns a factorisation is affordable, whatever its fill."""

_STEPS = 12
"""Steps of inverse iteration; a matrix that is nearly singular takes two."""

_EPS = float(np.finfo(np.float64).eps)


def estimated_condition(matrix: csr_array) -> float:
    """Return an estimate of the condition number of a matrix with its diagonal scaled to ones; infinite if singular.

    Up to some thousand unknowns it is right to a factor of two or so, as far as double precision can tell; above it is
    an estimate from below.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Symmetric, with a positive diagonal.

    Examples
    --------
    >>> from scipy.sparse import csr_array
    >>> round(estimated_condition(csr_array([[4.0, 1.0], [1.0, 1.0]])), 6)
    3.0
    """
    load_modules("scipy.sparse", "scipy.sparse.linalg")
    from scipy import sparse
    from scipy.sparse import linalg

    scaling = sparse.diags_array(1 / np.sqrt(matrix.diagonal()))
    unit = (scaling @ matrix @ scaling).tocsc()
    size = unit.shape[0]
    start = np.random.default_rng(0).uniform(-1, 1, size)
    largest = _grown(lambda vector: np.asarray(unit @ vector), start)
    if size > _FEW:
        smallest = ritz_value(matrix)
        return largest / smallest if smallest > 0 else math.inf
    try:
        factors = linalg.splu(unit)
    except RuntimeError:  # exactly singular
        return math.inf
    inverse = _grown(lambda vector: np.asarray(factors.solve(vector)), start)
    return largest * inverse if math.isfinite(inverse) else math.inf


def _grown(apply: Callable[[Vector], Vector], vector: Vector) -> float:
    """Return an estimate of a symmetric matrix's largest eigenvalue in modulus, by the power method."""
    norm = 0.0
    for _ in range(_STEPS):
        vector = vector / math.sqrt(float((vector * vector).sum()))
        vector = apply(vector)
        norm = math.sqrt(float((vector * vector).sum()))
        if not (0 < norm < math.inf):
            break
    return norm


def digits_kept(condition: float) -> int:
    """Return how many decimal digits of an answer double precision keeps at a condition number, at least 0.

    Examples
    --------
    >>> digits_kept(1.0), digits_kept(2e12), digits_kept(3e15), digits_kept(math.inf)
    (15, 3, 0, 0)
    """
    return max(0, int(-math.log10(min(condition, 1 / _EPS) * _EPS)))


def told_condition(condition: float) -> str:
    """Return a condition number in words.

    Examples
    --------
    >>> told_condition(2.2e12), told_condition(1e18)
    ('about 2e+12', 'above 4e+15')
    """
    return f"about {condition:.0e}" if condition < 1 / _EPS else "above 4e+15"
