"""The primal-dual active set method for sparse matrices, `contactqp.methods.active_set`.

A matrix that is not symmetric is left to its plain form, Howard's policy iteration.
"""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

import numpy as np

from ..algebra.band import Band
from ..algebra.narrow_band import stiff_band
from ..foundation.checks import Vector
from ..foundation.loading import load_modules, working_seconds
from ..foundation.threads import Team
from ..methods.active_set.cases import CaseSolver
from ..methods.active_set.iteration import ActiveSets
from ..methods.active_set.narrow import NarrowActiveSet
from ..methods.active_set.policy import PolicyIteration
from ..methods.active_set.renumbered import Renumbered
from ..methods.factors import DIRECT_SIZE
from ..problem.contact_problem import ContactProblem
from ..problem.load_cases import LoadCases
from .base import Answer, Backend, CaseAnswers, Need, State, Stop, Task, as_it_is_now

_MAX_STEPS = 500
_AT_REST = "nothing moves any more"
_LOOK_EVERY = 20
"""Steps after which the judge is asked: a set may move by rounding errors for ever."""


class ActiveSetBackend(Backend):
    """Primal-dual active sets: exact once the contact set is found, by factorisation or algebraic multigrid."""

    name: ClassVar[str] = "active-set"
    summary: ClassVar[str] = "primal-dual active sets, exact finish"
    package: ClassVar[str] = "scipy"
    licence: ClassVar[str] = "BSD-3-Clause"
    iteration_unit: ClassVar[str] = "step"
    practical_size: ClassVar[int | None] = 2_000_000
    reachable_tol: ClassVar[float | None] = 1e-14
    does_without: ClassVar[tuple[Need, ...]] = (Need.SYMMETRIC, Need.DEFINITE)

    def prepare(self, problem: ContactProblem, task: Task, *, history: bool = False) -> _Prepared:
        """Prepare active sets: the hierarchy or the factors of the last free nodes are kept from load to load.

        Parameters
        ----------
        problem, task
            See `Backend.solve`. Without a warm start it starts from ω = 0; with more than some thousand unknowns it
            works its way up from a coarse problem: that of a coarser lattice, if the matrix is recognised as a
            lattice's, numbered row by row, and else an algebraic one.
        history : bool
            Whether to record of every step: "exchanged" (nodes that changed sides) and "energy" (½ωᵀGω + qᵀω at its
            end, dimensionless; nan for a matrix that is not symmetric).
        """
        return _Prepared(problem, task, history)


class _Prepared(State):
    """The iteration of the last solve."""

    def __init__(self, problem: ContactProblem, task: Task, history: bool) -> None:
        started = working_seconds()
        self._problem, self._history, self._solver = problem, history, prepared(problem)
        self._setup_seconds = working_seconds() - started
        self._cases: CaseSolver | None = None

    def solve(self, q: Vector, task: Task, problem: ContactProblem | None = None) -> Answer:
        """See `State.solve`."""
        started = working_seconds()
        problem = as_it_is_now(self._problem, q, problem)
        self._solver.restart(q, problem.lower, problem.bounds.upper_if_any)
        _start(self._solver, problem, task)
        setup_seconds, self._setup_seconds = working_seconds() - started + self._setup_seconds, 0.0
        budget = _MAX_STEPS if task.max_iter is None else task.max_iter
        answer = iterate(self._solver, problem, task, budget, self._history)
        return replace(answer, setup_seconds=answer.setup_seconds + setup_seconds)

    def answers(self, cases: LoadCases, asked: int) -> CaseAnswers | None:
        """See `State.answers`."""
        started = working_seconds()
        if self._cases is None and not self._history and self._problem.symmetric and self._problem.kernel is None:
            self._cases = CaseSolver.of(self._problem.G, len(cases.q), asked)
        if self._cases is None or not self._cases.affordable:
            return None
        gaps, steps = self._cases.solve(cases.q, cases.lower, cases.upper)
        return CaseAnswers(gaps, steps, _AT_REST, ActiveSetBackend.iteration_unit, working_seconds() - started)


