"""Clarabel: a primal-dual interior-point method, called through its own API.

Goulart and Chen, *Clarabel: an interior-point solver for conic programs with quadratic objectives* (2024).
"""

from __future__ import annotations

import time
from functools import partial
from typing import Any, ClassVar, Literal

import numpy as np

from ..foundation.checks import Vector, one_of, positive_number
from ..foundation.progress import run_interruptibly
from ..problem.contact_qp import ContactQP
from .base import Answer, Backend, Stop, Task

_MAX_ITER = 200
_ROUND_ITER = 60
_MANY = 10_000
_FEASIBILITY = 1e-10
_CLOSE = 0.01
"""Width between two bounds that is none, in tolerances of the gap under the largest force on a node alone."""
_ROUNDS = ((1.0, None), (1.0, 1e-15), (100.0, 1e-16))
"""Factor on the objective and tolerance on the duality gap of the rounds, None for the first tolerance."""


class Clarabel(Backend):
    """Interior point; started again with a tighter tolerance where the judge is not satisfied."""

    name: ClassVar[str] = "clarabel"
    summary: ClassVar[str] = "interior point"
    package: ClassVar[str] = "clarabel"
    has_own_defaults: ClassVar[bool] = True
    reachable_tol: ClassVar[float | None] = 1e-12

    def solve(
        self,
        problem: ContactQP,
        task: Task,
        *,
        direct_solve_method: Literal["qdldl", "faer"] = "qdldl",
        equilibrate_enable: bool = True,
        static_regularization_constant: float = 1e-6,
        eps: float | None = None,
    ) -> Answer:
        """Solve by Clarabel.

        Parameters
        ----------
        problem, task
            See `Backend.solve`; the warm start is not used. With the library's own defaults there is one round.
        direct_solve_method, equilibrate_enable, static_regularization_constant
            Clarabel's settings of the same names; the defaults are the fastest of those that
            ``benchmarks/backend_settings.py`` tried.
        eps : float, optional
            Clarabel's first tolerance on the duality gap; by default 0.01 tol² (0.001 tol² for more than 10,000
            unknowns, whose certificate asks for more), but no less than at tol = 1e-6, where the rounding of the
            objective begins. Its square root counts: where gap and reaction are both small, an interior point has
            ω_i R_i ≈ eps and leaves √eps of both.
        """
        import clarabel
        from scipy import sparse

        if eps is not None:
            positive_number(eps, "eps")
        one_of(direct_solve_method, ("qdldl", "faer"), "direct_solve_method")
        budget = _MAX_ITER if task.max_iter is None else task.max_iter
        finest = 1e-15 if problem.size > _MANY else 1e-14
        first = finest * max(task.tol / 1e-6, 1.0) ** 2 if eps is None else eps
        abandoned = False
        # An interior point needs an interior: bounds that are closer than the tolerance tells are an equation.
        width_scale = float(np.abs(problem.q / problem.G.diagonal()).max())
        fixed = problem.upper - problem.lower <= _CLOSE * task.tol * width_scale
        equal = np.flatnonzero(fixed)

        def set_up(weight: float, eps: float, iterations: int) -> Any:
            settings = clarabel.DefaultSettings()
            settings.verbose = False
            settings.max_iter = iterations
            settings.time_limit = min(task.seconds_left, 1e10)
            passed_on = task.passed_on(
                direct_solve_method=direct_solve_method,
                equilibrate_enable=equilibrate_enable,
                static_regularization_constant=static_regularization_constant,
                eps=eps,
            )
            if "eps" in passed_on:
                settings.tol_gap_abs = settings.tol_gap_rel = passed_on.pop("eps")
            if not task.own_defaults:
                settings.tol_feas = _FEASIBILITY
            for name, value in passed_on.items():
                setattr(settings, name, value)
            below, above = (
                np.flatnonzero(problem.supported & ~fixed),
                np.flatnonzero(np.isfinite(problem.upper) & ~fixed),
            )
            columns = np.concatenate([equal, below, above])
            signs = np.concatenate([np.ones(equal.size), np.full(below.size, -1.0), np.ones(above.size)])
            middle = 0.5 * (problem.lower[equal] + problem.upper[equal])
            limits = np.concatenate([middle, -problem.lower[below], problem.upper[above]])
            held = sparse.csc_array((signs, (np.arange(columns.size), columns)), shape=(columns.size, problem.size))
            sizes = (clarabel.ZeroConeT, equal.size), (clarabel.NonnegativeConeT, below.size + above.size)
            cones = [cone(size) for cone, size in sizes if size]
            solver = clarabel.DefaultSolver(
                sparse.csc_matrix(sparse.triu(problem.G, format="csc")) * weight,
                problem.q * weight,
                sparse.csc_matrix(held),
                limits + 0.0,
                cones,
                settings,
            )
            solver.set_termination_callback(lambda info: abandoned)
            return solver

        def work(weight: float, eps: float, iterations: int) -> tuple[Vector, str, int, float]:
            started = time.perf_counter()
            solver = set_up(weight, eps, iterations)
            setup_seconds = time.perf_counter() - started
            result = solver.solve()
            gap = np.array(result.x)
            # The multiplier of an equation is -R, and R >= 0 at the lower bound.
            gap[equal] = np.where(np.array(result.z)[: equal.size] <= 0, problem.lower[equal], problem.upper[equal])
            return gap, str(result.status), int(result.iterations), setup_seconds

        def abandon() -> None:
            nonlocal abandoned
            abandoned = True

        started = time.perf_counter()
        done, setup_seconds = 0, 0.0
        gap: Vector | None = None
        least = np.inf
        for weight, tolerance in _ROUNDS[:1] if task.own_defaults else _ROUNDS:
            eps = first if tolerance is None else tolerance
            if tolerance is not None and eps >= first:
                continue
            call = partial(work, weight, eps, budget if task.own_defaults else min(budget - done, _ROUND_ITER))
            candidate, status, iterations, setup = run_interruptibly(call, task.progress, abandon)
            done += iterations
            setup_seconds += setup
            stop = _STOPS.get(status, Stop.FAILED)
            bound = task.bound(candidate)
            if gap is None or bound < least:
                gap, least = candidate, bound
            if least <= task.tol:
                stop = Stop.DONE
                break
            if stop in (Stop.FAILED, Stop.TIME_LIMIT):
                break
            if task.seconds_left <= 0:
                stop = Stop.TIME_LIMIT
                break
            if done >= budget:
                stop = Stop.ITERATION_LIMIT
                break
            stop = Stop.DONE
        note = ""
        if task.own_defaults:
            eps = eps if "eps" in task.given else float(clarabel.DefaultSettings().tol_gap_abs)
            note = f"Clarabel as shipped: tolerance {eps:g} of the duality gap, at most {budget} iterations"
        return Answer(
            gap=gap,
            stop=stop,
            termination=f"{status}, eps {eps:.0e}",
            iterations=done,
            setup_seconds=setup_seconds,
            solve_seconds=time.perf_counter() - started - setup_seconds,
            note=note,
            claimed_solved=stop is Stop.DONE and status == "Solved",
        )


# Without enough progress for its own test Clarabel may still have an answer that satisfies the judge.
_STOPS = {
    "Solved": Stop.DONE,
    "AlmostSolved": Stop.DONE,
    "InsufficientProgress": Stop.DONE,
    "MaxIterations": Stop.ITERATION_LIMIT,
    "MaxTime": Stop.TIME_LIMIT,
}
