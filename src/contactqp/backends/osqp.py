"""OSQP: operator splitting (ADMM), called through its own API.

Stellato, Banjac, Goulart, Bemporad and Boyd, *OSQP: an operator splitting solver for quadratic programs*,
Mathematical Programming Computation 12 (2020).
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from typing import Any, ClassVar

import numpy as np

from ..foundation.checks import Vector, open_interval, positive_number
from ..foundation.interrupts import run_interruptibly
from ..foundation.loading import load_modules, working_seconds
from ..problem.contact_qp import ContactQP
from .base import Answer, Backend, State, Stop, Task, as_it_is_now
from .tightening import Round, tightened

_MAX_ITER = 200_000
_TIGHTEST = 1e-14
_NEVER = 1e-15
_FIXED = {"polishing": False, "verbose": False, "warm_starting": True}
_OFTEN = 8
"""Iterations between tests for termination where a solve goes on from the load before: few may do."""


class Osqp(Backend):
    """Operator splitting; its tolerance is tightened, and the iteration resumed, until the judge is satisfied."""

    name: ClassVar[str] = "osqp"
    summary: ClassVar[str] = "operator splitting (ADMM)"
    package: ClassVar[str] = "osqp"
    has_own_defaults: ClassVar[bool] = True
    practical_size: ClassVar[int | None] = 100_000
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
        """Set OSQP up: its factors, the adapted ``rho`` and the iterate are kept from load to load.

        Parameters
        ----------
        problem, task
            See `Backend.solve`. With the library's own defaults it is called once; only where ``polishing`` is asked
            for as well, a second time for that.
        rho, alpha, sigma, scaling, adaptive_rho, check_termination
            OSQP's settings of the same names; the defaults are the fastest of those that
            ``benchmarks/backend_settings.py`` tried. From the second load on, a solve with a warm start tests for
            termination every 8 iterations at least.
        polishing : bool
            Whether to polish from the second round on until it succeeds once; of all rounds' answers the best is
            returned. A polished answer whose bound is above that of the rounds before is a finding. From the second
            load on, a solve with a warm start polishes in the first round already.
        eps : float, optional
            OSQP's first absolute and relative tolerance; by default 100 ``tol``.
        """
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
        return _Workspace(problem, task, settings, polishing, None if eps is None else positive_number(eps, "eps"))


class _Workspace(State):
    """OSQP's solver with rows l ≤ ω ≤ u, one for each unknown."""

    def __init__(
        self, problem: ContactQP, task: Task, settings: dict[str, Any], polishing: bool, eps: float | None
    ) -> None:
        self._problem, self._settings, self._polishing, self._eps = problem, settings, polishing, eps
        self._set_up(problem, task)

    def _set_up(self, problem: ContactQP, task: Task) -> None:
        load_modules("osqp", "scipy.sparse")
        import osqp
        from scipy import sparse

        def work() -> Any:
            matrix = sparse.csc_matrix(sparse.triu(problem.G, format="csc"))
            rows = sparse.csc_matrix(sparse.eye_array(problem.size))
            solver = osqp.OSQP()
            solver.setup(matrix, problem.q.copy(), rows, problem.lower, problem.upper, **_FIXED, **self._settings)
            return solver

        started = working_seconds()
        self._solver = run_interruptibly(work, task.progress)
        shipped = self._solver.settings
        self._shipped = float(shipped.eps_abs), float(shipped.rho), int(shipped.max_iter)
        self._check, self._vectors, self._used = int(shipped.check_termination), _vectors(problem), False
        self._setup_seconds = working_seconds() - started

    def solve(self, q: Vector, task: Task, problem: ContactQP | None = None) -> Answer:
        """See `State.solve`."""
        problem = as_it_is_now(self._problem, q, problem)
        if self._solver is None:
            self._set_up(problem, task)
        # After Ctrl-C the library may still be at work in it, and after a failure its iterate is of no use.
        solver, self._solver = self._solver, None
        resumed = self._start(solver, problem, task)
        first, budget, note = 100 * task.tol, _MAX_ITER, ""
        if task.own_defaults:
            first, rho, budget = self._shipped
        eps = first if self._eps is None else self._eps
        if task.own_defaults:
            note = f"OSQP as shipped: eps {eps:g}, rho {rho:g}, at most {budget} iterations"
        budget = budget if task.max_iter is None else task.max_iter
        rounds = _Rounds(solver, problem, task, self._polishing, resumed)
        answer = tightened(
            task, rounds.call, rounds.tolerances(eps), budget, setup_seconds=self._setup_seconds, note=note
        )
        self._solver = None if answer.stop is Stop.FAILED else solver
        self._setup_seconds, self._used = 0.0, True
        return answer

    def _start(self, solver: Any, problem: ContactQP, task: Task) -> bool:
        """Tell OSQP what has changed and where to start; return whether it goes on from a solve before."""
        vectors = _vectors(problem)
        changed = {name: new.copy() for name, new in vectors.items() if not np.array_equal(new, self._vectors[name])}
        if changed:
            solver.update(**changed)
            self._vectors = vectors
        resumed = self._used and task.warm_start is not None and not task.own_defaults
        solver.update_settings(check_termination=min(self._check, _OFTEN) if resumed else self._check)
        if task.warm_start is not None:
            start = problem.project(task.warm_start)
            solver.warm_start(x=start, y=-_reaction(problem, start))
        elif self._used:
            solver.warm_start(x=np.zeros(problem.size), y=np.zeros(problem.size))
        return resumed


