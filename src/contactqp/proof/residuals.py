"""Residuals: how far an answer is from the optimality conditions."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Residuals:
    """How far an answer is from the optimality conditions.

    Attributes
    ----------
    min_gap : float
        Least distance from a bound (length), over the nodes that have one: ω_i - l_i, or u_i - ω_i. Negative is a
        primal violation.
    min_reaction : float
        Least force that is not allowed to be negative: R_i where there is no upper bound, -R_i where the upper bound is
        the only one. Negative is a dual violation. At nodes with both bounds any reaction is allowed.
    complementarity : float
        Σ(ω_i - l_i)R_i where R_i ≥ 0, and Σ(ω_i - u_i)R_i where R_i < 0; where the bound is absent, ω_iR_i (force times
        length): the duality gap, if primal and dual conditions hold. Without an upper bound and with l = 0 it is ωᵀR.
    natural_residual : float
        Largest modulus of ω - P(ω - R/G_ii), with P the projection between the bounds (length): zero at the solution
        only. Where the lower bound 0 is the only one it is min(ω_i, R_i/G_ii).
    objective : float
        ½ωᵀGω + qᵀω (force times length); nan where the matrix is not symmetric, so that there is no such function.
    """

    min_gap: float
    min_reaction: float
    complementarity: float
    natural_residual: float
    objective: float
