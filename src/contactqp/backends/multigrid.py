"""The contact multigrid for lattices, `contactqp.multigrid`."""

from __future__ import annotations

import time
from typing import ClassVar

import numpy as np

from .._checks import Vector, integer_at_least
from ..problem import ContactQP
from ..progress import compiling
from ..team import Team
from .active_set import iterate, prepare
from .base import Answer, Backend, Need, Stop, Task

_MAX_CYCLES = 200
_PATIENCE = 5
"""Cycles without gain, at the level of rounding errors, after which the method gives up."""

_STALLING = 12
"""Cycles in which the bound is expected to fall by a factor of ten at least."""

_COLUMNS = ("bound", "contraction", "changes", "cut", "damping", "energy", "work")


class Multigrid(Backend):
    """Truncated nonsmooth Newton multigrid, started by nested iteration."""

    name: ClassVar[str] = "multigrid"
    summary: ClassVar[str] = "contact multigrid (own kernels)"
    package: ClassVar[str] = "numba"
    iteration_unit: ClassVar[str] = "cycle"
    needs: ClassVar[frozenset[Need]] = frozenset({Need.LATTICE})
    reachable_tol: ClassVar[float | None] = 1e-10

    def solve(self, problem: ContactQP, task: Task, *, threads: int | None = None, history: bool = False) -> Answer:
        """Solve by contact multigrid.

        Parameters
        ----------
        problem, task
            See `Backend.solve`. Without a warm start it works its way up from the coarsest lattice.
        threads : int, optional
            By default as many as cores.
        history : bool
            Whether to record of every cycle: "bound" (an estimate of the error's bound after its sweeps, relative to
            the gap scale), "contraction" (of that), "changes" (nodes that came into contact or left it), "cut" (nodes
            at which the support cut the correction short), "damping" (factor of the line search), "energy" (½ωᵀGω +
            qᵀω at its end, dimensionless) and "work" (sweeps over the lattice so far, or as much).
        """
        if threads is not None:
            threads = integer_at_least(threads, 1, "threads")
        stencil = problem.stencil
        assert stencil is not None
        with compiling("multigrid"):
            from ..multigrid.contact import ContactMultigrid, nested_start
            from ..multigrid.hierarchy import load_kernels
            from ..multigrid.net import net_of

            net = net_of(stencil, problem.layout)
            load_kernels(net)
        started = time.perf_counter()
        records: list[tuple[float, ...]] = []
        with Team(threads) as team:
            q = net.layout.grid(problem.q)
            if task.warm_start is not None:
                solver = ContactMultigrid(net, q, team)
                start = np.where(problem.supported, np.maximum(task.warm_start, 0.0), task.warm_start)
                solver.omega[...] = net.layout.grid(start)
            else:
                height = problem.reference_grid()
                solver = nested_start(
                    net, q, height, team, lambda nodes: task.progress.update(f"nested iteration, {nodes} nodes")
                )
                del height
            setup_seconds = time.perf_counter() - started

            budget = _MAX_CYCLES if task.max_iter is None else task.max_iter
            stop, why, cycle, contraction = Stop.ITERATION_LIMIT, "cycle limit", 0, 0.0
            estimates: list[float] = []
            idle = 0
            while True:
                before = solver.estimate
                solver.relax()
                cycle += 1
                estimate = solver.estimate * net.reach
                estimates.append(estimate)
                contraction = solver.estimate / before if 0 < before < np.inf else 0.0
                task.progress.update(f"cycle {cycle}, bound about {estimate:.0e}")
                if estimate <= task.tol:
                    bound = task.bound(net.layout.vector(solver.omega))
                    if bound <= task.tol:
                        stop, why = Stop.DONE, f"certified bound {bound:.1e}"
                gained = estimate <= 0.9 * min(estimates[:-1], default=np.inf)
                idle = idle + 1 if not gained and solver.estimate <= solver.rest() else 0
                if stop is not Stop.DONE:
                    if min(estimates[-_STALLING:]) > 0.1 * min(estimates[:-_STALLING], default=np.inf) and not idle:
                        return _hand_over(net.layout.vector(solver.omega), problem, task, cycle, started)
                    if idle == _PATIENCE:
                        stop, why = Stop.DONE, "what is left are rounding errors"
                    elif task.seconds_left <= 0:
                        stop, why = Stop.TIME_LIMIT, "time limit"
                over = stop is not Stop.ITERATION_LIMIT or cycle == budget
                if not over:
                    solver.correct()
                if history:
                    energy = solver.energy()
                    numbers = (estimate, contraction, solver.changes, solver.cut, solver.damping, energy, solver.work)
                    records.append(tuple(float(number) for number in numbers))
                if over:
                    break
            gap = net.layout.vector(solver.omega)
        return Answer(
            gap=gap,
            stop=stop,
            termination=f"{why} after {cycle} cycles, {solver.work:.0f} work units, last contraction {contraction:.2f}",
            iterations=cycle,
            setup_seconds=setup_seconds,
            solve_seconds=time.perf_counter() - started - setup_seconds,
            history=_columns(records) if history else {},
        )


def _hand_over(gap: Vector, problem: ContactQP, task: Task, cycles: int, started: float) -> Answer:
    """Go on by active sets: arms that jump by orders of magnitude from node to node defeat a geometric hierarchy."""
    solver = prepare(problem, task)
    solver.omega = gap
    answer = iterate(solver, problem, task, False, started)
    answer.note = f"multigrid stalled after {cycles} cycles, active sets went on"
    answer.iterations += cycles
    return answer


def _columns(records: list[tuple[float, ...]]) -> dict[str, Vector]:
    return dict(zip(_COLUMNS, np.array(records).reshape(-1, len(_COLUMNS)).T, strict=True))
