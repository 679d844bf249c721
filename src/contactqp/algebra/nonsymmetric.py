"""NonsymmetricStiffness: a matrix that the user brings and that need not be symmetric, and the checks of it."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from .sparse import SparseStiffness, square_matrix

if TYPE_CHECKING:
    from .stencil import Stencil


class NonsymmetricStiffness(SparseStiffness):
    """A sparse Z-matrix M, held as an array of rows.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        With a positive diagonal and sorted column numbers; `of` checks that.

    Examples
    --------
    >>> stiffness = NonsymmetricStiffness.of([[2.0, -1.0], [-0.5, 2.0]])
    >>> stiffness.asymmetry
    'M[0, 1] = -1 and M[1, 0] = -0.5'
    >>> stiffness.transposed.matvec(np.array([1.0, 0.0]))
    array([ 2., -1.])
    """

    @classmethod
    def of(cls, value: Any) -> Self:
        """Return a matrix that the user brings, checked to be a Z-matrix with a positive diagonal.

        Parameters
        ----------
        value : sparse array, sparse matrix or dense array, shape (n, n)
            M. Positive off-diagonal entries that are no more than rounding count as zero, see `Stiffness.surplus`.

        Raises
        ------
        TypeError
            If it is complex or not numeric.
        ValueError
            If it is empty, not square, not finite, or no Z-matrix, or has a diagonal entry <= 0.
        """
        matrix = square_matrix(value, "M")
        diagonal = matrix.diagonal()
        worst = int(np.argmin(diagonal))
        if not diagonal[worst] > 0:
            raise ValueError(f"M must have a positive diagonal, but M[{worst}, {worst}] is {diagonal[worst]:g}")
        matrix.sort_indices()
        matrix.data.setflags(write=False)
        found = cls(matrix)
        if found.positive_off_diagonal is not None:
            i, j, entry = found.positive_off_diagonal
            raise ValueError(
                f"M must be a Z-matrix (off-diagonal entries <= 0), but M[{i}, {j}] = {entry:g}; differences against "
                "the flow (upwind), or a finer grid, make it one"
            )
        return found

    @cached_property
    def asymmetry(self) -> str | None:
        """See `Stiffness.asymmetry`; the pair of entries that differs most is named."""
        difference = (self._matrix - self._matrix.T).tocoo()
        if not difference.nnz or not difference.data.any():
            return None
        worst = int(np.argmax(np.abs(difference.data)))
        i, j = sorted(int(coordinate[worst]) for coordinate in difference.coords)
        return f"M[{i}, {j}] = {self._matrix[i, j]:g} and M[{j}, {i}] = {self._matrix[j, i]:g}"

    @property
    def symmetric(self) -> bool:
        """See `Stiffness.symmetric`: nothing is made of it where it happens to be."""
        return False

    @cached_property
    def transposed(self) -> NonsymmetricStiffness:
        """The transposed matrix."""
        matrix = self._matrix.T.tocsr()
        matrix.sort_indices()
        return NonsymmetricStiffness(matrix)

    def recognised_lattice(self) -> Stencil | None:
        """Return None: arms pull both their ends with one stiffness."""
        return None
