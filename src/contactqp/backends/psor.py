"""Projected successive over-relaxation, the reference method.

Cryer, *The solution of a quadratic programming problem using systematic overrelaxation*, SIAM J. Control 9 (1971).
The kernels are in `contactqp.methods.sor`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np

from ..foundation.checks import Vector, one_of, open_interval, positive_number
from ..foundation.loading import load_modules, working_seconds
from ..problem.contact_problem import ContactProblem
from .base import Answer, Backend, Need, Stop, Task

if TYPE_CHECKING:
    from ..methods.sor.sweepers import Sweeper

_MAX_SWEEPS = 1_000_000
_ROUNDING = 16 * np.finfo(float).eps
_PATIENCE = 5
_STALLED = "steps are rounding errors"
_NODE_UPDATES_A_CALL = 20_000_000
"""Bounds the time between two looks at the clock and at the keyboard."""


class Psor(Backend):
    """Cryer's method: node by node ω_i ← max(l_i, min(u_i, ω_i - β R_i/G_ii)), with the newest values."""

    name: ClassVar[str] = "psor"
    summary: ClassVar[str] = "projected over-relaxation (own kernels)"
    package: ClassVar[str] = "numba"
    licence: ClassVar[str] = "BSD-3-Clause"
    practical_size: ClassVar[int | None] = 1_000_000
    reachable_tol: ClassVar[float | None] = 1e-13
    iteration_unit: ClassVar[str] = "sweep"
    does_without: ClassVar[tuple[Need, ...]] = (Need.SYMMETRIC, Need.DEFINITE)

    def solve(
        self,
        problem: ContactProblem,
        task: Task,
        *,
        relaxation: float | Literal["auto"] = "auto",
        order: Literal["lexicographic", "red-black"] = "lexicographic",
        stopping: Literal["certified", "step", "residual"] = "certified",
        stopping_length: float | None = None,
        history: bool = False,
    ) -> Answer:
        """Solve by projected over-relaxation.

        Parameters
        ----------
        problem, task
            See `Backend.solve`; it starts from zero, or from the warm start.
        relaxation : float in (0, 2) or "auto"
            The factor β; "auto" raises it as the decay of the steps asks for (see `contactqp.methods.sor.relaxation`),
            and goes back to 1 where the steps of a matrix that is not symmetric cease to fall.
        order : {"lexicographic", "red-black"}
            Order of the nodes; the second is for membranes and cables only. Red and black are told apart by row plus
            column, counted from the smallest box that holds the nodes.
        stopping : {"certified", "step", "residual"}
            "certified": when the judge is satisfied. "step": when max|ω_i change| of a sweep is below
            ``stopping_length``. "residual": when after a sweep max|min(ω_i, R_i/k)| is, with the stiffness k of an
            arm (on a membrane the tension; for a matrix, which has no arms, G_ii). The sweep that passes is counted.
        stopping_length : float, optional
            Length for the last two rules, in the problem's unit; by default ``tol`` times the gap scale. The paper's is
            0.001 of the spacing.
        history : bool
            Whether to record after every sweep "step" (length), "residual" (natural residual, length) and
            "relaxation".
        """
        load_modules("contactqp.methods.sor.sweepers", kernels="psor")
        from ..methods.sor.relaxation import AdaptiveRelaxation, GuardedRelaxation
        from ..methods.sor.sweepers import LatticeSweeper, SparseSweeper

        adaptive = None
        if relaxation == "auto":
            adaptive = AdaptiveRelaxation() if problem.symmetric else GuardedRelaxation()
        beta = adaptive.beta if adaptive else open_interval(relaxation, 0.0, 2.0, "relaxation")
        one_of(order, ("lexicographic", "red-black"), "order")
        one_of(stopping, ("certified", "step", "residual"), "stopping")
        small = task.tol * task.gap_scale
        if stopping_length is not None:
            small = positive_number(stopping_length, "stopping_length")
            if stopping == "certified":
                raise ValueError("stopping_length goes with stopping='step' or 'residual'; tol rules 'certified'")
        lattice = problem.stiffness.uniform_lattice
        if order == "red-black" and lattice is None:
            raise ValueError("order='red-black' needs a Membrane or a Cable: a lattice of equal arms")

        started = working_seconds()
        sweeper: Sweeper
        start = np.zeros(problem.size) if task.warm_start is None else problem.project(task.warm_start)
        if lattice is not None:
            unit, limits = float(np.max(task.length_unit)), problem.bound_grids()
            red_black = order == "red-black"
            sweeper = LatticeSweeper(lattice, problem.layout, problem.q, start, limits, unit, red_black=red_black)
        else:
            bounds = problem.lower, problem.bounds.upper_if_any
            sweeper = SparseSweeper(problem.stiffness, problem.q, start, *bounds, task.length_unit)
        rule: _Rule
        if stopping == "certified":
            rule = _CertifiedRule(task)
        else:
            rule = _StepRule(small) if stopping == "step" else _ResidualRule(small, _arm_weight(problem))
        setup_seconds = working_seconds() - started

        budget = _MAX_SWEEPS if task.max_iter is None else task.max_iter
        at_once = 1 if history or adaptive else max(1, _NODE_UPDATES_A_CALL // problem.size)
        records: list[tuple[float, float, float]] = []
        done = 0
        stop, why = Stop.ITERATION_LIMIT, "sweep limit"
        while done < budget:
            count, step = sweeper.sweep(beta, min(at_once, budget - done, rule.patience(done)), rule.small)
            done += count
            if history:
                records.append((step, sweeper.residual(1.0), beta))
            reason = rule.satisfied(sweeper, done, step, beta)
            if reason:
                stop, why = Stop.DONE, reason
                break
            if task.seconds_left <= 0:
                stop, why = Stop.TIME_LIMIT, "time limit"
                break
            if adaptive:
                adaptive.observe(step, 8 * rule.rounding)
                beta = adaptive.beta
        names = ("step", "residual", "relaxation")
        columns = np.array(records).reshape(-1, 3).T
        return Answer(
            gap=sweeper.gap() if rule.judged is None else rule.judged,
            stop=stop,
            termination=f"{why} after {done} sweeps, relaxation {beta:.4g}",
            iterations=done,
            setup_seconds=setup_seconds,
            solve_seconds=working_seconds() - started - setup_seconds,
            history=dict(zip(names, columns, strict=True)) if history else {},
            claimed_solved=stop is Stop.DONE and why != _STALLED,
        )


class _Rule:
    """When to stop.

    Attributes
    ----------
    small : float
        Step (length) at which a call of several sweeps may end early.
    rounding : float
        Step (length) that is no more than rounding errors, as far as known.
    judged : array or None
        The present gap, if the judge has been asked about it.
    """

    small = 0.0
    rounding = 0.0
    judged: Vector | None = None

    def patience(self, done: int) -> int:
        """Return how many sweeps may be done before the rule wants to look."""
        return _MAX_SWEEPS

    def satisfied(self, sweeper: Sweeper, done: int, step: float, beta: float) -> str | None:
        """Return why to stop after ``done`` sweeps, the last with the largest step ``step``; None to go on."""
        raise NotImplementedError


class _StepRule(_Rule):
    """The paper's first rule: the largest change of a sweep is small."""

    def __init__(self, small: float) -> None:
        self.small = small

    def satisfied(self, sweeper: Sweeper, done: int, step: float, beta: float) -> str | None:
        return f"step {step:.2g}" if step < self.small else None


class _ResidualRule(_Rule):
    """The second: max |min(ω_i, R_i/k)| after a sweep is small."""

    def __init__(self, enough: float, arm_weight: float) -> None:
        self._enough, self._arm_weight = enough, arm_weight

    def patience(self, done: int) -> int:
        return 1

    def satisfied(self, sweeper: Sweeper, done: int, step: float, beta: float) -> str | None:
        residual = sweeper.residual(self._arm_weight)
        return f"residual {residual:.2g}" if residual < self._enough else None


class _CertifiedRule(_Rule):
    """The judge is satisfied; or steps are rounding errors and the bound falls no more."""

    def __init__(self, task: Task) -> None:
        self._task = task
        self._next_check, self._least, self._stalled = 1, np.inf, 0

    def patience(self, done: int) -> int:
        return self._next_check - done

    def satisfied(self, sweeper: Sweeper, done: int, step: float, beta: float) -> str | None:
        self.judged = None
        if done < self._next_check:
            return None
        self._next_check = done + max(1, done // 20)
        gap = self.judged = sweeper.gap()
        bound = self._task.bound(gap)
        self._task.progress.update(f"{done} sweeps, bound {bound:.1e}")
        if bound <= self._task.tol:
            return f"certified bound {bound:.2g}"
        self.rounding = _ROUNDING * self._task.largest_length(gap) / (2 - beta)
        self._stalled = self._stalled + 1 if step <= self.rounding and bound > 0.9 * self._least else 0
        self._least = min(self._least, bound)
        return _STALLED if self._stalled == _PATIENCE else None


def _arm_weight(problem: ContactProblem) -> float:
    """Return G_ii over the stiffness of an arm, by which R_i/G_ii becomes R_i over that stiffness."""
    lattice = problem.stiffness.uniform_lattice
    if lattice is None:
        return 1.0
    return float(lattice.diagonal()[0]) / max(float(lattice.horizontal), float(lattice.vertical))
