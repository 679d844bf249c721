"""Options of PETSc that were given, and that nothing in it has asked for: most are misspelt."""

from __future__ import annotations

import warnings
from collections.abc import Set as AbstractSet

from ..errors import ContactWarning
from ..foundation.checks import Vector
from ..foundation.outside import stacklevel_outside
from ..problem.contact_problem import ContactProblem
from .base import Answer, Task
from .placed_state import PlacedState


class StateWithUnusedOptions(PlacedState):
    """PETSc in a process of its own, whose replies leave in `unused` the options that nothing has asked for.

    A warning tells of each of them once: it is misspelt, or belongs to what is not used.
    """

    unused: AbstractSet[str] = frozenset()
    _told: AbstractSet[str] = frozenset()

    def solve(self, q: Vector, task: Task, problem: ContactProblem | None = None) -> Answer:
        """See `State.solve`."""
        answer, news = super().solve(q, task, problem), self.unused - self._told
        if news:
            names = ", ".join(map(repr, sorted(news)))
            message = f"petsc_options has {names}, which nothing in PETSc asks for: misspelt, or of what is not used"
            warnings.warn(message, ContactWarning, stacklevel=stacklevel_outside())
        self._told |= news
        return answer
