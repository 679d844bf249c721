r"""Extremum properties of the solution: its energies, and what it is the least of.

*Energies.* Potential energy of a gap ω, less that of the gap zero: E(ω) = ½ωᵀGω + qᵀω. Complementary energy of a
reaction R = R⁺ - R⁻: E_c(R) = ½(R - q)ᵀG⁻¹(R - q) - lᵀR⁺ + uᵀR⁻; with the lower bound 0 alone, only the first term. For
every admissible gap, l ≤ ω ≤ u, and every admissible reaction, R⁺ = 0 where there is no lower bound and R⁻ = 0 where
there is no upper one,

.. math:: -E_c(R) ≤ -E_c(R*) = E(ω*) ≤ E(ω),

because E(ω) + E_c(R) = ½‖ω - G⁻¹(R - q)‖²_G + (ω - l)ᵀR⁺ + (u - ω)ᵀR⁻ ≥ 0, with equality at the solution. So of all
admissible gaps the solution has the least potential energy, and of all admissible reactions the least complementary
energy (Dorn, *Duality in quadratic programming*, Quart. Appl. Math. 18, 1960).

*The bracket.* Neither energy can be formed exactly, and G⁻¹ cannot be applied so; where G is nearly singular, rounding
alone would make the lower bound exceed the upper one. Let ω be admissible and R = Gω + q, known as r̃ with |R - r̃| ≤ e:
then E(ω) = ½ωᵀ(R + q), which is within ½|ω|ᵀe of ½ωᵀ(r̃ + q), and that is summed with all rounding bounded. Let R be
admissible, F = R - q, and x any vector, such as an approximate solution of Gx = F that leaves ρ = F - Gx. Since
G⁻¹F = x + G⁻¹ρ,

.. math:: ½FᵀG⁻¹F = ½Fᵀx + ½(Gx + ρ)ᵀG⁻¹ρ = ½xᵀ(F + ρ) + ½ρᵀG⁻¹ρ,

of which only the last term needs G⁻¹, and it is of second order in ρ. It is bounded by what is proven of G. With a
barrier v > 0 of the comparison matrix, 0 < s ≤ ⟨G⟩v, and τ = max |ρ_i|/s_i: |G⁻¹ρ| ≤ ⟨G⟩⁻¹|ρ| ≤ τ⟨G⟩⁻¹s ≤ τv (Ostrowski
1937; for an M-matrix ⟨G⟩ = G), so that ρᵀG⁻¹ρ ≤ τ|ρ|ᵀv. Where positive entries E count as zero, s bounds (G - E)v from
below; ⟨G⟩ = G - 2E, so that ⟨G⟩v ≥ s - Ev ≥ (1 - ε)s with ε = max (Ev)_i/s_i. With a lower bound λ of the smallest
eigenvalue of DGD: ρᵀG⁻¹ρ = (Dρ)ᵀ(DGD)⁻¹(Dρ) ≤ ‖Dρ‖²/λ. Where nothing is proven, the lower bound is -∞. Two x are tried:
the linear solve's, and ω itself, whose ρ is what was cut off its reaction; the larger of the two lower bounds is
returned.

*Least element.* For a Z-matrix and without upper bounds, of all gaps with ω ≥ l and Gω + q ≥ 0 the solution is the
least, node by node, and minimises cᵀω for every c > 0 (Mangasarian, *Linear complementarity problems solvable by a
single linear program*, Math. Program. 10, 1976). In deflections: of all w ≤ f that are subsolutions, Gw ≤ P + b, it is
the largest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..foundation.brackets import Bracket, sum_above, sum_below
from ..foundation.checks import Mask, Vector, vector
from ..foundation.rounding import UNIT_ROUNDOFF
from ..methods.factors import factorised
from ..methods.linear import solver
from ..models.base import ContactModel, split
from ..problem.barrier import Barrier
from ..problem.contact_problem import ContactProblem
from .enclosure import surplus_part
from .sharper import SHARP_SIZE

_PRECISE = 1e-13

_GROW = 1 + 8 * UNIT_ROUNDOFF

_TINY = 8 * float(np.finfo(np.float64).smallest_subnormal)
"""What underflow may take from some products and quotients."""


def potential_energy(problem: ContactProblem | ContactModel, gap: ArrayLike) -> float:
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
    return _with_energy(problem).objective(gap)


def complementary_energy(problem: ContactProblem | ContactModel, reaction: ArrayLike) -> float:
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
    algebra = _with_energy(problem)
    push = vector(reaction, algebra.size, "reaction")
    force = push - algebra.q
    at_bounds = np.where(push > 0, _finite(algebra.lower), _finite(algebra.upper)) * push
    return 0.5 * float(force @ _solved(algebra, force)) - float(at_bounds.sum())


def energy_bracket(problem: ContactProblem | ContactModel, gap: ArrayLike) -> Bracket:
    """Return -E_c(R) and E(ω) of the admissible states next to an answer, rounded outwards: E(ω*) lies between them.

    It is proven for the stored doubles, all rounding included (see `contactqp.proof.energy`): for a nearly singular
    matrix the bracket is wider than the two energies would have it, and where nothing is known of the matrix its lower
    end is -inf. The gap is projected between its bounds; its reaction is cut to R ≥ 0 where there is no upper bound, to
    R ≤ 0 where there is no lower one, and to 0 where there is neither. But for rounding, the difference of the two is
    the duality gap, which vanishes at the solution only.

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
    algebra = _with_energy(problem)
    omega = vector(gap, algebra.size, "gap")
    nodes = Nodes(algebra)
    admissible, reaction = admissible_state(algebra, omega)
    low, high = bracket_at(nodes, admissible, reaction)
    if low < high:
        with np.errstate(over="ignore", invalid="ignore"):
            solved = _tried(algebra, reaction - algebra.q)
            low = low if solved is None else max(low, _energy_below(nodes, reaction, solved))
    return Bracket(low, high)


