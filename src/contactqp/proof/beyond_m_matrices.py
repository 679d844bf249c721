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

That λ is a lower bound is proven in `contactqp.problem.eigenvalue`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..foundation.checks import Vector
from ..foundation.rounding import UNDERFLOW, UNIT_ROUNDOFF, gamma
from .enclosure import Base, Enclosure, limit, multiples

if TYPE_CHECKING:
    from ..problem.contact_qp import ContactQP


COMPARISON, EIGENVALUE = "comparison matrix", "smallest eigenvalue"


def weaker_enclosure(problem: ContactQP, answer: Vector) -> Enclosure | None:
    """Return an enclosure of the solution for a matrix that is no M-matrix, or None where none is known."""
    comparison = problem.comparison_barrier
    if comparison is not None:
        found = multiples(problem, Base.of(problem, answer), comparison.v, comparison.s)
        reach = max(found.raise_by, found.lower_by) * comparison.v * (1 + 8 * UNIT_ROUNDOFF) + UNDERFLOW
        return _about(problem, answer, answer, reach, COMPARISON)
    least = problem.least_eigenvalue
    if least is None:
        return None
    value, units = least
    diagonal = problem.stiffness.diagonal()
    reaction, _ = problem.stiffness.enclosed_product(answer, problem.q)
    at_lower, at_upper = problem.bounds.contact(answer, reaction / diagonal)
    base = problem.project(np.where(at_lower, problem.lower, answer))
    if not problem.one_sided:
        base = np.where(at_upper, problem.upper, base)
    reaction, error = problem.stiffness.enclosed_product(base, problem.q)
    out_of_balance = np.abs(reaction)
    out_of_balance = np.where(base == problem.lower, np.maximum(0.0, -reaction), out_of_balance)
    if not problem.one_sided:
        pressing = np.where(problem.lower == problem.upper, 0.0, np.maximum(0.0, reaction))
        out_of_balance = np.where(base == problem.upper, pressing, out_of_balance)
    out_of_balance += error
    with np.errstate(over="ignore"):
        norm = _norm(out_of_balance * units) * (1 + gamma(problem.size + 8)) + UNDERFLOW
        reach = (norm / value) * units * (1 + 8 * UNIT_ROUNDOFF) + UNDERFLOW
    return _about(problem, answer, base, reach, EIGENVALUE)


def _norm(vector: Vector) -> float:
    """Return the Euclidean norm; scaled by a power of two first, because squares under- and overflow."""
    largest = float(np.abs(vector).max())
    if not 0 < largest < np.inf:
        return largest
    exponent = int(np.frexp(largest)[1])
    return float(np.ldexp(np.linalg.norm(np.ldexp(vector, -exponent)), exponent))


def _about(problem: ContactQP, answer: Vector, base: Vector, reach: Vector, kind: str) -> Enclosure:
    """Return base ± reach as an enclosure about the answer; the two differ at nodes that the base has at a bound."""
    shift = base - answer
    # From zero and to itself a difference is exact.
    slack = np.where((base == 0) | (shift == 0), 0.0, 4 * UNIT_ROUNDOFF * np.abs(shift))
    fall, rise = np.nextafter(reach - shift + slack, np.inf), np.nextafter(shift + reach + slack, np.inf)
    limit(answer, problem.bounds, fall, rise)
    return Enclosure(answer, fall, rise, kind)
