"""KernelFacts: what is known of a positive semidefinite stiffness whose kernel is given."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Self

import numpy as np

from ..algebra.kernel import Kernel
from ..algebra.stiffness import Stiffness
from ..foundation.checks import Mask, Vector
from ..foundation.loading import load_modules
from ..foundation.text import counted
from ..methods.amg.ordered import Ordered
from .facts import MatrixFacts

if TYPE_CHECKING:
    from .bounds import Bounds

_SOFT = 1e-5
"""Stiffness of the springs that make a hierarchy definite, in parts of the diagonal."""


class KernelFacts(MatrixFacts):
    r"""Facts about a symmetric positive semidefinite G with a known kernel; see `MatrixFacts`.

    Let p be as many unknowns as the kernel K has columns, with K_p invertible, and r the others. As GK = 0, the columns
    of G at p are combinations of those at r, and G = LG_rrLᵀ with L = [I, -K_rK_p⁻¹]ᵀ. So G is positive semidefinite
    with no larger kernel exactly if G_rr, which is *grounded* at p, is positive definite.

    Parameters
    ----------
    stiffness : Stiffness
    kernel : Kernel
    candidate : array, shape (n,), optional
        See `MatrixFacts`.
    """

    def __init__(self, stiffness: Stiffness, kernel: Kernel, candidate: Vector | None = None) -> None:
        super().__init__(stiffness, candidate)
        self._kernel = kernel
        self._springs: tuple[Mask, MatrixFacts] | None = None

    @property
    def kernel(self) -> Kernel:
        """The vectors that the stiffness annihilates."""
        return self._kernel

    @property
    def kind(self) -> str:
        """See `MatrixFacts.kind`."""
        z_matrix = self.stiffness.positive_off_diagonal is None
        kernel = "constant" if self.kernel.constant else counted(self.kernel.size, "vector")
        return f"{'singular M-matrix' if z_matrix else 'semidefinite'}, kernel: {kernel}"

    @cached_property
    def grounded(self) -> MatrixFacts:
        """The facts about G without the kernel's grounds."""
        candidate = None if self._candidate is None else self._candidate[self._kept]
        return MatrixFacts(self.stiffness.restricted(self._kept), candidate)

    @cached_property
    def _kept(self) -> Mask:
        kept = np.ones(self.stiffness.size, dtype=np.bool_)
        kept[self.kernel.grounds] = False
        return kept

    def require_definite(self) -> None:
        """Raise a ValueError if G is found to be not semidefinite, or its kernel another one than was given."""
        self.kernel.require_of(self.stiffness)
        if self.stiffness.lattice is not None:
            # Its arms' sums are exact in proofs, but not where it is assembled, as a matrix with springs is.
            raise ValueError(
                "kernel must consist of vectors k with G k = 0, but a lattice whose arms end on the frame or on the "
                "ground has none, however soft these are; leave kernel out, or pass the matrix, stencil.tocsr()"
            )
        if not self._kept.any():
            raise ValueError("G must have fewer kernel vectors than rows")
        try:
            self.grounded.require_definite()
        except ValueError as error:
            parts = self._count_of_parts
            joined = f"; its unknowns fall into {parts} parts, each with a kernel of its own" if parts > 1 else ""
            told = str(error).removeprefix("G must be positive definite, but ")
            raise ValueError(
                "G must be positive semidefinite and have no other kernel than the one given, but without unknown "
                f"{', '.join(map(str, self.kernel.grounds))} (held there) it is not positive definite: {told}{joined}"
            ) from None

    @property
    def _count_of_parts(self) -> int:
        load_modules("scipy.sparse.csgraph")
        from scipy.sparse import csgraph

        return int(csgraph.connected_components(self.stiffness.tocsr(), directed=False)[0])

    @cached_property
    def energy_left_in_kernel(self) -> float:
        """See `Kernel.energy_left`."""
        return self.kernel.energy_left(self.stiffness)

    @property
    def proven_semidefinite(self) -> bool:
        """Whether G is proven to be positive semidefinite, but for rounding in GK = 0."""
        try:
            return self.grounded.proven_semidefinite
        except ValueError:
            return False

    def require_balance(self, q: Vector, bounds: Bounds) -> None:
        """Raise a ValueError unless every ray of the kernel is held by forces that press on a bound."""
        ray = self.kernel.unbalanced(q, bounds.lower, bounds.upper)
        if ray is None:
            return
        told = "the sum of q" if ray.name == "ones" else f"q·k, k = {ray.name},"
        if ray.work < 0:
            raise ValueError(
                f"q must press on the bounds along the kernel, but {told} is {ray.work:g}: nothing holds the gap back, "
                f"and it grows without end; a force of more than {-ray.work:g} the other way is missing"
            )
        raise ValueError(
            f"q must press on the bounds along the kernel, but {told} is 0 (to rounding): the gap is determined but "
            "for a multiple of it; a force towards the bounds is missing"
        )

    @property
    def barrier(self) -> None:
        """None: a singular matrix has none."""

    @property
    def comparison_barrier(self) -> None:
        """None."""

    @property
    def least_eigenvalue(self) -> None:
        """None: it is zero."""

    @property
    def estimated_least_eigenvalue(self) -> float:
        """That of the grounded matrix."""
        return self.grounded.estimated_least_eigenvalue

    @property
    def condition(self) -> float:
        """That of the grounded matrix."""
        return self.grounded.condition

    @property
    def why_nothing_is_proven(self) -> str:
        """See `MatrixFacts.why_nothing_is_proven`."""
        if not self.proven_semidefinite:
            return f"grounded, {self.grounded.why_nothing_is_proven}"
        return (
            "the answer is too far from the solution for nodes to be proven in contact that hold the kernel, or what "
            f"rounding leaves of dᵀGd in the kernel, {self.energy_left_in_kernel:.2g} |d|², may hold other solutions"
        )

    def mean_deflection(self, force: Vector) -> Vector:
        """Return the mean deflection that forces make where the grounds are held, shape (...)."""
        return self.grounded.mean_deflection(force[..., self._kept])

    def _in_units(self, stiffness: Stiffness, units: float | Vector) -> Self:
        candidate = None if isinstance(units, float) else units.min() / units
        return type(self)(stiffness, self.kernel.in_units(units), candidate)

    @cached_property
    def ordered(self) -> Ordered:
        """See `MatrixFacts.ordered`; the hierarchy is that of the matrix with soft springs at all unknowns."""
        return Ordered(self.G, self._candidate, springs=_SOFT)

    def with_springs(self, held: Mask) -> MatrixFacts:
        """See `MatrixFacts.with_springs`; the last ones are kept."""
        if self._springs is None or not np.array_equal(self._springs[0], held):
            self._springs = held.copy(), super().with_springs(held)
        return self._springs[1]
