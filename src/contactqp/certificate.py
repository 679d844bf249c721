"""Certificate: a rigorous enclosure of the true solution, from any approximate one."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._checks import Mask, Vector, one_of, vector
from .enclosure import (
    Base,
    Enclosure,
    certain_contact,
    enclosed_product,
    enclosed_reaction,
    enclosure_about,
    middle_and_radius,
    modulus_times,
    multiples,
)
from .errors import UnsuitableProblemError
from .lattice_bounds import LatticeBounds, parabola_of
from .model import ContactModel, split
from .problem import ContactQP
from .rounding import UNDERFLOW, UNIT_ROUNDOFF, at_most, growth_bound, sum_above, sum_below
from .sharpening import sharpened
from .weaker import COMPARISON, EIGENVALUE, weaker_enclosure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Effort = Literal["fast", "sharp"]

SHARP_SIZE = 5_000_000
"""Unknowns up to which a sharp certificate is made unless told otherwise: it takes a second or so for each million."""


class Bracket(NamedTuple):
    """A number that is known to lie between two others.

    Attributes
    ----------
    lower, upper : float
    """

    lower: float
    upper: float


@dataclass(frozen=True, eq=False)
class Certificate:
    """Bounds that the exact solution ω* of a problem provably satisfies, node by node.

    Attributes
    ----------
    problem : ContactQP
        The problem.
    model : Membrane, Cable, CableNet or None
        What it comes from, if that was certified.
    lower, upper : array, shape (n,)
        lower ≤ ω* ≤ upper (length).
    gap_bound : float
        max |ω - ω*| is at most this (length), for the ω that was certified.
    contact : array of bool, shape (n,)
        Nodes where R* > 0 is certain.
    clear : array of bool, shape (n,)
        Nodes where ω* > 0 is certain, and all nodes without a support.
    barrier : str
        What the bounds are multiples of: ``"paraboloid"``, ``"strip along x"``, ``"strip along y"``, ``"linear solve"``
        or ``"free set"``; for a matrix that is no M-matrix ``"comparison matrix"`` or ``"smallest eigenvalue"``.
    """

    problem: ContactQP = field(repr=False)
    lower: Vector
    upper: Vector
    gap_bound: float
    contact: Mask
    clear: Mask
    barrier: str
    model: ContactModel | None = field(default=None, repr=False)

    @property
    def undecided(self) -> Mask:
        """Nodes that are neither certainly clear nor certainly in contact."""
        return ~(self.contact | self.clear)

    @property
    def weaker(self) -> bool:
        """Whether the bound is one of those known beyond M-matrices, which may exceed the error by far."""
        return self.barrier in (COMPARISON, EIGENVALUE)

    @property
    def contact_nodes(self) -> Bracket:
        """Bracket of the number of nodes in contact, R* > 0: those certainly so, and with them the undecided ones."""
        certain = int(np.count_nonzero(self.contact))
        return Bracket(certain, certain + int(np.count_nonzero(self.undecided)))

    @property
    def contact_area(self) -> Bracket:
        """Bracket of the area in contact, Δ² for every node (cable: of the length, Δ for every node)."""
        nodes, area = self.contact_nodes, self._physical("contact_area").area_of_node("contact_area")
        return Bracket(nodes.lower * area, nodes.upper * area)

    @cached_property
    def reaction(self) -> tuple[Vector, Vector]:
        """Lower and upper bounds of the exact reaction R* = Gω* + q (force), shape (n,) each.

        R* is 0 at nodes that are certainly clear, and ≥ 0 everywhere.
        """
        problem = self.problem
        with np.errstate(over="ignore", invalid="ignore"):
            middle, radius = middle_and_radius(self.lower, self.upper)
            value, error = enclosed_reaction(problem, middle)
            reach = modulus_times(problem, radius) * (1 + 2 * growth_bound(problem.stiffness)) + error
            lower, upper = np.nextafter(value - reach, -np.inf), np.nextafter(value + reach, np.inf)
        known = np.isfinite(lower) & np.isfinite(upper)
        lower = np.where(known & ~self.clear, np.maximum(lower, 0.0), 0.0)
        upper = np.where(self.clear, 0.0, np.where(known, np.maximum(upper, 0.0), np.inf))
        return lower, upper

    @cached_property
    def total_reaction(self) -> Bracket:
        """Bracket of the sum of R* over all nodes (force).

        It is the better of two: the sum of the nodes' own brackets, and Σq + cᵀω* with the column sums c of G, which on
        a lattice are zero but beside the frame.
        """
        lower, upper = self.reaction
        low, high = sum_below(lower), sum_above(upper)
        problem = self.problem
        with np.errstate(over="ignore", invalid="ignore"):
            columns, slack = column_sums(problem)
            middle, radius = middle_and_radius(self.lower, self.upper)
            product = columns * middle
            reach = np.abs(columns) * radius + slack * (np.abs(middle) + radius)
            reach = (reach + 4 * UNIT_ROUNDOFF * np.abs(product) + UNDERFLOW) * (1 + 16 * UNIT_ROUNDOFF)
        if np.isfinite(product).all() and np.isfinite(reach).all():
            low = max(low, sum_below([*problem.q, *product, *-reach]))
            high = min(high, sum_above([*problem.q, *product, *reach]))
        return Bracket(max(0.0, low), high)

    def contains(self, gap: ArrayLike) -> bool:
        """Whether ``gap`` lies between the bounds at every node.

        An approximate answer may leave its own enclosure by its own error. `intersects` tells whether two answers are
        compatible.
        """
        omega = np.asarray(gap)
        return bool(((self.lower <= omega) & (omega <= self.upper)).all())

    def intersects(self, other: Certificate) -> bool:
        """Whether one and the same solution can satisfy both enclosures."""
        return bool((np.maximum(self.lower, other.lower) <= np.minimum(self.upper, other.upper)).all())

    def plot(self) -> Figure:
        """Draw the contact map of what is certain: nodes in contact, clear and undecided, each in their own colour.

        Of a cable it is the bounds of the gap, and of a cable net the plan.

        Raises
        ------
        AttributeError
            If a bare `ContactQP` was certified, which knows no places; certify the model.
        """
        from .plotting import plot_certificate

        return plot_certificate(self, self._physical("plot"))

    def _physical(self, attribute: str) -> ContactModel:
        if self.model is None:
            raise AttributeError(
                f"{attribute} needs a Membrane, a Cable or a CableNet; "
                "this certificate is of a bare ContactQP, certify the model"
            )
        return self.model

    def __repr__(self) -> str:
        kind = f"{self.barrier}, weaker than for an M-matrix" if self.weaker else self.barrier
        return (
            f"Certificate(|gap error| <= {at_most(self.gap_bound, 3)}; {np.count_nonzero(self.contact)} in contact, "
            f"{np.count_nonzero(self.clear)} clear, {np.count_nonzero(self.undecided)} undecided; {kind})"
        )


@np.errstate(over="ignore", invalid="ignore")
def certify(problem: ContactQP | ContactModel, gap: ArrayLike, *, effort: Effort | None = None) -> Certificate:
    r"""Enclose the exact solution of ``problem``, given any approximate ``gap`` from any program.

    With a barrier v > 0, s ≤ Gv, s > 0, and R = Gω + q let

    .. math::
        τ⁺ = \max_i \max(0, -ω_i/v_i, -R_i/s_i), \qquad τ⁻ = \max_i \max(0, \min(ω_i/v_i, R_i/s_i)).

    Then ω - τ⁻v ≤ ω* ≤ ω + τ⁺v, for ω + τ⁺v is a supersolution and ω - τ⁻v a subsolution; at a node without support
    ω_i/v_i counts as +∞. The proof, and that of what makes the bounds sharper, stands in `contactqp.enclosure`: a
    correction by Newton's method to lay the bounds about, a barrier that vanishes on the contact set, and monotone
    relaxation. For matrices that are no M-matrices there are weaker bounds, see `contactqp.weaker`.

    Every computed quantity is widened by a bound of its rounding error (Higham 2002, ch. 3), so that the
    statement holds for the exact solution of the problem whose G and q are the stored doubles; on a lattice G consists
    of the exact sums of its arms.

    Parameters
    ----------
    problem : Membrane, Cable, CableNet or ContactQP
        Any; what is known of its matrix decides on the kind of bound.
    gap : array, shape (n,)
        The approximate solution ω (length); it need not be feasible.
    effort : {"sharp", "fast"}, optional
        ``"fast"`` evaluates the formulas above, on a lattice in a pass or two over it. ``"sharp"`` takes some
        linear solves on the nodes that are not in contact, and bounds the error to within a per cent as a rule; it
        holds some thirty vectors in memory. By default sharp up to five million unknowns, and fast beyond.

    Returns
    -------
    Certificate

    Raises
    ------
    UnsuitableProblemError
        If no bound is known: the matrix is no M-matrix and no H-matrix, and too large for a dense factorisation.
    TypeError, ValueError
        If ``problem`` is no problem, ``gap`` has the wrong shape or is not finite, or ``effort`` is unknown; or if the
        matrix turns out not to be positive definite, to rounding.

    Examples
    --------
    >>> import numpy as np
    >>> import contactqp as cq
    >>> problem = cq.ContactQP(np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([-1.0, 3.0]))
    >>> cq.certify(problem, [0.5, 0.0]).gap_bound < 1e-14
    True
    >>> cq.certify(problem, [0.51, 0.0])
    Certificate(|gap error| <= 0.0101; 1 in contact, 1 clear, 0 undecided; linear solve)
    >>> cq.certify(problem, [0.51, 0.0], effort="fast")
    Certificate(|gap error| <= 0.0201; 1 in contact, 1 clear, 0 undecided; linear solve)
    """
    model, algebra = split(problem)
    if effort is None:
        effort = "sharp" if algebra.size <= SHARP_SIZE else "fast"
    one_of(effort, ("fast", "sharp"), "effort")
    found = _certified(algebra, vector(gap, algebra.size, "gap", copied=False), effort)
    return found if model is None else replace(found, model=model)


def _certified(problem: ContactQP, omega: Vector, effort: str) -> Certificate:
    if problem.barrier is None:
        return _weaker_certificate(problem, omega)
    parabola = parabola_of(problem)
    if parabola is None:
        first = fast_enclosure(problem, omega)
        return sharp_certificate(problem, first) if effort == "sharp" else _certificate(problem, first)
    fast = certificate_of(LatticeBounds(problem, parabola, omega))
    return sharper(fast, omega) if effort == "sharp" else fast


@np.errstate(over="ignore", invalid="ignore")
def fast_enclosure(problem: ContactQP, omega: Vector) -> Enclosure:
    """Return the enclosure about ``omega`` by the barrier of an M-matrix."""
    barrier = problem.barrier
    assert barrier is not None
    base = Base.of(problem, omega)
    found = multiples(problem, base, barrier.v, barrier.s)
    return enclosure_about(omega, problem.supported, base, barrier.v, found, barrier.kind)


@np.errstate(over="ignore", invalid="ignore")
def sharper(certificate: Certificate, omega: Vector) -> Certificate:
    """Return the sharp certificate of the answer whose fast one is given; a weaker one stays what it is."""
    if certificate.weaker:
        return certificate
    fall = np.nextafter(omega - certificate.lower, np.inf)
    rise = np.nextafter(certificate.upper - omega, np.inf)
    found = sharp_certificate(certificate.problem, Enclosure(omega, fall, rise, certificate.barrier))
    # What the fast one proves, it proves by sums of its own, whose roundings are others.
    return replace(
        found,
        lower=np.fmax(found.lower, certificate.lower),
        upper=np.fmin(found.upper, certificate.upper),
        gap_bound=min(found.gap_bound, certificate.gap_bound),
        contact=found.contact | certificate.contact,
        clear=found.clear | certificate.clear,
    )


def sharp_certificate(problem: ContactQP, first: Enclosure) -> Certificate:
    """Return the sharp certificate of an answer, from a first enclosure about it; only for an M-matrix."""
    if not np.isfinite(first.bound):
        return _know_nothing(problem, first.barrier)
    return _certificate(problem, sharpened(problem, first.answer, first))


def certificate_of(bounds: LatticeBounds) -> Certificate:
    """Return the fast certificate of an answer on a large lattice that has been measured already."""
    found = bounds.enclosure()
    if found is None:
        return _know_nothing(bounds.problem, bounds.barrier.kind)
    lower, upper, contact, clear, gap_bound = found
    return Certificate(bounds.problem, lower, upper, gap_bound, contact, clear, bounds.barrier.kind)


def column_sums(problem: ContactQP) -> tuple[Vector, Vector]:
    """Return the column sums of G, and bounds of their rounding errors."""
    return enclosed_product(problem, np.ones(problem.size))


def _certificate(problem: ContactQP, found: Enclosure) -> Certificate:
    lower, upper = found.bounds(problem.supported)
    if not (np.isfinite(found.bound) and np.isfinite(lower).all() and np.isfinite(upper).all()):
        return _know_nothing(problem, found.barrier)
    contact = certain_contact(problem, lower, upper)
    lower[contact] = upper[contact] = 0.0
    clear = (lower > 0) | ~problem.supported
    return Certificate(problem, lower, upper, found.bound, contact, clear, found.barrier)


def _weaker_certificate(problem: ContactQP, omega: Vector) -> Certificate:
    found = weaker_enclosure(problem, omega)
    if found is None:
        raise UnsuitableProblemError(
            f"no enclosure is known for {problem!r}: its matrix is neither an M-matrix nor an H-matrix, and "
            "too large for a proof of its smallest eigenvalue; rely on the residuals"
        )
    return _certificate(problem, found)


def _know_nothing(problem: ContactQP, barrier: str) -> Certificate:
    """Return the enclosure that always holds, for numbers whose bounds overflow."""
    nowhere = np.zeros(problem.size, dtype=np.bool_)
    lower = np.where(problem.supported, 0.0, -np.inf)
    return Certificate(problem, lower, np.full(problem.size, np.inf), np.inf, nowhere, ~problem.supported, barrier)
