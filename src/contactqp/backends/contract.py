"""What a backend declares and returns, checked where it comes in: other distributions bring theirs."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..foundation.checks import finite_number, integer_at_least, real_array
from .base import Answer, Backend, CaseAnswers, Stop

_DECLARED = "name", "summary", "package", "iteration_unit"


def check_declared(backend: Backend) -> None:
    """Raise a TypeError unless a backend declares what tables and messages call it by, and names its options.

    Examples
    --------
    >>> class Nameless(Backend):
    ...     summary, package = "a method", "numpy"
    >>> check_declared(Nameless())
    Traceback (most recent call last):
    TypeError: backend Nameless must have a class attribute 'name', a text that is not empty, but has none
    """
    for attribute in _DECLARED:
        value = getattr(backend, attribute, None)
        if not isinstance(value, str) or not value.strip():
            found = f"it is {value!r}" if hasattr(backend, attribute) else "has none"
            raise TypeError(
                f"backend {_called(backend)} must have a class attribute {attribute!r}, a text that is not empty, "
                f"but {found}"
            )
    for need in backend.needs:
        if not callable(getattr(need, "holds", None)):
            raise TypeError(f"backend {backend.name!r} needs {need!r}, which has no method holds(problem)")
    backend.options()


def checked_answer(backend: Backend, answer: Any, size: int) -> Answer:
    """Return a backend's answer; one that holds nan or infinite gaps counts as failed, and its words say so.

    Parameters
    ----------
    backend : Backend
    answer : Answer
        Anything else is refused.
    size : int
        Number of unknowns.

    Raises
    ------
    TypeError, ValueError
        If it is no `Answer`, or a part of it has the wrong kind or shape; the message names backend and part.
    """
    said = f"backend {backend.name!r} returned"
    if not isinstance(answer, Answer):
        raise TypeError(f"{said} {_described(answer)} where an Answer is needed (contactqp.backends.base.Answer)")
    stops = [stop.value for stop in Stop]
    if answer.stop not in stops:
        raise ValueError(f"{said} an Answer whose stop is {answer.stop!r}; take one of {', '.join(stops)}")
    if not isinstance(answer.termination, str):
        raise TypeError(f"{said} an Answer whose termination must be a text, got {answer.termination!r}")
    integer_at_least(answer.iterations, 0, f"iterations, which {said},")
    finite_number(answer.setup_seconds, f"setup_seconds, which {said},")
    finite_number(answer.solve_seconds, f"solve_seconds, which {said},")
    if answer.gap is None:
        return answer
    gap = real_array(answer.gap, f"the gap that {said}", copied=False)
    if gap.shape != (size,):
        raise ValueError(f"the gap that {said} must have shape ({size},), one number for each unknown, got {gap.shape}")
    finite = np.isfinite(gap)
    if finite.all():
        return answer
    bad = np.flatnonzero(~finite)
    words = f"{answer.termination}; but the gap is {gap[bad[0]]} at unknown {bad[0]} ({bad.size} of {size} not finite)"
    return replace(answer, stop=Stop.FAILED, termination=words, claimed_solved=answer.claimed)


def checked_cases(backend: Backend, found: Any, shape: tuple[int, ...]) -> CaseAnswers | None:
    """Return a backend's answers to load cases, or None if it has none.

    Parameters
    ----------
    backend : Backend
    found : CaseAnswers or None
        Anything else is refused.
    shape : tuple of int
        Of the cases' forces: (cases, n).

    Raises
    ------
    TypeError, ValueError
        If it is neither, or an array has the wrong kind or shape; the message names backend and part.
    """
    said = f"backend {backend.name!r} returned"
    if found is None:
        return None
    if not isinstance(found, CaseAnswers):
        raise TypeError(
            f"{said} {_described(found)} where CaseAnswers are needed (contactqp.backends.base.CaseAnswers)"
        )
    gaps = real_array(found.gaps, f"the gaps that {said}", copied=False)
    steps = np.asarray(found.iterations)
    if gaps.shape != shape or steps.shape != shape[:1]:
        raise ValueError(
            f"gaps and iterations that {said} must have shapes {shape} and {shape[:1]}, got {gaps.shape}, {steps.shape}"
        )
    return replace(found, gaps=gaps, iterations=steps)


def _called(backend: Backend) -> str:
    name = getattr(backend, "name", None)
    return repr(name) if isinstance(name, str) and name.strip() else type(backend).__name__


def _described(value: Any) -> str:
    return "None" if value is None else f"an object of type {type(value).__name__}"
