"""OSQP: operator splitting (ADMM), called through its own API.

Stellato, Banjac, Goulart, Bemporad and Boyd, *OSQP: an operator splitting solver for quadratic programs*,
Mathematical Programming Computation 12 (2020).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

import numpy as np

from ..foundation.checks import Vector, positive_number
from ..problem.contact_problem import ContactProblem
from .base import Backend, Need, Stop, Task
from .library import Ask, LibraryState, Outcome, Plan, Reply, Vectors, Workspace
from .matrices import identity, upper_triangle
from .option_checks import Check, Positive, between
from .osqp_interrupts import solved

_OFTEN = 8
"""Iterations between tests for termination where a solve goes on from the load before: few may do."""


class Osqp(Backend):
    """Operator splitting; its tolerance is tightened, and the iteration resumed, until the judge is satisfied."""

    name: ClassVar[str] = "osqp"
    summary: ClassVar[str] = "operator splitting (ADMM)"
    package: ClassVar[str] = "osqp"
    licence: ClassVar[str] = "Apache-2.0"
    has_own_defaults: ClassVar[bool] = True
    does_without: ClassVar[tuple[Need, ...]] = (Need.DEFINITE,)
    practical_size: ClassVar[int | None] = 100_000
    reachable_tol: ClassVar[float | None] = 1e-13

    def prepare(
        self,
        problem: ContactProblem,
        task: Task,
        *,
        rho: Positive = 3.0,
        alpha: Annotated[float, between(0.0, 2.0)] = 1.8,
        sigma: Positive = 1e-6,
        scaling: int = 10,
        adaptive_rho: bool = True,
        check_termination: Annotated[int, Check(positive_number)] = 25,
        polishing: bool = True,
        eps: Positive | None = None,
    ) -> _Prepared:
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
        options: dict[str, Any] = {"alpha": alpha, "rho": rho, "sigma": sigma, "scaling": scaling, "eps": eps}
        options |= {"adaptive_rho": adaptive_rho, "check_termination": check_termination, "polishing": polishing}
        # The program always has a solution: no test for the contrary may fire.
        return _Prepared(Osqp.prepare, problem, task, options | dict.fromkeys(("eps_prim_inf", "eps_dual_inf"), 1e-15))


class _Prepared(LibraryState):
    """OSQP's solver with rows l ≤ ω ≤ u, one for each unknown."""

    imports: ClassVar[str] = "osqp"
    outcomes: ClassVar[Mapping[Any, Outcome]] = {
        "solved": Outcome(Stop.DONE, claims=True),
        "solved inaccurate": Outcome(Stop.DONE),
        "maximum iterations reached": Outcome(Stop.ITERATION_LIMIT),
        "run time limit reached": Outcome(Stop.TIME_LIMIT),
    }
    finish_option: ClassVar[str] = "polishing"
    tightest: ClassVar[float] = 1e-14

    def plan(self, task: Task) -> Plan:
        """See `LibraryState.plan`."""
        if not task.own_defaults:
            return Plan(self.eps or 100 * task.tol, 200_000)
        extension = self.library.OSQP().ext
        own = extension.OSQPSettings()
        extension.osqp_set_default_settings(own)
        eps, rho, most = self.eps or own.eps_abs, self.settings.get("rho", own.rho), task.max_iter or own.max_iter
        return Plan(eps, most, f"OSQP as shipped: eps {eps:g}, rho {rho:g}, at most {most} iterations")

    def set_up(self, ask: Ask, vectors: Vectors) -> Workspace:
        """See `LibraryState.set_up`."""
        solver, matrices = self.library.OSQP(), {"P": upper_triangle(self.problem.G), "A": identity(self.problem.size)}
        solver.setup(**matrices, **vectors, verbose=False, **self.settings)
        return solver

    def start(self, workspace: Workspace, gap: Vector, reaction: Vector) -> None:
        """See `LibraryState.start`."""
        workspace.warm_start(x=gap, y=-reaction)

    def call(self, workspace: Workspace, ask: Ask) -> Reply:
        """See `LibraryState.call`."""
        check = self.settings.get("check_termination", workspace.settings.check_termination)
        limits = {"eps_abs": ask.eps, "eps_rel": ask.eps, "max_iter": ask.iterations, "time_limit": ask.seconds}
        often = min(check, _OFTEN) if ask.resumes else check
        workspace.update_settings(**limits, check_termination=often, polishing=ask.finishes)
        result = solved(workspace)
        info, reaction = result.info, -np.array(result.y)
        gap, polished = np.array(result.x) if info.status in self.outcomes else None, info.status_polish == 1
        return Reply(info.status, gap, int(info.iter), finished="polish" if polished else "", reaction=reaction)
