r"""Enclosures for matrices that are no M-matrices; they are symmetric about a base, and weaker.

*H-matrices.* Let ⟨G⟩ have the diagonal of G and the off-diagonal entries -\|G_ij\|, and let v > 0, 0 < s ≤ ⟨G⟩v. Then

.. math:: |ω - ω*| ≤ τv, \qquad τ = \max_i \max(0, -ω_i/v_i, -R_i/s_i, \min(ω_i/v_i, R_i/s_i)).

Proof: let e = ω - ω* and θ = max \|e_i\|/v_i, attained at i. Then \|(Ge)_i\| ≥ θ(⟨G⟩v)_i ≥ θs_i with the sign of e_i.
If e_i > 0, then R_i = R*_i + (Ge)_i ≥ θs_i and ω_i = ω*_i + θv_i ≥ θv_i. If e_i < 0, either ω*_i > 0, so R*_i = 0 and
R_i ≤ -θs_i, or ω*_i = 0 and ω_i = -θv_i. (Bounds in norms for H-matrices: Chen and Xiang, *Computation of error
bounds for P-matrix linear complementarity problems*, Math. Program. 106, 2006.)

*Symmetric positive definite matrices.* Let λ > 0 be a lower bound of the smallest eigenvalue, u the answer with zeros
where R_i/G_ii > ω_i, R its reaction, and ρ_i = \|R_i\| where u_i ≠ 0 or there is no support, ρ_i = max(0, -R_i)
elsewhere. Then ‖u - ω*‖₂ ≤ ‖ρ‖₂/λ. Proof: with e = u - ω*, eᵀGe = eᵀ(R - R*). For every i, e_i(R_i - R*_i) ≤
\|e_i\|ρ_i: as ω*_iR*_i = 0 and u_i ≥ 0, it is -e_iR*_i = -u_iR*_i ≤ 0, and where u_i = 0, e_i = -ω*_i ≤ 0. So λ‖e‖² ≤
eᵀGe ≤ ‖e‖‖ρ‖. (It is the classical bound for strongly monotone problems, Pang, *A posteriori error bounds for the
linearly-constrained variational inequality problem*, Math. Oper. Res. 12, 1987, with a residual that complementarity
makes smaller.) The unknowns are first scaled by powers of two that bring the diagonal close to one, which rounds
nothing.

That λ is a lower bound is proven by a Cholesky factorisation of G - σI that runs to completion in floating point:
then the smallest eigenvalue of G - σI is at least -γ_{n+1}/(1 - γ_{n+1}) times its trace (Rump, *Verification of
positive definiteness*, BIT 46, 2006; Higham 2002, theorem 10.3).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..foundation.checks import Vector
from ..foundation.rounding import UNDERFLOW, UNIT_ROUNDOFF, gamma
from .enclosure import Base, Enclosure, enclosed_reaction, multiples

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
    reaction, _ = enclosed_reaction(problem, answer)
    shut = problem.supported & ((reaction / problem.stiffness.diagonal() > answer) | (answer < 0))
    base = np.where(shut, 0.0, answer)
    reaction, error = enclosed_reaction(problem, base)
    free = (base != 0) | ~problem.supported
    out_of_balance = np.where(free, np.abs(reaction), np.maximum(0.0, -reaction)) + error
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
    """Return base ± reach as an enclosure about the answer; the base differs from it by zeros only."""
    fall = np.nextafter((answer - base) + reach, np.inf)
    rise = np.nextafter((base - answer) + reach, np.inf)
    np.minimum(fall, answer, out=fall, where=problem.supported)
    return Enclosure(answer, fall, rise, kind)