class Nodes:
    """All nodes of a problem: how G acts on them, what is proven of its inverse, and how something is summed over them.

    Parameters
    ----------
    problem : ContactProblem
    """

    def __init__(self, problem: ContactProblem) -> None:
        self.problem = problem

    @property
    def barrier(self) -> Barrier | None:
        """A barrier of the comparison matrix, where there is one."""
        return self.problem.comparison_barrier

    def product(self, x: Vector) -> tuple[Vector, Vector]:
        """Return Gx + q, and a bound of its error: in about twice the precision where that is affordable."""
        problem = self.problem
        if problem.size <= SHARP_SIZE:
            value, error = problem.stiffness.accurate_product(x, np.zeros_like(x), problem.q)
            if np.isfinite(value).all() and np.isfinite(error).all():
                return value, error
        return problem.stiffness.enclosed_product(x, problem.q)

    def any(self, *vectors: Vector) -> bool:
        """Whether any number at any node is not zero."""
        return any(bool(each.any()) for each in vectors)

    def largest(self, values: Vector) -> float:
        """Return the largest of some values >= 0."""
        return float(values.max())

    def inner_between(self, x: Vector, y: Vector, error: Vector) -> Bracket:
        """Return a bracket of Σ x_i y_i, where each y_i is known to within an error."""
        return inner_between(x, y, error)


def admissible_state(problem: ContactProblem, gap: Vector) -> tuple[Vector, Vector]:
    """Return the gap between the bounds, and the reaction that they can exert, next to an answer."""
    admissible = problem.project(gap)
    with np.errstate(over="ignore", invalid="ignore"):
        return admissible, problem.bounds.admissible_reaction(problem.reaction(admissible))


def bracket_at(nodes: Nodes, gap: Vector, reaction: Vector) -> Bracket:
    """Return -E_c(R) and E(ω) of an admissible state, rounded outwards, without a linear solve: x is ω."""
    with np.errstate(over="ignore", invalid="ignore"):
        return Bracket(_energy_below(nodes, reaction, gap), _energy_above(nodes, gap))


def _with_energy(problem: ContactProblem | ContactModel) -> ContactProblem:
    """Return the contact problem, if its matrix is symmetric; else raise an UnsuitableProblemError."""
    _, algebra = split(problem)
    algebra.require_energy()
    return algebra


def _energy_above(nodes: Nodes, gap: Vector) -> float:
    """Return an upper bound of E(ω) of a gap."""
    reaction, error = nodes.product(gap)
    force = reaction + nodes.problem.q
    error = error + UNIT_ROUNDOFF * np.abs(force) * _GROW
    return _half(nodes.inner_between(gap, force, error).upper, np.inf)


