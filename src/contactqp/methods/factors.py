"""Factors of a sparse symmetric matrix."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from ..foundation.checks import Vector
from ..foundation.loading import load_modules

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Solve: TypeAlias = Callable[[Vector], Vector]

DIRECT_SIZE = 4000
"""Up to this many unknowns linear systems are factorised, and nothing needs compiling."""


def factorised(matrix: csr_array, *, pivoting: bool = False, definite: bool = False) -> Solve | None:
    """Return a function that solves with a symmetric matrix by its factors; None where a pivot vanishes.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Symmetric and positive definite.
    pivoting : bool
        Whether rows may be exchanged: safer where the matrix is not known to be positive definite, and slower.
    definite : bool
        Whether to return None also where a pivot is negative, so that the matrix is not positive definite.
    """
    load_modules("scipy.sparse.linalg")
    from scipy.sparse import linalg

    symmetric = {} if pivoting else {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    try:
        factors = linalg.splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", **symmetric)
    except RuntimeError:
        return None
    if definite and not (factors.U.diagonal() > 0).all():
        return None
    return lambda force: np.asarray(factors.solve(force))
