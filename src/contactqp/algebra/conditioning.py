"""How nearly singular a symmetric positive definite matrix is: an estimate, and what it means, in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ..foundation.loading import load_modules
from .balanced import balanced
from .definiteness import FEW, ritz_value
from .power import largest_growth

if TYPE_CHECKING:
    from scipy.sparse import csr_array

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
    load_modules("scipy.sparse.linalg")
    from scipy.sparse import linalg

    unit = balanced(matrix, 1 / np.sqrt(matrix.diagonal())).tocsc()
    size = unit.shape[0]
    start = np.random.default_rng(0).uniform(-1, 1, size)
    largest = largest_growth(lambda vector: np.asarray(unit @ vector), start, _STEPS)
    if size > FEW:
        smallest = ritz_value(matrix)
        return largest / smallest if smallest > 0 else math.inf
    try:
        factors = linalg.splu(unit)
    except RuntimeError:  # exactly singular
        return math.inf
    inverse = largest_growth(lambda vector: np.asarray(factors.solve(vector)), start, _STEPS)
    return largest * inverse if math.isfinite(inverse) else math.inf


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
