"""A symmetric matrix whose unknowns are measured in other units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..foundation.checks import Vector
from ..foundation.loading import load_modules

if TYPE_CHECKING:
    from scipy.sparse import csr_array


def balanced(matrix: csr_array, weights: Vector) -> Any:
    """Return DGD for a diagonal matrix D, as a sparse array of some format.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        G.
    weights : array, shape (n,)
        The diagonal of D; with one over the roots of G's diagonal, the result has a diagonal of ones.

    Examples
    --------
    >>> import numpy as np
    >>> from scipy.sparse import csr_array
    >>> balanced(csr_array([[4.0, 1.0], [1.0, 1.0]]), np.array([0.5, 1.0])).toarray()
    array([[1. , 0.5],
           [0.5, 1. ]])
    """
    load_modules("scipy.sparse")
    from scipy import sparse

    scaling = sparse.diags_array(weights)
    return scaling @ matrix @ scaling
