"""Posed: forces on a matrix, between bounds; what holds of one problem's, and of many that differ in forces alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, TypeAlias, TypeVar

import numpy as np

from ..algebra.stiffness import LatticeStiffness, Stiffness
from ..foundation.checks import Mask, Vector, read_only
from .barrier import Barrier
from .bounds import Bounds
from .facts import MatrixFacts

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from ..algebra.kernel import Kernel
    from .eigenvalue import LeastEigenvalue

Value = TypeVar("Value")

Made: TypeAlias = "Value | Callable[[], Value]"
"""A value, or what makes it: a large vector that is wanted once need not be kept."""


def made(value: Made[Value]) -> Value:
    """Return a value, made now if it has not been made before."""
    return value() if callable(value) else value


@dataclass(frozen=True)
class Units:
    """What a dimensionless problem's numbers are worth in the original problem's.

    Attributes
    ----------
    length : float or array, shape (n,)
        Unit of the gap (length); each unknown of a matrix has its own.
    force : float or array, shape (n,)
        Unit of q and of the reaction (force).
    origin : float or array, shape (n,)
        The gap (length) that the dimensionless gap zero stands for: zero itself wherever the bounds admit it.
    """

    length: float | Vector
    force: float | Vector
    origin: float | Vector = 0.0

    def gap(self, dimensionless: Vector) -> Vector:
        """Return the original problem's gap (length), shape (n,)."""
        length = dimensionless * self.length
        return length if isinstance(self.origin, float) and self.origin == 0 else length + self.origin

    def dimensionless(self, gap: Vector) -> Vector:
        """Return the dimensionless problem's gap, shape (n,)."""
        return np.asarray((gap - self.origin) / self.length)


