"""The state of a library whose calls may be made in processes of their own, which Ctrl-C and the time limit end."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

from ..foundation.checks import Vector
from ..foundation.interrupts import OutOfTime
from ..problem.contact_problem import ContactProblem
from .base import Answer, Stop, Task
from .library import Ask, LibraryState, Outcome, Reply, Vectors
from .processes import LostProcessError, Placed

TIME = "time limit"
"""What a library is said to answer where it has looked at the clock itself."""

_ENDED = "ended at the time limit"

_GRACE = 0.2
"""Seconds after the time limit for libraries that watch the clock themselves; then their process is ended."""


class PlacedState(LibraryState):
    """A problem in objects that are `Placed`, here or elsewhere: what `set_up` returns is one.

    Vectors are handed over at each call. A subclass writes `question` and `reply` in the place of `call`.
    """

    outcomes: ClassVar[Mapping[Any, Outcome]] = {
        TIME: Outcome(Stop.TIME_LIMIT),
        _ENDED: Outcome(Stop.TIME_LIMIT, keeps=False),
    }

    @abstractmethod
    def question(self, ask: Ask) -> tuple[Any, ...]:
        """Return what the object's method ``solve`` is given."""

    @abstractmethod
    def reply(self, ask: Ask, found: Any) -> Reply:
        """Return what the object has found, as a gap."""

    def vectors(self, ask: Ask) -> Vectors:
        """See `LibraryState.vectors`."""
        return {}

    def solve(self, q: Vector, task: Task, problem: ContactProblem | None = None) -> Answer:
        """See `State.solve`; a process outlives it only where there may be another load."""
        answer = super().solve(q, task, problem)
        if not task.keeps:
            for workspace in self.dropped():
                workspace.end()
        return answer

    def call(self, workspace: Placed, ask: Ask) -> Reply:
        """See `LibraryState.call`."""
        seconds = None if ask.task.time_limit is None else ask.seconds + _GRACE
        try:
            found = workspace.call("solve", *self.question(ask), seconds=seconds)
        except OutOfTime:
            return Reply(_ENDED, None, 0, _ENDED)
        except LostProcessError as error:
            return Reply(str(error), None, 0, str(error))
        except BaseException:
            workspace.end()
            raise
        return self.reply(ask, found)
