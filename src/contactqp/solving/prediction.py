"""Prediction of an answer from those before: where forces go on in one direction, so does the gap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..foundation.checks import Mask, Vector
from ..problem.bounds import Bounds
from ..problem.contact_problem import ContactProblem

KEPT = 3
"""Answers that a prediction is made of at most."""

_ALIKE = 1e-6
"""Part of the change of forces that may point elsewhere than the changes before."""

_FARTHEST = -1.0, 2.0
"""Steps before and beyond the last answer, in units of the step that led to it, that are worth a prediction."""


class Everywhere:
    """What is asked of all nodes together, where vectors hold all of them."""

    def inner(self, one: Vector, other: Vector) -> float:
        """Return the sum of the products."""
        return float(one @ other)

    def largest(self, values: Vector) -> float:
        """Return the largest modulus."""
        return max(float(values.max()), -float(values.min()))

    def count(self, chosen: Mask) -> int:
        """Return how many nodes are chosen."""
        return int(np.count_nonzero(chosen))


_EVERYWHERE = Everywhere()


@dataclass(eq=False)
class Known:
    """A gap (length) between bounds, and its place along the way of the forces."""

    place: float
    gap: Vector
    bounds: Bounds

    @cached_property
    def root(self) -> Vector:
        """Root of the distance from the lower bound, shape (n,); of no use where there is none."""
        height = self.gap - self.bounds.floor
        np.maximum(height, 0.0, out=height)
        return np.asarray(np.sqrt(height, out=height))

    @cached_property
    def contact(self) -> Mask:
        """Nodes at the lower bound, shape (n,)."""
        return np.asarray(self.gap <= self.bounds.lower)


class Trail:
    """The last answers of a session, as long as only the forces change, and in one direction.

    Parameters
    ----------
    nodes : Everywhere
        What is asked of all nodes, where vectors hold a part of them only.
    """

    def __init__(self, nodes: Everywhere = _EVERYWHERE) -> None:
        self._nodes = nodes
        self._answers: list[Known] = []
        self._forces = self._direction = np.zeros(0)
        self._next: tuple[ContactProblem, float | None] | None = None

    def clear(self) -> None:
        """Forget the answers, as the matrix is another one from now on."""
        self._answers, self._next = [], None

    def add(self, problem: ContactProblem, gap: Vector) -> None:
        """Take note of an answer (length), shape (n,)."""
        if self._answers and not same_bounds(self._answers[-1].bounds, problem.bounds):
            self.clear()
        place = 0.0
        if self._answers:
            step = self._step(problem)
            if step is None:
                self._answers, self._direction, step = self._answers[-1:], problem.q - self._forces, 1.0
            place = self._answers[-1].place + step
            if place == self._answers[-1].place:
                self._answers.pop()
        self._answers = [*self._answers[1 - KEPT :], Known(place, gap, problem.bounds)]
        self._forces, self._next = problem.q, None

    def predicted(self, problem: ContactProblem) -> tuple[Vector, bool] | None:
        """Return what the answers let expect, see `extrapolated`.

        None unless the forces have changed from answer to answer and on to this problem in one direction.
        """
        if len(self._answers) < 2 or not same_bounds(self._answers[-1].bounds, problem.bounds):
            return None
        step = self._step(problem)
        return extrapolated(self._answers, step, self._nodes) if step else None

    def _step(self, problem: ContactProblem) -> float | None:
        """Return how far the forces go on in the direction of before; None if they lead elsewhere."""
        if self._next is None or self._next[0] is not problem:
            self._next = problem, self._step_of(problem.q - self._forces)
        return self._next[1]

    def _step_of(self, change: Vector) -> float | None:
        nodes = self._nodes
        largest = nodes.largest(change)
        if largest == 0:
            return 0.0
        if len(self._answers) < 2:
            return None
        direction = self._direction
        with np.errstate(over="ignore", under="ignore", invalid="ignore", divide="ignore"):
            step = float(np.divide(nodes.inner(change, direction), nodes.inner(direction, direction)))
            elsewhere = direction * step
            np.subtract(change, elsewhere, out=elsewhere)
            return step if nodes.largest(elsewhere) <= _ALIKE * largest else None


def extrapolated(answers: Sequence[Known], step: float, nodes: Everywhere = _EVERYWHERE) -> tuple[Vector, bool] | None:
    """Return an admissible gap (length) that extrapolates answers, and whether contact should stay or grow.

    None where the step is too long for that.

    While no node changes sides, the gap is affine in the forces, and so is the prediction. Where nodes do, it is
    the root of the gap that is extrapolated: next to the free boundary the gap grows as the square of the distance
    (Caffarelli, *The regularity of free boundaries in higher dimensions*, Acta Math. 139 (1977)), so that the
    boundary moves on by as much as before. A straight line through gaps would move a growing contact set too far,
    by 1.4 times its last step. The nodes in contact are those of a straight line through roots; at the others a
    parabola is more exact, where there are three answers and contact grows.

    Parameters
    ----------
    answers : sequence of Known
        Two or three, the last one last, between the same bounds.
    step : float
        How far to go from the place of the last one, other than zero.
    nodes : Everywhere
        See `Trail`.
    """
    *_, before, last = answers
    steps = step / (last.place - before.place)
    least, most = _FARTHEST
    if not least <= steps <= most:
        return None
    bounds = last.bounds
    if nodes.count(before.contact != last.contact) == 0:
        return bounds.project(_beyond(before.gap, last.gap, steps)), True
    gained = nodes.count(last.contact) - nodes.count(before.contact)
    grows = steps * gained >= 0
    root = _beyond(before.root, last.root, steps)
    if grows and len({answer.place for answer in answers}) == KEPT:
        parabola = _parabola(answers, last.place + step)
        parabola[root <= 0] = 0.0
        root = parabola
    np.square(np.maximum(root, 0.0, out=root), out=root)
    if bounds.standard and bounds.supported.all():
        return root, grows
    gap = np.where(bounds.supported, root + bounds.floor, _beyond(before.gap, last.gap, steps))
    return bounds.project(gap), grows


def _parabola(answers: Sequence[Known], place: float) -> Vector:
    """Return the roots at a place, by the parabola through those of three answers."""
    places = [answer.place for answer in answers]
    total, part = np.zeros_like(answers[-1].gap), np.empty_like(answers[-1].gap)
    for answer in answers:
        others = [other for other in places if other != answer.place]
        weight = float(np.prod([(place - other) / (answer.place - other) for other in others]))
        total += np.multiply(answer.root, weight, out=part)
    return total


def _beyond(before: Vector, last: Vector, steps: float) -> Vector:
    """Return ``last + steps (last - before)``."""
    gone = last - before
    gone *= steps
    gone += last
    return gone


def same_bounds(one: Bounds, other: Bounds) -> bool:
    """Whether bounds consist of the same numbers."""
    return one is other or (np.array_equal(one.lower, other.lower) and np.array_equal(one.upper, other.upper))