class Posed:
    """Forces q on a stiffness G, and bounds of the gap: those of one problem, or of many with the same G and bounds.

    What is asked of the forces here counts the unknowns along the last axis, and leaves any axis before it alone.

    Parameters
    ----------
    facts : MatrixFacts
        What is known of G.
    q : array, shape (n,) or (cases, n), or callable
        Reaction that would hold the gap ω = 0 (force), read-only, or what makes it when it is first asked for.
    bounds : Bounds
    """

    def __init__(self, facts: MatrixFacts, q: Made[Vector], bounds: Bounds) -> None:
        self.facts, self._q, self.bounds = facts, q, bounds

    @property
    def q(self) -> Vector:
        """Reaction that would hold the gap ω = 0 (force), shape (n,) or (cases, n), read-only."""
        self._q = made(self._q)
        return self._q

    @property
    def stiffness(self) -> Stiffness:
        """The stiffness G, as it is held."""
        return self.facts.stiffness

    @property
    def size(self) -> int:
        """Number of unknowns n."""
        return self.stiffness.size

    @property
    def G(self) -> csr_array:
        """The stiffness as a sparse array, read-only; assembled at the first call."""
        return self.facts.G

    @property
    def stencil(self) -> LatticeStiffness | None:
        """The stiffness as a lattice stencil, or None where G was given as a matrix."""
        return self.stiffness.lattice

    @property
    def lower(self) -> Vector:
        """Lower bound of the gap (length), shape (n,), read-only; -inf where there is no support."""
        return self.bounds.lower

    @property
    def upper(self) -> Vector:
        """Upper bound of the gap (length), shape (n,), read-only; inf where there is no ceiling."""
        return self.bounds.upper

    @property
    def supported(self) -> Mask:
        """Where there is a lower bound, shape (n,), read-only."""
        return self.bounds.supported

    @property
    def one_sided(self) -> bool:
        """Whether there is no upper bound."""
        return self.bounds.one_sided

    def project(self, gap: Vector) -> Vector:
        """Return the admissible gap nearest to a gap, node by node (length), shape (n,)."""
        return self.bounds.project(gap)

    @property
    def positive_off_diagonal(self) -> tuple[int, int, float] | None:
        """Row, column and value of the largest positive off-diagonal entry, or None for a Z-matrix."""
        return self.stiffness.positive_off_diagonal

    @property
    def is_z_matrix(self) -> bool:
        """Whether every off-diagonal entry of G is <= 0."""
        return self.positive_off_diagonal is None

    @property
    def kernel(self) -> Kernel | None:
        """The vectors that G annihilates; None where it is positive definite."""
        return self.facts.kernel

    @property
    def symmetric(self) -> bool:
        """Whether G is symmetric, so that the problem is a quadratic program."""
        return self.stiffness.symmetric

    def energy(self, gap: Vector, product: Vector) -> Vector:
        """Return ½ωᵀGω + qᵀω (force times length), shape (...), with the product Gω; nan where G is not symmetric."""
        if not self.symmetric:
            return np.full(gap.shape[:-1], np.nan)
        # Pairwise summation, without BLAS, whose threads stall on a busy machine.
        return np.asarray((gap * (0.5 * product + self.q)).sum(axis=-1))

    @property
    def is_m_matrix(self) -> bool:
        """Whether G is a Z-matrix with a verified `barrier`."""
        return self.barrier is not None

    @property
    def barrier(self) -> Barrier | None:
        """A vector v > 0 with Gv > 0 that proves G an M-matrix, or None where G is no Z-matrix.

        Raises
        ------
        ValueError
            If G turns out not to be positive definite.
        """
        return self.facts.barrier

    @property
    def comparison_barrier(self) -> Barrier | None:
        """A vector v > 0 with ⟨G⟩v > 0, where ⟨G⟩ is G with its off-diagonal entries made ≤ 0, or None.

        It proves G an H-matrix, for which an enclosure is known as well (see `contactqp.proof.beyond_m_matrices`).
        """
        return self.facts.comparison_barrier

    @property
    def least_eigenvalue(self) -> LeastEigenvalue | None:
        """A proven lower bound of the smallest eigenvalue of DGD, with powers of two D; None where none is proven."""
        return self.facts.least_eigenvalue

    @property
    def estimated_least_eigenvalue(self) -> float:
        """An estimate > 0 of the smallest eigenvalue of G with its diagonal scaled to ones; no bound, and no proof."""
        return self.facts.estimated_least_eigenvalue

    @property
    def condition(self) -> float:
        """An estimate of the condition number of G with its diagonal scaled to ones; no bound, and no proof."""
        return self.facts.condition

    @property
    def told_condition(self) -> str:
        """The condition number in words."""
        return self.facts.told_condition

    @property
    def _forces_at_origin(self) -> Vector:
        """Reaction at the admissible gap nearest to zero (force), shape of q."""
        origin = self.bounds.nearest_zero
        return self.q if isinstance(origin, float) else self.stiffness.matvec(origin) + self.q

    @property
    def _opening_forces(self) -> Vector:
        """Moduli of the forces that move the admissible gap nearest to zero, which the bounds there do not balance."""
        origin, force = self.bounds.nearest_zero, self._forces_at_origin
        opening = np.where(self.upper > origin, np.maximum(-force, 0.0), 0.0)
        return np.where(self.lower < origin, np.maximum(force, opening), opening)

    @cached_property
    def opens(self) -> Mask:
        """Whether a force moves the admissible gap nearest to zero, shape (...)."""
        if self.one_sided:
            pulled = np.asarray((self._forces_at_origin < 0).any(axis=-1))
            if pulled.all():
                return pulled
        return np.asarray(self._opening_forces.any(axis=-1))

    @cached_property
    def mean_opening(self) -> Vector:
        """Mean distance from the admissible gap nearest to zero that the forces which leave it make, see `ContactQP`.

        Length, shape (...); it is a bound, by the barrier, or an estimate, by the diagonal.
        """
        return self._mean_distance(self._opening_forces)

    def _mean_distance(self, force: Vector) -> Vector:
        return self.facts.mean_deflection(np.abs(force))

    def in_units(self, gap_scale: float) -> tuple[Callable[[], Vector], Bounds, Units]:
        """Return forces and bounds of the dimensionless problem whose unit of length is such a scale, and its units.

        The forces are to be made by the callable, each time anew.

        Raises
        ------
        ValueError
            If numbers overflow.
        """
        with np.errstate(over="ignore"):
            stiffness, relative, largest = self.facts.dimensionless
            origin = self.bounds.nearest_zero
            units = Units(gap_scale * relative, gap_scale * largest / relative, origin)
            forces = self._forces_at_origin
            representable = np.isfinite(_farthest(forces, units.force) / units.force).all()
        if not (representable and stiffness.finite):
            raise ValueError("the ranges of G and q are too wide for double precision: the scaled problem overflows")
        with np.errstate(over="ignore"):
            return partial(_quotient, forces, units.force), self.bounds.scaled(origin, units.length), units


def _farthest(vector: Vector, unit: float | Vector) -> Vector:
    """Return the numbers of a vector that can overflow first in such units: where all have the same, two of them."""
    return np.array([vector.min(), vector.max()]) if isinstance(unit, float) else vector


def _quotient(vector: Vector, unit: float | Vector) -> Vector:
    return read_only(vector / unit)
