"""Clarabel: a primal-dual interior-point method, called through its own API.

Goulart and Chen, *Clarabel: an interior-point solver for conic programs with quadratic objectives* (2024).
"""

from __future__ import annotations

from threading import Event
from typing import Any, ClassVar, Literal

import numpy as np

from ..foundation.checks import Mask, Vector, one_of, positive_number
from ..foundation.loading import load_modules, working_seconds
from ..problem.contact_qp import ContactQP
from .base import Answer, Backend, State, Stop, Task, as_it_is_now
from .tightening import Round, tightened

_MAX_ITER = 200
_ROUND_ITER = 60
_MANY = 10_000
_FEASIBILITY = 1e-10
_CLOSE = 0.01
"""Width between two bounds that is none, in tolerances of the gap under the largest force on a node alone."""
_TIGHTER = ((1.0, 1e-15), (100.0, 1e-16))
"""Factor on the objective and tolerance on the duality gap of the rounds after the first."""


class Clarabel(Backend):
    """Interior point; started again with a tighter tolerance where the judge is not satisfied."""

    name: ClassVar[str] = "clarabel"
    summary: ClassVar[str] = "interior point"
    package: ClassVar[str] = "clarabel"
    has_own_defaults: ClassVar[bool] = True
    practical_size: ClassVar[int | None] = 100_000
    reachable_tol: ClassVar[float | None] = 1e-12

    def prepare(
        self,
        problem: ContactQP,
        task: Task,
        *,
        direct_solve_method: Literal["qdldl", "faer"] = "qdldl",
        equilibrate_enable: bool = True,
        static_regularization_constant: float = 1e-6,
        eps: float | None = None,
    ) -> _Prepared:
        """Prepare Clarabel: its matrices, their scaling and the order of elimination are kept from load to load.

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
        if eps is not None:
            positive_number(eps, "eps")
        one_of(direct_solve_method, ("qdldl", "faer"), "direct_solve_method")
        settings = task.passed_on(
            direct_solve_method=direct_solve_method,
            equilibrate_enable=equilibrate_enable,
            static_regularization_constant=static_regularization_constant,
        )
        return _Prepared(problem, task, settings, eps)


class _Prepared(State):
    """Clarabel's matrices, and its solvers by the factor on the objective."""

    def __init__(self, problem: ContactQP, task: Task, settings: dict[str, Any], eps: float | None) -> None:
        load_modules("scipy.sparse")
        from scipy import sparse

        started = working_seconds()
        self._problem, self._settings, self._eps = problem, settings, eps
        self._matrix = sparse.csc_matrix(sparse.triu(problem.G, format="csc"))
        self._rows, self._solvers = _Rows(problem, task.tol), dict[float, tuple[Any, ContactQP]]()
        self._setup_seconds = working_seconds() - started

    def solve(self, q: Vector, task: Task, problem: ContactQP | None = None) -> Answer:
        """See `State.solve`."""
        problem = as_it_is_now(self._problem, q, problem)
        if not self._rows.suit(problem, task.tol):
            self._rows, self._solvers = _Rows(problem, task.tol), {}
        # After Ctrl-C the library may still be at work in them.
        solvers, self._solvers, abandoned = self._solvers, {}, Event()
        statuses = dict[float, str]()

        def call(setting: tuple[float, float], left: int) -> Round:
            started, (weight, eps) = working_seconds(), setting
            iterations = left if task.own_defaults else min(left, _ROUND_ITER)
            kept = weight in solvers and weight not in statuses
            solver = self._solver(solvers, weight, problem, self._all_settings(task, eps, iterations))
            solver.set_termination_callback(lambda info: abandoned.is_set())
            setup_seconds, result = working_seconds() - started, solver.solve()
            statuses[weight] = status = str(result.status)
            if kept and status not in _STOPS and not abandoned.is_set():
                # The scaling of its data was made for other forces.
                del solvers[weight], statuses[weight]
                return call(setting, left)
            stop = _STOPS.get(status, Stop.FAILED)
            return Round(
                gap=self._rows.gap(problem, np.array(result.x), np.array(result.z)),
                stop=Stop.DONE if stop is Stop.ITERATION_LIMIT and iterations < left else stop,
                termination=f"{status}, eps {eps:.0e}",
                iterations=int(result.iterations),
                setup_seconds=setup_seconds,
                claims=status == "Solved",
            )

        first, budget, note = self._first(task), _MAX_ITER if task.max_iter is None else task.max_iter, ""
        schedule = [(1.0, first), *(tighter for tighter in _TIGHTER if tighter[1] < first)]
        if task.own_defaults:
            del schedule[1:]
            note = f"Clarabel as shipped: tolerance {first:g} of the duality gap, at most {budget} iterations"
        seconds, self._setup_seconds = self._setup_seconds, 0.0
        answer = tightened(task, call, schedule, budget, abandoned=abandoned, setup_seconds=seconds, note=note)
        self._solvers = {weight: kept for weight, kept in solvers.items() if statuses.get(weight) in _SOUND}
        return answer

    def _first(self, task: Task) -> float:
        """Return the first tolerance on the duality gap."""
        load_modules("clarabel")
        import clarabel

        if self._eps is not None:
            return self._eps
        if task.own_defaults:
            return float(clarabel.DefaultSettings().tol_gap_abs)
        return (1e-15 if self._problem.size > _MANY else 1e-14) * max(task.tol / 1e-6, 1.0) ** 2

    def _all_settings(self, task: Task, eps: float, iterations: int) -> Any:
        load_modules("clarabel")
        import clarabel

        settings = clarabel.DefaultSettings()
        settings.verbose, settings.max_iter, settings.time_limit = False, iterations, min(task.seconds_left, 1e10)
        settings.tol_gap_abs = settings.tol_gap_rel = eps
        if not task.own_defaults:
            settings.tol_feas = _FEASIBILITY
        for name, value in self._settings.items():
            setattr(settings, name, value)
        return settings

    def _solver(
        self, solvers: dict[float, tuple[Any, ContactQP]], weight: float, problem: ContactQP, settings: Any
    ) -> Any:
        """Return a solver of the problem with its objective times ``weight``: one that is known, with new vectors."""
        load_modules("clarabel")
        import clarabel

        forces, limits = problem.q * weight, self._rows.limits(problem)
        solver, solved = solvers.get(weight, (None, None))
        if solver is not None and solver.is_data_update_allowed():
            solver.update(settings=settings, **({} if solved is problem else {"q": forces, "b": limits}))
        else:
            data = self._matrix * weight, forces, self._rows.matrix, limits, self._rows.cones
            solver = clarabel.DefaultSolver(*data, settings)
        solvers[weight] = solver, problem
        return solver


