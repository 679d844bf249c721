r"""Enclosures for matrices that are no M-matrices; they are symmetric about a base, and weaker.

*H-matrices.* Let ⟨G⟩ have the diagonal of G and the off-diagonal entries -\|G_ij\|, and let v > 0, 0 < s ≤ ⟨G⟩v. Then
\|ω - ω*\| ≤ max(τ⁺, τ⁻)v, with the multiples τ⁺ and τ⁻ of `contactqp.proof.enclosure` for the base ω. Without an upper
bound and with l = 0 that is

.. math:: |ω - ω*| ≤ τv, \qquad τ = \max_i \max(0, -ω_i/v_i, -R_i/s_i, \min(ω_i/v_i, R_i/s_i)).

Proof: let e = ω - ω* and θ = max \|e_i\|/v_i, attained at i. Then \|(Ge)_i\| ≥ θ(⟨G⟩v)_i ≥ θs_i with the sign of e_i.
Let e_i > 0, so that ω*_i < ω_i. If R*_i ≥ 0, then R_i = R*_i + (Ge)_i ≥ θs_i and ω_i - l_i ≥ ω_i - ω*_i = θv_i; if
R*_i < 0, then ω*_i = u_i and ω_i - u_i = θv_i. Either way θ ≤ τ⁻. For e_i < 0 the same holds with the bounds and signs
exchanged, and θ ≤ τ⁺. (Bounds in norms for H-matrices: Chen and Xiang, *Computation of error bounds for P-matrix linear
complementarity problems*, Math. Program. 106, 2006.)

*Symmetric positive definite matrices.* Let λ > 0 be a lower bound of the smallest eigenvalue, b the answer moved to a
bound wherever it lies beyond it or its reaction presses it there, R its reaction, and ρ_i = \|R_i\| at nodes strictly
between their bounds, ρ_i = max(0, -R_i) where b_i = l_i, ρ_i = max(0, R_i) where b_i = u_i. Then ‖b - ω*‖₂ ≤ ‖ρ‖₂/λ.
Proof: with e = b - ω*, eᵀGe = eᵀ(R - R*). For every i, e_i(R_i - R*_i) ≤ \|e_i\|ρ_i: as b is admissible,
-e_iR*_i ≤ 0, because R*_i > 0 only where ω*_i = l_i ≤ b_i, and R*_i < 0 only where ω*_i = u_i ≥ b_i; and e_iR_i ≤
\|e_i\|ρ_i, because e_i ≤ 0 where b_i = l_i and e_i ≥ 0 where b_i = u_i. So λ‖e‖² ≤ eᵀGe ≤ ‖e‖‖ρ‖. (It is the classical
bound for strongly monotone problems, Pang, *A posteriori error bounds for the linearly-constrained variational
inequality problem*, Math. Oper. Res. 12, 1987, with a residual that complementarity makes smaller.) The unknowns are
first scaled by powers of two that bring the diagonal close to one, which rounds nothing.

*Contact by energy.* The same proof bounds the energy of the error, E = eᵀGe ≤ ‖ρ‖²/λ. By Cauchy's inequality in the
product of G, the reaction's error at a node is \|(Ge)_i\| ≤ √(G_ii E), of which a small λ makes far less than of e
itself. Where R_i exceeds that, R*_i > 0, and the node is held by its lower bound; where -R_i does, by its upper one.

That λ is a lower bound is proven in `contactqp.algebra.band`, in `contactqp.algebra.narrow_band`, or in
`contactqp.problem.eigenvalue`.

*Repair.* Both bounds hold about any base (the second about any admissible one), not only about the answer; and they
shrink with what the base leaves out of balance. So they are laid about the solution of the equations of the answer's
own free nodes, as the unrounded sum of a vector and its correction, with the reaction in about twice the precision: for
the right contact set that leaves 1e-30 or so out of balance, which even a smallest eigenvalue of 1e-12 makes little of.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..algebra.band import Band
from ..algebra.compensated import two_sum
from ..algebra.narrow_band import solver
from ..foundation.checks import Mask, Vector
from ..foundation.rounding import UNDERFLOW, UNIT_ROUNDOFF, gamma
from ..methods.factors import DIRECT_SIZE, Solve
from ..methods.linear import free_set_solver
from .enclosure import Base, Enclosure, distance, limit, multiples

if TYPE_CHECKING:
    from ..problem.posed import Posed


COMPARISON, EIGENVALUE = "comparison matrix", "smallest eigenvalue"

_GROW = 1 + 8 * UNIT_ROUNDOFF

_MOST_STEPS, _MOST_CHEAP_STEPS = 3, 40
"""Newton steps, and what they may be where few unknowns make them cheap."""

_MOST_CORRECTIONS = 6
_USEFUL = 0.5
"""What a correction should at least multiply the enclosure's width by, to be followed by another one."""