def _start(solver: ActiveSets, problem: ContactProblem, task: Task) -> None:
    """Set ω to the warm start, or start from coarser problems."""
    if task.warm_start is not None:
        solver.start_from(problem.project(task.warm_start))
        return
    alone = problem.size <= DIRECT_SIZE or problem.kernel is not None
    start_on_lattice = None if alone else _lattice_start(problem, task)
    if start_on_lattice is None:
        solver.start(task.progress.update)
    else:
        solver.start_from(start_on_lattice)


def prepared(problem: ContactProblem) -> ActiveSets:
    """Return the iteration at ω = 0."""
    bounds = problem.lower, problem.bounds.upper_if_any
    if not problem.symmetric:
        return PolicyIteration(problem.G, problem.q, *bounds)
    if not problem.is_z_matrix and problem.kernel is None:
        band = Band(problem.G)
        stiff = stiff_band(band)
        if stiff is not None:
            return NarrowActiveSet(band, stiff, problem.q, *bounds)
    return Renumbered(problem.facts.ordered, problem.q, *bounds, problem.is_z_matrix, problem.kernel)


def _units(problem: ContactProblem, task: Task) -> Vector:
    return np.broadcast_to(np.asarray(task.length_unit, dtype=np.float64), (problem.size,))


def _lattice_start(problem: ContactProblem, task: Task) -> Vector | None:
    """Return a gap by multigrid if the matrix is that of a lattice, whether it was given so or not; else None."""
    units = _units(problem, task)
    relative = units / units.max()
    stencil = problem.stiffness.in_units(1 / relative).recognised_lattice()
    if stencil is None:
        return None
    layout = problem.bounds.layout(stencil)
    load_modules("contactqp.methods.multigrid.nested", kernels="multigrid")
    from ..methods.multigrid.arms import arms_of
    from ..methods.multigrid.contact import NO_LIMITS
    from ..methods.multigrid.nested import nearly_solved
    from ..methods.multigrid.weighted_hierarchy import load_kernels

    lattice = arms_of(stencil, layout)
    load_kernels(lattice)
    with Team() as team:
        limits = NO_LIMITS
        if not problem.bounds.standard:
            limits = lattice.layout.grid(problem.lower * relative), lattice.layout.grid(problem.upper * relative)
        gap = nearly_solved(
            lattice, lattice.layout.grid(problem.q / relative), team, lambda: task.seconds_left <= 0, limits
        )
    return np.asarray(lattice.layout.vector(gap) / relative)


def iterate(solver: ActiveSets, problem: ContactProblem, task: Task, budget: int, history: bool = False) -> Answer:
    """Go on until the contact set rests and the equations of the free nodes are solved."""
    started = working_seconds()
    stop, why, steps = Stop.ITERATION_LIMIT, "step limit", 0
    records: list[tuple[float, float]] = []
    while stop is Stop.ITERATION_LIMIT and steps < budget:
        try:
            step = solver.step()
        except np.linalg.LinAlgError as error:
            stop, why = Stop.FAILED, str(error)
            break
        steps += 1
        task.progress.update(f"step {steps}, {step.exchanged} nodes changed sides")
        if history:
            gap = solver.feasible()
            records.append((float(step.exchanged), float(problem.energy(gap, problem.stiffness.matvec(gap)))))
        if step.finished:
            stop, why = Stop.DONE, _AT_REST
        elif steps % _LOOK_EVERY == 0 and task.accepts(solver.feasible()):
            stop, why = Stop.DONE, "certified, though nodes without gap and reaction still change sides,"
        elif task.seconds_left <= 0:
            stop, why = Stop.TIME_LIMIT, "time limit"
    columns, gap = np.array(records).reshape(-1, 2).T, solver.feasible()
    return Answer(
        gap=gap,
        stop=stop,
        termination=f"{why} after {steps} steps",
        iterations=steps,
        setup_seconds=0.0,
        solve_seconds=working_seconds() - started,
        history=_named(columns) if history else {},
    )


def _named(columns: Vector) -> dict[str, Vector]:
    return {"exchanged": columns[0], "energy": columns[1]}
