"""Modified proportioning with reduced gradient projections (MPRGP), preconditioned by algebraic multigrid.

Dostál and Schöberl, *Minimizing quadratic functions subject to bound constraints with the rate of convergence and
finite termination*, Computational Optimization and Applications 30 (2005); the preconditioner acts in the face of free
unknowns (Dostál, *Optimal Quadratic Programming Algorithms*, 2009, section 5.10), and where a step of conjugate
gradients leaves the bounds, it is projected if that lowers the energy (Kružík, Horák, Čermák, Pospíšil and Pecha,
*Active set expansion strategies in MPRGP algorithm*, Advances in Engineering Software 149, 2020).
"""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np

from ..foundation.loading import working_seconds
from ..methods.face import Face
from ..methods.linear import cycle_of
from ..problem.contact_problem import ContactProblem
from .base import Answer, Backend, Stop, Task
from .option_checks import Positive, between, check_values

_MAX_ITERATIONS = 20_000
_ROUNDING = 8 * np.finfo(float).eps
_LOOK_AGAIN = 0.1
"""The judge is asked once the projected gradient has fallen by this factor since it was asked last."""
_RENEWALS = 5
"""So often is the gradient computed anew where it has vanished to rounding, and the judge is not satisfied.

It is updated from step to step, and the roundings of that add up; an ill-conditioned matrix makes much of little.
"""


class Mprgp(Backend):
    """Conjugate gradients in the face of free unknowns, until those at a bound are pulled harder than these."""

    name: ClassVar[str] = "mprgp"
    summary: ClassVar[str] = "gradient projection and proportioning"
    package: ClassVar[str] = "numba"
    licence: ClassVar[str] = "BSD-3-Clause"
    practical_size: ClassVar[int | None] = 200_000
    reachable_tol: ClassVar[float | None] = 1e-14

    def solve(
        self,
        problem: ContactProblem,
        task: Task,
        *,
        proportioning: Positive = 1.0,
        expansion: Annotated[float, between(0.0, 2.0)] = 1.8,
        preconditioned: bool = True,
        history: bool = False,
    ) -> Answer:
        """Solve by proportioning and gradient projections.

        Parameters
        ----------
        problem, task
            See `Backend.solve`; it starts from zero, or from the warm start.
        proportioning : float
            Γ: unknowns are released from their bounds once the part of the projected gradient there is longer than Γ
            times the reduced free gradient.
        expansion : float
            Length of gradient steps, in parts of one over the largest eigenvalue.
        preconditioned : bool
            Whether conjugate gradients are preconditioned by a multigrid cycle for the free unknowns.
        history : bool
            Whether to record "gradient" (largest entry of the projected gradient) and "energy" at each iteration, both
            dimensionless.
        """
        check_values(Mprgp.solve, {"proportioning": proportioning, "expansion": expansion})
        started = working_seconds()
        ordered = problem.facts.ordered
        start = np.zeros(problem.size) if task.warm_start is None else problem.project(task.warm_start)
        inwards = ordered.inwards
        bounds = inwards(problem.lower), inwards(problem.upper)
        face = Face(ordered.matrix, inwards(problem.q), *bounds, inwards(start), expansion)
        cycles = preconditioned and cycle_of(ordered) is not None
        setup_seconds = working_seconds() - started
        budget = _MAX_ITERATIONS if task.max_iter is None else task.max_iter
        stop, why, done, look, direction = Stop.ITERATION_LIMIT, "iteration limit", 0, task.tol, None
        records: list[tuple[float, float]] = []
        level, renewals, least, best = _ROUNDING, _RENEWALS, np.inf, None
        while True:
            free, pulled = face.split()
            size = float(np.abs(np.where(free, face.gradient, pulled)).max())
            if history:
                records.append((size, face.energy(face.x)))
            rounding = size <= level * max(1.0, float(np.abs(face.x).max()))
            if size <= look or rounding:
                look, gap = _LOOK_AGAIN * size, ordered.outwards(face.x)
                bound = task.bound(gap)
                if bound < least and (rounding or bound <= task.tol):  # a renewed gradient may lead to a worse gap
                    least, best = bound, gap
                if bound <= task.tol or (rounding and not renewals):
                    stop, why = Stop.DONE, f"projected gradient {size:.2g}"
                    break
                if rounding:
                    level, renewals, direction = _LOOK_AGAIN * level, renewals - 1, None
                    face.renew()
                    continue
            if done >= budget:
                break
            if task.seconds_left <= 0:
                stop, why = Stop.TIME_LIMIT, "time limit"
                break
            done += 1
            task.progress.update(f"{done} iterations, projected gradient {size:.1e}")
            if float(pulled @ pulled) > proportioning**2 * face.reduced(free):
                face.move(pulled)
                direction = None
                continue
            if direction is None:
                part = ordered.amg.part(free) if cycles else None
                inside = np.where(free, face.gradient, 0.0)
                direction = inside if part is None else part.cycle(inside)
            image = face.move(direction)
            if image is None:  # it has met a bound
                direction = None
                continue
            inside = np.where(free, face.gradient, 0.0)
            better = inside if part is None else part.cycle(inside)
            direction = better - float(better @ image) / float(direction @ image) * direction
        names, columns = ("gradient", "energy"), np.array(records).reshape(-1, 2).T
        return Answer(
            gap=ordered.outwards(face.x) if best is None else best,
            stop=stop,
            termination=f"{why} after {done} iterations",
            iterations=done,
            setup_seconds=setup_seconds,
            solve_seconds=working_seconds() - started - setup_seconds,
            history=dict(zip(names, columns, strict=True)) if history else {},
        )
