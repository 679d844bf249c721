"""Many loads of one matrix, answered and judged together."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..backends.base import Answer, Backend, CaseAnswers
from ..foundation.checks import Vector
from ..foundation.loading import working_seconds
from ..models.base import ContactModel, split
from ..problem.contact_problem import ContactProblem
from ..problem.load_cases import LoadCases
from ..proof.judge import judge
from ..proof.measure import measures_of_cases
from ..proof.measures import Measures
from .prediction import same_bounds
from .request import Request
from .solution import Solution, shut_answer

_NUMBERS_AT_ONCE = 40_000
"""Entries of arrays that are measured in one pass: a processor's cache holds some of them."""


def solved_together(
    backend: Backend,
    subjects: Sequence[ContactModel | ContactProblem],
    request: Request,
    answers: Callable[[ContactProblem, LoadCases], CaseAnswers | None],
    note: str,
) -> list[Solution | None]:
    """Return the certified solutions of problems with one matrix; None for each that is to be solved by itself.

    Those are the ones with other bounds than the first, and those whose answer the judge does not certify: what there
    is to say of them the usual way says. The judge is the same, and so are the passes by which it measures; they are
    made over all answers at once.

    Parameters
    ----------
    backend : Backend
    subjects : sequence of Membrane, Cable, CableNet, ContactQP or ContactLCP
        Their problems share their facts.
    request : Request
        Without limits and options.
    answers : callable
        Returns what the backend answers to load cases (see `State.answers`), given one of the problems, too.
    note : str
        Why the backend was chosen.
    """
    solutions: list[Solution | None] = [None] * len(subjects)
    started = working_seconds()
    problems = [split(subject)[1] for subject in subjects]
    first = problems[0]
    if first.barrier is None:
        return solutions
    places = [k for k, problem in enumerate(problems) if same_bounds(problem.bounds, first.bounds)]
    answered = _answered([problems[k] for k in places], answers)
    places = [k for k, found in zip(places, answered, strict=True) if found is not None]
    if not places:
        return solutions
    chosen = [problems[k] for k in places]
    given = [found for found in answered if found is not None]
    at_once = max(1, _NUMBERS_AT_ONCE // first.size)
    measured = [
        measures
        for k in range(0, len(chosen), at_once)
        for measures in _measured(chosen[k : k + at_once], [gap for _, gap in given[k : k + at_once]])
    ]
    together, now = (working_seconds() - started) / len(subjects), working_seconds()
    for k, problem, (answer, gap), measures in zip(places, chosen, given, measured, strict=True):
        model, _ = split(subjects[k])
        verdict = judge(problem, gap, request.tolerance.tol, model=model, measures=measures)
        if verdict.status.ok:
            before, now = now, working_seconds()
            solutions[k] = Solution.of(
                backend, subjects[k], request, answer, gap, verdict, note=note, seconds=together + now - before
            )
    return solutions


def _measured(problems: list[ContactProblem], gaps: list[Vector]) -> list[Measures]:
    """Return the measures of answers to problems that differ in their forces alone, after the passes for them."""
    found = measures_of_cases(LoadCases.of(problems), problems, np.array(gaps))
    _ = found[0].certificate()
    return found


def _answered(
    problems: list[ContactProblem], answers: Callable[[ContactProblem, LoadCases], CaseAnswers | None]
) -> list[tuple[Answer, Vector] | None]:
    """Return answers and their gaps (length) to problems that differ in their forces alone; None where there is none.

    The vectors hold no memory of others.
    """
    found: list[tuple[Answer, Vector] | None] = [None] * len(problems)
    LoadCases.of(problems).tell(problems)
    opened = list[int]()
    for k, problem in enumerate(problems):
        if problem.shut:
            shut = shut_answer(problem)
            found[k] = None if shut.gap is None else (shut, shut.gap)
        else:
            opened.append(k)
    if not opened:
        return found
    cases = LoadCases.of([problems[k] for k in opened])
    try:
        scaled, units = cases.scaled(max(problems[k].gap_scale for k in opened))
    except ValueError:  # the numbers of one of them overflow, which says so when it is solved by itself
        return found
    given = answers(problems[opened[0]], scaled)
    if given is None:
        return found
    with np.errstate(over="ignore", invalid="ignore"):
        gaps = units.gap(given.gaps)
    solved = (given.iterations > 0) & np.isfinite(gaps).all(axis=1)
    for case, k in enumerate(opened):
        if solved[case]:
            found[k] = given.answer(case), gaps[case].copy()
    return found
