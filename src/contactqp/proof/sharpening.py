"""A sharper enclosure: Newton's step from the answer, the free-set barrier, and monotone relaxation.

How good a base vector is does not matter to the proof, only to the width. So the base is made better than the answer:
its contact nodes are held at their bounds, the equations of the others are solved for a correction, and the correction
is kept apart, as the low part of a sum, so that it loses no digits. What is left out of balance is bounded by a
barrier.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..algebra.compensated import two_sum
from ..foundation.checks import Mask, Vector
from ..foundation.rounding import UNIT_ROUNDOFF
from ..methods.factors import DIRECT_SIZE
from ..methods.linear import free_set_solver
from ..problem.contact_problem import ContactProblem
from .enclosure import (
    Base,
    Enclosure,
    certain_contact,
    certainly_free,
    enclosure_about,
    multiples,
    relaxed,
)

_MOST_STEPS, _MOST_CHEAP_STEPS = 3, 60
"""Newton steps, and what they may be where few unknowns make them cheap."""

_SHARP = 1.5
"""Bound over the least error that it may still be, above which another Newton step is worth its time."""

_MOST_CORRECTIONS = 3
_WORTH_CORRECTING = 0.02
"""What the bound may exceed the correction by before another correction with the same matrix is made."""

_SWEEPS = 2
_REPAIRS = 3
"""Times that nodes which a barrier would move are freed, before the free-set barrier is given up."""


def sharpened(problem: ContactProblem, answer: Vector, first: Enclosure) -> Enclosure:
    """Return an enclosure within ``first`` whose bound is close to the answer's true error.

    Some Newton steps are made, the first from the answer's own contact set, until no node is undecided and the bound is
    proven to be less than 1.5 times the error, or as small as rounding errors of the answer; or the contact set comes
    to rest.

    Parameters
    ----------
    problem : ContactProblem
        With an M-matrix.
    answer : array, shape (n,)
        A finite gap (length).
    first : Enclosure
        About the answer.
    """
    best, steps = first, 0
    high, low = answer, np.zeros_like(answer)
    reaction, _ = problem.stiffness.enclosed_product(answer, problem.q)
    most = _MOST_CHEAP_STEPS if problem.size <= DIRECT_SIZE else _MOST_STEPS
    contact: tuple[Mask, Mask] | None = None
    while True:
        lower, upper = best.bounds(problem.bounds)
        proven = certain_contact(problem, lower, upper)
        decided = proven[0] | proven[1] | certainly_free(problem, lower, upper)
        guessed = problem.bounds.contact(high + low, reaction / problem.stiffness.diagonal())
        wanted = proven[0] | (~decided & guessed[0]), proven[1] | (~decided & guessed[1])
        sharp = best.bound <= max(_SHARP * best.least_error, 4 * UNIT_ROUNDOFF * float(np.abs(answer).max()))
        at_rest = contact is not None and all(map(np.array_equal, wanted, contact))
        if steps == most or at_rest or (sharp and decided.all()):
            return _relaxed(problem, best)
        contact = wanted
        held = wanted[0] | wanted[1]
        high, low = np.where(held, _held_at(problem, wanted[1]), high), np.where(held, 0.0, low)
        base, found = _corrected(problem, answer, high, low, held, proven[0] | proven[1])
        if not (np.isfinite(found.fall).all() and np.isfinite(found.rise[proven[1]]).all()):
            return _relaxed(problem, best)
        best, steps = best.met_with(found), steps + 1
        high, low, reaction = base.high, base.low, base.reaction


def _held_at(problem: ContactProblem, at_upper: Mask) -> Vector:
    """Return the gap that a node in contact is held at."""
    return problem.lower if problem.one_sided else np.where(at_upper, problem.upper, problem.lower)


def _corrected(
    problem: ContactProblem, answer: Vector, high: Vector, low: Vector, held: Mask, proven: Mask
) -> tuple[Base, Enclosure]:
    """Return the base that solves the free nodes' equations with the others held, and the enclosure about it."""
    barrier = problem.barrier
    assert barrier is not None
    base = Base.accurate(problem, high, low)
    best = _enclosure(problem, answer, base, barrier.v, barrier.s, barrier.kind)
    free = ~held
    if not free.any():
        return base, best
    solver = free_set_solver(problem.stiffness, free)
    if solver is None:
        return base, best
    solve, exact = solver
    for _ in range(_MOST_CORRECTIONS):
        step = np.zeros(problem.size)
        step[free] = -solve(base.reaction[free])
        if not np.isfinite(step).all():
            break
        base = Base.accurate(problem, *two_sum(base.high, base.low + step))
        found = _enclosure(problem, answer, base, barrier.v, barrier.s, barrier.kind)
        useful = found.bound < (1 - _WORTH_CORRECTING) * best.bound
        best = best.met_with(found)
        if not useful or best.bound <= (1 + _WORTH_CORRECTING) * best.least_error:
            break
    if exact:
        best = _within_the_free_set(problem, best, base, free, proven, solve)
    return base, best


def _enclosure(problem: ContactProblem, answer: Vector, base: Base, v: Vector, s: Vector, kind: str) -> Enclosure:
    return enclosure_about(answer, problem.bounds, base, v, multiples(problem, base, v, s), kind)


def _within_the_free_set(
    problem: ContactProblem, best: Enclosure, base: Base, free: Mask, proven: Mask, solve: Callable[[Vector], Vector]
) -> Enclosure:
    """Return the intersection with what the free-set barrier gives; nodes that it would move become free."""
    for _ in range(_REPAIRS):
        v = np.zeros(problem.size)
        v[free] = solve(np.ones(np.count_nonzero(free)))
        product, error = problem.stiffness.enclosed_product(v)
        s = product - error
        if problem.stiffness.surplus is not None:
            s -= 2 * (problem.stiffness.surplus @ v)
        if not ((v[free] > 0) & (s[free] > 0)).all():
            return best
        found = multiples(problem, base, v, s, proven, known=best)
        best = best.met_with(enclosure_about(best.answer, problem.bounds, base, v, found, "free set"))
        kept = found.held & found.held_above
        if kept.all():
            return best
        free = free | ~kept
        solver = free_set_solver(problem.stiffness, free)
        if solver is None:
            return best
        solve, _ = solver
    return best


def _relaxed(problem: ContactProblem, best: Enclosure) -> Enclosure:
    lower, upper = relaxed(problem, *best.bounds(problem.bounds), sweeps=_SWEEPS)
    fall, rise = np.nextafter(best.answer - lower, np.inf), np.nextafter(upper - best.answer, np.inf)
    return best.met_with(Enclosure(best.answer, fall, rise, best.barrier))
