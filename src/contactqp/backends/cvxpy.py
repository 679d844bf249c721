"""The solvers of quadratic programs that CVXPY finds: ``cvxpy:clarabel``, ``cvxpy:piqp`` and others.

Diamond and Boyd, *CVXPY: a Python-embedded modeling language for convex optimization*, Journal of Machine Learning
Research 17 (2016).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from ..problem.contact_problem import ContactProblem
from .base import Task
from .families import Found, Member, MemberState, Program, Question
from .option_checks import Positive, Settings
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
    ) -> MemberState:
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
        return MemberState(self, _Program, Cvxpy.prepare, problem, task, {"eps": eps, "settings": settings})


class _Program(Program):
    """The stated program; it is stated anew for other vectors.

    With forces and limits as parameters CVXPY would keep an array of 2 n² numbers.
    """

    family: ClassVar[str] = "cvxpy"

    def found(self, question: Question, settings: Mapping[str, Any]) -> Found:
        """See `Program.found`."""
        variable, equal, stated = self._stated(question)
        try:
            data, chain, inverse = stated.get_problem_data(self.solver.upper(), solver_opts=dict(settings))
            # What the solver itself says of Ctrl-C, CVXPY does not pass on.
            told = chain.solve_via_data(stated, data, warm_start=False, verbose=False, solver_opts=dict(settings))
            if _interrupted(told):
                return Found("interrupted")
            stated.unpack_results(told, chain, inverse)
        except (self.library.error.SolverError, ArithmeticError) as error:
            return Found(" ".join(str(error).split()))
        gap = None if variable.value is None else np.array(variable.value, dtype=np.float64)
        multiplier = equal[0].dual_value if equal else None
        stats = stated.solver_stats
        done = None if stats is None or stats.num_iters is None else int(stats.num_iters)
        return Found(str(stated.status), gap, multiplier, done, solved=stated.status == self.library.OPTIMAL)

    def _stated(self, question: Question) -> tuple[Any, list[Any], Any]:
        """Return the variable, the equations and the problem."""
        cp, rows, equations, limits = self.library, self.rows, self.equations, question.limits
        vectors = np.concatenate([question.q, limits])
        if self._last is None or not np.array_equal(vectors, self._last[0]):
            gap = cp.Variable(question.q.size)
            energy = 0.5 * cp.quad_form(gap, cp.psd_wrap(self.stiffness.tocsc())) + question.q @ gap
            equal = [rows[:equations] @ gap == limits[:equations]] if equations else []
            below = [rows[equations:] @ gap <= limits[equations:]] if rows.shape[0] > equations else []
            # Some solvers take no program without a row.
            stated = cp.Problem(cp.Minimize(energy), [*equal, *below] or [0.0 * cp.sum(gap) <= 1.0])
            self._last = vectors, (gap, equal, stated)
        return self._last[1]

    _last: tuple[Any, tuple[Any, list[Any], Any]] | None = None


def _interrupted(told: Any) -> bool:
    """Whether a solver says that Ctrl-C has ended it."""
    info = told.get("info") if isinstance(told, dict) else getattr(told, "info", None)
    status = info.get("status") if isinstance(info, dict) else getattr(info, "status", None)
    return "interrupt" in str(status)
