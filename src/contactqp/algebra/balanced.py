"""A symmetric matrix whose unknowns are measured in other units."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..foundation.checks import Vector
from ..foundation.loading import load_modules

if TYPE_CHECKING:
    from scipy.sparse import csr_array


def balanced(matrix: csr_array, weights: Vector) -> csr_array:
    """Return DGD for a diagonal matrix D, as an array that shares its row pointers and column numbers with G.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        G.
    weights : array, shape (n,)
        The diagonal of D; with one over the roots of G's diagonal, the result has a diagonal of ones.

    Examples
    --------
    >>> from scipy.sparse import csr_array
    >>> balanced(csr_array([[4.0, 1.0], [1.0, 1.0]]), np.array([0.5, 1.0])).toarray()
    array([[1. , 0.5],
           [0.5, 1. ]])
    """
    load_modules("scipy.sparse")
    from scipy import sparse

    rows = np.repeat(np.arange(matrix.shape[0], dtype=np.int32), np.diff(matrix.indptr))
    # One factor after the other: their product alone may leave the range.
    entries = matrix.data * weights[rows]
    entries *= weights[matrix.indices]
    return sparse.csr_array((entries, matrix.indices, matrix.indptr), shape=matrix.shape)
