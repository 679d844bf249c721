"""MatrixFacts: what is proven of a stiffness, found once and shared by all problems with it."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from ..algebra.conditioning import estimated_condition, told_condition
from ..algebra.definiteness import refuse_indefinite, ritz_value, weakly_dominant
from ..algebra.narrow_band import solver
from ..algebra.sparse import SparseStiffness
from ..algebra.stiffness import Stiffness
from ..foundation.checks import Mask, Vector
from ..foundation.loading import load_modules
from ..methods.amg.ordered import Ordered
from ..methods.factors import DIRECT_SIZE, Solve
from ..methods.free_system import FreeSystem
from ..methods.linear import cycle_of
from .barrier import Barrier, Preconditioner, find_barrier
from .eigenvalue import LeastEigenvalue, affordable, narrow_band_of, proven_least_eigenvalue

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from ..algebra.kernel import Kernel
    from .bounds import Bounds


class MatrixFacts:
    """Facts about a stiffness G, each found when it is first asked for.

    Parameters
    ----------
    stiffness : Stiffness
    candidate : array, shape (n,), optional
        A positive vector that the stiffness nearly annihilates, away from where it is held; ones by default.
    """

    def __init__(self, stiffness: Stiffness, candidate: Vector | None = None) -> None:
        self.stiffness, self._candidate = stiffness, candidate
        self._free_system: FreeSystem | None = None

    def __getstate__(self) -> dict[str, Any]:
        # Factors cannot be pickled, and are soon made.
        return {**self.__dict__, "_free_system": None}

    def free_system(self, free: Mask) -> FreeSystem:
        """Return the equations of some nodes, the others held; those of the last nodes asked for are kept.

        Parameters
        ----------
        free : array of bool, shape (n,)
        """
        kept = self._free_system
        if kept is None or not np.array_equal(kept.free, free):
            self._free_system = kept = FreeSystem(self.stiffness, free)
        return kept

    @property
    def kind(self) -> str:
        """What the matrix is, in a word or two."""
        return "M-matrix" if self.stiffness.positive_off_diagonal is None else "no Z-matrix"

    @cached_property
    def G(self) -> csr_array:
        """The stiffness as a sparse array, read-only."""
        matrix = self.stiffness.tocsr()
        matrix.data.setflags(write=False)
        return matrix

    def mean_deflection(self, force: Vector) -> Vector:
        """Return the mean deflection that forces make, shape (...): a bound by the barrier, or an estimate.

        The rough one is by the diagonal; in a narrow band it is no less than the exact mean, to rounding.

        Parameters
        ----------
        force : array, shape (..., n)
            Force, >= 0.
        """
        if self.barrier is not None:
            return np.asarray(self.barrier.mean_deflection(force))
        rough = np.asarray((force / self.stiffness.diagonal()).max(axis=-1))
        if self._bend is None:
            return rough
        bent = [np.abs(self._bend(one)).mean() for one in np.atleast_2d(force)]
        # Forces on few nodes of many hardly move the mean.
        return np.asarray(np.maximum(rough, np.asarray(bent).reshape(force.shape[:-1])))

    @cached_property
    def _bend(self) -> Solve | None:
        """What solves with a matrix in a narrow band, of which the diagonal tells next to nothing; None for others."""
        band = narrow_band_of(self.G)
        if band is None:
            return None
        least = self.least_eigenvalue
        return solver(band, 0.0 if least is None else least.bound)

    @property
    def kernel(self) -> Kernel | None:
        """The vectors that the stiffness annihilates, None where it is positive definite."""
        return None

    @property
    def proven_semidefinite(self) -> bool:
        """Whether the stiffness is proven to be positive semidefinite."""
        return self.comparison_barrier is not None or self.least_eigenvalue is not None

    def with_springs(self, held: Mask) -> MatrixFacts:
        """Return the facts about G with springs at some nodes, each as stiff as its diagonal entry."""
        load_modules("scipy.sparse")
        from scipy import sparse

        springs = np.where(held, self.stiffness.diagonal(), 0.0)
        matrix = (self.stiffness.tocsr() + sparse.diags_array(springs)).tocsr()
        matrix.sort_indices()
        return MatrixFacts(SparseStiffness(matrix), self._candidate)

    def require_balance(self, q: Vector, bounds: Bounds) -> None:
        """Raise a ValueError if forces and bounds leave a problem without a solution, or with many: here never."""

    def require_definite(self) -> None:
        """Raise a ValueError if the stiffness, a matrix that a user brings, is found to be not positive definite.

        Of a matrix that is diagonally dominant the proof is left to the barrier, which every use of it needs anyway.
        For many unknowns a barrier, or what else the judge needs, is the proof: that is found once, and kept.
        """
        matrix = self.stiffness.tocsr()
        if weakly_dominant(matrix):
            return
        if self.stiffness.size > DIRECT_SIZE:
            if self.barrier is not None or self.comparison_barrier is not None or self.least_eigenvalue is not None:
                return
            if self.stiffness.positive_off_diagonal is None:
                return  # the search for a barrier has found nothing against it
        refuse_indefinite(matrix)

    @cached_property
    def barrier(self) -> Barrier | None:
        """A vector v > 0 with Gv > 0 that proves G an M-matrix, or None where G is no Z-matrix.

        Raises
        ------
        ValueError
            If G turns out not to be positive definite.
        """
        if self.stiffness.positive_off_diagonal is not None:
            return None
        found = find_barrier(self.stiffness, self._preconditioner)
        if found is None:
            refuse_indefinite(self.G)
        return found

    @cached_property
    def comparison_barrier(self) -> Barrier | None:
        """A vector v > 0 with ⟨G⟩v > 0, where ⟨G⟩ is the comparison matrix, or None: it proves G an H-matrix."""
        if self.stiffness.positive_off_diagonal is None:
            return self.barrier
        return find_barrier(self.stiffness.comparison())

    @cached_property
    def least_eigenvalue(self) -> LeastEigenvalue | None:
        """A proven lower bound of the smallest eigenvalue of DGD, with powers of two D; None where none is proven."""
        found = proven_least_eigenvalue(self.G, self._cycle)
        stiffness = self.stiffness
        return found and found.of_exact_diagonal(stiffness.diagonal(), stiffness.diagonal_rounding)

    @cached_property
    def estimated_least_eigenvalue(self) -> float:
        """An estimate > 0 of the smallest eigenvalue of G with its diagonal scaled to ones; no bound, and no proof."""
        return max(ritz_value(self.G), float(np.finfo(np.float64).tiny))

    @cached_property
    def condition(self) -> float:
        """An estimate of the condition number of G with its diagonal scaled to ones; infinite if it is singular."""
        return estimated_condition(self.G)

    @property
    def told_condition(self) -> str:
        """The condition number in words."""
        return f"its condition number is {told_condition(self.condition)} (diagonal scaled to ones)"

    @property
    def energy_left_in_kernel(self) -> float:
        """Largest modulus of dᵀGd for a d of length one in the kernel; 0 without one."""
        return 0.0

    @property
    def why_nothing_is_proven(self) -> str:
        """Why no bound is known for the matrix, in words, where none is."""
        if affordable(self.G):
            return f"its matrix is too ill-conditioned for a proof: {self.told_condition}"
        return "its matrix is neither an M-matrix nor an H-matrix, and too large for a proof of its smallest eigenvalue"

    @cached_property
    def dimensionless(self) -> tuple[Stiffness, float | Vector, float]:
        """See `Stiffness.dimensionless`."""
        return self.stiffness.dimensionless()

    @cached_property
    def scaled(self) -> Self:
        """The facts about the dimensionless stiffness."""
        stiffness, units, _ = self.dimensionless
        scaled = self._in_units(stiffness, units)
        scaled.scaled = scaled
        return scaled

    def _in_units(self, stiffness: Stiffness, units: float | Vector) -> Self:
        """Return the facts about the stiffness of unknowns that are measured in units of length."""
        return type(self)(stiffness, None if isinstance(units, float) else units.min() / units)

    @cached_property
    def ordered(self) -> Ordered:
        """The matrix in an order for large problems, with its hierarchy, which all solves and proofs share."""
        return Ordered(self.G, self._candidate)

    @property
    def _preconditioner(self) -> Preconditioner | None:
        if self.stiffness.lattice is not None:
            return None
        _, units, largest = self.dimensionless
        return Preconditioner(units / np.sqrt(largest), self._cycle)

    def _cycle(self) -> Solve | None:
        """Return a preconditioner of the dimensionless matrix; None where there is none."""
        return cycle_of(self.scaled.ordered)