class WeakerProof(ABC):
    """A way to enclose the solution of a problem whose matrix is no M-matrix.

    Attributes
    ----------
    kind : str
    """

    kind: ClassVar[str]

    def __init__(self, problem: Posed) -> None:
        self.problem = problem

    @abstractmethod
    def first_base(self, answer: Vector) -> Base:
        """Return the base that costs nothing to find."""

    @abstractmethod
    def about(self, answer: Vector, base: Base) -> Enclosure:
        """Return an enclosure about an answer, from a base."""

    def _laid(self, answer: Vector, base: Base, reach: Vector) -> Enclosure:
        """Return base ± reach as an enclosure about the answer."""
        from_high = base.high - answer
        shift = from_high + base.low
        # From zero and to itself a difference is exact.
        exact = (base.low == 0) & ((base.high == 0) | (shift == 0))
        slack = np.where(exact, 0.0, 4 * UNIT_ROUNDOFF * (np.abs(from_high) + np.abs(base.low)))
        fall, rise = np.nextafter(reach - shift + slack, np.inf), np.nextafter(shift + reach + slack, np.inf)
        limit(answer, self.problem.bounds, fall, rise)
        return Enclosure(answer, fall, rise, self.kind)


class _ByComparison(WeakerProof):
    """By a barrier of the comparison matrix."""

    kind = COMPARISON

    def __init__(self, problem: Posed, v: Vector, s: Vector) -> None:
        super().__init__(problem)
        self._v, self._s = v, s

    def first_base(self, answer: Vector) -> Base:
        return Base.of(self.problem, answer)

    def about(self, answer: Vector, base: Base) -> Enclosure:
        found = multiples(self.problem, base, self._v, self._s)
        return self._laid(answer, base, np.maximum(found.raise_by, found.lower_by) * self._v * _GROW + UNDERFLOW)


class _ByEigenvalue(WeakerProof):
    """By a lower bound of the smallest eigenvalue of DGD, with powers of two D."""

    kind = EIGENVALUE

    def __init__(self, problem: Posed, least: float, units: Vector) -> None:
        super().__init__(problem)
        self._least, self._units, self._diagonal = least, units, problem.stiffness.diagonal()

    def first_base(self, answer: Vector) -> Base:
        problem = self.problem
        reaction, _ = problem.stiffness.enclosed_product(answer, problem.q)
        at_lower, at_upper = problem.bounds.contact(answer, reaction / problem.stiffness.diagonal())
        base = problem.project(np.where(at_lower, problem.lower, answer))
        return Base.of(problem, base if problem.one_sided else np.where(at_upper, problem.upper, base))

    def about(self, answer: Vector, base: Base) -> Enclosure:
        problem, base = self.problem, self._admissible(base)
        at_lower = (base.high == problem.lower) & (base.low == 0)
        # Where a bound presses by more than its reaction is off, nothing is out of balance.
        pulled = np.maximum(0.0, base.error - base.reaction)
        out_of_balance = np.where(at_lower, pulled, np.abs(base.reaction) + base.error)
        if not problem.one_sided:
            at_upper = (base.high == problem.upper) & (base.low == 0)
            pressing = np.where(problem.lower == problem.upper, 0.0, np.maximum(0.0, base.error + base.reaction))
            out_of_balance = np.where(at_upper, pressing, out_of_balance)
        with np.errstate(over="ignore"):
            norm = _norm(out_of_balance * self._units) * (1 + gamma(problem.size + 8)) + UNDERFLOW
            reach = (norm / self._least) * self._units * _GROW + UNDERFLOW
            off = base.error + np.sqrt(self._diagonal) * (norm / np.sqrt(self._least)) * (2 * _GROW - 1) + UNDERFLOW
        at_lower = (base.reaction > off) & problem.supported
        at_upper = np.False_ if problem.one_sided else (-base.reaction > off) & np.isfinite(problem.upper)
        return replace(self._laid(answer, base, reach), at_lower=at_lower, at_upper=at_upper)

    def _admissible(self, base: Base) -> Base:
        """Return the base with every node that is not certain to lie between its bounds moved to one."""
        problem = self.problem
        above, slack = distance(base, problem.lower)
        to_lower = ~(above > slack) & problem.supported
        to_upper = np.zeros_like(to_lower)
        if not problem.one_sided:
            below, room = distance(base, problem.upper)
            to_upper = ~(below < -room) & np.isfinite(problem.upper) & ~to_lower
        high = np.where(to_lower, problem.lower, np.where(to_upper, problem.upper, base.high))
        low = np.where(to_lower | to_upper, 0.0, base.low)
        if np.array_equal(high, base.high) and np.array_equal(low, np.broadcast_to(base.low, low.shape)):
            return base
        return Base.accurate(problem, high, low) if low.any() else Base.of(problem, high)


