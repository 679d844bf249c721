r"""Enclosures of the exact solution of an M-matrix problem, from a base vector and a barrier.

Let ω* solve the problem with bounds l ≤ ω ≤ u and a nonsingular M-matrix G: with R(x) = Gx + q and R* = R(ω*), it is
R*_i ≥ 0 wherever ω*_i < u_i, and R*_i ≤ 0 wherever ω*_i > l_i. (Without an upper bound and with l = 0: R* ≥ 0, ω* ≥ 0,
ω*ᵀR* = 0.) A bound that is absent is infinite, and what is said of it below is then empty.

*Supersolution.* If x ≥ l, and R(x)_i ≥ 0 wherever x_i < u_i, then ω* ≤ x. *Subsolution.* If z ≤ u, and R(z)_i ≤ 0
wherever z_i > l_i, then z ≤ ω*. Proof of both (cf. Cottle, Pang and Stone, *The Linear Complementarity Problem*, 1992,
theorem 3.11.6, on least elements): let d = ω* - x, or d = z - ω*, and S the nodes where d_i > 0. On S it is
x_i < ω*_i ≤ u_i and ω*_i > x_i ≥ l_i, so R*_i ≤ 0 ≤ R(x)_i; or it is z_i > ω*_i ≥ l_i and ω*_i < z_i ≤ u_i, so
R(z)_i ≤ 0 ≤ R*_i. Either way (Gd)_i ≤ 0 on S, hence G_SS d_S ≤ -G_ST d_T with T the other nodes, where d_T ≤ 0 and
G_ST ≤ 0; so G_SS d_S ≤ 0. G_SS is an M-matrix, its inverse is ≥ 0, and d_S ≤ 0: S is empty.

*From a base.* Let b be any vector, v > 0, s > 0, s ≤ Gv. Then b - τ⁻v ≤ ω* ≤ b + τ⁺v with

.. math::

    τ⁺ &= \max_i \max(0, (l_i - b_i)/v_i, \min((u_i - b_i)/v_i, -R(b)_i/s_i)), \\
    τ⁻ &= \max_i \max(0, (b_i - u_i)/v_i, \min((b_i - l_i)/v_i, R(b)_i/s_i)).

For x = b + τ⁺v is ≥ l; and where x_i < u_i, it is τ⁺ < (u_i - b_i)/v_i, so that τ⁺ ≥ -R(b)_i/s_i, and R(x)_i =
R(b)_i + τ⁺(Gv)_i ≥ R(b)_i + τ⁺s_i ≥ 0: a supersolution. Likewise b - τ⁻v is a subsolution. Any larger multiples will do
as well.

*Free-set barrier.* Let C be nodes taken for contact, F the others, v_F = G_FF⁻¹ 1 and v_C = 0. On F it is Gv = 1. On
C it is (Gv)_C = G_CF v_F ≤ 0, negative beside F, so v is no barrier of G; and still it may be used, if b_i is l_i or
u_i at each node of C. What is asked above of the nodes with v_i > 0 is asked of F. On C, where b + τ⁺v and b - τ⁻v are
b, a node at u asks nothing from above, and one at l nothing from below; but for a supersolution R(b)_i + τ⁺s_i ≥ 0
must hold at the nodes at l, which it does for small τ⁺ if the support pushes, R(b)_i > 0; and for a subsolution
R(b)_i - τ⁻s_i ≤ 0 at those at u. So the error is allowed to spread through the free nodes alone, held by the contact
nodes as a membrane is by its frame, and the bound is the smaller, the smaller the free region. Of a node that is in
contact beyond doubt even that may be dropped: as ω*_i is known, its row and column leave the problem, and what is left
is one for the M-matrix of the other nodes.

*Relaxation.* The map T(x)_i = min(u_i, max(l_i, x_i - R(x)_i/G_ii)) does not depend on x_i, and it is monotone, because
the off-diagonal entries are ≤ 0; ω* is its fixed point. So an upper bound x of ω* has ω* = T(ω*) ≤ T(x), and
min(x, T(x)) is one again; likewise max(z, T(z)) from below. If x is a supersolution, T(x) ≤ x and T(x) is a
supersolution again, since T(T(x)) ≤ T(x), whether nodes are relaxed together (Jacobi) or in turn (projected
Gauss-Seidel): the bounds shrink monotonically.

*Entries that count as zero.* Where G has positive off-diagonal entries that are no more than rounding, let E ≥ 0 hold
them, so that Ĝ = G - E is a Z-matrix, and let it be an M-matrix. Since Gω* + q = Ĝω* + (q + Eω*), ω* solves the problem
with the matrix Ĝ and the forces q + Eω* as well, and all of the above holds for that, with the reaction R̂(x) = Ĝx + q +
Eω* = R(x) + E(ω* - x) in the place of R(x). What is unknown of it is small. If ω* is known to lie in some enclosure,
\|E(ω* - x)\| is at most E times the distance to its farther end, which is added to the error of R(x). If nothing is
known yet, let v > 0 and s ≤ Ĝv be a barrier, ε = max (Ev)_i/s_i, θ = max \|ω*_i - b_i\|/v_i: then \|E(ω* - b)\| ≤
θEv ≤ θεs, so that the multiples for R̂ are at most τ⁺ + θε and τ⁻ + θε with those for R; θ is at most the larger of the
two, hence θ ≤ max(τ⁺, τ⁻)/(1 - ε) if ε < 1, and it is enough to add ε max(τ⁺, τ⁻)/(1 - ε) to both.

All this is evaluated in floating point with every rounding bounded (Higham, *Accuracy and Stability of Numerical
Algorithms*, 2002, ch. 3), so that it holds for the stored doubles G and q.

*Many at once.* Vectors count the unknowns along their last axis. Where forces and answers have shape (cases, n), what
is said of a problem is said of each case by itself, by the same passes: none of them adds or compares numbers of two
cases.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..algebra.stiffness import Stiffness, growth_bound
from ..foundation.checks import Mask, Vector
from ..foundation.rounding import DIFFERENCES, UNDERFLOW, UNIT_ROUNDOFF, gamma
from ..problem.bounds import Bounds
from ..problem.posed import Posed

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_GROW = 1 + 16 * UNIT_ROUNDOFF


@dataclass(frozen=True)
class Base:
    """A vector that bounds are laid about, as an unrounded sum, and its reaction.

    Attributes
    ----------
    high, low : array, shape (..., n)
        The base is high + low (length).
    reaction, error : array, shape (..., n)
        R(base) as computed, and a bound of its error (force).
    """

    high: Vector
    low: Vector
    reaction: Vector
    error: Vector

    @classmethod
    def of(cls, problem: Posed, omega: Vector) -> Base:
        """Return ``omega`` with its reaction in plain double precision."""
        reaction, error = problem.stiffness.enclosed_product(omega, problem.q)
        return cls(omega, np.zeros(1), reaction, error)

    @classmethod
    def accurate(cls, problem: Posed, high: Vector, low: Vector) -> Base:
        """Return high + low with its reaction in about twice the precision."""
        return cls(high, low, *problem.stiffness.accurate_product(high, low, problem.q))


@dataclass(frozen=True)
class Enclosure:
    """Bounds of the exact solution, by their distance from an answer: answer - fall ≤ ω* ≤ answer + rise.

    A distance is < 0 where the answer lies outside the bounds.

    Attributes
    ----------
    answer, fall, rise : array, shape (..., n)
    barrier : str
        The kind of barrier.
    at_lower, at_upper : array of bool, shape (..., n)
        Nodes that are known to be held by their lower and by their upper bound, beside those that the distances tell.
    """

    answer: Vector
    fall: Vector
    rise: Vector
    barrier: str
    at_lower: Mask | np.bool_ = np.False_
    at_upper: Mask | np.bool_ = np.False_

    @cached_property
    def error_bound(self) -> Vector:
        """Bound of max|answer - ω*|, infinite where numbers overflow, shape (...)."""
        largest = np.maximum(self.fall.max(axis=-1), self.rise.max(axis=-1))
        return np.where(np.isnan(largest), np.inf, np.maximum(largest, 0.0))

    @property
    def bound(self) -> float:
        """Bound of max|answer - ω*| for one answer, infinite where numbers overflow."""
        return float(self.error_bound)

    @property
    def width(self) -> float:
        """Largest distance between the bounds of a node."""
        return float((self.fall + self.rise).max())

    @property
    def least_error(self) -> float:
        """What max|answer - ω*| is at least."""
        return max(0.0, -float(self.fall.min()), -float(self.rise.min()))

    def met_with(self, other: Enclosure) -> Enclosure:
        """Return the intersection with another enclosure about the same answer, named after the better of the two."""
        barrier = self.barrier if self.bound <= other.bound else other.barrier
        fall, rise = np.fmin(self.fall, other.fall), np.fmin(self.rise, other.rise)
        at_lower, at_upper = self.at_lower | other.at_lower, self.at_upper | other.at_upper
        return Enclosure(self.answer, fall, rise, barrier, at_lower, at_upper)

    def bounds(self, admissible: Bounds) -> tuple[Vector, Vector]:
        """Return lower ≤ ω* ≤ upper, rounded outwards, and within what is admissible."""
        slack = 4 * UNIT_ROUNDOFF
        lower, upper = self.answer - self.fall, self.answer + self.rise
        lower -= slack * np.abs(lower) + UNDERFLOW
        upper += slack * np.abs(upper) + UNDERFLOW
        np.maximum(lower, admissible.lower, out=lower)
        if not admissible.one_sided:
            np.minimum(upper, admissible.upper, out=upper)
        return lower, upper


@dataclass(frozen=True)
class Multiples:
    """The multiples of a barrier by which a base has to be raised and lowered to become an upper and a lower bound.

    Attributes
    ----------
    raise_by, lower_by : array, shape (..., 1)
    held, held_above : array of bool, shape (..., n)
        Whether node i, if v_i = 0, stays at its lower bound when the others are raised, and at its upper bound when
        they are lowered; True where nothing is asked of it.
    """

    raise_by: Vector
    lower_by: Vector
    held: Mask
    held_above: Mask


def _largest(numbers: Vector, chosen: Mask) -> Vector:
    """Return the largest of the chosen numbers of each case, at least zero, shape (..., 1)."""
    return np.asarray(numbers.max(axis=-1, keepdims=True, where=chosen, initial=0.0))


def multiples(
    problem: Posed,
    base: Base,
    v: Vector,
    s: Vector,
    proven_contact: Mask | None = None,
    known: Enclosure | None = None,
    largest: Callable[[Vector, Mask], Vector] = _largest,
) -> Multiples:
    """Return τ⁺ and τ⁻, enlarged by what rounding may have taken from them.

    A distance from a bound that is not zero is a difference of two roundings, (b_high - l) + b_low, and is off by at
    most 2u(|b_high - l| + |b_low|), u the unit roundoff; twice that is granted to both multiples.

    Parameters
    ----------
    problem : Posed
        With an M-matrix.
    base : Base
        At a bound wherever v is zero; of each case one.
    v, s : array, shape (n,)
        v ≥ 0 and s ≤ Gv, with s_i > 0 wherever v_i > 0.
    proven_contact : array of bool, shape (n,), optional
        Nodes of v_i = 0 that are known to be in contact.
    known : Enclosure, optional
        One that is known already; where v_i = 0 somewhere, entries that count as zero ask for it.
    largest : callable
        Largest of some chosen numbers of all nodes, where vectors hold a part of them only.
    """
    if known is not None:
        base = replace(base, error=base.error + _surplus_error(problem, base, known))
    reaching = v > 0
    lower, upper = problem.lower, problem.upper
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        above_lower, slack = distance(base, lower)
        above_lower = np.where(reaching & problem.supported, above_lower / v, np.inf)
        slack = np.where(reaching & (lower != 0) & problem.supported, slack / v, 0.0)
        pushed, pulled = (base.error - base.reaction) / s, (base.error + base.reaction) / s
        raising, lowering = pushed, np.minimum(pulled, above_lower + slack)
        at_upper: Mask | np.bool_ = np.False_
        if not problem.one_sided:
            below_upper, room = distance(base, upper)
            bounded = reaching & np.isfinite(upper)
            below_upper = np.where(bounded, -below_upper / v, np.inf)
            room = np.where(bounded, room / v, 0.0)
            raising = np.minimum(raising, below_upper + room)
            lowering = np.maximum(lowering, room - below_upper)
            at_upper = (base.high == upper) & ~reaching
        raising = np.where(problem.supported, np.maximum(raising, slack - above_lower), raising)
        raise_by = largest(raising, reaching) * _GROW + UNDERFLOW
        lower_by = largest(lowering, reaching) * _GROW + UNDERFLOW
        if known is None:
            more = _surplus_share(problem, v, s) * np.maximum(raise_by, lower_by)
            raise_by, lower_by = (raise_by + more) * _GROW, (lower_by + more) * _GROW
        left = base.reaction - base.error + raise_by * s
        certain = 8 * UNIT_ROUNDOFF * np.abs(base.reaction)
        held = reaching | at_upper | (left >= certain)
        held_above = np.ones(held.shape, dtype=np.bool_)
        if not problem.one_sided:
            held_above = ~at_upper | (lower_by * s - base.error - base.reaction >= certain)
    if proven_contact is not None:
        held |= proven_contact
        held_above |= proven_contact
    return Multiples(raise_by, lower_by, held, held_above)


def _surplus_share(problem: Posed, v: Vector, s: Vector) -> float:
    """Return ε/(1 - ε), rounded upwards; infinite where the entries that count as zero are too large for a proof."""
    surplus = problem.stiffness.surplus
    if surplus is None:
        return 0.0
    if not (v > 0).all():
        return np.inf
    part = surplus_part(problem.stiffness, surplus, v, s) * _GROW
    return part / (1 - part) * _GROW if part < 0.5 else np.inf


def surplus_part(stiffness: Stiffness, surplus: csr_array, v: Vector, s: Vector) -> float:
    """Return ε = max (Ev)_i/s_i, but for some roundings, with E the entries that count as zero."""
    return float(((surplus @ v) / s).max()) * (1 + 2 * growth_bound(stiffness))


def _surplus_error(problem: Posed, base: Base, known: Enclosure) -> Vector | float:
    r"""Return a bound of \|E(ω* - b)\|, with E the entries that count as zero, for a solution in a known enclosure."""
    if problem.stiffness.surplus is None:
        return 0.0
    lower, upper = known.bounds(problem.bounds)
    farther = np.maximum(np.abs(upper - base.high), np.abs(lower - base.high)) + np.abs(base.low)
    return _spread(problem, farther)


def _spread(problem: Posed, reach: Vector) -> Vector | float:
    """Return E times a vector ≥ 0, rounded upwards, with E the entries that count as zero."""
    surplus = problem.stiffness.surplus
    if surplus is None:
        return 0.0
    return np.asarray((surplus @ reach) * (1 + 2 * growth_bound(problem.stiffness)) * _GROW + UNDERFLOW)


def distance(base: Base, bound: Vector) -> tuple[Vector, Vector]:
    """Return how far the base lies above a bound, and what its rounding, twice over, amounts to."""
    from_high = base.high - bound
    return from_high + base.low, 4 * UNIT_ROUNDOFF * (np.abs(from_high) + np.abs(base.low))


def enclosure_about(
    answer: Vector, admissible: Bounds, base: Base, v: Vector, found: Multiples, barrier: str
) -> Enclosure:
    """Return the enclosure base - τ⁻v ≤ ω* ≤ base + τ⁺v, by its distance from an answer.

    The rise is infinite if a node of v_i = 0 does not stay at its lower bound, and the fall if one does not stay at its
    upper bound.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        raise_by = np.where(found.held.all(axis=-1, keepdims=True), found.raise_by, np.inf)
        lower_by = np.where(found.held_above.all(axis=-1, keepdims=True), found.lower_by, np.inf)
        shift = (base.high - answer) + base.low
        slack = 8 * UNIT_ROUNDOFF * (np.abs(base.high - answer) + np.abs(base.low))
        # Of an infinite multiple and a zero nothing is known.
        up = np.where(np.isinf(raise_by), np.inf, raise_by * v * _GROW)
        down = np.where(np.isinf(lower_by), np.inf, lower_by * v * _GROW)
        rise, fall = _widened(shift + up, slack), _widened(down - shift, slack)
        limit(answer, admissible, fall, rise)
    return Enclosure(answer, fall, rise, barrier)