class _Rounds:
    """The calls for one solve, and whether to polish in the next one."""

    def __init__(self, solver: Any, problem: ContactQP, task: Task, polishing: bool, resumed: bool) -> None:
        self._solver, self._problem, self._task, self._resumed = solver, problem, task, resumed
        self._polishing, self._polish = polishing, False

    def tolerances(self, eps: float) -> Iterator[float]:
        """Yield the tolerances of the rounds; with own defaults there is a second one only if it is to polish."""
        yield eps
        if self._task.own_defaults:
            if self._polish:
                yield eps
            return
        while eps / 10 >= _TIGHTEST:
            eps /= 10
            yield eps

    def call(self, eps: float, iterations: int) -> Round:
        """Return what one round finds; where a solve goes on from the load before, its first round polishes."""
        if not self._resumed:
            return self._iterate(eps, iterations)
        self._resumed = False
        rough = self._iterate(10 * eps, iterations)
        if rough.stop is not Stop.DONE or rough.iterations >= iterations:
            return rough
        fine = self._iterate(eps, iterations - rough.iterations)
        return replace(fine, iterations=rough.iterations + fine.iterations)

    def _iterate(self, eps: float, iterations: int) -> Round:
        """Iterate from where the call before has ended, and polish where that is due."""
        limit = min(max(self._task.seconds_left, 1e-6), 1e10)
        self._solver.update_settings(
            eps_abs=eps, eps_rel=eps, max_iter=iterations, time_limit=limit, polishing=self._polish
        )
        result = self._solver.solve(raise_error=False)
        status, gap = result.info.status, np.array(result.x)
        if status == "interrupted" or _took_interrupt():
            raise KeyboardInterrupt
        # The library keeps the outcome of the last polish, so it counts only where one was asked for.
        polished = self._polish and result.info.status_polish == 1
        # A polish that succeeded and did not satisfy the judge got the contact set wrong in a few nodes; repeated, it
        # would undo what the iteration mends.
        self._polishing = self._polishing and not polished
        self._polish = self._polishing and _in_contact(self._problem, gap, np.array(result.y))
        return Round(
            gap if status in _STOPS else None,
            _STOPS.get(status, Stop.FAILED),
            f"{status}, eps {eps:.0e}",
            int(result.info.iter),
            claims=status == "solved",
            finish="polish" if polished else "",
        )


_STOPS = {
    "solved": Stop.DONE,
    "solved inaccurate": Stop.DONE,
    "maximum iterations reached": Stop.ITERATION_LIMIT,
    "run time limit reached": Stop.TIME_LIMIT,
}


@cache
def _own_memory_of_interrupts() -> Callable[[], int]:
    """Return the library's function that tells whether Ctrl-C came in its last call, where it can be reached."""
    load_modules("osqp")
    from osqp import ext_builtin

    try:
        told: Callable[[], int] = ctypes.CDLL(str(ext_builtin.__file__)).osqp_is_interrupted
    except (AttributeError, OSError):
        return lambda: 0
    return told


def _took_interrupt() -> bool:
    """Whether Ctrl-C came, and the library, which catches it while it works, was past its last look for it."""
    return bool(_own_memory_of_interrupts()())


def _vectors(problem: ContactQP) -> dict[str, Vector]:
    return {"q": problem.q, "l": problem.lower, "u": problem.upper}


def _reaction(problem: ContactQP, gap: Vector) -> Vector:
    """Return the reaction R of the bounds that a warm start suggests."""
    return problem.bounds.admissible_reaction(problem.stiffness.matvec(gap) + problem.q)


def _in_contact(problem: ContactQP, gap: Vector, multiplier: Vector) -> bool:
    """Whether a bound presses: asked to polish where none does, OSQP writes to the terminal."""
    least = 1e-6 * np.abs(problem.q).max()
    below = (multiplier < -least) & (gap - problem.lower < 1e-6)
    above = (multiplier > least) & (problem.upper - gap < 1e-6)
    return bool((below | above).any())
