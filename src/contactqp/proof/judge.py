"""The judge: what an answer is worth, from the problem's own data alone."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..foundation.checks import Vector
from ..models.base import ContactModel
from ..problem.contact_qp import ContactQP
from .certificate import Certificate
from .certify import SHARP_SIZE, sharper
from .measure import measure
from .measures import Measures
from .residuals import Residuals
from .status import Status


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
        The length that the error is measured by, see `Measures.scale`.
    """

    status: Status
    residuals: Residuals | None
    certificate: Certificate | None
    scale: float = 1.0

    @property
    def relative_bound(self) -> float:
        """The certified bound over `scale`; without a certificate the natural residual, without an answer infinite."""
        return self.relative_bound_of(self.certificate)

    def relative_bound_of(self, certificate: Certificate | None) -> float:
        """Return the same for another certificate of the answer."""
        if self.residuals is None:
            return np.inf
        error = self.residuals.natural_residual if certificate is None else certificate.gap_bound
        return error / self.scale


def judge(
    problem: ContactQP,
    gap: Vector | None,
    tol: float,
    limit: Status | None = None,
    *,
    model: ContactModel | None = None,
    measures: Measures | None = None,
) -> Verdict:
    """Judge an answer: by the fast certificate, and where that is not within ``tol``, by the sharp one.

    Parameters
    ----------
    problem : ContactQP
        The problem as posed, not scaled.
    gap : array, shape (n,), or None
        The answer (length); None if the backend returned nothing.
    tol : float
        Tolerance on the certified bound of the gap, relative to ``problem.gap_scale``.
    limit : Status, optional
        Why the backend stopped early, if it did: the status of an answer that is not good enough.
    model : ContactModel, optional
        What the problem comes from, for the certificate.
    measures : Measures, optional
        Those of ``gap``, if they have been taken before.

    Returns
    -------
    Verdict
    """
    if gap is None or gap.shape != (problem.size,) or not np.isfinite(gap).all():
        return Verdict(limit or Status.FAILED, None, None)
    if measures is None:
        measures = measure(problem, gap)
    residuals, scale, certificate = measures.residuals, measures.scale, measures.certificate()
    if certificate is not None:
        certificate = replace(certificate, model=model)
        if certificate.gap_bound > tol * scale and problem.size <= SHARP_SIZE:
            certificate = sharper(certificate, gap)
    error = residuals.natural_residual if certificate is None else certificate.gap_bound
    if certificate is not None and error <= tol * scale:
        status = Status.CERTIFIED
    elif not problem.is_m_matrix and residuals.natural_residual <= tol * scale:
        status = Status.SOLVED
    else:
        status = limit or Status.INACCURATE
    return Verdict(status, residuals, certificate, scale)
