"""certify(): enclose the exact solution, given any approximate one."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..errors import UnsuitableProblemError
from ..foundation.checks import Vector, one_of, vector
from ..models.base import ContactModel, split
from ..problem.contact_qp import ContactQP
from .beyond_m_matrices import weaker_enclosure
from .certificate import Certificate
from .enclosure import (
    Base,
    Enclosure,
    certain_contact,
    enclosure_about,
    multiples,
)
from .lattice_measures import LatticeBounds, parabola_of
from .sharpening import sharpened

Effort = Literal["fast", "sharp"]

SHARP_SIZE = 5_000_000
"""Unknowns up to which a sharp certificate is made unless told otherwise: it takes a second or so for each million."""


@np.errstate(over="ignore", invalid="ignore")
def certify(problem: ContactQP | ContactModel, gap: ArrayLike, *, effort: Effort | None = None) -> Certificate:
    r"""Enclose the exact solution of ``problem``, given any approximate ``gap`` from any program.

    With a barrier v > 0, s ≤ Gv, s > 0, and R = Gω + q let

    .. math::
        τ⁺ = \max_i \max(0, -ω_i/v_i, -R_i/s_i), \qquad τ⁻ = \max_i \max(0, \min(ω_i/v_i, R_i/s_i)).

    Then ω - τ⁻v ≤ ω* ≤ ω + τ⁺v, for ω + τ⁺v is a supersolution and ω - τ⁻v a subsolution; at a node without support
    ω_i/v_i counts as +∞. The proof, and that of what makes the bounds sharper, stands in `contactqp.proof.enclosure`: a
    correction by Newton's method to lay the bounds about, a barrier that vanishes on the contact set, and monotone
    relaxation. For matrices that are no M-matrices there are weaker bounds, see `contactqp.proof.beyond_m_matrices`.

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
