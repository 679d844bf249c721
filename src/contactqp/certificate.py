"""Certificate: a rigorous enclosure of the true solution, from any approximate one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ._checks import Mask, Vector, vector
from .errors import UnsuitableProblemError
from .lattice_bounds import LatticeBounds, parabola_of
from .problem import ContactQP
from .rounding import DIFFERENCES, UNDERFLOW, UNIT_ROUNDOFF, gamma, growth_bound


@dataclass(frozen=True)
class Certificate:
    """Bounds that the exact solution ω* of a problem provably satisfies, node by node.

    Attributes
    ----------
    lower, upper : array, shape (n,)
        lower ≤ ω* ≤ upper (length).
    gap_bound : float
        max |ω - ω*| is at most this (length), for the ω that was certified.
    contact : array of bool, shape (n,)
        Nodes where R* > 0 is certain.
    clear : array of bool, shape (n,)
        Nodes where ω* > 0 is certain, and all nodes without a support.
    barrier : str
        The kind of barrier that the bounds are multiples of.
    """

    lower: Vector
    upper: Vector
    gap_bound: float
    contact: Mask
    clear: Mask
    barrier: str

    @property
    def undecided(self) -> Mask:
        """Nodes that are neither certainly clear nor certainly in contact."""
        return ~(self.contact | self.clear)

    def contains(self, gap: ArrayLike) -> bool:
        """Whether ``gap`` lies between the bounds at every node.

        An approximate answer may leave its own enclosure by its own error: a supported node's lower bound is never
        below 0, a backend's gap may be. `intersects` tells whether two answers are compatible.
        """
        omega = np.asarray(gap)
        return bool(((self.lower <= omega) & (omega <= self.upper)).all())

    def intersects(self, other: Certificate) -> bool:
        """Whether one and the same solution can satisfy both enclosures."""
        return bool((np.maximum(self.lower, other.lower) <= np.minimum(self.upper, other.upper)).all())

    def __repr__(self) -> str:
        return (
            f"Certificate(|gap error| <= {self.gap_bound:.3g}; {np.count_nonzero(self.contact)} in contact, "
            f"{np.count_nonzero(self.clear)} clear, {np.count_nonzero(self.undecided)} undecided; {self.barrier})"
        )


def certify(problem: ContactQP, gap: ArrayLike) -> Certificate:
    r"""Enclose the exact solution of ``problem``, given any approximate ``gap`` from any program.

    With a barrier v > 0, s ≤ Gv, s > 0, and R = Gω + q let

    .. math::
        τ⁺ = \max_i \max(0, -ω_i/v_i, -R_i/s_i), \qquad τ⁻ = \max_i \max(0, \min(ω_i/v_i, R_i/s_i)).

    Then ω - τ⁻v ≤ ω* ≤ ω + τ⁺v. *Upper:* ω + τ⁺v is ≥ 0 and its reaction R + τ⁺Gv ≥ R + τ⁺s is ≥ 0: it is
    feasible, and for an M-matrix ω* is the least feasible vector (Cottle, Pang and Stone, *The Linear
    Complementarity Problem*, 1992, theorem 3.11.6). *Lower:* put z = ω - τ⁻v; wherever z_i > 0 we have
    ω_i/v_i > τ⁻, hence R_i/s_i ≤ τ⁻ and (Gz + q)_i ≤ R_i - τ⁻s_i ≤ 0. If z exceeded ω* anywhere, take the largest
    θ with (z - ω* - θv)_i ≤ 0 for all i, attained at i: there z_i > ω*_i ≥ 0, (G(z - ω*))_i ≤ 0 as (Gω* + q)_i ≥ 0,
    but (G(z - ω* - θv))_i ≥ 0 for a Z-matrix with the maximum 0 at i, a contradiction with θ(Gv)_i > 0.
    At a node without support ω_i/v_i counts as +∞ in both formulas.

    Every computed quantity is widened by a bound of its rounding error (Higham 2002, ch. 3), so that the
    statement holds for the exact solution of the problem whose G and q are the stored doubles; on a lattice G consists
    of the exact sums of its arms.

    Parameters
    ----------
    problem : ContactQP
        Its matrix must be an M-matrix.
    gap : array, shape (n,)
        The approximate solution ω (length); it need not be feasible.

    Raises
    ------
    UnsuitableProblemError
        If the matrix is not (verifiably) an M-matrix: then no such bound is known.
    ValueError
        If ``gap`` has the wrong shape or is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> import contactqp as cq
    >>> problem = cq.ContactQP(np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([-1.0, 3.0]))
    >>> cq.certify(problem, [0.5, 0.0]).gap_bound < 1e-14
    True
    >>> cq.certify(problem, [0.51, 0.0])
    Certificate(|gap error| <= 0.02; 1 in contact, 1 clear, 0 undecided; linear solve)
    """
    barrier = problem.barrier
    if barrier is None:
        raise UnsuitableProblemError(
            f"no enclosure is known for {problem!r}: its matrix is not verifiably an M-matrix; rely on the residuals"
        )
    omega = vector(gap, problem.size, "gap")
    parabola = parabola_of(problem)
    if parabola is not None:
        return certificate_of(LatticeBounds(problem, parabola, omega))
    v, s, free = barrier.v, barrier.s, ~problem.supported

    with np.errstate(over="ignore", invalid="ignore"):
        reaction, error = _enclosed_reaction(problem, omega)
        clearance = omega / v
        clearance[free] = np.inf
        grow = 1 + 16 * UNIT_ROUNDOFF
        raise_by = grow * np.maximum(-clearance, (error - reaction) / s).max(initial=0.0) + UNDERFLOW
        lower_by = grow * np.minimum(clearance, (error + reaction) / s).max(initial=0.0) + UNDERFLOW

        slack = 4 * UNIT_ROUNDOFF
        upper = omega + raise_by * v
        upper += slack * (np.abs(omega) + raise_by * v) + UNDERFLOW
        lower = omega - lower_by * v
        lower -= slack * (np.abs(omega) + lower_by * v) + UNDERFLOW
        np.maximum(lower, 0.0, out=lower, where=problem.supported)
        upper_reaction, upper_error = _enclosed_reaction(problem, upper)
        # The reaction with node i itself held at zero gap and all others as far away as they can be.
        own = problem.stiffness.diagonal() * upper
        held_shut = upper_reaction - own
        contact = (held_shut > 2 * upper_error + gamma(DIFFERENCES) * np.abs(own)) & problem.supported
        gap_bound = grow * np.maximum(upper - omega, omega - lower).max() + UNDERFLOW
    if not (np.isfinite(upper_reaction).all() and np.isfinite(upper_error).all() and np.isfinite(gap_bound)):
        return _know_nothing(problem, barrier.kind)
    return Certificate(lower, upper, float(gap_bound), contact, (lower > 0) | free, barrier.kind)


def certificate_of(bounds: LatticeBounds) -> Certificate:
    """Return the certificate of an answer on a large lattice that has been measured already."""
    found = bounds.enclosure()
    if found is None:
        return _know_nothing(bounds.problem, bounds.barrier.kind)
    lower, upper, contact, clear, gap_bound = found
    return Certificate(lower, upper, gap_bound, contact, clear, bounds.barrier.kind)


def _know_nothing(problem: ContactQP, barrier: str) -> Certificate:
    """Return the enclosure that always holds, for numbers whose bounds overflow."""
    nowhere = np.zeros(problem.size, dtype=np.bool_)
    lower = np.where(problem.supported, 0.0, -np.inf)
    return Certificate(lower, np.full(problem.size, np.inf), np.inf, nowhere, ~problem.supported, barrier)


def _enclosed_reaction(problem: ContactQP, omega: Vector) -> tuple[Vector, Vector]:
    """Return R = Gω + q as computed, and a bound of its rounding error."""
    stencil = problem.stencil
    if stencil is not None:
        # Differences of neighbours keep the digits that a product with the diagonal would lose.
        reaction, bound = stencil.pull_and_magnitude(stencil.pad(omega))
        bound += np.abs(problem.q)
        bound *= gamma(DIFFERENCES)
    else:
        reaction = problem.stiffness.matvec(omega)
        magnitude = np.abs(omega)
        # |G| |ω| of a Z-matrix, without a second matrix: twice the diagonal part less G |ω|.
        bound = 2 * problem.stiffness.diagonal() * magnitude - (
            reaction if omega.min() >= 0 else problem.stiffness.matvec(magnitude)
        )
        bound += np.abs(problem.q)
        bound *= growth_bound(problem.stiffness)
    bound += UNDERFLOW
    return reaction + problem.q, bound
