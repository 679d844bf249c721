"""Clarabel: a primal-dual interior-point method, called through its own API.

Goulart and Chen, *Clarabel: an interior-point solver for conic programs with quadratic objectives* (2024).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, ClassVar, Literal

import numpy as np

from ..problem.contact_problem import ContactProblem
from .base import Backend, Need, Stop, Task
from .library import Ask, Outcome, Plan, Reply, Setting, Vectors, Workspace
from .matrices import upper_triangle
from .option_checks import Positive
from .rows import StateInRows

_MANY = 10_000


class Clarabel(Backend):
    """Interior point; started again with a tighter tolerance where the judge is not satisfied."""

    name: ClassVar[str] = "clarabel"
    summary: ClassVar[str] = "interior point"
    package: ClassVar[str] = "clarabel"
    licence: ClassVar[str] = "Apache-2.0"
    has_own_defaults: ClassVar[bool] = True
    does_without: ClassVar[tuple[Need, ...]] = (Need.DEFINITE,)
    practical_size: ClassVar[int | None] = 100_000
    reachable_tol: ClassVar[float | None] = 1e-12

    def prepare(
        self,
        problem: ContactProblem,
        task: Task,
        *,
        direct_solve_method: Literal["qdldl", "faer"] = "qdldl",
        equilibrate_enable: bool = True,
        static_regularization_constant: float = 1e-6,
        eps: Positive | None = None,
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
        options = {"eps": eps, "direct_solve_method": direct_solve_method, "equilibrate_enable": equilibrate_enable}
        options |= {"static_regularization_constant": static_regularization_constant, "tol_feas": 1e-10}
        return _Prepared(Clarabel.prepare, problem, task, options)


class _Prepared(StateInRows):
    """Clarabel's solvers by the factor on the objective."""

    imports: ClassVar[str] = "clarabel"
    # Without enough progress for its own test Clarabel may still have an answer that satisfies the judge.
    outcomes: ClassVar[Mapping[Any, Outcome]] = {
        "Solved": Outcome(Stop.DONE, claims=True),
        "AlmostSolved": Outcome(Stop.DONE),
        "InsufficientProgress": Outcome(Stop.DONE, keeps=False),
        "MaxIterations": Outcome(Stop.ITERATION_LIMIT, keeps=False),
        "MaxTime": Outcome(Stop.TIME_LIMIT, keeps=False),
    }
    most_iterations: ClassVar[int | None] = 60
    # The scaling of its data may have been made for other forces.
    starts_again: ClassVar[bool] = True

    def plan(self, task: Task) -> Plan:
        """See `LibraryState.plan`."""
        if not task.own_defaults:
            least = 1e-15 if self.problem.size > _MANY else 1e-14
            return Plan(self.eps or least * max(task.tol / 1e-6, 1.0) ** 2, 200)
        eps, most = self.eps or self.library.DefaultSettings().tol_gap_abs, task.max_iter or 200
        return Plan(eps, most, f"Clarabel as shipped: tolerance {eps:g} of the duality gap, at most {most} iterations")

    def tighter(self, eps: float) -> Iterable[Setting]:
        """See `LibraryState.tighter`."""
        return [setting for setting in (Setting(1e-15), Setting(1e-16, weight=100.0)) if setting.eps < eps]

    def set_up(self, ask: Ask, vectors: Vectors) -> Workspace:
        """See `LibraryState.set_up`."""
        sizes = (self.library.ZeroConeT, ask.form.equations), (self.library.NonnegativeConeT, ask.form.inequalities)
        matrix, cones = upper_triangle(self.problem.G) * ask.weight, [cone(size) for cone, size in sizes if size]
        return self.library.DefaultSolver(matrix, vectors["q"], ask.form.matrix, vectors["b"], cones, self._told(ask))

    def change(self, workspace: Workspace, changed: Vectors) -> bool:
        """See `LibraryState.change`."""
        return workspace.is_data_update_allowed() and super().change(workspace, changed)

    def call(self, workspace: Workspace, ask: Ask) -> Reply:
        """See `LibraryState.call`."""
        workspace.update(settings=self._told(ask))
        workspace.set_termination_callback(lambda info: ask.task.abandoned.is_set())
        result = workspace.solve()
        gap = ask.form.gap(ask.problem, np.array(result.x), np.array(result.z))
        return Reply(str(result.status), gap, int(result.iterations))

    def _told(self, ask: Ask) -> Any:
        """Return all settings for a call."""
        settings = self.library.DefaultSettings()
        limits = {"verbose": False, "max_iter": ask.iterations, "time_limit": ask.seconds}
        for name, value in {**limits, "tol_gap_abs": ask.eps, "tol_gap_rel": ask.eps, **self.settings}.items():
            setattr(settings, name, value)
        return settings
