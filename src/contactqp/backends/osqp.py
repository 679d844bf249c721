"""OSQP: operator splitting (ADMM), called through its own API.

Stellato, Banjac, Goulart, Bemporad and Boyd, *OSQP: an operator splitting solver for quadratic programs*,
Mathematical Programming Computation 12 (2020).
"""

from __future__ import annotations

import time
from functools import partial
from typing import Any, ClassVar

import numpy as np

from ..foundation.checks import Vector, open_interval, positive_number
from ..foundation.progress import run_interruptibly
from ..problem.contact_qp import ContactQP
from .base import Answer, Backend, Stop, Task

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

    def solve(
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
    ) -> Answer:
        """Solve by OSQP.

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
        import osqp
        from scipy import sparse

        open_interval(alpha, 0.0, 2.0, "alpha")
        for name, value in (("rho", rho), ("sigma", sigma), ("check_termination", check_termination)):
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
        if eps is not None:
            eps = positive_number(eps, "eps")
        given_up = False

        def set_up() -> Any:
            solver = osqp.OSQP()
            solver.setup(
                sparse.csc_matrix(sparse.triu(problem.G, format="csc")),
                problem.q.copy(),
                sparse.csc_matrix(sparse.eye_array(problem.size)),
                np.where(problem.supported, 0.0, -np.inf),
                np.full(problem.size, np.inf),
                polishing=False,
                verbose=False,
                warm_starting=True,
                **settings,
            )
            if task.warm_start is not None:
                solver.warm_start(x=task.warm_start, y=-_reaction(problem, task.warm_start))
            return solver

        def resume(solver: Any, eps: float, iterations: int) -> Any:
            if given_up:
                return None
            limits = {"time_limit": min(task.seconds_left, 1e10)}
            solver.update_settings(eps_abs=eps, eps_rel=eps, max_iter=iterations, **limits)
            return solver.solve(raise_error=False)

        def give_up() -> None:
            nonlocal given_up
            given_up = True

        started = time.perf_counter()
        solver = run_interruptibly(set_up, task.progress)
        setup_seconds = time.perf_counter() - started
        usual_iterations, note = _MAX_ITER, ""
        if task.own_defaults:
            shipped = solver.settings
            usual_iterations = int(shipped.max_iter)
            eps = float(shipped.eps_abs) if eps is None else eps
            note = f"OSQP as shipped: eps {eps:g}, rho {shipped.rho:g}, at most {usual_iterations} iterations"
        elif eps is None:
            eps = 100 * task.tol
        budget = usual_iterations if task.max_iter is None else task.max_iter
        gap: Vector | None = None
        findings: list[str] = []
        done, rounds, least, polish_next = 0, 0, np.inf, False
        status, stop = "time limit during set-up", Stop.TIME_LIMIT
        while task.seconds_left > 0:
            task.progress.update(f"{done} iterations")
            rounds += 1
            result = run_interruptibly(partial(resume, solver, eps, budget - done), task.progress, give_up)
            done += int(result.info.iter)
            status = result.info.status
            if status == "interrupted":
                raise KeyboardInterrupt
            stop = _STOPS.get(status, Stop.FAILED)
            if status in _USABLE:
                candidate = np.array(result.x)
                bound = task.bound(candidate)
                # The library keeps the outcome of the last polish, so it counts only where one was asked for.
                if polish_next and result.info.status_polish == 1 and bound > least:
                    findings.append(
                        f"polish made the answer worse: bound {bound:.2g} after, {least:.2g} before (of the gap "
                        "scale); the answer before was kept"
                    )
                if gap is None or bound < least:
                    gap, least = candidate, bound
                # Asked to polish where nothing is in contact, OSQP writes to the terminal. A polish that succeeded and
                # did not satisfy the judge got the contact set wrong in a few nodes; repeated, it would undo what the
                # iteration mends.
                polishing = polishing and result.info.status_polish != 1
                pressed = np.array(result.y) < -1e-6 * np.abs(problem.q).max()
                polish_next = polishing and bool((pressed & (candidate < 1e-6)).any())
            if stop is not Stop.DONE or least <= task.tol:
                break
            if done >= budget:
                stop = Stop.ITERATION_LIMIT
                break
            if task.own_defaults:
                # A second call iterates no further than to the next test for termination, and polishes.
                finished, tighter = rounds > 1 or not polish_next, eps
            else:
                finished, tighter = eps / 10 < _TIGHTEST, eps / 10
            if finished:
                stop = Stop.DONE
                break
            stop, eps = Stop.TIME_LIMIT, tighter
            solver.update_settings(polishing=polish_next)
        return Answer(
            gap=gap,
            stop=stop,
            termination=f"{status}, eps {eps:.0e}",
            iterations=done,
            setup_seconds=setup_seconds,
            solve_seconds=time.perf_counter() - started - setup_seconds,
            note=note,
            findings=tuple(findings),
            claimed_solved=stop is Stop.DONE and status == "solved",
        )


_STOPS = {
    "solved": Stop.DONE,
    "solved inaccurate": Stop.DONE,
    "maximum iterations reached": Stop.ITERATION_LIMIT,
    "run time limit reached": Stop.TIME_LIMIT,
}
_USABLE = frozenset(_STOPS)


def _reaction(problem: ContactQP, gap: Vector) -> Vector:
    """Return the multipliers R of the constraints that a warm start suggests."""
    reaction = problem.stiffness.matvec(gap) + problem.q
    return np.where(problem.supported, np.maximum(reaction, 0.0), 0.0)
