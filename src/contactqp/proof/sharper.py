"""sharper(): the sharp certificate of an answer, from the fast one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..foundation.checks import Vector
from .beyond_m_matrices import repaired
from .certificate import Certificate
from .enclosure import Enclosure
from .sharpening import sharpened

SHARP_SIZE = 5_000_000
"""Unknowns up to which a sharp certificate is made unless told otherwise: it takes a second or so for each million."""


@np.errstate(over="ignore", invalid="ignore")
def sharper(certificate: Certificate, omega: Vector) -> Certificate:
    """Return the sharp certificate of the answer whose fast one is given."""
    problem = certificate.enclosed or certificate.problem
    fall = np.nextafter(omega - certificate.lower, np.inf)
    rise = np.nextafter(certificate.upper - omega, np.inf)
    first = Enclosure(omega, fall, rise, certificate.barrier)
    if not np.isfinite(first.bound):
        return certificate
    improved = repaired if certificate.weaker else sharpened
    found = Certificate.of(problem, improved(problem, omega, first))
    # The fast certificate rounds differently, so it may prove a node that the sharp one does not: keep both.
    return replace(
        found,
        problem=certificate.problem,
        enclosed=certificate.enclosed,
        lower=np.fmax(found.lower, certificate.lower),
        upper=np.fmin(found.upper, certificate.upper),
        gap_bound=min(found.gap_bound, certificate.gap_bound),
        contact=found.contact | certificate.contact,
        contact_upper=found.contact_upper | certificate.contact_upper,
        clear=found.clear | certificate.clear,
        model=certificate.model,
    )
