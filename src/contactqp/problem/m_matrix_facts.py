"""MMatrixFacts: what is proven of a matrix that is meant to be an M-matrix, and need not be symmetric."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..foundation.checks import Vector
from .barrier import Barrier, find_barrier
from .facts import MatrixFacts


class MMatrixFacts(MatrixFacts):
    """Facts about a Z-matrix M that must be a nonsingular M-matrix; see `MatrixFacts`.

    A Z-matrix is one exactly if there is a v > 0 with Mv > 0, and exactly if its transposed matrix is one (Berman and
    Plemmons, *Nonnegative Matrices in the Mathematical Sciences*, 1994, theorem 6.2.3, conditions I27 and A1). So v is
    looked for by rows whether it is rows or columns that dominate.
    """

    def require_definite(self) -> None:
        """Raise a ValueError unless M is proven to be a nonsingular M-matrix."""
        _ = self.barrier

    @cached_property
    def barrier(self) -> Barrier:
        """A vector v > 0 with Mv > 0, rounding errors included.

        Raises
        ------
        ValueError
            If none is found: M is no nonsingular M-matrix, or too nearly singular for double precision to tell.
        """
        found = find_barrier(self.stiffness)
        if found is None:
            raise ValueError(
                "M must be a nonsingular M-matrix, but no vector v > 0 with Mv > 0 is found: M is singular, or has an "
                "eigenvalue with a real part <= 0, or is too nearly so for double precision to tell"
            )
        return found

    @property
    def comparison_barrier(self) -> Barrier:
        """The barrier: M is its own comparison matrix."""
        return self.barrier

    @property
    def least_eigenvalue(self) -> None:
        """None: the barrier proves what is to be proven."""

    @cached_property
    def estimated_least_eigenvalue(self) -> float:
        """A lower bound of the smallest eigenvalue's modulus, for a diagonal of ones: min s_i/(m_ii v_i).

        It is Collatz and Wielandt's, for the M-matrix D⁻¹M and the vector v.
        """
        return float((self.barrier.s / (self.stiffness.diagonal() * self.barrier.v)).min())

    def mean_deflection(self, force: Vector) -> Vector:
        """Return a bound of the mean of M⁻¹ force, shape (...), by the barrier of the transposed matrix.

        The mean is that of force · M⁻ᵀ1. Where rounding hides that barrier, the largest M⁻¹ force is bounded instead.
        """
        if self._barrier_of_columns is not None:
            return self._barrier_of_columns.mean_deflection(force)
        with np.errstate(over="ignore"):
            return np.asarray((force / self.barrier.s).max(axis=-1) * self.barrier.v.max())

    @cached_property
    def _barrier_of_columns(self) -> Barrier | None:
        return find_barrier(self.stiffness.transposed)
