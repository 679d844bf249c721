"""Deadline: a limit in seconds that holds even for calls that cannot be stopped."""

from __future__ import annotations

import time
from collections.abc import Callable
from threading import Event
from typing import TypeVar

from .interrupts import OutOfTime, run_interruptibly
from .progress import Progress

T = TypeVar("T")

LEAST_SLACK, SLACK = 1.0, 0.05
"""A time limit is kept to within this many seconds, or this part of it, whichever is more."""

_WORK, _CHECKS = 0.4, 0.7
"""Parts of the slack after which work, and the checks that follow it, are given up."""


class Deadline:
    """A limit in seconds from when it is made; without one, all work is done where it is asked for.

    With a limit, work is done in a thread of its own, and left behind if it is not over in time: a call into a compiled
    library cannot be stopped. What is left behind must not be used again.

    Parameters
    ----------
    seconds : float or None

    Attributes
    ----------
    seconds : float or None
    started : float
        When it was made, by ``time.perf_counter()``.
    abandoned : Event
        It is set once work has been left behind, by Ctrl-C or at the limit: nobody waits for it any more.

    Examples
    --------
    >>> Deadline(None).checked(lambda: "done")
    'done'
    >>> Deadline(1e-9).checked(lambda: time.sleep(2.0)) is None
    True
    """

    def __init__(self, seconds: float | None) -> None:
        self.seconds, self.started, self.abandoned = seconds, time.perf_counter(), Event()

    def work(self, call: Callable[[], T], progress: Progress | None = None) -> T:
        """Return what a call returns.

        Raises
        ------
        OutOfTime
            If it takes longer than the limit and some of the slack.
        """
        return self._within(_WORK, call, progress, self.abandoned.set)

    def checked(self, call: Callable[[], T]) -> T | None:
        """Return what a call returns; None if it takes longer than the limit and most of the slack."""
        try:
            return self._within(_CHECKS, call)
        except OutOfTime:
            return None

    def _within(
        self,
        part: float,
        call: Callable[[], T],
        progress: Progress | None = None,
        abandon: Callable[[], None] | None = None,
    ) -> T:
        if self.seconds is None:
            return call()
        slack = max(LEAST_SLACK, SLACK * self.seconds)
        left = self.started + self.seconds + part * slack - time.perf_counter()
        return run_interruptibly(call, progress, abandon, max(left, 0.0))