def limit(answer: Vector, admissible: Bounds, fall: Vector, rise: Vector) -> None:
    """Let the distances from an answer, in place, reach no farther than the bounds of what is admissible."""
    room = answer - admissible.lower
    # A difference from zero is exact.
    np.minimum(fall, room if admissible.standard else np.nextafter(room, np.inf), out=fall)
    if not admissible.one_sided:
        np.minimum(rise, np.nextafter(admissible.upper - answer, np.inf), out=rise)


def _widened(distance: Vector, slack: Vector) -> Vector:
    return distance + (slack + 8 * UNIT_ROUNDOFF * np.abs(distance) + UNDERFLOW)


def relaxed(problem: Posed, lower: Vector, upper: Vector, sweeps: int = 1) -> tuple[Vector, Vector]:
    """Return bounds of the solution after some sweeps of monotone projected relaxation, which never widens them.

    Parameters
    ----------
    problem : Posed
        With an M-matrix.
    lower, upper : array, shape (n,)
        lower ≤ ω* ≤ upper (length).
    sweeps : int

    Returns
    -------
    lower, upper : array, shape (n,)

    Examples
    --------
    >>> import numpy as np
    >>> import contactqp as cq
    >>> problem = cq.ContactQP(np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([-1.0, 3.0]))
    >>> lower, upper = relaxed(problem, np.zeros(2), np.ones(2), sweeps=2)
    >>> lower.round(9).tolist(), upper.round(9).tolist()
    ([0.5, 0.0], [0.5, 0.0])
    """
    diagonal = problem.stiffness.diagonal()
    for _ in range(sweeps):
        unknown = _spread(problem, upper - lower)
        upper = np.fmin(upper, _relaxed(problem, diagonal, upper, 1.0, unknown))
        lower = np.fmax(lower, _relaxed(problem, diagonal, lower, -1.0, unknown))
    return lower, upper


