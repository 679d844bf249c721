"""solve_many(): many problems, those with one matrix in one session."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ..backends.base import Backend
from ..foundation.checks import one_of
from ..models.base import ContactModel, split
from ..problem.contact_qp import ContactQP
from .solution import OnFailure, Solution
from .solver import Solver


def solve_many(
    problems: Iterable[ContactQP | ContactModel],
    backend: str | Backend = "auto",
    *,
    tol: float | str = 1e-6,
    max_iter: int | None = None,
    time_limit: float | None = None,
    on_failure: OnFailure = "warn",
    **options: Any,
) -> list[Solution]:
    """Solve many problems, one after the other, and judge each answer as `contactqp.solve` does.

    Problems whose matrices are equal are solved in one session: what is proven of the matrix, what the backend has set
    up, and the last answer to start from serve for all of them. They need not stand together.

    Parameters
    ----------
    problems : iterable of Membrane, Cable, CableNet or ContactQP
        What to solve; an iterator is taken one by one.
    backend : str or Backend
        As for `contactqp.solve`; ``"auto"`` chooses once for each matrix.
    tol, max_iter, time_limit, on_failure, **options
        As for `contactqp.solve`, for each problem.

    Returns
    -------
    list of Solution
        In the order of the problems.

    Raises
    ------
    UnknownBackendError, MissingBackendError, UnsuitableProblemError, NotCertifiedError
        See `contactqp.solve`.
    TypeError, ValueError
        If an argument has the wrong kind or range, or an item is no problem.

    Examples
    --------
    >>> import contactqp as cq
    >>> first = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
    >>> solutions = cq.solve_many(first.with_forces([force, 3.0]) for force in (-1.0, 0.0, -2.0))
    >>> [solution.gap.round(9).tolist() for solution in solutions]
    [[0.5, 0.0], [0.0, 0.0], [1.0, 0.0]]
    """
    one_of(on_failure, ("warn", "raise", "ignore"), "on_failure")
    if isinstance(problems, (ContactQP, ContactModel)):
        raise TypeError(f"problems must be an iterable of problems, got one: {problems!r}; solve() takes that")
    sessions: list[tuple[ContactQP, Solver]] = []
    solutions = []
    for subject in problems:
        _, problem = split(subject)
        solver = next((solver for first, solver in reversed(sessions) if problem.share_facts(first)), None)
        if solver is None:
            solver = Solver(subject, backend, tol=tol, max_iter=max_iter, time_limit=time_limit, **options)
            sessions = [*sessions[1 - _SESSIONS :], (problem, solver)]
        solution = solver.solve_varied(subject)
        solution.report(on_failure)
        solutions.append(solution)
    return solutions


_SESSIONS = 16
"""Sessions that are kept open: each holds factors, and each matrix is compared with all of theirs."""
