"""OSQP: operator splitting (ADMM), called through its own API.

Stellato, Banjac, Goulart, Bemporad and Boyd, *OSQP: an operator splitting solver for quadratic programs*,
Mathematical Programming Computation 12 (2020).
"""

from __future__ import annotations

import time
from typing import Any, ClassVar

from ..foundation.checks import open_interval, positive_number
from ..foundation.progress import run_interruptibly
from ..problem.contact_qp import ContactQP
from .base import Backend, State, Task

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
    """OSQP's workspace: rows l ≤ ω ≤ u for all unknowns, -inf and inf where there is no bound."""

    def __init__(
        self, problem: ContactQP, task: Task, settings: dict[str, Any], polishing: bool, eps: float | None
    ) -> None:
        self._problem, self._settings, self._polishing, self._eps = problem, settings, polishing, eps
        self._solver: Any = None
        self._set_up(problem, task)

    def _set_up(self, problem: ContactQP, task: Task) -> None:
        import osqp
        from scipy import sparse

        def work() -> Any:
            solver = osqp.OSQP()
            solver.setup(
                sparse.csc_matrix(sparse.triu(problem.G, format="csc")),
                problem.q.copy(),
                sparse.csc_matrix(sparse.eye_array(problem.size)),
                problem.lower,
                problem.upper,
                polishing=False,
                verbose=False,
                warm_starting=True,
                **self._settings,
            )
            return solver

        started = time.perf_counter()
        self._solver = run_interruptibly(work, task.progress)
        self._known = {"q": problem.q, "l": problem.lower, "u": problem.upper}
        self._setup_seconds = time.perf_counter() - started
