r"""Extremum properties of the solution: its energies, and what it is the least of.

*Energies.* Potential energy of a gap ω, less that of the gap zero: E(ω) = ½ωᵀGω + qᵀω. Complementary energy of a
reaction R = R⁺ - R⁻: E_c(R) = ½(R - q)ᵀG⁻¹(R - q) - lᵀR⁺ + uᵀR⁻; with the lower bound 0 alone, only the first term. For
every admissible gap, l ≤ ω ≤ u, and every admissible reaction, R⁺ = 0 where there is no lower bound and R⁻ = 0 where
there is no upper one,

.. math:: -E_c(R) ≤ -E_c(R*) = E(ω*) ≤ E(ω),

because E(ω) + E_c(R) = ½‖ω - G⁻¹(R - q)‖²_G + (ω - l)ᵀR⁺ + (u - ω)ᵀR⁻ ≥ 0, with equality at the solution. So of all
admissible gaps the solution has the least potential energy, and of all admissible reactions the least complementary
energy (Dorn, *Duality in quadratic programming*, Quart. Appl. Math. 18, 1960).

*Least element.* For a Z-matrix and without upper bounds, of all gaps with ω ≥ l and Gω + q ≥ 0 the solution is the
least, node by node, and minimises cᵀω for every c > 0 (Mangasarian, *Linear complementarity problems solvable by a
single linear program*, Math. Program. 10, 1976). In deflections: of all w ≤ f that are subsolutions, Gw ≤ P + b, it is
the largest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..foundation.brackets import Bracket
from ..foundation.checks import Mask, Vector, vector
from ..methods.factors import factorised
from ..methods.linear import solver
from ..models.base import ContactModel, split
from ..problem.contact_qp import ContactQP

_PRECISE = 1e-13

_UNDERFLOWS = 8
"""Operations on each unknown that may underflow when an energy is formed."""


def potential_energy(problem: ContactQP | ContactModel, gap: ArrayLike) -> float:
    """Return E(ω) = ½ωᵀGω + qᵀω (force times length): the potential energy less that of the shut gap.

    Parameters
    ----------
    problem : Membrane, Cable, CableNet or ContactQP
    gap : array, shape (n,)
        ω (length).

    Raises
    ------
    ValueError
        If ``gap`` has the wrong shape or is not finite.

    Examples
    --------
    >>> import contactqp as cq
    >>> problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
    >>> potential_energy(problem, [0.5, 0.0]), potential_energy(problem, [0.5, 0.5])
    (-0.25, 1.25)
    """
    return split(problem)[1].objective(gap)


def complementary_energy(problem: ContactQP | ContactModel, reaction: ArrayLike) -> float:
    """Return E_c(R) = ½(R - q)ᵀG⁻¹(R - q) - lᵀR⁺ + uᵀR⁻ (force times length); it takes a linear solve.

    R⁺ and R⁻ are the positive and the negative part of R = R⁺ - R⁻. Where a bound is absent the term counts as zero.

    Parameters
    ----------
    problem : Membrane, Cable, CableNet or ContactQP
    reaction : array, shape (n,)
        R (force).

    Raises
    ------
    ValueError
        If ``reaction`` has the wrong shape or is not finite.

    Examples
    --------
    >>> import contactqp as cq
    >>> problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
    >>> round(complementary_energy(problem, [0.0, 2.5]), 12), round(complementary_energy(problem, [0.1, 2.5]), 12)
    (0.25, 0.303333333333)
    """
    _, algebra = split(problem)
    push = vector(reaction, algebra.size, "reaction")
    force = push - algebra.q
    at_bounds = np.where(push > 0, _finite(algebra.lower), _finite(algebra.upper)) * push
    return 0.5 * float(force @ _solved(algebra, force)) - float(at_bounds.sum())


def energy_bracket(problem: ContactQP | ContactModel, gap: ArrayLike) -> Bracket:
    """Return -E_c(R) and E(ω) of the admissible states next to an answer: E(ω*) lies between them, up to rounding.

    The gap is projected between its bounds; its reaction is cut to R ≥ 0 where there is no upper bound, to R ≤ 0 where
    there is no lower one, and to 0 where there is neither. The difference of the two is the duality gap; it vanishes at
    the solution only.

    Parameters
    ----------
    problem : Membrane, Cable, CableNet or ContactQP
    gap : array, shape (n,)
        ω (length), an approximate solution.

    Examples
    --------
    >>> import contactqp as cq
    >>> problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
    >>> low, high = energy_bracket(problem, [0.5, 0.0])
    >>> round(low, 12), round(high, 12)
    (-0.25, -0.25)
    >>> low, high = energy_bracket(problem, [0.6, 0.0])
    >>> bool(low < -0.25 < high)
    True
    """
    _, algebra = split(problem)
    omega = vector(gap, algebra.size, "gap")
    admissible = algebra.project(omega)
    reaction = algebra.bounds.admissible_reaction(algebra.reaction(admissible))
    low, high = -complementary_energy(algebra, reaction), potential_energy(algebra, admissible)
    # Of products below the smallest number nothing is left; where a state is zero, nothing is lost either.
    lost = _UNDERFLOWS * algebra.size * float(np.finfo(np.float64).smallest_subnormal)
    return Bracket(
        low - lost if (reaction != algebra.q).any() else low,
        high + lost if admissible.any() else high,
    )


def feasible(problem: ContactQP | ContactModel, gap: ArrayLike, slack: float = 0.0) -> Mask:
    """Return at which nodes a gap satisfies ω ≥ l, and R ≥ 0 or ω ≥ u.

    For a Z-matrix the solution is the least gap that does everywhere. Without an upper bound and with l = 0 the two
    conditions are ω ≥ 0 and R ≥ 0.

    Parameters
    ----------
    problem : Membrane, Cable, CableNet or ContactQP
    gap : array, shape (n,)
        ω (length).
    slack : float
        Length by which ω - l, and R over the stiffness G_ii, may be below 0, and ω below u.

    Returns
    -------
    array of bool, shape (n,)

    Examples
    --------
    >>> import contactqp as cq
    >>> feasible(cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0]), [0.4, 0.0])
    array([False,  True])
    """
    _, algebra = split(problem)
    omega = vector(gap, algebra.size, "gap")
    pressed = algebra.reaction(omega) >= -slack * algebra.stiffness.diagonal()
    if not algebra.one_sided:
        pressed |= omega >= algebra.upper - slack
    return np.asarray(pressed & (omega - algebra.lower >= -slack))


def _finite(bound: Vector) -> Vector:
    return np.where(np.isfinite(bound), bound, 0.0)


def _solved(problem: ContactQP, force: Vector) -> Vector:
    """Return G⁻¹ force to rounding, by factors or, on large lattices, by multigrid."""
    if problem.stencil is not None:
        found = solver(problem.stiffness, _PRECISE)
        solve = None if found is None else found[0]
    else:
        solve = factorised(problem.G, pivoting=True)
    if solve is None:
        raise ValueError(f"the matrix of {problem!r} is singular in double precision")
    return solve(force)
