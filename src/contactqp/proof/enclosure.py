r"""Enclosures of the exact solution of an M-matrix problem, from a base vector and a barrier.

Let ω* solve Gω + q = R ≥ 0, ω ≥ 0, ωᵀR = 0 with a nonsingular M-matrix G, and R(x) = Gx + q.

*Supersolution.* If u ≥ 0 and R(u) ≥ 0, then ω* ≤ u. *Subsolution.* If R(z)_i ≤ 0 wherever z_i > 0, then z ≤ ω*. Proof
of both (cf. Cottle, Pang and Stone, *The Linear Complementarity Problem*, 1992, theorem 3.11.6, on least elements):
let d = ω* - u, or d = z - ω*, and S the nodes where d_i > 0. On S it is ω*_i > 0, so R*_i = 0 ≤ R(u)_i, or it is z_i
> 0, so R(z)_i ≤ 0 ≤ R*_i. Either way (Gd)_i ≤ 0 on S, hence G_SS d_S ≤ -G_ST d_T with T the other nodes, where d_T ≤
0 and G_ST ≤ 0; so G_SS d_S ≤ 0. G_SS is an M-matrix, its inverse is ≥ 0, and d_S ≤ 0: S is empty. At a node without
support R* = 0 and ω* has no sign: there u needs R(u)_i ≥ 0 alone, and z needs R(z)_i ≤ 0 in any case.

*From a base.* Let b be any vector, v ≥ 0, s ≤ Gv. Then ω* ≤ b + τ⁺v for any τ⁺ with

.. math:: b_i + τ⁺v_i ≥ 0, \qquad R(b)_i + τ⁺s_i ≥ 0 \qquad \text{for all } i,

because R(b + τ⁺v) = R(b) + τ⁺Gv; and b - τ⁻v ≤ ω* for

.. math:: τ⁻ = \max_i \max(0, \min(b_i/v_i, R(b)_i/s_i)) \qquad \text{over all } i \text{ with } v_i > 0,

if s_i > 0 there and b_i ≤ 0 elsewhere: where b_i > τ⁻v_i, it is R(b)_i ≤ τ⁻s_i, so that R(b - τ⁻v)_i ≤ 0.

*Free-set barrier.* Let C be nodes taken for contact, F the others, v_F = G_FF⁻¹ 1 and v_C = 0. On F it is Gv = 1. On
C it is (Gv)_C = G_CF v_F ≤ 0, negative beside F, so v is no barrier of G; and still it may be used, if b_C = 0: from
below nothing is asked of C, where v_i = 0; from above R(b)_i + τ⁺s_i ≥ 0 must hold there, which it does for small τ⁺
if the reaction R(b)_i > 0. So the error is allowed to spread through the free nodes alone, held at zero by the
contact nodes as a membrane is by its frame, and the bound is the smaller, the smaller the free region. Of a node that
is in contact beyond doubt even that may be dropped: as ω*_i = 0 is known, its row and column leave the problem, and
what is left is one for the M-matrix of the other nodes.

*Relaxation.* The map T(x)_i = max(0, x_i - R(x)_i/G_ii) does not depend on x_i, and it is monotone, because the
off-diagonal entries are ≤ 0; ω* is its fixed point. So an upper bound u of ω* has ω* = T(ω*) ≤ T(u), and min(u, T(u))
is one again; likewise max(z, T(z)) from below. If u is a supersolution, T(u) ≤ u and T(u) is a supersolution again,
since T(T(u)) ≤ T(u), whether nodes are relaxed together (Jacobi) or in turn (projected Gauss-Seidel): the bounds
shrink monotonically.

All this is evaluated in floating point with every rounding bounded (Higham, *Accuracy and Stability of Numerical
Algorithms*, 2002, ch. 3), so that it holds for the stored doubles G and q.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..algebra.stencil import Stencil
from ..algebra.stiffness import growth_bound
from ..foundation.checks import Mask, Vector
from ..foundation.rounding import DIFFERENCES, UNDERFLOW, UNIT_ROUNDOFF, gamma
from ..problem.contact_qp import ContactQP
from .compensated import accurate_reaction

_GROW = 1 + 16 * UNIT_ROUNDOFF


@dataclass(frozen=True)
class Base:
    """A vector that bounds are laid about, as an unrounded sum, and its reaction.

    Attributes
    ----------
    high, low : array, shape (n,)
        The base is high + low (length).
    reaction, error : array, shape (n,)
        R(base) as computed, and a bound of its error (force).
    """

    high: Vector
    low: Vector
    reaction: Vector
    error: Vector

    @classmethod
    def of(cls, problem: ContactQP, omega: Vector) -> Base:
        """Return ``omega`` with its reaction in plain double precision."""
        reaction, error = enclosed_reaction(problem, omega)
        return cls(omega, np.zeros(1), reaction, error)

    @classmethod
    def accurate(cls, problem: ContactQP, high: Vector, low: Vector) -> Base:
        """Return high + low with its reaction in about twice the precision."""
        return cls(high, low, *accurate_reaction(problem, high, low))


@dataclass(frozen=True)
class Enclosure:
    """Bounds of the exact solution, by their distance from an answer: answer - fall ≤ ω* ≤ answer + rise.

    A distance is < 0 where the answer lies outside the bounds.

    Attributes
    ----------
    answer, fall, rise : array, shape (n,)
    barrier : str
        The kind of barrier.
    """

    answer: Vector
    fall: Vector
    rise: Vector
    barrier: str

    @property
    def bound(self) -> float:
        """Bound of max|answer - ω*|, infinite where numbers overflow."""
        largest = float(np.maximum(self.fall.max(), self.rise.max()))
        return np.inf if np.isnan(largest) else max(largest, 0.0)

    @property
    def least_error(self) -> float:
        """What max|answer - ω*| is at least."""
        return max(0.0, -float(self.fall.min()), -float(self.rise.min()))

    def met_with(self, other: Enclosure) -> Enclosure:
        """Return the intersection with another enclosure about the same answer, named after the better of the two."""
        barrier = self.barrier if self.bound <= other.bound else other.barrier
        return Enclosure(self.answer, np.fmin(self.fall, other.fall), np.fmin(self.rise, other.rise), barrier)

    def bounds(self, supported: Mask) -> tuple[Vector, Vector]:
        """Return lower ≤ ω* ≤ upper, rounded outwards."""
        slack = 4 * UNIT_ROUNDOFF
        lower, upper = self.answer - self.fall, self.answer + self.rise
        lower -= slack * np.abs(lower) + UNDERFLOW
        upper += slack * np.abs(upper) + UNDERFLOW
        np.maximum(lower, 0.0, out=lower, where=supported)
        return lower, upper


@dataclass(frozen=True)
class Multiples:
    """The multiples of a barrier by which a base has to be raised and lowered to become an upper and a lower bound.

    Attributes
    ----------
    raise_by, lower_by : float
    held : array of bool, shape (n,)
        Whether node i, if v_i = 0, stays in contact when the others are raised; True where v_i > 0.
    """

    raise_by: float
    lower_by: float
    held: Mask


def multiples(problem: ContactQP, base: Base, v: Vector, s: Vector, proven_contact: Mask | None = None) -> Multiples:
    """Return τ⁺ and τ⁻, enlarged by what rounding may have taken from them.

    Parameters
    ----------
    problem : ContactQP
        With an M-matrix.
    base : Base
        Zero wherever v is.
    v, s : array, shape (n,)
        v ≥ 0 and s ≤ Gv, with s_i > 0 wherever v_i > 0.
    proven_contact : array of bool, shape (n,), optional
        Nodes of v_i = 0 that are known to be in contact.
    """
    reaching = v > 0
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        clearance = np.where(reaching & problem.supported, (base.high + base.low) / v, np.inf)
        pushed, pulled = (base.error - base.reaction) / s, (base.error + base.reaction) / s
        needed = np.where(problem.supported, np.maximum(pushed, -clearance), pushed)
        raise_by = float(needed.max(where=reaching, initial=0.0)) * _GROW + UNDERFLOW
        lower_by = float(np.minimum(pulled, clearance).max(where=reaching, initial=0.0)) * _GROW + UNDERFLOW
        left = base.reaction - base.error + raise_by * s
        held = reaching | (left >= 8 * UNIT_ROUNDOFF * np.abs(base.reaction))
    if proven_contact is not None:
        held |= proven_contact
    return Multiples(raise_by, lower_by, held)


def enclosure_about(
    answer: Vector, supported: Mask, base: Base, v: Vector, found: Multiples, barrier: str
) -> Enclosure:
    """Return the enclosure base - τ⁻v ≤ ω* ≤ base + τ⁺v, by its distance from an answer.

    The rise is infinite, if a node of v_i = 0 is not held.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        raise_by = found.raise_by if found.held.all() else np.inf
        shift = (base.high - answer) + base.low
        slack = 8 * UNIT_ROUNDOFF * (np.abs(base.high - answer) + np.abs(base.low))
        up = np.full(v.shape, np.inf) if np.isinf(raise_by) else raise_by * v * _GROW
        rise, fall = _widened(shift + up, slack), _widened(found.lower_by * v * _GROW - shift, slack)
        np.minimum(fall, answer, out=fall, where=supported)
    return Enclosure(answer, fall, rise, barrier)


