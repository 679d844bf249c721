"""The contact multigrid for lattices, `contactqp.methods.multigrid`."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar, Protocol

import numpy as np

from ..foundation.checks import Vector, integer_at_least
from ..foundation.loading import load_modules, working_seconds
from ..foundation.threads import Team
from ..problem.contact_problem import ContactProblem
from .active_set import iterate, prepared
from .base import Answer, Backend, Need, State, Stop, Task, as_it_is_now

if TYPE_CHECKING:
    from ..methods.multigrid.contact import ContactMultigrid

MAX_CYCLES = 200
_PATIENCE = 5
"""Cycles without gain, at the level of rounding errors, after which the method gives up."""

_PATIENCE_WHERE_ARMS_DIFFER = 2
_SETTLED = 0.01
"""So many such cycles suffice where arms differ, if the gap changes by less than this part of the tolerance: the
forces of stiff arms, rounded, say little, and the judge has a sharper certificate."""

_ROUNDING = "what is left are rounding errors"

_STALLING, _STALLING_WHERE_ARMS_DIFFER = 12, 24
"""Cycles in which the bound is expected to fall by a factor of ten at least."""

_WORTH_ASSEMBLING = 1_000_000
"""Nodes up to which active sets may go on: they assemble the matrix."""


class Multigrid(Backend):
    """Truncated nonsmooth Newton multigrid, started by nested iteration."""

    name: ClassVar[str] = "multigrid"
    summary: ClassVar[str] = "contact multigrid (own kernels)"
    package: ClassVar[str] = "numba"
    licence: ClassVar[str] = "BSD-3-Clause"
    iteration_unit: ClassVar[str] = "cycle"
    needs: ClassVar[Collection[Need]] = (Need.LATTICE,)
    reachable_tol: ClassVar[float | None] = 1e-13

    def prepare(
        self, problem: ContactProblem, task: Task, *, threads: int | None = None, history: bool = False
    ) -> _Prepared:
        """Prepare contact multigrid: its hierarchy is kept from load to load.

        Parameters
        ----------
        problem, task
            See `Backend.solve`. Without a warm start it works its way up from the coarsest lattice.
        threads : int, optional
            By default as many as cores.
        history : bool
            Whether to record of every cycle: "bound" (an estimate of the error's bound after its sweeps, relative to
            the error scale), "contraction" (of that), "changes" (nodes that came into contact or left it), "cut" (nodes
            at which a bound cut the correction short), "damping" (factor of the line search), "energy" (½ωᵀGω + qᵀω at
            its end, dimensionless) and "work" (sweeps over the lattice so far, or as much). Where active sets go on
            because it stalls, it ends there, and ``iterations`` counts their steps too.
        """
        if threads is not None:
            threads = integer_at_least(threads, 1, "threads")
        return _Prepared(problem, task, threads, history)


class _Prepared(State):
    """The lattice with its arms, and the problems on it, whose iteration keeps its hierarchy."""

    def __init__(self, problem: ContactProblem, task: Task, threads: int | None, history: bool) -> None:
        stencil = problem.stencil
        assert stencil is not None
        load_modules("contactqp.methods.multigrid.nested", kernels="multigrid")
        from ..methods.multigrid.arms import arms_of
        from ..methods.multigrid.nested import Succession
        from ..methods.multigrid.weighted_hierarchy import load_kernels

        self._arms = arms_of(stencil, problem.layout)
        load_kernels(self._arms)
        self._problem, self._threads, self._history = problem, threads, history
        self._problems = Succession(self._arms, keeps=task.keeps)

    def solve(self, q: Vector, task: Task, problem: ContactProblem | None = None) -> Answer:
        """See `State.solve`."""
        return self.solve_problem(as_it_is_now(self._problem, q, problem), task)

    def solve_problem(self, problem: ContactProblem, task: Task) -> Answer:
        """See `State.solve_problem`."""
        started = working_seconds()
        arms = self._arms
        budget = MAX_CYCLES if task.max_iter is None else task.max_iter
        log = CycleLog(arms.reach)
        outcome: tuple[Stop, str] | None = None
        with Team(self._threads) as team:
            solver = self._problems.begun(
                problem,
                team,
                task.warm_start,
                unit=float(np.max(task.length_unit)),
                predicted=task.predicted,
                resumes=task.resumes,
                report=lambda nodes: task.progress.update(f"nested iteration, {nodes} nodes"),
            )
            setup_seconds = working_seconds() - started
            while outcome is None:
                solver.relax()
                log.add(solver.estimate)
                task.progress.update(f"cycle {log.cycles}, bound about {log.bounds[-1]:.0e}")
                outcome = log.outcome(solver, task, budget)
                if outcome is None:
                    solver.correct()
                if self._history:
                    log.record(solver)
        stop, why = outcome
        contraction = f"last contraction {log.contraction:.2f}"
        answer = Answer(
            gap=arms.layout.vector(solver.omega) if log.judged is None else log.judged,
            stop=stop,
            termination=f"{why} after {log.cycles} cycles, {solver.work:.0f} work units, {contraction}",
            iterations=log.cycles,
            setup_seconds=setup_seconds,
            solve_seconds=working_seconds() - started - setup_seconds,
            history=log.columns() if self._history else {},
            claimed_solved=stop is Stop.DONE and why.startswith("certified"),
        )
        return _handed_over(answer, problem, task, budget) if stop is Stop.FAILED else answer


def _handed_over(answer: Answer, problem: ContactProblem, task: Task, budget: int) -> Answer:
    """Go on by active sets: arms that jump by orders of magnitude from node to node defeat a geometric hierarchy."""
    started = working_seconds()
    solver = prepared(problem)
    assert answer.gap is not None
    solver.start_from(answer.gap)
    preparing_seconds = working_seconds() - started
    went_on = iterate(solver, problem, task, budget - answer.iterations)
    return replace(
        went_on,
        note=f"multigrid stalled after {answer.iterations} cycles, active sets went on",
        iterations=answer.iterations + went_on.iterations,
        setup_seconds=answer.setup_seconds + preparing_seconds,
        solve_seconds=answer.solve_seconds + went_on.setup_seconds + went_on.solve_seconds,
        history=answer.history,
    )


class Asked(Protocol):
    """What a `CycleLog` asks of a `Task`."""

    @property
    def tol(self) -> float: ...  # noqa: D102
    @property
    def seconds_left(self) -> float: ...  # noqa: D102
    def bound(self, gap: Vector) -> float: ...  # noqa: D102


class CycleLog:
    """The estimated bounds of the cycles so far, when to stop, and what is recorded on request.

    Parameters
    ----------
    reach : float
        Of the lattice, see `contactqp.methods.multigrid.arms.Arms`.

    Attributes
    ----------
    bounds : list of float
        Estimated by the forces out of balance, relative to the dimensionless unit of length.
    judged : array, shape (n,), or None
        The gap that the judge was asked about after the last cycle.
    """

    _columns = ("bound", "contraction", "changes", "cut", "damping", "energy", "work")

    def __init__(self, reach: float) -> None:
        self._reach = reach
        self._idle = 0
        self._records: list[tuple[float, ...]] = []
        self.bounds: list[float] = []
        self.judged: Vector | None = None

    @property
    def cycles(self) -> int:
        """Cycles so far."""
        return len(self.bounds)

    @property
    def contraction(self) -> float:
        """Last bound over the one before."""
        return self.bounds[-1] / self.bounds[-2] if self.cycles > 1 and self.bounds[-2] > 0 else 0.0

    def add(self, estimate: float) -> None:
        """Take note of the force that a cycle's sweeps left out of balance."""
        self.bounds.append(estimate * self._reach)

    def outcome(self, solver: ContactMultigrid, task: Asked, budget: int) -> tuple[Stop, str] | None:
        """Return why to stop, None to go on, and FAILED where another method has to go on."""
        self.judged = None
        if self.bounds[-1] <= task.tol:
            solver.give_up_spare()
            self.judged = solver.lattice.layout.vector(solver.omega)
            bound = task.bound(self.judged)
            if bound <= task.tol:
                return Stop.DONE, f"certified bound {bound:.1e}"
        gained = self.bounds[-1] <= 0.9 * min(self.bounds[:-1], default=np.inf)
        self._idle = self._idle + 1 if not gained and solver.estimate <= solver.rest() else 0
        if task.seconds_left <= 0:
            return Stop.TIME_LIMIT, "time limit"
        if self.cycles == budget:
            return Stop.ITERATION_LIMIT, "cycle limit"
        settled = solver.lattice.varying and self._idle >= _PATIENCE_WHERE_ARMS_DIFFER
        if settled and solver.last_step() <= _SETTLED * task.tol:
            return Stop.DONE, _ROUNDING
        if self._idle == _PATIENCE:
            # Where arms differ much, what is rounding for the stiff ones may be an error for the soft.
            return self._hand_over(solver, solver.lattice.varying, _ROUNDING)
        window = _STALLING_WHERE_ARMS_DIFFER if solver.lattice.varying else _STALLING
        lately, before = self.bounds[-window:], self.bounds[:-window]
        if not self._idle and before and min(lately) > 0.1 * min(before):
            return self._hand_over(solver, True, "stalled")
        return None

    def _hand_over(self, solver: ContactMultigrid, useful: bool, why: str) -> tuple[Stop, str]:
        affordable = solver.lattice.size <= _WORTH_ASSEMBLING
        return (Stop.FAILED if useful and affordable else Stop.DONE), why

    def record(self, solver: ContactMultigrid) -> None:
        """Keep a row of the history."""
        numbers = (solver.changes, solver.cut, solver.damping, solver.energy(), solver.work)
        self._records.append((self.bounds[-1], self.contraction, *(float(number) for number in numbers)))

    def columns(self) -> dict[str, Vector]:
        """Return the history by name."""
        return dict(zip(self._columns, np.array(self._records).T, strict=True))
