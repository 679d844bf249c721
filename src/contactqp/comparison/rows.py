"""Row: one backend's line in a comparison."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..foundation.rounding import quotient_above, quotient_below
from ..problem.contact_problem import ContactProblem
from ..proof.status import Status
from ..solving.solution import Solution
from .answers import Answers
from .outcome import Outcome, Refusal


@dataclass(frozen=True)
class Row:
    """What one backend achieved. A backend that returned nothing has a `status` and a ``message`` only.

    Attributes
    ----------
    backend : str
    status : str
        A `Status`, or that of a `Refusal`: ``"missing"``, ``"unsuitable"`` or ``"error"``.
    message : str
        The backend's own words, or the error's.
    iterations : int or None
    setup_seconds, solve_seconds : float or None
    min_gap, min_reaction, complementarity, natural_residual, objective : float or None
        See `Residuals`; complementarity ωᵀR is the duality gap.
    relative_bound : float or None
        Certified bound over the error scale (see `Verdict.scale`), infinite without a certificate.
    relative_residual : float or None
        Natural residual over the same scale: no bound of the error.
    contact : int or None
        Nodes in contact by the backend's own answer, whichever bound holds them.
    contact_upper : int or None
        Those of them that the upper bound holds; None if the problem has no upper bound.
    certain_contact, certain_clear, undecided : int or None
        Nodes that the certificate decides, and those that it does not.
    primal_residual, dual_residual : float or None
        max(0, -min_gap) (length) and max(0, -min_reaction) (force): by how much bounds are overstepped, and by how
        much they pull.
    gap_bound : float or None
        Certified bound of max|ω_i - ω*_i| (length).
    true_error_lower, true_error_upper : float or None
        Two lengths between which max|ω_i - ω*_i| lies, by the certificates of all backends; None without a truth.
    relative_true_error : float or None
        The upper one over the scale that ``relative_bound`` is measured by.
    contact_jaccard : float or None
        1 - |intersection| / |union| of the contact set and the best answer's. A contact is a node and the bound that
        holds it.
    boundary_distance : float or None
        Hausdorff distance of the free boundary from the best answer's (length): 0 if neither has one, infinite if only
        one has; None for a bare matrix.
    cold_seconds : float or None
        The first run, with scaling and judging.
    loading_seconds : float or None
        What loading libraries and compiling kernels took before it; no other time contains it.
    warm_seconds : float or None
        The fastest of the runs after it, in a `Solver` that keeps the backend's set-up; None if there were none.
    error_scale : float or None
        The length that the answer's error is measured by, see `Verdict.scale`.
    claimed : bool or None
        Whether the backend itself said that it had solved the problem.
    max_slope : float or None
        Largest slope of the deflection along an arm; the theory assumes small ones. None for a bare matrix.
    findings : tuple of str
        What the judge caught the backend at on the way.
    """

    backend: str
    status: str
    message: str
    iterations: int | None = None
    setup_seconds: float | None = None
    solve_seconds: float | None = None
    min_gap: float | None = None
    min_reaction: float | None = None
    complementarity: float | None = None
    natural_residual: float | None = None
    objective: float | None = None
    relative_bound: float | None = None
    relative_residual: float | None = None
    contact: int | None = None
    contact_upper: int | None = None
    certain_contact: int | None = None
    certain_clear: int | None = None
    undecided: int | None = None
    primal_residual: float | None = None
    dual_residual: float | None = None
    gap_bound: float | None = None
    true_error_lower: float | None = None
    true_error_upper: float | None = None
    relative_true_error: float | None = None
    contact_jaccard: float | None = None
    boundary_distance: float | None = None
    cold_seconds: float | None = None
    loading_seconds: float | None = None
    warm_seconds: float | None = None
    error_scale: float | None = None
    claimed: bool | None = None
    max_slope: float | None = None
    findings: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether the answer is proven to be as good as was asked for."""
        return self.status == Status.CERTIFIED

    @property
    def least_error(self) -> float:
        """What the error is proven to be at least, over the error scale; 0 where nothing is proven."""
        if self.true_error_lower is None or self.error_scale is None:
            return 0.0
        return quotient_below(self.true_error_lower, self.error_scale)


def records_of(rows: Iterable[Row], problem: ContactProblem) -> list[dict[str, Any]]:
    """Return rows as plain data; ``contact_upper`` is among them if the problem has an upper bound."""
    left_out = {"contact_upper"} if problem.one_sided else set()
    return [{name: value for name, value in asdict(row).items() if name not in left_out} for row in rows]


def row_of(outcome: Outcome, answers: Answers) -> Row:
    """Return what is to be said of one outcome, by itself and beside all answers."""
    answer = outcome.answer
    if isinstance(answer, Refusal):
        return Row(outcome.backend, answer.status, answer.message)
    return Row(
        backend=outcome.backend,
        status=answer.status.value,
        message=answer.termination,
        iterations=answer.iterations,
        setup_seconds=answer.setup_seconds,
        solve_seconds=answer.solve_seconds,
        cold_seconds=answer.seconds,
        loading_seconds=answer.loading_seconds,
        warm_seconds=outcome.warm_seconds,
        claimed=answer.claimed_solved,
        findings=answer.findings,
        **_optimality(answer),
        **_certified(answer),
        **_beside_others(outcome.backend, answers),
    )


def _optimality(solution: Solution) -> dict[str, Any]:
    """Return how far a finite answer is from the optimality conditions, and the bound of its error."""
    residuals = solution.residuals
    if residuals is None:
        return {}
    return asdict(residuals) | {
        "primal_residual": max(0.0, -residuals.min_gap),
        "dual_residual": max(0.0, -residuals.min_reaction),
        "relative_bound": solution.relative_bound,
        "relative_residual": solution.relative_residual,
        "error_scale": solution.verdict.scale,
        "contact": int(np.count_nonzero(solution.contact)),
        "max_slope": None if solution.model is None else solution.max_slope,
        "contact_upper": None if solution.problem.one_sided else int(np.count_nonzero(solution.contact_upper)),
    }


def _certified(solution: Solution) -> dict[str, Any]:
    """Return what the answer's own certificate says."""
    certificate = solution.certificate
    if certificate is None:
        return {}
    return {
        "gap_bound": certificate.gap_bound,
        "certain_contact": int(np.count_nonzero(certificate.contact)),
        "certain_clear": int(np.count_nonzero(certificate.clear)),
        "undecided": int(np.count_nonzero(certificate.undecided)),
    }


def _beside_others(backend: str, answers: Answers) -> dict[str, Any]:
    """Return a finite answer's distances from the truth and from the best answer."""
    if backend not in answers.finite:
        return {}
    solution, best = answers.finite[backend], answers.best_backend
    assert best is not None
    low, high = (None, None) if answers.truth is None else answers.truth.error(solution.gap)
    if high is not None and solution.certificate is not None:
        high = min(high, solution.certificate.gap_bound)
    return {
        "contact_jaccard": answers.contact_jaccard(backend, best),
        "boundary_distance": answers.boundary_distance(backend, best),
        "true_error_lower": low,
        "true_error_upper": high,
        "relative_true_error": None if high is None else quotient_above(high, solution.verdict.scale),
    }