class _Rows:
    """Rows -ω ≤ -l and ω ≤ u where there is such a bound; where both are close, an equation in their place."""

    def __init__(self, problem: ContactQP, tol: float) -> None:
        load_modules("clarabel", "scipy.sparse")
        import clarabel
        from scipy import sparse

        self._close = _close(problem, tol)
        masks = self._close, problem.supported & ~self._close, np.isfinite(problem.upper) & ~self._close
        self._equal, self._below, self._above = (np.flatnonzero(mask) for mask in masks)
        columns = np.concatenate([self._equal, self._below, self._above])
        signs = np.repeat([1.0, -1.0, 1.0], [self._equal.size, self._below.size, self._above.size])
        places = np.arange(columns.size), columns
        self.matrix = sparse.csc_matrix(sparse.csc_array((signs, places), shape=(columns.size, problem.size)))
        sizes = (clarabel.ZeroConeT, self._equal.size), (clarabel.NonnegativeConeT, self._below.size + self._above.size)
        self.cones = [cone(size) for cone, size in sizes if size]

    def suit(self, problem: ContactQP, tol: float) -> bool:
        """Whether these are the rows of another problem with bounds of the same kinds."""
        return np.array_equal(_close(problem, tol), self._close)

    def limits(self, problem: ContactQP) -> Vector:
        """Return the rows' right-hand side."""
        middle = 0.5 * (problem.lower[self._equal] + problem.upper[self._equal])
        return np.concatenate([middle, 0.0 - problem.lower[self._below], problem.upper[self._above]])

    def gap(self, problem: ContactQP, solution: Vector, multiplier: Vector) -> Vector:
        """Return Clarabel's solution, at an equation the bound that its multiplier tells."""
        equal = self._equal
        # The multiplier of an equation is -R, and R >= 0 at the lower bound.
        solution[equal] = np.where(multiplier[: equal.size] <= 0, problem.lower[equal], problem.upper[equal])
        return solution


def _close(problem: ContactQP, tol: float) -> Mask:
    """Where bounds are closer than the tolerance tells: an interior point needs an interior."""
    scale = float(np.abs(problem.q / problem.stiffness.diagonal()).max())
    return problem.upper - problem.lower <= _CLOSE * tol * scale


_SOUND = "Solved", "AlmostSolved", None
"""What the last solve may have ended with, if it took part, for a solver to be used again."""

# Without enough progress for its own test Clarabel may still have an answer that satisfies the judge.
_STOPS = {
    "Solved": Stop.DONE,
    "AlmostSolved": Stop.DONE,
    "InsufficientProgress": Stop.DONE,
    "MaxIterations": Stop.ITERATION_LIMIT,
    "MaxTime": Stop.TIME_LIMIT,
}
