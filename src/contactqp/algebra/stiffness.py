"""Stiffness: what the program needs of a matrix G, whatever holds it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from ..foundation.checks import Vector
from ..foundation.rounding import gamma

if TYPE_CHECKING:
    from scipy.sparse import csr_array


class Stiffness(Protocol):
    """A symmetric matrix G known by what it does: a `Stencil`, or a `SparseStiffness`."""

    @property
    def size(self) -> int:
        """Number of rows."""
        ...

    @property
    def nonzeros(self) -> int:
        """Number of stored entries."""
        ...

    def matvec(self, vector: Vector) -> Vector:
        """Return G times ``vector``."""
        ...

    def diagonal(self) -> Vector:
        """Return the diagonal."""
        ...

    def tocsr(self) -> csr_array:
        """Return G as a sparse array with sorted column numbers."""
        ...


def growth_bound(stiffness: Stiffness) -> float:
    """Return c such that a computed row of G x + q is within c (|G| |x| + |q|) of the exact one.

    A row with m entries takes m products and m sums (Higham 2002, eq. 3.5); four operations are added for the
    evaluation of the bound itself.
    """
    return gamma(longest_row(stiffness) + 6)


def longest_row(stiffness: Stiffness) -> int:
    """Return the largest number of entries in a row of G."""
    from .stencil import Stencil

    return 5 if isinstance(stiffness, Stencil) else int(np.diff(stiffness.tocsr().indptr).max())
