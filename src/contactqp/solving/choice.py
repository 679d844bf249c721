"""The choice of a backend: by name, by ``"auto"`` or as it is, checked against the problem before long work."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..backends import check_suitable, choose_backend, get_backend
from ..backends.base import Backend
from ..problem.contact_problem import ContactProblem


def chosen_backend(backend: str | Backend, problem: ContactProblem, options: Mapping[str, Any]) -> tuple[Backend, str]:
    """Return the backend to call, and why ``"auto"`` chose it (empty where it was named).

    Raises
    ------
    TypeError
        If an option is not the backend's.
    UnknownBackendError, MissingBackendError
        If there is no such backend, or its library is not installed.
    UnsuitableProblemError
        If its method needs a property that the problem does not have.
    """
    name, note = choose_backend(problem) if backend == "auto" else (backend, "")
    method = get_backend(name)
    try:
        method.check_options(options)
    except TypeError as error:
        if backend != "auto":
            raise
        why = note.removeprefix("auto: ")
        raise TypeError(f"{error} (backend='auto' chose it, {why}; name the one you mean)") from None
    method.require()
    check_suitable(method, problem)
    return method, note
