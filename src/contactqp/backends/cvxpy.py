"""The solvers of quadratic programs that CVXPY finds: ``cvxpy:clarabel``, ``cvxpy:piqp`` and others.

Diamond and Boyd, *CVXPY: a Python-embedded modeling language for convex optimization*, Journal of Machine Learning
Research 17 (2016).
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from ..problem.contact_problem import ContactProblem
from .base import Task
from .families import Member, MemberState, Settings
from .library import Ask, Reply, Vectors, Workspace
from .option_checks import Positive
from .solvers import solvers_through


class Cvxpy(Member):
    """A solver that CVXPY calls; started again with a tighter tolerance where the judge is not satisfied."""

    family: ClassVar[str] = "cvxpy"

    @staticmethod
    def offered(library: Any) -> list[str]:
        """See `Member.offered`: those with a row, and others that take quadratic programs."""
        defined = library.reductions.solvers.defines
        quadratic = {*defined.QP_SOLVERS, *map(str.upper, solvers_through("cvxpy"))}
        return [name.lower() for name in library.installed_solvers() if name in quadratic]

    @staticmethod
    def known_by(library: Any) -> list[str]:
        """See `Member.known_by`."""
        return [name.lower() for name in library.reductions.solvers.defines.QP_SOLVERS]

    def prepare(
        self, problem: ContactProblem, task: Task, *, eps: Positive | None = None, settings: Settings | None = None
    ) -> _Prepared:
        """State the program in CVXPY's words.

        Parameters
        ----------
        problem, task
            See `Backend.solve`; the warm start is not used. With the library's own defaults the solver is called once.
        eps : float, optional
            The solver's first tolerance; by default what its row in the table of solvers says.
        settings : mapping of str to object, optional
            Settings of the solver, by its own names.
        """
        return _Prepared(self, Cvxpy.prepare, problem, task, {"eps": eps, "settings": settings})


class _Prepared(MemberState):
    """The stated program; it is stated anew at each load.

    With forces and limits as parameters CVXPY would keep an array of 2 n² numbers.
    """

    imports: ClassVar[str] = "cvxpy"

    def set_up(self, ask: Ask, vectors: Vectors) -> Workspace:
        """See `LibraryState.set_up`; returned are the variable, the equations, and the problem."""
        form, cp, limits = ask.form, self.library, vectors["b"]
        gap, rows, equations = cp.Variable(self.problem.size), form.matrix, form.equations
        energy = 0.5 * cp.quad_form(gap, cp.psd_wrap(self.problem.G.tocsc())) + vectors["q"] @ gap
        equal = [rows[:equations] @ gap == limits[:equations]] if equations else []
        below = [rows[equations:] @ gap <= limits[equations:]] if form.inequalities else []
        # Some solvers take no program without a row.
        return gap, equal, cp.Problem(cp.Minimize(energy), [*equal, *below] or [0.0 * cp.sum(gap) <= 1.0])

    def change(self, workspace: Workspace, changed: Vectors) -> bool:
        """See `LibraryState.change`."""
        return False

    def ask(self, workspace: Workspace, ask: Ask, settings: dict[str, Any]) -> Reply:
        """See `MemberState.ask`."""
        variable, equal, stated = workspace
        try:
            stated.solve(solver=self.member.solver.upper(), warm_start=False, **settings)
        except (self.library.error.SolverError, ArithmeticError) as error:
            return self.reply(ask, None, " ".join(str(error).split()), None, solved=False)
        told, gap = stated.solver_stats, variable.value
        gap = None if gap is None else np.array(gap, dtype=np.float64)
        if gap is not None and equal:
            multiplier = equal[0].dual_value
            gap = ask.form.gap(ask.problem, gap, np.zeros(gap.size) if multiplier is None else multiplier)
        done = None if told is None or told.num_iters is None else int(told.num_iters)
        return self.reply(ask, gap, str(stated.status), done, solved=stated.status == self.library.OPTIMAL)