def _relaxed(problem: Posed, diagonal: Vector, omega: Vector, outwards: float, unknown: Vector | float) -> Vector:
    """Return T(ω), rounded upwards or downwards, with a part of the reaction unknown."""
    reaction, error = problem.stiffness.enclosed_product(omega, problem.q)
    step = (reaction - outwards * (error + unknown)) / diagonal
    moved = omega - step
    moved += outwards * (8 * UNIT_ROUNDOFF * (np.abs(omega) + np.abs(step)) + UNDERFLOW)
    return problem.project(moved)


def certainly_free(problem: Posed, lower: Vector, upper: Vector) -> Mask:
    """Return the nodes that bounds of the solution keep away from both bounds of the problem, and unbounded nodes."""
    above = (lower > problem.lower) | ~problem.supported
    return above if problem.one_sided else above & ((upper < problem.upper) | np.isposinf(problem.upper))


def certain_contact(problem: Posed, lower: Vector, upper: Vector) -> tuple[Mask, Mask]:
    """Return the nodes that are certain to be held by the lower and by the upper bound.

    Let r_i = q_i + Σ_{j≠i} G_ij ω*_j + G_ii l_i. If r_i > 0, then ω*_i > l_i would make R*_i = r_i + G_ii(ω*_i - l_i)
    positive, which complementarity forbids; so ω*_i = l_i, and R*_i = r_i. For a Z-matrix r_i is least with the upper
    bounds of the others. With u_i for l_i and the lower bounds of the others, a sum below zero holds node i at u_i.
    """
    diagonal = problem.stiffness.diagonal()
    z_matrix = problem.is_z_matrix and problem.stiffness.surplus is None

    def sums(others: Vector, bound: Vector, spread: Vector) -> tuple[Vector, Vector]:
        """Return the sums r with such values of the others, and a bound of their errors."""
        reaction, error = problem.stiffness.enclosed_product(others, problem.q)
        own = diagonal * (others - bound)
        return reaction - own, 2 * error + spread + gamma(DIFFERENCES) * np.abs(own)

    if z_matrix:
        below, above, spread = upper, lower, np.zeros(1)
    else:
        middle, radius = middle_and_radius(lower, upper)
        below = above = middle
        reach = problem.stiffness.modulus_matvec(radius)
        # A large share of the node's own swallows digits of the others', so that what is rounded is all of it.
        spread = reach * (1 + 4 * growth_bound(problem.stiffness)) - diagonal * radius
    total, error = sums(below, problem.lower, spread)
    at_lower = np.asarray((total > error) & problem.supported)
    if problem.one_sided:
        return at_lower, np.zeros(at_lower.shape, dtype=np.bool_)
    total, error = sums(above, problem.upper, spread)
    return at_lower, np.asarray((-total > error) & np.isfinite(problem.upper))


