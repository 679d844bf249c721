"""The solvers that qpsolvers finds: ``qpsolvers:piqp``, ``qpsolvers:highs`` and others.

Caron et al., *qpsolvers: quadratic programming solvers in Python with a unified API*.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from ..problem.contact_problem import ContactProblem
from .base import Task
from .families import Member, MemberState, Settings
from .library import Ask, Reply, Vectors, Workspace
from .matrices import upper_triangle
from .option_checks import Positive

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
    ) -> _Prepared:
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
        return _Prepared(self, QpSolvers.prepare, problem, task, {"eps": eps, "settings": settings})


class _Prepared(MemberState):
    """The matrices: that of the objective, and the rows of equations and inequalities."""

    imports: ClassVar[str] = "qpsolvers"

    def vectors(self, ask: Ask) -> Vectors:
        """See `LibraryState.vectors`; they are handed over at each call."""
        return {}

    def set_up(self, ask: Ask, vectors: Vectors) -> Workspace:
        """See `LibraryState.set_up`."""
        form = ask.form
        stiffness = upper_triangle(self.problem).T if self.facts.triangle else self.problem.G
        parts = stiffness.tocsc(), form.matrix[: form.equations], form.matrix[form.equations :]
        if self.facts.dense:
            return [part.toarray() for part in parts]
        sparse = type(form.matrix)  # a matrix, which is all that some of the solvers take
        return [sparse(part) for part in parts]

    def ask(self, workspace: Workspace, ask: Ask, settings: dict[str, Any]) -> Reply:
        """See `MemberState.ask`."""
        problem, form = ask.problem, ask.form
        objective, equal, below = workspace
        limits, box = form.limits(problem), form.box(problem)
        program = {"A": equal, "b": limits[: form.equations]} if form.equations else {}
        if not self.facts.box and form.inequalities:
            program |= {"G": below, "h": limits[form.equations :]}
        if self.facts.box:
            program |= {name: bound for name, bound in zip(("lb", "ub"), box, strict=True) if np.isfinite(bound).any()}
        posed = self.library.Problem(objective, np.array(problem.q), **program)
        start = ask.task.warm_start if self.facts.warm else None
        start = None if start is None else problem.project(start)
        try:
            found = self.library.solve_problem(posed, self.member.solver, initvals=start, **settings)
        except (self.library.exceptions.SolverError, ArithmeticError) as error:
            return self.reply(ask, None, " ".join(str(error).split()), None, solved=False)
        gap = None if found.x is None else np.array(found.x, dtype=np.float64)
        if gap is not None:
            multiplier = np.zeros(form.equations) if found.y is None or not len(found.y) else np.asarray(found.y)
            gap = form.gap(problem, gap, multiplier)
        word = _said(found.extras, "status") or ("solved" if found.found else "not solved")
        steps = _said(found.extras, "iter", "iterations")
        done = None if steps is None else int(np.ravel(steps)[0])
        return self.reply(ask, gap, str(word), done, solved=bool(found.found))


def _said(extras: dict[str, Any], *names: str) -> Any:
    """Return what a solver tells under one of some names, by itself or within its record."""
    for name in names:
        said = extras.get(name, getattr(extras.get("info"), name, None))
        if said is not None:
            return said
    return None