def _widened(distance: Vector, slack: Vector) -> Vector:
    return distance + (slack + 8 * UNIT_ROUNDOFF * np.abs(distance) + UNDERFLOW)


def relaxed(problem: ContactQP, lower: Vector, upper: Vector, sweeps: int = 1) -> tuple[Vector, Vector]:
    """Return bounds of the solution after some sweeps of monotone projected relaxation, which never widens them.

    Parameters
    ----------
    problem : ContactQP
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
        upper = np.fmin(upper, _relaxed(problem, diagonal, upper, 1.0))
        lower = np.fmax(lower, _relaxed(problem, diagonal, lower, -1.0))
    return lower, upper


def _relaxed(problem: ContactQP, diagonal: Vector, omega: Vector, outwards: float) -> Vector:
    """Return T(ω), rounded upwards or downwards."""
    reaction, error = enclosed_reaction(problem, omega)
    step = (reaction - outwards * error) / diagonal
    moved = omega - step
    moved += outwards * (8 * UNIT_ROUNDOFF * (np.abs(omega) + np.abs(step)) + UNDERFLOW)
    return np.maximum(moved, 0.0, out=moved, where=problem.supported)


def certain_contact(problem: ContactQP, lower: Vector, upper: Vector) -> Mask:
    """Return the nodes where R* > 0 is certain, all others being as far away as they can be.

    If q_i + Σ_{j≠i} G_ij ω*_j > 0, then ω*_i > 0 would make R*_i > 0, which complementarity forbids; so ω*_i = 0,
    and R*_i is that sum. For a Z-matrix it is least with the upper bounds.
    """
    if problem.is_z_matrix:
        reaction, error = enclosed_reaction(problem, upper)
        own = problem.stiffness.diagonal() * upper
        return np.asarray((reaction - own > 2 * error + gamma(DIFFERENCES) * np.abs(own)) & problem.supported)
    middle, radius = middle_and_radius(lower, upper)
    reaction, error = enclosed_reaction(problem, middle)
    diagonal = problem.stiffness.diagonal()
    others = modulus_times(problem, radius) - diagonal * radius
    own = diagonal * middle
    return np.asarray(
        (reaction - own > 2 * error + others * _GROW + gamma(DIFFERENCES) * np.abs(own)) & problem.supported
    )


def enclosed_reaction(problem: ContactQP, omega: Vector) -> tuple[Vector, Vector]:
    """Return R = Gω + q as computed, and a bound of its rounding error."""
    return _enclosed(problem, omega, problem.q)


def enclosed_product(problem: ContactQP, vector: Vector) -> tuple[Vector, Vector]:
    """Return G times a vector as computed, and a bound of its rounding error."""
    return _enclosed(problem, vector, np.zeros(1))


def _enclosed(problem: ContactQP, omega: Vector, force: Vector) -> tuple[Vector, Vector]:
    stencil = problem.stencil
    if stencil is not None:
        # Differences of neighbours keep the digits that a product with the diagonal would lose.
        product, bound = stencil.pull_and_magnitude(stencil.pad(omega))
        bound += np.abs(force)
        bound *= gamma(DIFFERENCES)
    else:
        product = problem.stiffness.matvec(omega)
        if problem.is_z_matrix and omega.min() >= 0:
            bound = problem.stiffness.diagonal() * (2 * omega) - product
        else:
            bound = modulus_times(problem, np.abs(omega))
        bound += np.abs(force)
        bound *= growth_bound(problem.stiffness)
    bound += UNDERFLOW
    return product + force, bound


def modulus_times(problem: ContactQP, vector: Vector) -> Vector:
    """Return |G| times a vector, for a Z-matrix without a second matrix."""
    stiffness = problem.stiffness
    if isinstance(stiffness, Stencil) or problem.is_z_matrix:
        return np.asarray(stiffness.diagonal() * (2 * vector) - stiffness.matvec(vector))
    return stiffness.modulus_matvec(vector)


def middle_and_radius(lower: Vector, upper: Vector) -> tuple[Vector, Vector]:
    """Return the middle of bounds, rounded, and a radius about it that reaches both."""
    middle = 0.5 * lower + 0.5 * upper
    radius = np.maximum(upper - middle, middle - lower)
    return middle, radius * (1 + 4 * UNIT_ROUNDOFF) + UNDERFLOW
