"""Active sets for many load cases of one small matrix, by a compiled kernel."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...algebra.band import Band
from ...foundation.checks import Vector, read_only
from ...foundation.loading import can_compile, load_modules
from ...foundation.threads import Team

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_KERNELS = "contactqp.methods.active_set.case_kernels"

_MOST_UNKNOWNS, _MOST_WORK = 1000, 2e7
"""Unknowns, and multiplications of a factorisation, beyond which one by one takes little more time: factors are kept
then, and the next solve starts from the last answer. A call of the kernel is kept short by that, too."""

_WORTH_LOADING = 1000
"""Cases that take longer one by one than loading the kernels does."""

_FEWEST = 4
"""Cases that are worth being laid out together."""

_MOST_STEPS = 40

_LANES = 32
"""Cases side by side: more do not fit into a processor's cache, and fewer are not worth the loops about them."""

_WORK_AT_ONCE = 2e8
"""Multiplications of a factorisation, times the cases that the kernel is given at once: some tenths of a second, in
which an interrupt has to wait."""


class CaseSolver:
    """Solves min ½ωᵀGω + qᵀω between bounds l ≤ 0 ≤ u for many forces q.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Symmetric positive definite, with ascending column numbers.

    Attributes
    ----------
    order : array of int, shape (n,)
        The unknowns in an order in which the matrix's band is narrow.
    """

    def __init__(self, matrix: csr_array) -> None:
        band = Band(matrix)
        self._width, self.order = band.width, np.argsort(band.place)
        ordered = matrix[self.order][:, self.order].tocsr()
        ordered.sort_indices()
        self._rows = ordered.indptr.astype(np.int32), ordered.indices.astype(np.int32), read_only(ordered.data)
        self._diagonal = read_only(ordered.diagonal())
        self._work = float(matrix.shape[0] * (self._width + 8) ** 2)

    @classmethod
    def of(cls, matrix: csr_array, cases: int, asked: int) -> CaseSolver | None:
        """Return a solver where load cases are worth being solved together, and None where not.

        Parameters
        ----------
        matrix
            See the class.
        cases, asked : int
            Cases at hand, and those that are asked for in all, as far as that is known.
        """
        loaded = asked >= _WORTH_LOADING or _KERNELS in sys.modules
        if matrix.shape[0] > _MOST_UNKNOWNS or cases < _FEWEST or not (loaded and can_compile()):
            return None
        return cls(matrix)

    @property
    def affordable(self) -> bool:
        """Whether a factorisation of one case is little work."""
        return self._work <= _MOST_WORK

    def solve(self, forces: Vector, lower: Vector, upper: Vector) -> tuple[Vector, NDArray[np.int64]]:
        """Return each case's gap, and the number of steps that it took: 0 where it did not come to an end.

        Parameters
        ----------
        forces : array, shape (cases, n)
            q.
        lower, upper : array, shape (n,)
            Bounds, -inf and inf where there is none.

        Returns
        -------
        gaps : array, shape (cases, n)
        steps : array of int, shape (cases,)

        Examples
        --------
        >>> from scipy import sparse
        >>> solver = CaseSolver(sparse.csr_array([[2.0, -1.0], [-1.0, 2.0]]))
        >>> gaps, steps = solver.solve(np.array([[-1.0, 3.0], [-3.0, 0.0]]), np.zeros(2), np.full(2, np.inf))
        >>> gaps.round(12).tolist(), steps.tolist()
        ([[0.5, 0.0], [2.0, 1.0]], [1, 1])
        """
        load_modules(_KERNELS, kernels="active sets for many loads")
        from .case_kernels import solve_cases

        cases, size = forces.shape
        order = self.order
        given = read_only(np.ascontiguousarray(forces[:, order]))
        found, steps = np.empty((cases, size)), np.zeros(cases, dtype=np.int64)
        problem = *self._rows, read_only(lower[order]), read_only(upper[order]), self._diagonal, given
        lanes, at_once = min(_LANES, cases), max(_FEWEST, int(_WORK_AT_ONCE / self._work))
        with Team() as team:
            for first in range(0, cases, at_once):
                strips = team.strips(first, min(first + at_once, cases), size * (self._width + 1), least=_LANES)
                team.run(solve_cases, strips, *problem, self._width, lanes, _MOST_STEPS, found, steps)
        gaps = np.empty_like(found)
        gaps[:, order] = found
        return gaps, steps
