"""solve_many(): many problems, those with one matrix in one session, and small ones among them together."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sized
from typing import Any

from ..backends.base import Backend
from ..foundation.checks import one_of
from ..models.base import ContactModel, split
from ..problem.contact_problem import ContactProblem
from .solution import OnFailure, Solution
from .solver import Solver


def solve_many(
    problems: Iterable[ContactProblem | ContactModel],
    backend: str | Backend = "auto",
    *,
    tol: float | str = 1e-6,
    max_iter: int | None = None,
    time_limit: float | None = None,
    on_failure: OnFailure = "warn",
    **options: Any,
) -> list[Solution]:
    """Solve many problems, and judge each answer as `contactqp.solve` does.

    Problems whose matrices are equal are solved in one session: what is proven of the matrix, what the backend has set
    up, and the last answer to start from serve for all of them. They need not stand together.

    Where there are thousands of problems with a narrow band, up to 1000 unknowns, one matrix and the same bounds, as
    loads of one model are, ``"active-set"`` (which ``"auto"`` takes) answers some hundreds of them at once, by compiled
    kernels, and the judge measures their answers in common passes. It takes a tenth of a millisecond a problem, or
    three for 400 unknowns on a lattice. ``seconds`` is a problem's share of the time then. A limit, or an option, is
    one of each problem, and has them solved one by one.

    Parameters
    ----------
    problems : iterable of Membrane, Cable, CableNet, ContactQP or ContactLCP
        What to solve. Of an iterator some hundred small problems are taken before they are solved, and large ones one
        by one.
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
    if isinstance(problems, (ContactProblem, ContactModel)):
        raise TypeError(f"problems must be an iterable of problems, got one: {problems!r}; solve() takes that")
    sessions: list[tuple[ContactProblem, Solver]] = []
    solutions: list[Solution] = []
    expected = len(problems) if isinstance(problems, Sized) else 0
    for some in _portions(problems):
        answered: dict[int, Solution] = {}
        asked: dict[Solver, list[int]] = {}
        for place, subject in enumerate(some):
            _, problem = split(subject)
            solver = next((solver for first, solver in reversed(sessions) if problem.share_facts(first)), None)
            if solver is None:
                solver = Solver(subject, backend, tol=tol, max_iter=max_iter, time_limit=time_limit, **options)
                sessions = [*sessions[1 - _SESSIONS :], (problem, solver)]
            asked.setdefault(solver, []).append(place)
        for solver, places in asked.items():
            found = solver.solve_together([some[place] for place in places], expected)
            answered.update(zip(places, found, strict=True))
        for place in range(len(some)):
            answered[place].report(on_failure)
            solutions.append(answered[place])
    return solutions


def _portions(
    problems: Iterable[ContactProblem | ContactModel],
) -> Iterator[list[ContactProblem | ContactModel]]:
    """Yield problems that are answered together: few where they are large.

    A failure that is to be raised does not wait for many others.
    """
    portion: list[ContactProblem | ContactModel] = []
    unknowns = 0
    for subject in problems:
        portion.append(subject)
        unknowns += split(subject)[1].size
        if unknowns >= _UNKNOWNS_AT_ONCE or len(portion) == _PROBLEMS_AT_ONCE:
            yield portion
            portion, unknowns = [], 0
    if portion:
        yield portion


_UNKNOWNS_AT_ONCE = 250_000
"""Unknowns of problems that are answered together, whose vectors take two megabytes each."""

_PROBLEMS_AT_ONCE = 500

_SESSIONS = 16
"""Sessions that are kept open: each holds factors, and each matrix is compared with all of theirs."""
