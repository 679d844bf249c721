"""Matrices as libraries take them: in compressed columns, and of a symmetric one its upper triangle."""

from __future__ import annotations

from typing import Any

from ..foundation.loading import load_modules


def upper_triangle(matrix: Any) -> Any:
    """Return the upper triangle of a sparse matrix, a csc_matrix of shape (n, n)."""
    load_modules("scipy.sparse")
    from scipy import sparse

    return sparse.csc_matrix(sparse.triu(matrix, format="csc"))


def identity(size: int) -> Any:
    """Return an identity, a csc_matrix of shape (n, n)."""
    load_modules("scipy.sparse")
    from scipy import sparse

    return sparse.csc_matrix(sparse.eye_array(size))