def middle_and_radius(lower: Vector, upper: Vector) -> tuple[Vector, Vector]:
    """Return the middle of bounds, rounded, and a radius about it that reaches both."""
    middle = 0.5 * lower + 0.5 * upper
    radius = np.maximum(upper - middle, middle - lower)
    return middle, radius * (1 + 4 * UNIT_ROUNDOFF) + UNDERFLOW


@dataclass(frozen=True, eq=False)
class Proven:
    """What an enclosure of the solution proves, or one for each case.

    Attributes
    ----------
    lower, upper : array, shape (..., n)
        lower ≤ ω* ≤ upper (length); both are the bound where a node is held by one beyond doubt.
    error_bound : array, shape (...)
        max|ω - ω*| is at most this (length).
    at_lower, at_upper : array of bool, shape (..., n)
        Nodes that are certain to be held by their lower and by their upper bound.
    clear : array of bool, shape (..., n)
        Nodes that are certain to lie strictly between their bounds, and all nodes without a bound.
    finite : array of bool, shape (...)
        Where numbers have not overflowed; elsewhere nothing of the above is known.
    barrier : str
    """

    lower: Vector
    upper: Vector
    error_bound: Vector
    at_lower: Mask
    at_upper: Mask
    clear: Mask
    finite: Mask
    barrier: str

    @cached_property
    def contact(self) -> Mask:
        """Nodes that are certain to be held by either bound, shape (..., n)."""
        return self.at_lower | self.at_upper


def proven(problem: Posed, found: Enclosure) -> Proven:
    """Return what an enclosure of the solution proves."""
    with np.errstate(over="ignore", invalid="ignore"):
        lower, upper = found.bounds(problem.bounds)
        finite = np.isfinite(found.error_bound)
        finite = finite & np.isfinite(lower).all(axis=-1) & np.isfinite(upper).all(axis=-1)
        at_lower, at_upper = certain_contact(problem, lower, upper)
        at_lower, at_upper = at_lower | found.at_lower, at_upper | found.at_upper
        for bound in (lower, upper):
            np.copyto(bound, problem.lower, where=at_lower)
            if not problem.one_sided:
                np.copyto(bound, problem.upper, where=at_upper)
        clear = certainly_free(problem, lower, upper)
    return Proven(lower, upper, found.error_bound, at_lower, at_upper, clear, finite, found.barrier)
