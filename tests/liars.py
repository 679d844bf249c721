"""Backends that say that they have solved what they have not, for processes that import them."""

from typing import ClassVar

import numpy as np

from contactqp.backends.base import Answer, Backend, Stop


class Liar(Backend):
    """Returns no gap anywhere, and says that this is the solution."""

    name: ClassVar[str] = "liar"
    summary: ClassVar[str] = "claims"
    package: ClassVar[str] = "numpy"

    def solve(self, problem, task) -> Answer:
        return Answer(np.zeros(problem.size), Stop.DONE, "solved", 1, 0.0, 0.0)


class Crash(Liar):
    """Ends its process."""

    def solve(self, problem, task) -> Answer:
        import os

        os._exit(7)


class Glutton(Liar):
    """Asks for more memory than there is."""

    def solve(self, problem, task) -> Answer:
        held = [np.empty(2**24) for _ in range(10_000)]
        return Answer(held[0], Stop.DONE, "solved", 1, 0.0, 0.0)
