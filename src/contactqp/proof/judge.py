"""The judge: what an answer is worth, from the problem's own data alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np

from ..foundation.checks import Vector
from ..models.base import ContactModel
from ..problem.contact_problem import ContactProblem
from .certificate import Certificate
from .measure import measure
from .measures import Measures
from .residuals import Residuals
from .sharper import SHARP_SIZE, sharper
from .status import Status

Optional: TypeAlias = Callable[[Callable[[], Certificate | None]], Certificate | None]
"""What does work that may be left out, see `judge`."""


@dataclass(frozen=True)
class Verdict:
    """The judge's findings on one answer.

    Attributes
    ----------
    status : Status
    residuals : Residuals or None
        None if the answer is not a finite vector.
    certificate : Certificate or None
        None if the answer is not a finite vector, or nothing is known of such a matrix. It is the fast one, where that
        is good enough.
    scale : float
        The error scale: the length that the error is measured by, see `Measures.scale`.
    """

    status: Status
    residuals: Residuals | None
    certificate: Certificate | None
    scale: float = 1.0

    @property
    def relative_bound(self) -> float:
        """The certified bound over `scale`, infinite without a certificate."""
        return self.relative_bound_of(self.certificate)

    def relative_bound_of(self, certificate: Certificate | None) -> float:
        """Return the same for another certificate of the answer."""
        return np.inf if certificate is None else certificate.gap_bound / self.scale

    @property
    def relative_residual(self) -> float:
        """The natural residual over `scale`, infinite without an answer; no bound of the error, and no part of one."""
        return np.inf if self.residuals is None else self.residuals.natural_residual / self.scale


def judge(
    problem: ContactProblem,
    gap: Vector | None,
    tol: float,
    limit: Status | None = None,
    *,
    model: ContactModel | None = None,
    measures: Measures | None = None,
    optional: Optional | None = None,
) -> Verdict:
    """Judge an answer: by the fast certificate, and where that is not within ``tol``, by the sharp one.

    Only a proven bound within ``tol`` makes the status ok.

    Parameters
    ----------
    problem : ContactProblem
        The problem as posed, not scaled.
    gap : array, shape (n,), or None
        The answer (length); None if the backend returned nothing.
    tol : float
        Tolerance on the certified bound of the gap, relative to the answer's error scale.
    limit : Status, optional
        Why the backend stopped early, if it did: the status of an answer that is not good enough.
    model : ContactModel, optional
        What the problem comes from, for the certificate.
    measures : Measures, optional
        Those of ``gap``, if they have been taken before.
    optional : callable, optional
        Does the work that finds certificates, and returns what that returns, or None if it takes too long; by default
        it may take any time.

    Returns
    -------
    Verdict
    """
    if gap is None or gap.shape != (problem.size,) or not np.isfinite(gap).all():
        return Verdict(limit or Status.FAILED, None, None)
    if measures is None:
        measures = measure(problem, gap)
    do = _at_any_time if optional is None else optional
    residuals, scale, certificate = measures.residuals, measures.scale, do(measures.certificate)
    if certificate is not None:
        certificate = certificate if model is None else replace(certificate, model=model)
        if certificate.gap_bound > tol * scale and problem.size <= SHARP_SIZE:
            certificate = do(partial(sharper, certificate, gap)) or certificate
    if certificate is not None and certificate.gap_bound <= tol * scale:
        status = Status.CERTIFIED
    elif residuals.natural_residual <= tol * scale and _may_be_within(certificate, gap, tol * scale):
        status = Status.UNPROVEN
    else:
        status = limit or Status.INACCURATE
    return Verdict(status, residuals, certificate, scale)


def _at_any_time(work: Callable[[], Certificate | None]) -> Certificate | None:
    return work()


def _may_be_within(certificate: Certificate | None, gap: Vector, error: float) -> bool:
    """Whether it is the certificate's weakness, and not the answer's error, that keeps the bound above ``error``.

    For an M-matrix the certificate is not weak, and an answer that is not certified is an inaccurate one.
    """
    if certificate is None:
        return True
    if not certificate.weaker:
        return False
    with np.errstate(over="ignore", invalid="ignore"):
        return bool((gap >= certificate.lower - error).all() and (gap <= certificate.upper + error).all())
