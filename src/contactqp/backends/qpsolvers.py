"""The solvers that qpsolvers finds: ``qpsolvers:piqp``, ``qpsolvers:highs`` and others.

Caron et al., *qpsolvers: quadratic programming solvers in Python with a unified API*.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from ..problem.contact_problem import ContactProblem
from .base import Task
from .families import Found, Member, MemberState, Program, Question
from .matrices import upper_triangle
from .option_checks import Positive, Settings

_CALLED = "_solve_problem"


class QpSolvers(Member):
    """A solver that qpsolvers calls; started again with a tighter tolerance where the judge is not satisfied."""

    family: ClassVar[str] = "qpsolvers"

    @staticmethod
    def offered(library: Any) -> list[str]:
        """See `Member.offered`."""
        return list(library.available_solvers)

    @staticmethod
    def known_by(library: Any) -> list[str]:
        """See `Member.known_by`: a function is named after each."""
        return [name.removesuffix(_CALLED) for name in dir(library.solvers) if name.endswith(_CALLED)]

    def prepare(
        self, problem: ContactProblem, task: Task, *, eps: Positive | None = None, settings: Settings | None = None
    ) -> MemberState:
        """Prepare the program's matrices, in the form that the solver takes.

        Parameters
        ----------
        problem, task
            See `Backend.solve`. With the library's own defaults the solver is called once.
        eps : float, optional
            The solver's first tolerance; by default what its row in the table of solvers says.
        settings : mapping of str to object, optional
            Settings of the solver, by its own names.
        """
        return MemberState(self, _Program, QpSolvers.prepare, problem, task, {"eps": eps, "settings": settings})


class _Program(Program):
    """The matrices in the form that the solver takes: that of the objective, of the equations and the inequalities."""

    family: ClassVar[str] = "qpsolvers"

    def __init__(self, solver: str, stiffness: Any, rows: Any, equations: int) -> None:
        super().__init__(solver, stiffness, rows, equations)
        if self.facts.triangle:
            stiffness = upper_triangle(stiffness).T
        parts = stiffness.tocsc(), rows[:equations], rows[equations:]
        sparse = type(rows)  # a matrix, which is all that some of the solvers take
        self._matrices = [part.toarray() if self.facts.dense else sparse(part) for part in parts]

    def found(self, question: Question, settings: Mapping[str, Any]) -> Found:
        """See `Program.found`."""
        objective, equal, below = self._matrices
        program = {"A": equal, "b": question.limits[: self.equations]} if self.equations else {}
        if self.facts.box:
            box = ("lb", question.lower), ("ub", question.upper)
            program |= {name: bound for name, bound in box if np.isfinite(bound).any()}
        elif below.shape[0]:
            program |= {"G": below, "h": question.limits[self.equations :]}
        posed = self.library.Problem(objective, question.q, **program)
        try:
            found = self.library.solve_problem(posed, self.solver, initvals=question.start, **settings)
        except (self.library.exceptions.SolverError, ArithmeticError) as error:
            return Found(" ".join(str(error).split()))
        gap = None if found.x is None else np.array(found.x, dtype=np.float64)
        multiplier = None if found.y is None or not len(found.y) else np.asarray(found.y)
        word = _said(found.extras, "status") or ("solved" if found.found else "not solved")
        steps = _said(found.extras, "iter", "iterations")
        done = None if steps is None else int(np.ravel(steps)[0])
        return Found(str(word), gap, multiplier, done, solved=bool(found.found))


def _said(extras: dict[str, Any], *names: str) -> Any:
    """Return what a solver tells under one of some names, by itself or within its record."""
    for name in names:
        said = extras.get(name, getattr(extras.get("info"), name, None))
        if said is not None:
            return said
    return None
