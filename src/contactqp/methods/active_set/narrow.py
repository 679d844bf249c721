"""Active sets on a narrow band in twice the precision, for bending in one direction.

There double precision has too few digits, and exchanges of nodes creep. So an interior-point iteration finds the
contact set (`contactqp.methods.active_set.interior_point`), and exchanges finish it, as double words: contact nodes
are held at their bounds, the equations of the others solved, and nodes of the wrong sign exchanged. A few exchanges are
tried whenever the interior point tells the same set twice; if they do not come to rest, it goes on. It converges
whatever they do, so that nothing goes round for ever.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...algebra.band import Band
from ...algebra.compensated import two_sum
from ...algebra.narrow_band import NarrowBand
from ...foundation.checks import Mask, Vector
from .interior_point import InteriorPoint
from .primal_dual import Step

_FEW_EXCHANGES = 8
"""Exchanges that are tried before the interior point goes on."""

_WELL_ON = 1e-6
"""Reduction of the products of gap and reaction below which the interior point's contact set is worth a try."""

_LAST_REDUCTION = 1e-30
"""A reduction below which an interior point has nothing more to tell."""

_ROUNDING = 2.0**-98
"""Of double words, with some operations."""


class NarrowActiveSet:
    """The iteration on min ½ωᵀGω + qᵀω between bounds l ≤ 0 ≤ u.

    Parameters
    ----------
    band : Band
        The matrix, and where its unknowns stand in the band.
    matrix : NarrowBand
        The same in that order: positive definite, with diagonal entries of about one.
    q : array, shape (n,)
    lower, upper : array, shape (n,)
        Bounds, -inf and inf where there is none; ``upper`` is empty where there is none at all.
    """

    def __init__(self, band: Band, matrix: NarrowBand, q: Vector, lower: Vector, upper: Vector) -> None:
        self._band, self._matrix = band, matrix
        self._diagonal = matrix.diagonal()
        self.restart(q, lower, upper)

    def restart(self, q: Vector, lower: Vector, upper: Vector) -> None:
        """Go back to ω = 0 with other forces and other values of the bounds."""
        self._q, self._lower = self._band.inwards(q), self._band.inwards(lower)
        self._upper = self._band.inwards(upper) if upper.size else np.full(q.size, np.inf)
        self._omega = np.zeros(q.size), np.zeros(q.size)
        self._point: InteriorPoint | None = None
        self._held: tuple[Mask, Mask] | None = None
        self._told: list[tuple[Mask, Mask]] = []
        self._exchanges, self._seen = 0, set[bytes]()

    def start(self, report: Callable[[str], None] = lambda text: None) -> None:
        """Start from within the bounds: the first step does."""

    def start_from(self, gap: Vector) -> None:
        """Start from a gap, shape (n,), whose contact set is taken for nearly right."""
        self._omega = self._band.inwards(gap), np.zeros(gap.size)
        self._held = self._omega[0] <= self._lower, (self._omega[0] >= self._upper) & (self._lower < self._upper)

    def feasible(self) -> Vector:
        """Return ω between its bounds, which it may leave on its way."""
        return np.minimum(np.maximum(self._lower, self._omega[0]), self._upper)[self._band.place]

    def step(self) -> Step:
        """Exchange nodes and solve for the others, or let the interior point go on."""
        if self._held is not None:
            return self._exchange(*self._held)
        return self._go_on()

    def _go_on(self) -> Step:
        """Make a step of the interior point."""
        if self._point is None:
            self._point = InteriorPoint(self._matrix, self._q, self._lower, self._upper)
        point, before = self._point, self._point.held
        point.step()
        self._omega = point.omega
        changed = sum(int(np.count_nonzero(now != was)) for now, was in zip(point.held, before, strict=True))
        ended = point.at_rest or point.reduction < _LAST_REDUCTION
        if ended or (changed == 0 and point.reduction < _WELL_ON):
            self._held, self._exchanges = point.held, 0
        return Step(changed, False)

    def _exchange(self, at_lower: Mask, at_upper: Mask) -> Step:
        """Solve the equations of the free nodes with the others held, and exchange nodes of the wrong sign."""
        held = at_lower | at_upper
        high = np.where(at_lower, self._lower, np.where(at_upper, self._upper, self._omega[0]))
        low = np.where(held, 0.0, self._omega[1])
        factors = self._matrix.factors(0.0, held)
        if factors is None:
            raise np.linalg.LinAlgError("the matrix of the free nodes is not positive definite, in twice the precision")
        reaction, reaction_low = self._matrix.product(high, low, self._q)
        for _ in range(2):  # the second time for what rounding has left
            reaction[held] = reaction_low[held] = 0.0
            way, way_low = factors.solve(-reaction, -reaction_low)
            high, rest = two_sum(high, way)
            high, low = two_sum(high, rest + (low + way_low))
            reaction, reaction_low = self._matrix.product(high, low, self._q)
        self._omega = high, low
        rounding = _ROUNDING * float(np.abs(high).max())
        below = ~held & ((high - self._lower) + low < -rounding)
        above = ~held & ((self._upper - high) - low < -rounding)
        pulled = np.where(at_upper, reaction, -reaction) > rounding * self._diagonal
        leaves = held & pulled & (self._lower < self._upper)
        exchanged = int(np.count_nonzero(below | above | leaves))
        self._exchanges += 1
        if exchanged == 0:
            return Step(0, True)
        at_lower, at_upper = (at_lower & ~leaves) | below, (at_upper & ~leaves) | above
        mark = np.packbits(at_lower).tobytes() + np.packbits(at_upper).tobytes()
        again = mark in self._seen
        self._seen.add(mark)
        self._held = at_lower, at_upper
        if again or self._exchanges >= _FEW_EXCHANGES:
            ended = self._point is not None and (self._point.at_rest or self._point.reduction < _LAST_REDUCTION)
            if ended:
                return Step(exchanged, again)
            self._held = None
        return Step(exchanged, False)