def weaker_proof(problem: Posed) -> WeakerProof | None:
    """Return the way to enclose the solution for a matrix that is no M-matrix, or None where none is known."""
    comparison = problem.comparison_barrier
    if comparison is not None:
        return _ByComparison(problem, comparison.v, comparison.s)
    least = problem.least_eigenvalue
    return None if least is None else _ByEigenvalue(problem, least.bound, least.units)


def weaker_enclosure(problem: Posed, answer: Vector) -> Enclosure | None:
    """Return an enclosure of the solution for a matrix that is no M-matrix, or None where none is known."""
    proof = weaker_proof(problem)
    return None if proof is None else proof.about(answer, proof.first_base(answer))


def repaired(problem: Posed, answer: Vector, first: Enclosure) -> Enclosure:
    """Return an enclosure within ``first``, laid about the answer after some Newton steps.

    Parameters
    ----------
    problem : Posed
        With a matrix that is no M-matrix.
    answer : array, shape (n,)
        A finite gap (length).
    first : Enclosure
        About the answer.
    """
    proof = weaker_proof(problem)
    best, diagonal = first, problem.stiffness.diagonal()
    if proof is None:
        return best
    high, low = answer, np.zeros_like(answer)
    reaction, _ = problem.stiffness.enclosed_product(answer, problem.q)
    before: tuple[Mask, Mask] | None = None
    for _ in range(_MOST_CHEAP_STEPS if problem.size <= DIRECT_SIZE else _MOST_STEPS):
        at_lower, at_upper = problem.bounds.contact(high + low, reaction / diagonal)
        if before is not None and np.array_equal(at_lower, before[0]) and np.array_equal(at_upper, before[1]):
            break
        before = at_lower, at_upper
        held = at_lower | at_upper
        at_bound = problem.lower if problem.one_sided else np.where(at_upper, problem.upper, problem.lower)
        base = Base.accurate(problem, np.where(held, at_bound, high), np.where(held, 0.0, low))
        base, best = _corrected(problem, proof, best, base, ~held)
        if not np.isfinite(base.reaction).all():
            break
        high, low, reaction = base.high, base.low, base.reaction
    return best


def _corrected(problem: Posed, proof: WeakerProof, best: Enclosure, base: Base, free: Mask) -> tuple[Base, Enclosure]:
    """Return the base that solves the free nodes' equations with the others held, and the enclosure met with it."""
    about = partial(proof.about, best.answer)
    found = about(base)
    best = best.met_with(found)
    if not free.any():
        return base, best
    solve = _solver(problem, free)
    if solve is None:
        return base, best
    for _ in range(_MOST_CORRECTIONS):
        step = np.zeros(problem.size)
        step[free] = -solve(base.reaction[free])
        if not np.isfinite(step).all():
            break
        base, last = Base.accurate(problem, *two_sum(base.high, base.low + step)), found.width
        found = about(base)
        best = best.met_with(found)
        if not found.width < _USEFUL * last:
            break
    return base, best


def _solver(problem: Posed, free: Mask) -> Solve | None:
    """Return a function that solves with the free nodes' matrix, to rounding where factors are affordable."""
    least = problem.least_eigenvalue
    direct = solver(Band(problem.stiffness.restricted(free).tocsr()), np.inf if least is None else least.bound)
    if direct is not None:
        return direct
    iterated = free_set_solver(problem.stiffness, free)
    return None if iterated is None else iterated[0]


def _norm(vector: Vector) -> float:
    """Return the Euclidean norm; scaled by a power of two first, because squares under- and overflow."""
    largest = float(np.abs(vector).max())
    if not 0 < largest < np.inf:
        return largest
    exponent = int(np.frexp(largest)[1])
    return float(np.ldexp(np.linalg.norm(np.ldexp(vector, -exponent)), exponent))
