"""OSQP: operator splitting (ADMM), called through its own API.

Stellato, Banjac, Goulart, Bemporad and Boyd, *OSQP: an operator splitting solver for quadratic programs*,
Mathematical Programming Computation 12 (2020).
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from functools import partial
from typing import Any, ClassVar

import numpy as np

from ..foundation.checks import Vector, open_interval, positive_number
from ..foundation.progress import run_interruptibly
from ..problem.contact_qp import ContactQP
from .base import Answer, Backend, State, Stop, Task, as_it_is_now
from .tightening import Round, tightened

_MAX_ITER = 200_000
_TIGHTEST = 1e-14
_NEVER = 1e-15


class Osqp(Backend):
    """Operator splitting; its tolerance is tightened, and the iteration resumed, until the judge is satisfied."""

    name: ClassVar[str] = "osqp"
    summary: ClassVar[str] = "operator splitting (ADMM)"
    package: ClassVar[str] = "osqp"
    has_own_defaults: ClassVar[bool] = True
    reachable_tol: ClassVar[float | None] = 1e-13

    def prepare(
        self,
        problem: ContactQP,
        task: Task,
        *,
        rho: float = 3.0,
        alpha: float = 1.8,
        sigma: float = 1e-6,
        scaling: int = 10,
        adaptive_rho: bool = True,
        check_termination: int = 25,
        polishing: bool = True,
        eps: float | None = None,
    ) -> _Workspace:
        """Set OSQP up: its factors and the adapted ``rho`` are kept from load to load.

        Parameters
        ----------
        problem, task
            See `Backend.solve`. With the library's own defaults it is called once; only where ``polishing`` is asked
            for as well, a second time for that.
        rho, alpha, sigma, scaling, adaptive_rho, check_termination
            OSQP's settings of the same names; the defaults are the fastest of those that
            ``benchmarks/backend_settings.py`` tried.
        polishing : bool
            Whether to polish from the second round on until it succeeds once; of all rounds' answers the best is
            returned. A polished answer whose bound is above that of the rounds before is a finding.
        eps : float, optional
            OSQP's first absolute and relative tolerance; by default 100 ``tol``.
        """
        open_interval(alpha, 0.0, 2.0, "alpha")
        for name, value in (
            ("rho", rho),
            ("sigma", sigma),
            ("check_termination", check_termination),
        ):
            positive_number(value, name)
        settings = task.passed_on(
            rho=rho,
            alpha=alpha,
            sigma=sigma,
            scaling=scaling,
            adaptive_rho=int(adaptive_rho),
            check_termination=check_termination,
        )
        if not task.own_defaults:
            # With G positive definite the program always has a solution: no test for the contrary may fire.
            settings |= {"eps_prim_inf": _NEVER, "eps_dual_inf": _NEVER}
        polishing = polishing and (not task.own_defaults or "polishing" in task.given)
        return _Workspace(
            problem,
            task,
            settings,
            polishing,
            None if eps is None else positive_number(eps, "eps"),
        )


class _Workspace(State):
    """OSQP's workspace: factors, adapted ``rho`` and last iterate; every unknown has a row l ≤ ω ≤ u."""

    def __init__(
        self,
        problem: ContactQP,
        task: Task,
        settings: dict[str, Any],
        polishing: bool,
        eps: float | None,
    ) -> None:
        self._problem, self._settings, self._polishing, self._eps = (
            problem,
            settings,
            polishing,
            eps,
        )
        self._set_up(problem, task)

    def _set_up(self, problem: ContactQP, task: Task) -> None:
        import osqp
        from scipy import sparse

        started, self._solver, self._used = time.perf_counter(), osqp.OSQP(), False
        matrix = sparse.csc_matrix(sparse.triu(problem.G, format="csc"))
        rows = sparse.csc_matrix(sparse.eye_array(problem.size))
        data = matrix, problem.q.copy(), rows, problem.lower, problem.upper
        fixed = {"polishing": False, "verbose": False, "warm_starting": True}
        run_interruptibly(partial(self._solver.setup, *data, **fixed, **self._settings), task.progress)
        shipped = self._solver.settings
        self._shipped = (
            float(shipped.eps_abs),
            float(shipped.rho),
            int(shipped.max_iter),
        )
        self._vectors = {"q": problem.q, "l": problem.lower, "u": problem.upper}
        self._setup_seconds = time.perf_counter() - started

    def solve(self, q: Vector, task: Task, problem: ContactQP | None = None) -> Answer:
        """See `State.solve`."""
        problem = as_it_is_now(self._problem, q, problem)
        if self._solver is None:
            self._set_up(problem, task)
        # After Ctrl-C the library may still be at work in it, and after a failure its iterate is of no use.
        solver, self._solver = self._solver, None
        self._start(solver, problem, task.warm_start)
        rounds = _Rounds(
            solver,
            problem,
            task,
            self._polishing,
            self._used and task.warm_start is not None,
        )
        eps, budget, note = self._eps, _MAX_ITER, ""
        if task.own_defaults:
            usual, rho, budget = self._shipped
            eps = usual if eps is None else eps
            note = f"OSQP as shipped: eps {eps:g}, rho {rho:g}, at most {budget} iterations"
        schedule = rounds.tolerances(eps)
        budget = budget if task.max_iter is None else task.max_iter
        answer = tightened(
            task,
            rounds.call,
            schedule,
            budget,
            setup_seconds=self._setup_seconds,
            note=note,
        )
        self._setup_seconds, self._used = 0.0, True
        self._solver = None if answer.stop is Stop.FAILED else solver
        return answer

    def _start(self, solver: Any, problem: ContactQP, warm_start: Vector | None) -> None:
        """Put new forces and bounds into the workspace, and its iterate where the solve is to start."""
        vectors = {"q": problem.q, "l": problem.lower, "u": problem.upper}
        changed = {k: v.copy() for k, v in vectors.items() if not np.array_equal(v, self._vectors[k])}
        if changed:
            solver.update(**changed)
            self._vectors = vectors
        if warm_start is not None:
            start = problem.project(warm_start)
            solver.warm_start(x=start, y=-_reaction(problem, start))
        elif self._used:
            solver.warm_start(x=np.zeros(problem.size), y=np.zeros(problem.size))


