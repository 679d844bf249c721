"""Status: what the judge found, and what to do about it."""

from __future__ import annotations

from enum import StrEnum

DISCRETE = "the exact solution of the discrete problem"
"""What every error, and every bound of one, is measured against: that of the discretisation is no part of it."""


class Status(StrEnum):
    """What the judge found; `advice` says what to do about it."""

    CERTIFIED = "certified"
    UNPROVEN = "unproven"
    SOLVED = "unproven"  # the earlier name of UNPROVEN
    INACCURATE = "inaccurate"
    ITERATION_LIMIT = "iteration_limit"
    TIME_LIMIT = "time_limit"
    FAILED = "failed"

    @property
    def ok(self) -> bool:
        """Whether the answer is proven to be as good as was asked for."""
        return self is Status.CERTIFIED

    @property
    def advice(self) -> str:
        """One sentence for the person who reads the status."""
        return _ADVICE[self]


_ADVICE = {
    Status.CERTIFIED: f"{DISCRETE.capitalize()} is proven to lie within tol of the answer.",
    Status.UNPROVEN: "Its residual is small, but nothing is proven of its error: polish() it, or take active-set.",
    Status.INACCURATE: "Use it with the bound that it achieved, loosen tol, or take another backend.",
    Status.ITERATION_LIMIT: "Raise max_iter, pass this answer as warm_start, or take another backend.",
    Status.TIME_LIMIT: "Raise time_limit, pass this answer as warm_start, or take another backend.",
    Status.FAILED: "Take another backend; the solution's termination says what this one reported.",
}
