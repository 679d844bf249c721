"""solve(): scale the problem, call a backend by name, judge its answer."""

from __future__ import annotations

import time
import warnings
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from ..backends import choose_backend, get_backend
from ..backends.base import Answer, Stop, Task
from ..errors import ContactWarning, NotCertifiedError
from ..foundation.checks import Vector, integer_at_least, one_of, positive_number, vector
from ..foundation.progress import Progress
from ..models.base import ContactModel, split
from ..problem.contact_qp import ContactQP
from ..proof.judge import judge, relative_bound
from ..proof.status import Status
from .solution import Solution
from .tolerances import tolerance_of

_LIMITS = {
    Stop.DONE: None,
    Stop.ITERATION_LIMIT: Status.ITERATION_LIMIT,
    Stop.TIME_LIMIT: Status.TIME_LIMIT,
    Stop.FAILED: Status.FAILED,
}


_OUTCOMES = {
    Status.INACCURATE: "returned an inaccurate answer",
    Status.ITERATION_LIMIT: "stopped at its iteration limit",
    Status.TIME_LIMIT: "stopped at its time limit",
    Status.FAILED: "failed",
}


def solve(
    problem: ContactQP | ContactModel,
    backend: str = "auto",
    *,
    tol: float | str = 1e-6,
    max_iter: int | None = None,
    time_limit: float | None = None,
    warm_start: ArrayLike | Solution | None = None,
    on_failure: Literal["warn", "raise", "ignore"] = "warn",
    **options: Any,
) -> Solution:
    """Solve a contact problem with the backend of the given name, and judge the answer.

    Parameters
    ----------
    problem : Membrane, Cable, CableNet or ContactQP
        What to solve; it is never modified.
    backend : str
        ``"auto"`` or a name in `backend_names`: ``"osqp"``, ``"clarabel"``, ``"mangasarian"``, ``"psor"``,
        ``"multigrid"``, ``"active-set"``. ``"auto"`` takes active sets for few unknowns, multigrid on a lattice, and
        otherwise active sets, or Clarabel if G is no M-matrix; the solution's ``note`` says why.
    tol : float or str
        Wanted bound of max|ω_i - ω*_i| relative to ``problem.gap_scale``, or to the answer's largest deflection (for a
        matrix, gap) where that is smaller; in (0, 1). It means the same for every backend, because the package
        certifies it itself. Or a level: ``"low"`` (1e-3), ``"mid"`` (1e-6), ``"high"`` (1e-9), or ``"default"``: one
        run of the library as its authors ship it, on the dimensionless problem, judged by 1e-6.
    max_iter : int, optional
        Limit of the backend's iterations, >= 1.
    time_limit : float, optional
        Limit in seconds, > 0.
    warm_start : array or Solution, optional
        A gap to start from, shape (n,), length. Clarabel and Mangasarian's linear program cannot use one; multigrid and
        active sets drop one whose energy is above that of ω = 0.
    on_failure : {"warn", "raise", "ignore"}
        What to do when the answer is not certified: issue a `ContactWarning`, raise a `NotCertifiedError` or
        leave it to the reader of ``solution.status``.
    **options
        The backend's own options; an unknown one is a TypeError that lists them.

    Returns
    -------
    Solution

    Raises
    ------
    UnknownBackendError, MissingBackendError
        If there is no such backend, or its library is not installed.
    UnsuitableProblemError
        If the backend's method needs a property that G does not have.
    NotCertifiedError
        If the answer is not certified and ``on_failure="raise"``.
    TypeError, ValueError
        If an argument has the wrong kind, shape or range.

    Examples
    --------
    >>> import contactqp as cq
    >>> lattice = cq.Frame.disk(1.0).lattice(spacing=0.25)
    >>> membrane = cq.Membrane(lattice, tension=1.0, load=4.0, support=0.5)
    >>> solution = cq.solve(membrane, backend="clarabel", tol=1e-8)
    >>> solution.status.value, int(solution.certificate.undecided.sum())
    ('certified', 0)
    """
    model, algebra = split(problem)
    wanted = tolerance_of(tol)
    if max_iter is not None:
        max_iter = integer_at_least(max_iter, 1, "max_iter")
    if time_limit is not None:
        time_limit = positive_number(time_limit, "time_limit")
    one_of(on_failure, ("warn", "raise", "ignore"), "on_failure")
    note = ""
    if backend == "auto":
        backend, note = choose_backend(algebra)
    method = get_backend(backend)
    method.check_options(options)
    method.require()
    method.check_problem(algebra)
    start_gap = _start(warm_start, algebra)

    started = time.perf_counter()
    scaled, units = algebra.scaled()

    def bound(gap: Vector) -> float:
        candidate = gap * units.length
        return relative_bound(algebra, candidate) if np.isfinite(candidate).all() else np.inf

    with Progress(f"{backend} · {algebra.size} unknowns") as progress:
        task = Task(
            tol=wanted.tol,
            max_iter=max_iter,
            time_limit=time_limit,
            warm_start=None if start_gap is None else start_gap / units.length,
            bound=bound,
            length_unit=units.length,
            gap_scale=algebra.gap_scale,
            progress=progress,
            own_defaults=wanted.own_defaults,
            given=frozenset(options),
        )
        answer: Answer = method().solve(scaled, task, **options)
    gap = None if answer.gap is None else np.asarray(answer.gap, dtype=np.float64) * units.length
    verdict = judge(algebra, gap, wanted.tol, _LIMITS[answer.stop])
    solution = Solution(
        problem=algebra,
        model=model,
        backend=backend,
        note="; ".join(part for part in (note, answer.note) if part),
        gap=gap if verdict.residuals is not None and gap is not None else np.full(algebra.size, np.nan),
        tol=wanted.tol,
        status=verdict.status,
        residuals=verdict.residuals,
        first_certificate=verdict.certificate,
        first_relative_bound=verdict.relative_bound,
        termination=answer.termination,
        iterations=answer.iterations,
        iteration_unit=method.iteration_unit,
        setup_seconds=answer.setup_seconds,
        solve_seconds=answer.solve_seconds,
        seconds=time.perf_counter() - started,
        history=answer.history,
        setting=wanted.setting,
        claimed_solved=answer.claimed,
        findings=answer.findings,
    )
    _report(solution, on_failure)
    return solution


def _start(value: ArrayLike | Solution | None, problem: ContactQP) -> Vector | None:
    if value is None:
        return None
    if isinstance(value, Solution):
        value = value.gap
    return vector(value, problem.size, "warm_start")


def _report(solution: Solution, on_failure: str) -> None:
    if solution.status.ok or on_failure == "ignore":
        return
    message = (
        f"{solution.backend} {_OUTCOMES[solution.status]}: "
        f"bound {solution.relative_bound:.2g} of the gap scale, wanted {solution.tol:g} "
        f"({solution.termination}). {solution.status.advice}"
    )
    if on_failure == "raise":
        raise NotCertifiedError(message, solution)
    warnings.warn(message, ContactWarning, stacklevel=3)
