"""Residuals: how far an answer is from the optimality conditions."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from ..foundation.checks import Vector
from ..problem.contact_qp import ContactQP
from .lattice_measures import LatticeBounds, parabola_of


@dataclass(frozen=True)
class Residuals:
    """How far an answer is from the optimality conditions.

    Attributes
    ----------
    min_gap : float
        min ω_i over supported nodes (length): negative is a primal violation.
    min_reaction : float
        min R_i (force): negative is a dual violation.
    complementarity : float
        ωᵀR (force times length): the duality gap, if both are feasible.
    natural_residual : float
        max |min(ω_i, R_i/G_ii)| (length), |R_i/G_ii| where there is no support: zero at the solution only.
    objective : float
        ½ωᵀGω + qᵀω (force times length).
    """

    min_gap: float
    min_reaction: float
    complementarity: float
    natural_residual: float
    objective: float

    def to_dict(self) -> dict[str, float]:
        """Return the residuals by name."""
        return asdict(self)


@np.errstate(over="ignore", invalid="ignore")
def compute_residuals(problem: ContactQP, gap: Vector) -> Residuals:
    """Return the `Residuals` of ``gap``, a finite vector of the problem's size."""
    parabola = parabola_of(problem)
    if parabola is not None:
        return residuals_of(LatticeBounds(problem, parabola, gap))
    product = problem.stiffness.matvec(gap)
    reaction = product + problem.q
    return Residuals(
        min_gap=float(gap.min(where=problem.supported, initial=np.inf)),
        min_reaction=float(reaction.min()),
        complementarity=inner(gap, reaction),
        natural_residual=float(np.abs(natural_map(problem, gap, reaction)).max()),
        objective=inner(gap, 0.5 * product + problem.q),
    )


def residuals_of(bounds: LatticeBounds) -> Residuals:
    """Return the residuals of an answer on a large lattice that has been measured already."""
    return Residuals(
        min_gap=bounds.least_gap,
        min_reaction=bounds.least_reaction,
        complementarity=bounds.complementarity,
        natural_residual=bounds.natural_residual,
        objective=bounds.objective,
    )


def natural_map(problem: ContactQP, gap: Vector, reaction: Vector) -> Vector:
    """Return min(ω_i, R_i/G_ii), and R_i/G_ii where there is no support: zero at the solution only."""
    correction = reaction / problem.stiffness.diagonal()
    return np.where(problem.supported, np.minimum(gap, correction), correction)


def inner(first: Vector, second: Vector) -> float:
    """Return the inner product by pairwise summation, without BLAS, whose threads stall on a busy machine."""
    return float((first * second).sum())
