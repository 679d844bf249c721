"""A sharper enclosure: Newton's step from the answer, the free-set barrier, and monotone relaxation.

How good a base vector is does not matter to the proof, only to the width. So the base is made better than the answer:
its contact nodes are held at zero, the equations of the others are solved for a correction, and the correction is
kept apart, as the low part of a sum, so that it loses no digits. What is left out of balance is bounded by a barrier.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..foundation.checks import Mask, Vector
from ..foundation.rounding import UNIT_ROUNDOFF
from ..methods.active_set.primal_dual import DIRECT_SIZE
from ..methods.linear import free_set_solver
from ..problem.contact_qp import ContactQP
from .compensated import two_sum
from .enclosure import (
    Base,
    Enclosure,
    certain_contact,
    enclosed_product,
    enclosed_reaction,
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
"""Times that nodes which a barrier would lift are let go, before the free-set barrier is given up."""


def sharpened(problem: ContactQP, answer: Vector, first: Enclosure) -> Enclosure:
    """Return an enclosure within ``first`` whose bound is close to the answer's true error.

    Some Newton steps are made, the first from the answer's own contact set, until no node is undecided and the bound is
    proven to be less than 1.5 times the error, or as small as rounding errors of the answer; or the contact set rests.

    Parameters
    ----------
    problem : ContactQP
        With an M-matrix.
    answer : array, shape (n,)
        Finite.
    first : Enclosure
        About the answer.
    """
    best, steps = first, 0
    high, low = answer, np.zeros_like(answer)
    reaction, _ = enclosed_reaction(problem, answer)
    most = _MOST_CHEAP_STEPS if problem.size <= DIRECT_SIZE else _MOST_STEPS
    shut: Mask | None = None
    while True:
        lower, upper = best.bounds(problem.supported)
        proven = certain_contact(problem, lower, upper)
        decided = proven | (lower > 0) | ~problem.supported
        wanted = proven | (~decided & (reaction / problem.stiffness.diagonal() > high + low))
        sharp = best.bound <= max(_SHARP * best.least_error, 4 * UNIT_ROUNDOFF * float(np.abs(answer).max()))
        settled = shut is not None and np.array_equal(wanted, shut)
        if steps == most or settled or (sharp and decided.all()):
            return _relaxed(problem, best)
        shut = wanted
        high, low = np.where(shut, 0.0, high), np.where(shut, 0.0, low)
        base, found = _corrected(problem, answer, high, low, shut, proven)
        if not np.isfinite(found.fall).all():
            return _relaxed(problem, best)
        best, steps = best.met_with(found), steps + 1
        high, low, reaction = base.high, base.low, base.reaction


def _corrected(
    problem: ContactQP, answer: Vector, high: Vector, low: Vector, shut: Mask, proven: Mask
) -> tuple[Base, Enclosure]:
    """Return the base that solves the free nodes' equations with the others held, and the enclosure about it."""
    barrier = problem.barrier
    assert barrier is not None
    base = Base.accurate(problem, high, low)
    best = _enclosure(problem, answer, base, barrier.v, barrier.s, barrier.kind)
    free = ~shut
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


def _enclosure(problem: ContactQP, answer: Vector, base: Base, v: Vector, s: Vector, kind: str) -> Enclosure:
    return enclosure_about(answer, problem.supported, base, v, multiples(problem, base, v, s), kind)


def _within_the_free_set(
    problem: ContactQP, best: Enclosure, base: Base, free: Mask, proven: Mask, solve: Callable[[Vector], Vector]
) -> Enclosure:
    """Return the intersection with what the free-set barrier gives; nodes that it would lift become free."""
    for _ in range(_REPAIRS):
        v = np.zeros(problem.size)
        v[free] = solve(np.ones(np.count_nonzero(free)))
        product, error = enclosed_product(problem, v)
        s = product - error
        if not ((v[free] > 0) & (s[free] > 0)).all():
            return best
        found = multiples(problem, base, v, s, proven)
        best = best.met_with(enclosure_about(best.answer, problem.supported, base, v, found, "free set"))
        if found.held.all():
            return best
        free = free | ~found.held
        solver = free_set_solver(problem.stiffness, free)
        if solver is None:
            return best
        solve, _ = solver
    return best


def _relaxed(problem: ContactQP, best: Enclosure) -> Enclosure:
    lower, upper = relaxed(problem, *best.bounds(problem.supported), sweeps=_SWEEPS)
    fall, rise = np.nextafter(best.answer - lower, np.inf), np.nextafter(upper - best.answer, np.inf)
    return best.met_with(Enclosure(best.answer, fall, rise, best.barrier))
