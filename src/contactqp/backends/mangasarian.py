"""Mangasarian's single linear program, by HiGHS through scipy.optimize.linprog.

Mangasarian, *Linear complementarity problems solvable by a single linear program*, Mathematical Programming 10 (1976).
"""

from __future__ import annotations

import sys
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from ..foundation.checks import Vector, one_of, vector
from ..foundation.loading import load_modules, working_seconds
from ..problem.contact_qp import ContactQP
from .base import Answer, Backend, Need, State, Stop, Task, as_it_is_now
from .tightening import Round, tightened

_TIGHTEST = 1e-10


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
    has_own_defaults: ClassVar[bool] = True
    practical_size: ClassVar[int | None] = 10_000
    reachable_tol: ClassVar[float | None] = 1e-9
    needs: ClassVar[tuple[Need, ...]] = (Need.Z_MATRIX, Need.ONE_SIDED)

    def prepare(
        self,
        problem: ContactQP,
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
        one_of(method, ("highs-ds", "highs-ipm"), "method")
        weights = np.ones(problem.size) if cost is None else vector(cost, problem.size, "cost")
        if not weights.min() > 0:
            worst = int(np.argmin(weights))
            raise ValueError(f"cost must be > 0 everywhere, but entry {worst} is {weights[worst]:g}")
        options: dict[str, Any] = {}
        if task.passed_on(eps=eps):
            options = {"primal_feasibility_tolerance": eps, "dual_feasibility_tolerance": eps}
        chosen = task.passed_on(method=method)
        attempts = (presolve,) if presolve is not None or task.own_defaults else (False, True)
        return _Prepared(problem, weights / weights.max(), chosen, options, attempts)


class _Prepared(State):
    """The program's matrix and cost, scipy's arguments, and for each attempt whether HiGHS is to simplify."""

    def __init__(
        self,
        problem: ContactQP,
        cost: Vector,
        chosen: dict[str, Any],
        options: dict[str, Any],
        attempts: tuple[bool | None, ...],
    ) -> None:
        started = working_seconds()
        self._problem, self._cost, self._chosen, self._options = problem, cost, chosen, options
        self._attempts, self._matrix = attempts, -problem.G
        self._setup_seconds = working_seconds() - started

    def solve(self, q: Vector, task: Task, problem: ContactQP | None = None) -> Answer:
        """See `State.solve`."""
        load_modules("scipy.optimize")
        from scipy.optimize import linprog

        problem = as_it_is_now(self._problem, q, problem)
        bounds = np.column_stack([problem.lower, problem.upper])

        def call(attempts: tuple[bool | None, ...], iterations: int) -> Round:
            for simplify in attempts:
                options = self._options if simplify is None else self._options | {"presolve": simplify}
                if task.max_iter is not None:
                    options = options | {"maxiter": task.max_iter}
                if task.time_limit is not None:
                    options = options | {"time_limit": max(task.seconds_left, 1e-3)}
                program = {"A_ub": self._matrix, "b_ub": problem.q, "bounds": bounds, "options": options}
                result = linprog(self._cost, **program, **self._chosen)
                if result.status in (0, 1):
                    break
            return Round(
                gap=None if result.x is None else np.asarray(result.x),
                stop=_stop(int(result.status), str(result.message)),
                termination=" ".join(str(result.message).split()),
                iterations=int(result.nit),
                claims=result.status == 0,
            )

        setup_seconds, self._setup_seconds = self._setup_seconds, 0.0
        return tightened(task, call, [self._attempts], sys.maxsize, setup_seconds=setup_seconds)


def _stop(status: int, message: str) -> Stop:
    """Translate scipy's status; 1 stands for either limit, and 4 (numerical difficulties) is left to the judge."""
    if status == 1:
        return Stop.TIME_LIMIT if "time limit" in message.lower() else Stop.ITERATION_LIMIT
    return Stop.DONE if status in (0, 4) else Stop.FAILED
