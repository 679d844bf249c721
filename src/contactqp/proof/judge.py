"""The judge: what an answer is worth, from the problem's own data alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import UnsuitableProblemError
from ..foundation.checks import Vector
from ..problem.contact_qp import ContactQP
from .certificate import Certificate
from .certify import SHARP_SIZE, certificate_of, certify, fast_enclosure, sharper
from .lattice_measures import LatticeBounds, parabola_of
from .residuals import Residuals, compute_residuals, residuals_of
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
    relative_bound : float
        The certified bound over the problem's gap scale (see `answer_scale`); without a certificate the natural
        residual over it; infinite where there is no answer.
    """

    status: Status
    residuals: Residuals | None
    certificate: Certificate | None
    relative_bound: float


_LEAST_ANSWER = 1e-6


@np.errstate(over="ignore", invalid="ignore")
def answer_scale(problem: ContactQP, gap: Vector) -> float:
    """Return the length that the error of ``gap`` is measured by: the gap scale, but not more than the answer's own.

    The answer's is max|w|, w = reference - ω (for a matrix, max|ω|). If the error is proven below tol times that, it
    is the true solution's up to tol, so no overestimated gap scale lets a poor answer pass. Answers near zero
    count as a millionth of the gap scale; where no force opens a gap, the gap scale counts unabated.
    """
    return _measured_scale(problem, float(np.abs(problem.reference - gap).max()))


def _measured_scale(problem: ContactQP, largest_deflection: float) -> float:
    scale = problem.gap_scale
    measured = scale if problem.shut else max(min(scale, largest_deflection), _LEAST_ANSWER * scale)
    return max(measured, float(np.finfo(np.float64).tiny))


def relative_bound(problem: ContactQP, gap: Vector) -> float:
    """Return a bound of the error of a finite ``gap`` over the gap scale, as cheaply as it can be had.

    For an M-matrix it is that of the fast certificate, or a little more; otherwise it is the natural residual.
    """
    parabola = parabola_of(problem)
    if parabola is not None:
        bounds = LatticeBounds(problem, parabola, gap)
        return bounds.gap_bound / _measured_scale(problem, bounds.largest_deflection)
    certified = problem.is_m_matrix
    bound = fast_enclosure(problem, gap).bound if certified else compute_residuals(problem, gap).natural_residual
    return bound / answer_scale(problem, gap)


def judge(problem: ContactQP, gap: Vector | None, tol: float, limit: Status | None = None) -> Verdict:
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

    Returns
    -------
    Verdict
    """
    if gap is None or gap.shape != (problem.size,) or not np.isfinite(gap).all():
        return Verdict(limit or Status.FAILED, None, None, np.inf)
    parabola = parabola_of(problem)
    if parabola is not None:
        bounds = LatticeBounds(problem, parabola, gap)
        residuals, scale = residuals_of(bounds), _measured_scale(problem, bounds.largest_deflection)
        certificate: Certificate | None = certificate_of(bounds)
    else:
        residuals, scale = compute_residuals(problem, gap), answer_scale(problem, gap)
        certificate = _fast_certificate(problem, gap)
    if certificate is not None and certificate.gap_bound > tol * scale and problem.size <= SHARP_SIZE:
        certificate = sharper(certificate, gap)
    error = residuals.natural_residual if certificate is None else certificate.gap_bound
    if certificate is not None and error <= tol * scale:
        status = Status.CERTIFIED
    elif not problem.is_m_matrix and residuals.natural_residual <= tol * scale:
        status = Status.SOLVED
    else:
        status = limit or Status.INACCURATE
    return Verdict(status, residuals, certificate, error / scale)


def _fast_certificate(problem: ContactQP, gap: Vector) -> Certificate | None:
    try:
        return certify(problem, gap, effort="fast")
    except UnsuitableProblemError:
        return None
