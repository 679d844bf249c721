"""The loop of every backend that calls a library: call, ask the judge, tighten, keep the best, count, watch the clock.

The judge decides when the answer is good enough: a library's own residuals say little about the gap's error.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import TypeVar

import numpy as np

from ..foundation.checks import Vector
from ..foundation.interrupts import run_interruptibly
from ..foundation.loading import working_seconds
from .base import Answer, Stop, Task

Setting = TypeVar("Setting")


@dataclass(frozen=True)
class Round:
    """What one call of a library returned.

    Attributes
    ----------
    gap : array, shape (n,), or None
        The dimensionless gap; None if there is nothing to judge.
    stop : Stop
        Why the library stopped. Only after `Stop.DONE` is a tighter setting of any use.
    termination : str
        The library's own words for it.
    iterations : int
        Iterations of this call.
    setup_seconds : float
        Time of this call that went into set-up.
    claims : bool
        Whether the library said that it had solved the problem.
    finish : str
        Name of a last step that was taken once the library had converged, say ``"polish"``. Where it made the answer
        worse than the one of the round before, that is a finding.
    history : mapping of str to vector
        What was recorded in this call, on request.
    """

    gap: Vector | None
    stop: Stop
    termination: str
    iterations: int
    setup_seconds: float = 0.0
    claims: bool = False
    finish: str = ""
    history: Mapping[str, Vector] = field(default_factory=dict)


def tightened(
    task: Task,
    call: Callable[[Setting, int], Round],
    schedule: Iterable[Setting],
    budget: int,
    *,
    setup_seconds: float = 0.0,
    note: str = "",
) -> Answer:
    """Call a library with one setting after the other until the judge is satisfied, and return the best answer.

    Parameters
    ----------
    task : Task
    call : callable
        ``call(setting, iterations_left)`` calls the library once. It runs in a thread of its own, so that Ctrl-C is
        answered at once.
    schedule : iterable
        The settings, the loosest first. A setting is asked for only once the round before is over, so that a generator
        can decide by its outcome.
    budget : int
        Limit of the iterations over all rounds.
    setup_seconds : float
        Time that went into set-up before, to be counted with that of the rounds.
    note : str
        See `Answer`.

    Returns
    -------
    Answer
        Its gap is the very array that the judge was asked about.

    Raises
    ------
    KeyboardInterrupt
        After Ctrl-C, with ``task.abandoned`` set; the library may still be at work then.
    """
    started, setup_before = working_seconds(), setup_seconds
    gap: Vector | None = None
    least, done, stop, findings, histories = np.inf, 0, Stop.DONE, list[str](), list[Mapping[str, Vector]]()
    latest = Round(None, Stop.TIME_LIMIT, "time limit during set-up", 0)

    def begin(setting: Setting, iterations: int) -> Round:
        # Ctrl-C may come before the thread gets to work.
        return latest if task.abandoned.is_set() else call(setting, iterations)

    for setting in schedule:
        if task.seconds_left <= 0:
            stop = Stop.TIME_LIMIT
            break
        task.progress.update(f"{done} iterations")
        latest = run_interruptibly(partial(begin, setting, budget - done), task.progress, task.abandoned.set)
        done += latest.iterations
        setup_seconds += latest.setup_seconds
        histories.append(latest.history)
        stop = latest.stop
        if latest.gap is not None:
            bound = task.bound(latest.gap)
            if latest.finish and bound > least:
                findings.append(
                    f"{latest.finish} made the answer worse: bound {bound:.2g} after, {least:.2g} before (of the error "
                    "scale); the answer before was kept"
                )
            if gap is None or bound < least:
                gap, least = latest.gap, bound
        if least <= task.tol:
            stop = Stop.DONE
        elif stop is Stop.DONE and done >= budget:
            stop = Stop.ITERATION_LIMIT
        if least <= task.tol or stop is not Stop.DONE:
            break
    if gap is None and stop is Stop.DONE:
        stop = Stop.FAILED
    return Answer(
        gap=gap,
        stop=stop,
        termination=latest.termination,
        iterations=done,
        setup_seconds=setup_seconds,
        solve_seconds=working_seconds() - started - (setup_seconds - setup_before),
        history=one_after_the_other(histories),
        note=note,
        findings=tuple(findings),
        claimed_solved=stop is Stop.DONE and latest.claims,
    )


def one_after_the_other(histories: Iterable[Mapping[str, Vector]]) -> dict[str, Vector]:
    """Return what was recorded in several calls as one record."""
    told = [history for history in histories if history]
    return {name: np.concatenate([history[name] for history in told]) for name in (told[0] if told else ())}
