"""Mangasarian's single linear program, by HiGHS through scipy.optimize.linprog.

Mangasarian, *Linear complementarity problems solvable by a single linear program*, Mathematical Programming 10 (1976).
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from ..foundation.checks import positive_vector
from ..problem.contact_problem import ContactProblem
from .base import Backend, Need, Stop, Task
from .library import Ask, LibraryState, Outcome, Plan, Reply, Vectors, Workspace

_TIGHTEST = 1e-10
_SOLVED, _LIMIT, _DIFFICULTIES, _TIME_LIMIT = 0, 1, 4, "time limit"
"""How scipy numbers what HiGHS has ended with; the words alone tell which of two limits it was."""


class Mangasarian(Backend):
    r"""min cᵀω over the feasible set {ω ≥ l, Gω + q ≥ 0}, for any c > 0.

    For a Z-matrix G that set has a least element, and it solves the complementarity problem; every positive cost
    finds it. For other matrices the program has an optimum that solves nothing, so they are refused. So are upper
    bounds: where one presses, Gω + q < 0, so that the solution is not in that set; and the set that it is in, with
    Gω + q ≥ 0 or ω = u at each node, is not convex. After Ctrl-C the call returns at once, but HiGHS, which cannot be
    told to stop, runs on in the background until it is done.
    """

    name: ClassVar[str] = "mangasarian"
    summary: ClassVar[str] = "single linear program (HiGHS through scipy.optimize.linprog)"
    package: ClassVar[str] = "scipy"
    licence: ClassVar[str] = "MIT"
    has_own_defaults: ClassVar[bool] = True
    practical_size: ClassVar[int | None] = 10_000
    reachable_tol: ClassVar[float | None] = 1e-9
    needs: ClassVar[tuple[Need, ...]] = (Need.Z_MATRIX, Need.ONE_SIDED)
    does_without: ClassVar[tuple[Need, ...]] = (Need.SYMMETRIC, Need.DEFINITE)

    def prepare(
        self,
        problem: ContactProblem,
        task: Task,
        *,
        cost: ArrayLike | None = None,
        method: Literal["highs-ds", "highs-ipm"] = "highs-ds",
        presolve: bool | None = None,
        eps: float = _TIGHTEST,
    ) -> _Prepared:
        """Prepare the linear program, which is solved anew at each load.

        Parameters
        ----------
        problem, task
            See `Backend.solve`; the warm start is not used. With the library's own defaults HiGHS chooses its method,
            simplifies, and has feasibility tolerances of 1e-7.
        cost : array, shape (n,), optional
            Any positive vector c; ones by default. Ones, the barrier, its stiffness and random costs took the same time
            within 3 % (``benchmarks/backend_settings.txt``).
        method : {"highs-ds", "highs-ipm"}
            HiGHS's dual simplex or interior-point method; on the hexagon and a bowl of 63² nodes the first took 0.4 to
            0.5 of the second's time.
        presolve : bool, optional
            Whether HiGHS simplifies the program first. By default it does only where it fails without, as it does
            with some tens of thousands of unknowns: presolving gained nothing there, and doubled the time at 100².
        eps : float
            HiGHS's primal and dual feasibility tolerance; 1e-10 is the tightest it takes.
        """
        attempts = (presolve,) if presolve is not None or task.own_defaults else (False, True)
        options = {"method": method, "eps": eps}
        return _Prepared(cost, attempts, Mangasarian.prepare, problem, task, options)


class _Prepared(LibraryState):
    """The program's matrix and cost, and for each attempt whether HiGHS is to simplify."""

    imports: ClassVar[str] = "scipy.optimize"
    # What comes of numerical difficulties is left to the judge.
    outcomes: ClassVar[Mapping[Any, Outcome]] = {
        _SOLVED: Outcome(Stop.DONE, claims=True),
        _LIMIT: Outcome(Stop.ITERATION_LIMIT),
        _TIME_LIMIT: Outcome(Stop.TIME_LIMIT),
        _DIFFICULTIES: Outcome(Stop.DONE),
    }

    def __init__(self, cost: ArrayLike | None, attempts: tuple[bool | None, ...], *prepared: Any) -> None:
        super().__init__(*prepared)
        weights = np.ones(self.problem.size) if cost is None else positive_vector(cost, self.problem.size, "cost")
        self._cost, self._attempts = weights / weights.max(), attempts

    def plan(self, task: Task) -> Plan:
        """See `LibraryState.plan`; there is one round."""
        return Plan(_TIGHTEST, sys.maxsize)

    def set_up(self, ask: Ask, vectors: Vectors) -> Workspace:
        """See `LibraryState.set_up`."""
        return -self.problem.G

    def vectors(self, ask: Ask) -> Vectors:
        """See `LibraryState.vectors`; they are handed over at each call."""
        return {}

    def call(self, workspace: Workspace, ask: Ask) -> Reply:
        """See `LibraryState.call`."""
        bounds = np.column_stack([ask.problem.lower, ask.problem.upper])
        limits = {"maxiter": ask.task.max_iter, "time_limit": None if ask.task.time_limit is None else ask.seconds}
        told = {**limits, "primal_feasibility_tolerance": self.eps, "dual_feasibility_tolerance": self.eps}
        program = {"A_ub": workspace, "b_ub": ask.problem.q, "bounds": bounds, **self.settings}
        for presolve in self._attempts:
            options = {name: value for name, value in {**told, "presolve": presolve}.items() if value is not None}
            result = self.library.linprog(self._cost, **program, options=options)
            if result.status in (_SOLVED, _LIMIT):
                break
        words = " ".join(str(result.message).split())
        status = _TIME_LIMIT if result.status == _LIMIT and "time limit" in words.lower() else int(result.status)
        return Reply(status, None if result.x is None else np.asarray(result.x), int(result.nit), words)