def _energy_below(nodes: Nodes, reaction: Vector, x: Vector) -> float:
    """Return a lower bound of -E_c(R) of a reaction, by an approximate solution of Gx = R - q."""
    problem = nodes.problem
    product, error = nodes.product(x)
    left, force = reaction - product, reaction - problem.q
    error = error + UNIT_ROUNDOFF * np.abs(left) * _GROW
    if not nodes.any(x, force):
        left, error = np.zeros_like(left), np.zeros_like(left)  # Gx = R - q exactly
    work = force + left
    slack = (error + UNIT_ROUNDOFF * (np.abs(force) + np.abs(work))) * _GROW
    known = _half(nodes.inner_between(x, work, slack).upper, np.inf)
    rest = _half(_most_of_inverse(nodes, (np.abs(left) + error) * _GROW), np.inf)
    nearest = np.where(reaction > 0, _finite(problem.lower), _finite(problem.upper))
    at_bounds = nodes.inner_between(reaction, nearest, np.zeros_like(nearest)).lower
    parts = [at_bounds, -known, -rest]
    if np.isnan(parts).any() or np.isinf(parts).any():
        return -np.inf
    return sum_below(parts) if any(parts) else 0.0


def _most_of_inverse(nodes: Nodes, most: Vector) -> float:
    """Return an upper bound of ρᵀG⁻¹ρ for all ρ with |ρ_i| at most as large as given; infinite where none is known."""
    if not nodes.any(most):
        return 0.0
    problem, barrier = nodes.problem, nodes.barrier
    if barrier is not None:
        share = _surplus_part(problem, barrier.v, barrier.s)
        # A subnormal quotient has lost digits, which what it is multiplied by may make much of.
        largest = nodes.largest(most / barrier.s) + _TINY
        multiple = largest * _GROW / (1 - share) * _GROW if share < 1 else np.inf
        above = nodes.inner_between(most, np.asarray(barrier.v), np.zeros_like(most)).upper
        return multiple * above * _GROW + _TINY
    found = problem.least_eigenvalue
    if found is None:
        return np.inf
    balanced = most * found.units * _GROW
    return nodes.inner_between(balanced, balanced, np.zeros_like(most)).upper / found.bound * _GROW + _TINY


def _surplus_part(problem: ContactProblem, v: Vector, s: Vector) -> float:
    """Return ε, rounded upwards: what the positive entries that count as zero take from a barrier."""
    surplus = problem.stiffness.surplus
    if surplus is None or problem.barrier is None:
        return 0.0  # otherwise it is the barrier of the comparison matrix, in which they have their place
    return surplus_part(problem.stiffness, surplus, v, s) * _GROW


def inner_between(x: Vector, y: Vector, error: Vector) -> Bracket:
    """Return a bracket of Σ x_i y_i, where each y_i is known to within an error; exact zero where nothing is added."""
    product = x * y
    slack = (np.abs(x) * error + UNIT_ROUNDOFF * np.abs(product)) * _GROW
    slack[(x != 0) & ((y != 0) | (error != 0))] += _TINY
    if not (np.isfinite(product).all() and np.isfinite(slack).all()):
        return Bracket(-np.inf, np.inf)
    if not slack.any():
        return Bracket(0.0, 0.0)
    return Bracket(sum_below(np.concatenate([product, -slack])), sum_above(np.concatenate([product, slack])))


def _half(value: float, towards: float) -> float:
    """Return half of a number, rounded towards another where it is subnormal."""
    return float(np.nextafter(0.5 * value, towards)) if value else 0.0


def _tried(problem: ContactProblem, force: Vector) -> Vector | None:
    """Return G⁻¹ force to rounding, None where the matrix is singular in double precision."""
    try:
        found = _solved(problem, force)
    except ValueError:
        return None
    return found if np.isfinite(found).all() else None


def feasible(problem: ContactProblem | ContactModel, gap: ArrayLike, slack: float = 0.0) -> Mask:
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


def _solved(problem: ContactProblem, force: Vector) -> Vector:
    """Return G⁻¹ force to rounding, by factors or, on large lattices, by multigrid."""
    if problem.stencil is not None:
        found = solver(problem.stiffness, _PRECISE)
        solve = None if found is None else found[0]
    else:
        solve = factorised(problem.G, pivoting=True) if problem.kernel is None else None
    if solve is None:
        raise ValueError(f"the matrix of {problem!r} is singular, or so in double precision: it has no inverse")
    return solve(force)
