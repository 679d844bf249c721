"""One backend's line in a comparison, one pair of backends, and their numbers as text."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..solving.solution import Solution


@dataclass(frozen=True)
class Row:
    """What one backend achieved; a backend that could not run has ``message`` and no solution.

    Attributes
    ----------
    backend : str
    status : str
        A `Status`, ``"missing"`` (library not installed), ``"unsuitable"`` (the method does not apply) or ``"error"``.
    message : str
        The backend's own words, or the error's.
    iterations : int or None
    setup_seconds, solve_seconds : float or None
    min_gap, min_reaction, complementarity, natural_residual, objective : float or None
        See `Residuals`; complementarity ωᵀR is the duality gap.
    relative_bound : float or None
        Certified bound over the gap scale.
    contact : int or None
        Nodes in contact in the backend's own view.
    certain_contact, certain_clear, undecided : int or None
        Nodes that the certificate decides, and those that it does not.
    primal_residual, dual_residual : float or None
        max(0, -min ω_i) over supported nodes (length) and max(0, -min R_i) (force).
    gap_bound : float or None
        Certified bound of max|ω_i - ω*_i| (length).
    true_error_lower, true_error_upper : float or None
        Two lengths between which max|ω_i - ω*_i| lies, by the certificates of all backends; None without a truth.
    relative_true_error : float or None
        The upper one over the scale that ``relative_bound`` is measured by.
    contact_jaccard : float or None
        1 - |intersection| / |union| of the contact set and the best answer's.
    boundary_distance : float or None
        Hausdorff distance of the free boundary from the best answer's (length): 0 if neither has one, infinite if only
        one has; None without a lattice.
    cold_seconds : float or None
        The first run, with scaling and judging.
    warm_seconds : float or None
        The fastest of the runs after it; None if there were none.
    claimed : bool or None
        Whether the backend itself said that it had solved the problem.
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
    contact: int | None = None
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
    warm_seconds: float | None = None
    claimed: bool | None = None
    findings: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether the answer is as good as was asked for."""
        return self.status in ("certified", "solved")


@dataclass(frozen=True)
class Pair:
    """How two backends' answers differ.

    Attributes
    ----------
    first, second : str
        The backends.
    gap_difference : float
        max |Δω| (length).
    contact_jaccard : float
        1 - |intersection| / |union| of the two contact sets: 0 if they are equal.
    differing_nodes : array of int
        Nodes that one has in contact and the other does not.
    consistent : bool
        Whether one solution can satisfy both enclosures (without enclosures: whether the gaps differ by at most
        100 tol times the gap scale).
    boundary_distance : float or None
        Hausdorff distance of the two free boundaries (length); None without a lattice.
    """

    first: str
    second: str
    gap_difference: float
    contact_jaccard: float
    differing_nodes: np.ndarray[Any, np.dtype[np.int64]]
    consistent: bool
    boundary_distance: float | None = None


def row_of(solution: Solution, name: str, warm_seconds: float | None = None) -> Row:
    """Return what one solution says by itself; the distances from others are left None."""
    facts: dict[str, Any] = {}
    if solution.residuals is not None:
        facts |= asdict(solution.residuals)
        facts |= {
            "primal_residual": max(0.0, -solution.residuals.min_gap),
            "dual_residual": max(0.0, -solution.residuals.min_reaction),
            "relative_bound": solution.relative_bound,
            "contact": int(np.count_nonzero(solution.contact)),
        }
    if solution.certificate is not None:
        facts |= {
            "gap_bound": solution.certificate.gap_bound,
            "certain_contact": int(np.count_nonzero(solution.certificate.contact)),
            "certain_clear": int(np.count_nonzero(solution.certificate.clear)),
            "undecided": int(np.count_nonzero(solution.certificate.undecided)),
        }
    return Row(
        backend=name,
        status=solution.status.value,
        message=solution.termination,
        iterations=solution.iterations,
        setup_seconds=solution.setup_seconds,
        solve_seconds=solution.solve_seconds,
        cold_seconds=solution.seconds,
        warm_seconds=warm_seconds,
        claimed=solution.claimed_solved,
        findings=solution.findings,
        **facts,
    )
