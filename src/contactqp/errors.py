"""Errors and warnings that callers may want to catch by name."""

from __future__ import annotations

from typing import Any


class ContactWarning(UserWarning):
    """An answer was not certified to the requested tolerance, or the data of a model may not be what was meant."""


class NotCertifiedError(RuntimeError):
    """Raised instead of a `ContactWarning` when ``on_failure="raise"``.

    Attributes
    ----------
    solution : Solution
        The uncertified answer, with its residuals and its enclosure.
    """

    def __init__(self, message: str, solution: Any) -> None:
        super().__init__(message)
        self.solution = solution


class UnknownBackendError(ValueError):
    """No backend has the given name."""


class MissingBackendError(ImportError):
    """The backend is known, but the library it calls is not installed."""


class UnsuitableProblemError(ValueError):
    """The backend's method needs a property that this problem's matrix does not have."""


class CaseFileError(ValueError):
    """A case file is unreadable or holds a bad value; the message names file, key and value."""
