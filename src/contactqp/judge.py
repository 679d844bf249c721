"""The judge: what an answer is worth, from the problem's own data alone."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from enum import StrEnum

import numpy as np

from ._checks import Vector
from .certificate import SHARP_SIZE, Certificate, certificate_of, certify, fast_enclosure, sharper
from .errors import UnsuitableProblemError
from .lattice_bounds import LatticeBounds, parabola_of
from .problem import ContactQP


class Status(StrEnum):
    """What the judge found; `advice` says what to do about it."""

    CERTIFIED = "certified"
    SOLVED = "solved"
    INACCURATE = "inaccurate"
    ITERATION_LIMIT = "iteration_limit"
    TIME_LIMIT = "time_limit"
    FAILED = "failed"

    @property
    def ok(self) -> bool:
        """Whether the answer is as good as was asked for."""
        return self in (Status.CERTIFIED, Status.SOLVED)

    @property
    def advice(self) -> str:
        """One sentence for the person who reads the status."""
        return _ADVICE[self]


_ADVICE = {
    Status.CERTIFIED: "The exact solution of the discrete problem is proven to lie within tol of the answer.",
    Status.SOLVED: "The residuals are within tol; what is known of such a matrix does not prove the error to be.",
    Status.INACCURATE: "Use it with the bound that it achieved, loosen tol, or take another backend.",
    Status.ITERATION_LIMIT: "Raise max_iter, pass this answer as warm_start, or take another backend.",
    Status.TIME_LIMIT: "Raise time_limit, pass this answer as warm_start, or take another backend.",
    Status.FAILED: "Take another backend; the solution's termination says what this one reported.",
}


@dataclass(frozen=True)
class Residuals:
    """How far an answer is from the optimality conditions.

    Attributes
    ----------
    min_gap : float
        min ω_i over supported nodes (length): negative is a primal violation.
    min_reaction : float
        min R_i (force): negative is a dual violation.
    complementarity : float
        ωᵀR (force times length): the duality gap, if both are feasible.
    natural_residual : float
        max |min(ω_i, R_i/G_ii)| (length), |R_i/G_ii| where there is no support: zero at the solution only.
    objective : float
        ½ωᵀGω + qᵀω (force times length).
    """

    min_gap: float
    min_reaction: float
    complementarity: float
    natural_residual: float
    objective: float

    def to_dict(self) -> dict[str, float]:
        """Return the residuals by name."""
        return asdict(self)


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


@np.errstate(over="ignore", invalid="ignore")
def compute_residuals(problem: ContactQP, gap: Vector) -> Residuals:
    """Return the `Residuals` of ``gap``, a finite vector of the problem's size."""
    parabola = parabola_of(problem)
    if parabola is not None:
        return _residuals_of(LatticeBounds(problem, parabola, gap))
    product = problem.stiffness.matvec(gap)
    reaction = product + problem.q
    return Residuals(
        min_gap=float(gap.min(where=problem.supported, initial=np.inf)),
        min_reaction=float(reaction.min()),
        complementarity=_inner(gap, reaction),
        natural_residual=float(np.abs(natural_map(problem, gap, reaction)).max()),
        objective=_inner(gap, 0.5 * product + problem.q),
    )


def _residuals_of(bounds: LatticeBounds) -> Residuals:
    return Residuals(
        min_gap=bounds.least_gap,
        min_reaction=bounds.least_reaction,
        complementarity=bounds.complementarity,
        natural_residual=bounds.natural_residual,
        objective=bounds.objective,
    )


def natural_map(problem: ContactQP, gap: Vector, reaction: Vector) -> Vector:
    """Return min(ω_i, R_i/G_ii), and R_i/G_ii where there is no support: zero at the solution only."""
    correction = reaction / problem.stiffness.diagonal()
    return np.where(problem.supported, np.minimum(gap, correction), correction)


def _inner(first: Vector, second: Vector) -> float:
    """Return the inner product by pairwise summation, without BLAS, whose threads stall on a busy machine."""
    return float((first * second).sum())


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
        residuals, scale = _residuals_of(bounds), _measured_scale(problem, bounds.largest_deflection)
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
