r"""Enclosures for a positive semidefinite matrix: those of a positive definite problem with the same solution.

Let GK = 0 for the columns of K, and let G be positive semidefinite with no larger kernel (proven by the grounded
matrix, see `contactqp.problem.kernel_facts`). *Springs.* Let C be some nodes that an answer has in contact, b_i the
bound that holds node i, and t_i > 0. With springs t_i from b_i to the gap the problem has the matrix Ĝ = G + D and the
forces q̂ = q - Db, D the diagonal matrix of t on C and zero elsewhere; if K has full rank on C, Ĝ is positive definite,
for an x with xᵀĜx = 0 is in the kernel, and vanishes on C. Let ω̂ be its solution. If ω̂_i = b_i is proven for every i
in C, no spring is stretched: R̂(ω̂) = Gω̂ + q + D(ω̂ - b) = R(ω̂), and if R_i(ω̂) has the sign that its bound asks for,
ω̂ solves the problem without springs as well. What is known of ω̂, by whatever proof suits Ĝ, is then known of a
solution ω* = ω̂.

*It is the only one.* Let ω be another solution, with the reaction R, and d = ω - ω*. By complementarity dᵀ(R - R*) ≤ 0,
and it is dᵀGd ≥ 0, so Gd = 0 and R = R*. At a node of C it is R*_i ≠ 0, so ω_i is the bound b_i as well, and d_i = 0: d
is in the kernel and vanishes on C. (The contact nodes that the forces press on hold the kernel, and their reactions
balance the forces along it: KᵀR* = Kᵀq.)

*Rounding.* Neither the springs' stiffness nor Db needs to be exact: where b_i is proven to be ω̂_i, the sign of R_i(ω̂)
is proven with G and q themselves, and the rows of other nodes are those of G and q. Where rounding keeps GK from
vanishing, the stored G may be indefinite by as much, and ω̂ still solves the problem of the stored doubles, but need not
be its only solution. Let ω̂ + d be another one. As above Σ_C |d_i||R*_i| ≤ -dᵀGd. Away from the kernel G resists, so
that dᵀGd is hardly negative but for the part of d in the kernel, where it is at least -ε|d|²; and there the sum is at
least ρ|d|, ρ the least length of R* d on C, entry by entry, over that of d. So d is longer than ρ/ε, to first order in
what is left of GK. Nothing is certified unless that is a thousand times (`_FAR`) the length of gaps of the problem's
scale at all nodes: the enclosed solution is the one that is meant by a matrix whose last digits are rounded. Where
GK = 0 exactly, as of whole numbers, it is the only one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..algebra.kernel import Kernel
from ..foundation.checks import Mask, Vector
from ..problem.contact_problem import ContactProblem
from .certificate import Certificate
from .enclosure import certain_contact
from .sharper import sharper
from .vector_measures import VectorMeasures

_STRONG = 0.25
"""Part of the largest pressing, R_i/G_ii, above which a node in contact is given a spring."""

_FAR = 1000.0
"""Lengths of the gaps by which other solutions are away, if rounding of the matrix makes any."""

_ROUNDS = 3
"""Choices of springs that are tried: those which are not proven to be in contact lose theirs."""


@dataclass(frozen=True)
class _Springs:
    """Springs at nodes that an answer has in contact.

    Attributes
    ----------
    at_lower, at_upper : array of bool, shape (n,)
        Nodes with a spring, by the bound that holds them.
    """

    at_lower: Mask
    at_upper: Mask

    @classmethod
    def chosen(cls, problem: ContactProblem, gap: Vector, kernel: Kernel) -> _Springs | None:
        """Return springs at the nodes that press most, or at all in contact where those do not hold the kernel."""
        correction = (problem.stiffness.matvec(gap) + problem.q) / problem.stiffness.diagonal()
        at_lower, at_upper = problem.bounds.contact(gap, correction)
        pressing = np.where((at_lower & (correction > 0)) | (at_upper & (correction < 0)), np.abs(correction), 0.0)
        for part in (_STRONG, 0.0):
            strong = pressing > part * pressing.max()
            if kernel.held_by(strong):
                return cls(at_lower & strong, at_upper & strong)
        return None

    def __and__(self, kept: tuple[Mask, Mask]) -> _Springs:
        """Return those that stand at some nodes, too."""
        return _Springs(self.at_lower & kept[0], self.at_upper & kept[1])

    @property
    def held(self) -> Mask:
        """Nodes with a spring."""
        return self.at_lower | self.at_upper

    def proven(self, problem: ContactProblem, certificate: Certificate) -> _Springs:
        """Return those whose nodes are proven to be at their bounds, and pressed there without the springs, too."""
        at_lower, at_upper = certain_contact(problem, certificate.lower, certificate.upper)
        return self & (certificate.contact_lower & at_lower, certificate.contact_upper & at_upper)


class SemidefiniteMeasures(VectorMeasures):
    """See `Measures`; for a problem with a kernel."""

    @property
    def gap_bound(self) -> float:
        """See `Measures`; infinite where the fast enclosure does not prove that contact holds the kernel."""
        return np.inf if self._fast is None else self._fast.gap_bound

    @property
    def estimated_error(self) -> float:
        """See `Measures`; where nothing is proven yet, the natural residual over the grounded matrix's eigenvalue."""
        bound = self.gap_bound
        if np.isfinite(bound):
            return bound
        return self.residuals.natural_residual / self.problem.estimated_least_eigenvalue

    def certificate(self) -> Certificate | None:
        """See `Measures`; the sharp one where the fast one proves nothing."""
        return self._fast if self._fast is not None else self._found(sharp=True)

    @cached_property
    def _fast(self) -> Certificate | None:
        return self._found(sharp=False)

    def _found(self, sharp: bool) -> Certificate | None:
        """Return the certificate of a problem with springs, if it proves that they make no difference."""
        problem, gap, kernel = self.problem, self._gap, self.problem.kernel
        if kernel is None or not problem.facts.proven_semidefinite:
            return None
        springs = _Springs.chosen(problem, gap, kernel)
        for _ in range(_ROUNDS):
            if springs is None or not kernel.held_by(springs.held):
                return None
            certificate = self._with_springs(springs, sharp)
            if certificate is None:
                return None
            proven = springs.proven(problem, certificate)
            if np.array_equal(proven.held, springs.held):
                if not self._others_are_far(springs.held, kernel):
                    return None
                return replace(certificate, problem=problem, enclosed=certificate.problem)
            springs = proven
        return None

    def _others_are_far(self, held: Mask, kernel: Kernel) -> bool:
        """Whether no other solution is near that rounding in GK = 0 may have made; see the module."""
        problem, left = self.problem, self.problem.facts.energy_left_in_kernel
        if left == 0.0:
            return True
        pressing = np.where(held, np.abs(problem.stiffness.matvec(self._gap) + problem.q), 0.0)
        size = max(problem.gap_scale, float(np.abs(self._gap).max())) * np.sqrt(problem.size)
        return bool(kernel.least_hold(pressing) >= _FAR * size * left)

    def _with_springs(self, springs: _Springs, sharp: bool) -> Certificate | None:
        problem, gap = self.problem, self._gap
        sprung = problem.with_springs(springs.at_lower, springs.at_upper)
        try:
            certificate = VectorMeasures(sprung, gap).certificate()
        except ValueError:  # too nearly singular for a barrier
            return None
        return sharper(certificate, gap) if sharp and certificate is not None else certificate