class _Rounds:
    """The calls of one solve, and whether to polish in the next."""

    def __init__(
        self,
        solver: Any,
        problem: ContactQP,
        task: Task,
        polishing: bool,
        resumed: bool,
    ) -> None:
        self._solver, self._task, self._polishing, self._polish = (
            solver,
            task,
            polishing,
            False,
        )
        self._check = int(solver.settings.check_termination)
        self._resumed = resumed and not task.own_defaults
        self._pressed = 1e-6 * np.abs(problem.q).max()

    def call(self, eps: float, iterations: int) -> Round:
        limit = min(max(self._task.seconds_left, 1e-6), 1e10)
        self._solver.update_settings(
            eps_abs=eps,
            eps_rel=eps,
            max_iter=iterations,
            time_limit=limit,
            polishing=self._polish,
            check_termination=1 if self._polish and self._resumed else self._check,
        )
        result = self._solver.solve(raise_error=False)
        self._solver.update_settings(check_termination=self._check)
        status = result.info.status
        if status == "interrupted":
            raise KeyboardInterrupt
        # The library keeps the outcome of the last polish, so it counts only where one was asked for.
        polished = self._polish and result.info.status_polish == 1
        # Asked to polish where nothing is in contact, OSQP writes to the terminal.
        self._polishing = self._polishing and not polished
        self._polish = self._polishing and bool(np.abs(result.y).max() > self._pressed)
        return Round(
            np.array(result.x) if status in _STOPS else None,
            _STOPS.get(status, Stop.FAILED),
            f"{status}, eps {eps:.0e}",
            int(result.info.iter),
            claims=status == "solved",
            finish="polish" if polished else "",
        )

    def tolerances(self, eps: float | None) -> Iterator[float]:
        eps = (1000 if self._resumed else 100) * self._task.tol if eps is None else eps
        yield eps
        if self._task.own_defaults:
            if self._polish:
                yield eps
            return
        while eps / 10 >= _TIGHTEST:
            eps /= 10
            yield eps


_STOPS = {
    "solved": Stop.DONE,
    "solved inaccurate": Stop.DONE,
    "maximum iterations reached": Stop.ITERATION_LIMIT,
    "run time limit reached": Stop.TIME_LIMIT,
}


def _reaction(problem: ContactQP, gap: Vector) -> Vector:
    """Return the multipliers R of the constraints that a warm start suggests."""
    reaction = problem.stiffness.matvec(gap) + problem.q
    lower, upper = np.isfinite(problem.lower), np.isfinite(problem.upper)
    return np.clip(reaction, np.where(upper, -np.inf, 0.0), np.where(lower, np.inf, 0.0))
