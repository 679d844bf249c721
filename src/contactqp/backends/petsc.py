"""PETSc: SNESVI, Newton steps in the space of the unknowns that no bound holds, with multigrid (PCMG, GAMG).

Benson and Munson, *Flexible complementarity solvers for large-scale applications*, Optimization Methods and Software 21
(2006); Balay and others, *PETSc/TAO users manual*, Argonne National Laboratory.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import Annotated, Any, ClassVar

import numpy as np

from ..foundation.checks import Vector, integer_at_least
from ..methods.factors import DIRECT_SIZE
from ..problem.contact_problem import ContactProblem
from .base import Backend, Stop, Task
from .library import Ask, Outcome, Plan, Reply, Vectors
from .option_checks import Check, PlainSettings, Positive
from .petsc_place import INSTALL, interpreter, options, placed
from .petsc_unused import StateWithUnusedOptions
from .processes import LostProcessError, Placed


class Petsc(Backend):
    """PETSc's SNESVI, called by a worker of the interpreter that has petsc4py."""

    name: ClassVar[str] = "petsc"
    summary: ClassVar[str] = "reduced-space Newton steps (SNESVI) with multigrid"
    package: ClassVar[str] = "petsc4py"
    install: ClassVar[str] = INSTALL
    licence: ClassVar[str] = "BSD-2-Clause"
    iteration_unit: ClassVar[str] = "step"
    has_own_defaults: ClassVar[bool] = True
    practical_size: ClassVar[int | None] = 100_000
    reachable_tol: ClassVar[float | None] = 1e-14

    def prepare(
        self,
        problem: ContactProblem,
        task: Task,
        *,
        ranks: Annotated[int, Check(lambda value, name: integer_at_least(value, 1, name))] = 1,
        petsc_options: PlainSettings | None = None,
        history: bool = False,
        eps: Positive | None = None,
    ) -> _Prepared:
        """Hand the matrix over to PETSc; it is kept from load to load, and each solve sets its linear solvers up anew.

        Parameters
        ----------
        problem, task
            See `Backend.solve`. Without a warm start, more than some thousand unknowns start from the solution of
            coarser problems, since else the contact set would move by a layer of nodes in each step.
            With the library's own defaults it is called once, with the linear solver and the tolerances that PETSc is
            shipped with.
        ranks : int
            Processes that share the work, started by ``mpiexec``.
        petsc_options : mapping of str to str, number or None, optional
            PETSc's own options, by their names without a dash: ``{"pc_type": "hypre", "snes_vi_monitor": None}``. They
            override the package's: ``{"pc_type": "gamg"}`` takes algebraic multigrid on a lattice, too. What they have
            PETSc print goes to standard error. Of those that nothing in PETSc has asked for, a warning tells: they are
            misspelt, or belong to what is not used.
        history : bool
            Whether to record of every step: "active" (nodes that a bound holds at its end), "changed" (nodes that it
            has moved from one set to another) and "residual" (Euclidean norm over the others, dimensionless).
        eps : float, optional
            How far the residual is to fall at first, relative to the forces; by default 0.1 ``tol``.
        """
        given = {"ranks": ranks, "petsc_options": petsc_options, "history": history, "eps": eps}
        return _Prepared(Petsc.prepare, problem, task, given)

    def version(self) -> str | None:
        """See `Backend.version`; the interpreters of this machine are asked."""
        found = interpreter()
        return None if found is None else found.version


class _Prepared(StateWithUnusedOptions):
    """The matrix in PETSc."""

    imports: ClassVar[str] = "numpy"  # PETSc is loaded where it is
    outcomes: ClassVar[Mapping[Any, Outcome]] = {
        **StateWithUnusedOptions.outcomes,
        "converged": Outcome(Stop.DONE, claims=True),
        "diverged": Outcome(Stop.DONE),  # where rounding stops it, the answer may be good enough
        "DIVERGED_MAX_IT": Outcome(Stop.ITERATION_LIMIT),
    }
    tightest: ClassVar[float] = 1e-15
    starts_again: ClassVar[bool] = True

    def plan(self, task: Task) -> Plan:
        """See `LibraryState.plan`."""
        if task.own_defaults:
            return Plan(self.eps or np.inf, 50, "SNESVI as PETSc is shipped: at most 50 steps, rtol 1e-8")
        return Plan(self.eps or max(0.1 * task.tol, 100 * self.tightest), 1000)

    def set_up(self, ask: Ask, vectors: Vectors) -> Placed:
        """See `LibraryState.set_up`."""
        ranks = self.settings.get("ranks", 1)
        own = {} if ask.task.own_defaults else options(self.problem, ranks)
        return placed(self.problem, ranks, own | dict(self.settings.get("petsc_options") or {}))

    def start(self, workspace: Placed, gap: Vector, reaction: Vector) -> None:
        """See `LibraryState.start`."""
        with suppress(LostProcessError):  # the call that follows tells of it
            workspace.call("start", {"gap": gap} if gap.any() else {}, {})

    def question(self, ask: Ask) -> tuple[Any, ...]:
        """See `PlacedState.question`."""
        task, problem = ask.task, ask.problem
        told: dict[str, Any] = {"steps": ask.iterations, "history": self.settings.get("history", False)}
        told["eps"] = ask.eps if np.isfinite(ask.eps) else None
        told["seconds"] = None if task.time_limit is None else ask.seconds
        told["coarse"] = problem.size > DIRECT_SIZE and not task.own_defaults
        return {"q": problem.q, "l": problem.lower, "u": problem.upper}, told

    def reply(self, ask: Ask, found: Any) -> Reply:
        """See `PlacedState.reply`."""
        gap, facts = found
        self.unused, word = set(facts["unused"]) & set(self.settings.get("petsc_options") or {}), facts["word"]
        status = word if word in self.outcomes else "converged" if word.startswith("CONVERGED") else "diverged"
        eps = f", eps {ask.eps:.0e}" if np.isfinite(ask.eps) else ""
        history = {name: np.array(values) for name, values in facts["history"].items()}
        return Reply(status, gap, facts["steps"], f"{word}{eps}", history=history)
