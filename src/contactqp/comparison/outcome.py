"""Outcome: what came of asking one backend."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import MissingBackendError, UnsuitableProblemError
from ..solving.solution import Solution


@dataclass(frozen=True)
class Refusal:
    """Why a backend returned nothing.

    Attributes
    ----------
    status : str
        ``"missing"`` (not installed, or it cannot be loaded), ``"unsuitable"`` (the method does not apply) or
        ``"error"``.
    message : str
        The reason in words.
    """

    status: str
    message: str

    @classmethod
    def by(cls, error: BaseException) -> Refusal:
        """Return the refusal that an error stands for.

        Examples
        --------
        >>> Refusal.by(ZeroDivisionError("deep inside"))
        Refusal(status='error', message='ZeroDivisionError: deep inside')
        """
        if isinstance(error, MissingBackendError):
            return cls("missing", str(error))
        if isinstance(error, UnsuitableProblemError):
            return cls("unsuitable", str(error))
        return cls("error", f"{type(error).__name__}: {error}")


@dataclass(frozen=True)
class Outcome:
    """What came of asking one backend: a solution, or the reason why there is none.

    Attributes
    ----------
    backend : str
        The name that it was asked by.
    answer : Solution or Refusal
    warm_seconds : float or None
        The fastest of the runs after the first, for which the backend kept its set-up; None if there were none.
    """

    backend: str
    answer: Solution | Refusal
    warm_seconds: float | None = None
