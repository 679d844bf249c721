"""Status: what the judge found, and what to do about it."""

from __future__ import annotations

from enum import StrEnum


class Status(StrEnum):
    """What the judge found; `advice` says what to do about it."""

    CERTIFIED = "certified"
    SOLVED = "solved"
    INACCURATE = "inaccurate"
    ITERATION_LIMIT = "iteration_limit"
    TIME_LIMIT = "time_limit"
    FAILED = "failed"

    @property
    def ok(self) -> bool:
        """Whether the answer is as good as was asked for."""
        return self in (Status.CERTIFIED, Status.SOLVED)

    @property
    def advice(self) -> str:
        """One sentence for the person who reads the status."""
        return _ADVICE[self]


_ADVICE = {
    Status.CERTIFIED: "The exact solution of the discrete problem is proven to lie within tol of the answer.",
    Status.SOLVED: "The residuals are within tol; what is known of such a matrix does not prove the error to be.",
    Status.INACCURATE: "Use it with the bound that it achieved, loosen tol, or take another backend.",
    Status.ITERATION_LIMIT: "Raise max_iter, pass this answer as warm_start, or take another backend.",
    Status.TIME_LIMIT: "Raise time_limit, pass this answer as warm_start, or take another backend.",
    Status.FAILED: "Take another backend; the solution's termination says what this one reported.",
}
