"""Mangasarian's single linear program, by HiGHS through scipy.optimize.linprog.

Mangasarian, *Linear complementarity problems solvable by a single linear program*, Mathematical Programming 10 (1976).
"""

from __future__ import annotations

import time
from collections.abc import Collection
from functools import partial
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from ..foundation.checks import Vector, one_of, vector
from ..foundation.progress import run_interruptibly
from ..problem.contact_qp import ContactQP
from .base import Answer, Backend, Need, Stop, Task

_TIGHTEST = 1e-10


class Mangasarian(Backend):
    r"""min cᵀω over the feasible set {ω ≥ l, Gω + q ≥ 0}, for any c > 0.

    For a Z-matrix G that set has a least element, and it solves the complementarity problem; every positive cost
    finds it. For other matrices the program has an optimum that solves nothing, so they are refused. So are problems
    with an upper bound: where it holds a node the reaction is negative, the solution does not lie in the set, and the
    set that it does lie in is not convex. After Ctrl-C the
    call returns at once, but HiGHS, which cannot be told to stop, runs on in the background until it is done.
    """

    name: ClassVar[str] = "mangasarian"
    summary: ClassVar[str] = "single linear program (HiGHS through scipy.optimize.linprog)"
    package: ClassVar[str] = "scipy"
    has_own_defaults: ClassVar[bool] = True
    reachable_tol: ClassVar[float | None] = 1e-9
    needs: ClassVar[Collection[Need]] = (Need.Z_MATRIX, Need.ONE_SIDED)

    def solve(
        self,
        problem: ContactQP,
        task: Task,
        *,
        cost: ArrayLike | None = None,
        method: Literal["highs-ds", "highs-ipm"] = "highs-ds",
        presolve: bool | None = None,
        eps: float = _TIGHTEST,
    ) -> Answer:
        """Solve by one linear program.

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
        from scipy.optimize import linprog

        one_of(method, ("highs-ds", "highs-ipm"), "method")
        weights = np.ones(problem.size) if cost is None else vector(cost, problem.size, "cost")
        if not weights.min() > 0:
            worst = int(np.argmin(weights))
            raise ValueError(f"cost must be > 0 everywhere, but entry {worst} is {weights[worst]:g}")
        options: dict[str, Any] = {}
        if task.passed_on(eps=eps):
            options |= {"primal_feasibility_tolerance": eps, "dual_feasibility_tolerance": eps}
        chosen = task.passed_on(method=method)
        if task.max_iter is not None:
            options["maxiter"] = task.max_iter
        started = time.perf_counter()
        bounds = np.column_stack([problem.lower, problem.upper])
        constraint = -problem.G
        setup_seconds = time.perf_counter() - started

        def work(simplify: bool | None) -> Any:
            simplification = {} if simplify is None else {"presolve": simplify}
            limit = {} if task.time_limit is None else {"time_limit": max(task.seconds_left, 1e-3)}
            return linprog(
                weights / weights.max(),
                A_ub=constraint,
                b_ub=problem.q,
                bounds=bounds,
                options=options | limit | simplification,
                **chosen,
            )

        attempts: tuple[bool | None, ...] = (presolve,)
        if presolve is None and not task.own_defaults:
            attempts = (False, True)
        for simplify in attempts:
            result = run_interruptibly(partial(work, simplify), task.progress)
            if result.status in (0, 1):
                break
        gap: Vector | None = None if result.x is None else np.asarray(result.x)
        return Answer(
            gap=gap,
            stop=_stop(int(result.status), str(result.message)),
            termination=" ".join(str(result.message).split()),
            iterations=int(result.nit),
            setup_seconds=setup_seconds,
            solve_seconds=time.perf_counter() - started - setup_seconds,
            claimed_solved=result.status == 0,
        )


def _stop(status: int, message: str) -> Stop:
    """Translate scipy's status; 1 stands for either limit, and 4 (numerical difficulties) is left to the judge."""
    if status == 1:
        return Stop.TIME_LIMIT if "time limit" in message.lower() else Stop.ITERATION_LIMIT
    return Stop.DONE if status in (0, 4) else Stop.FAILED
