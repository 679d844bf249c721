"""A large sparse matrix with its unknowns in an order in which neighbours are near each other, and its hierarchy."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...foundation.checks import Vector
from ...foundation.loading import load_modules
from ..factors import DIRECT_SIZE
from .amg import Amg

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_FAR = 4.0
"""Neighbours that are this many times the root of the size apart, on average, are worth renumbering: sweeps over them
wait for memory. Of lattices in the plane, row by row, they are one root apart."""


class Ordered:
    """A matrix whose unknowns are numbered along the fronts of a breadth-first search, where that brings them together.

    Cuthill and McKee, *Reducing the bandwidth of sparse symmetric matrices*, Proc. 24th ACM National Conference (1969).

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Symmetric, with ascending column numbers.
    candidate : array, shape (n,), optional
        See `Amg`.
    springs : float
        What is added to the diagonal of the hierarchy's matrix, in parts of it: more than zero where the matrix is
        semidefinite.

    Attributes
    ----------
    matrix : csr_array, shape (n, n)
        In the new order; the one given, if that is kept.
    """

    def __init__(self, matrix: csr_array, candidate: Vector | None = None, *, springs: float = 0.0) -> None:
        self._springs, self._order = springs, _order(matrix)
        self._candidate = None if candidate is None else self.inwards(candidate)
        if self._order is not None:
            matrix = matrix[self._order][:, self._order]
            matrix.sort_indices()
        self.matrix = matrix

    @cached_property
    def amg(self) -> Amg:
        """The hierarchy of the matrix, or of that with springs, in the new order."""
        if not self._springs:
            return Amg(self.matrix, self._candidate)
        load_modules("scipy.sparse")
        from scipy import sparse

        sprung = (self.matrix + sparse.diags_array(self._springs * self.matrix.diagonal())).tocsr()
        sprung.sort_indices()
        return Amg(sprung, self._candidate)

    def inwards(self, vector: Vector) -> Vector:
        """Return a vector, or rows of an array, in the new order; one without entries as it is."""
        return vector if self._order is None or not vector.size else vector[self._order]

    def outwards(self, vector: Vector) -> Vector:
        """Return a vector of the new order in the old one."""
        if self._order is None:
            return vector
        old = np.empty_like(vector)
        old[self._order] = vector
        return old

    def cycle(self, right: Vector) -> Vector:
        """Return the result of a V-cycle from zero, for a right-hand side in the old order."""
        return self.outwards(self.amg.cycle(self.inwards(right)))


def _order(matrix: csr_array) -> NDArray[np.int32] | None:
    """Return the old numbers in the new order; None where the order is good as it is, or does not matter."""
    if matrix.shape[0] <= DIRECT_SIZE:
        return None
    rows = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
    if np.abs(rows - matrix.indices).mean() <= _FAR * np.sqrt(matrix.shape[0]):
        return None
    load_modules("scipy.sparse.csgraph")
    from scipy.sparse import csgraph

    order: NDArray[np.int32] = csgraph.reverse_cuthill_mckee(matrix, symmetric_mode=True)
    return order
