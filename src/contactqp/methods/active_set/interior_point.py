"""An interior-point iteration on a narrow band, in twice the precision: it tells the contact set of bending.

Mehrotra, *On the implementation of a primal-dual interior point method*, SIAM J. Optim. 2 (1992), for
min ½ωᵀGω + qᵀω between bounds: with distances from them s > 0 and reactions z > 0, each step is Newton's for
Gω + q = z_l - z_u and sz = σμ, a factorisation of G + diag(z/s) and two solutions. The number of steps hardly depends
on the number of unknowns. Gaps are double words; distances and reactions, which have relative accuracy, are doubles.
"""

from __future__ import annotations

import numpy as np

from ...algebra.compensated import two_sum
from ...algebra.narrow_band import NarrowBand
from ...foundation.checks import Mask, Vector
from ...foundation.loading import load_modules

_MOST_OF_THE_WAY = 0.995
"""Part of the way to the nearest bound that is gone."""

_ROOM = 0.1
"""Part of the distance between two bounds that a start keeps from either, at least."""


class InteriorPoint:
    """The iteration, from a start between the bounds.

    Parameters
    ----------
    matrix : NarrowBand
        Positive definite, with diagonal entries of about one.
    q : array, shape (n,)
    lower, upper : array, shape (n,)
        Bounds, -inf and inf where there is none.

    Attributes
    ----------
    omega : (array, array), shapes (n,)
        The gap as double words.
    held : (array of bool, array of bool), shapes (n,)
        Nodes that seem to be held by their lower and by their upper bound.
    at_rest : bool
        Whether there is nothing more to be gained.

    Examples
    --------
    >>> band = NarrowBand(np.array([[2.0, -1.0], [2.0, 0.0]]))
    >>> point = InteriorPoint(band, np.array([-1.0, 3.0]), np.zeros(2), np.full(2, np.inf))
    >>> for _ in range(12):
    ...     point.step()
    >>> point.omega[0].round(9).tolist(), [side.tolist() for side in point.held]
    ([0.5, 0.0], [[False, True], [False, False]])
    """

    def __init__(self, matrix: NarrowBand, q: Vector, lower: Vector, upper: Vector) -> None:
        load_modules("contactqp.methods.active_set.interior_point_kernels", kernels="active-set")
        self._matrix, self._q = matrix, q
        self._fixed: Mask = lower == upper
        self._bounds = np.where(self._fixed, -np.inf, lower), np.where(self._fixed, np.inf, upper)
        self._pairs = max(1, sum(int(np.isfinite(bound).sum()) for bound in self._bounds))
        self.omega, self._reactions = self._start(np.where(self._fixed, lower, 0.0))
        self._distances = np.empty_like(q), np.empty_like(q)
        self._springs = np.empty_like(q)
        self._first = self._mean = self._measured()
        self.held = np.zeros_like(self._fixed), np.zeros_like(self._fixed)
        self.at_rest = not self._first > 0

    @property
    def reduction(self) -> float:
        """By how much the mean product of distance and reaction has fallen since the start."""
        return self._mean / self._first if self._first > 0 else 0.0

    def step(self) -> None:
        """Make a step, and take nodes for held whose distance shrinks more than their reaction, in proportion."""
        from . import interior_point_kernels as kernels

        if self.at_rest:  # without a product of distance and reaction that is not zero there is nowhere to go
            return
        factors = self._matrix.factors(self._springs, self._fixed)
        if factors is None:
            self.at_rest = True
            return
        reaction, reaction_low = self._matrix.product(*self.omega, self._q)
        reaction[self._fixed] = reaction_low[self._fixed] = 0.0
        state = *self._distances, *self._reactions
        way, _ = factors.solve(-reaction, -reaction_low)
        none = np.zeros_like(way)
        length = 1 / max(1.0, kernels.fastest(way, *state, none, none))
        left = kernels.left(length, way, *state) / self._pairs
        aims, force = (np.empty_like(way), np.empty_like(way)), np.empty_like(way)
        kernels.aim_at(self._mean * min(1.0, left / self._mean) ** 3, way, *state, *aims, force)
        total, error = two_sum(force, -reaction)
        way, way_low = factors.solve(total, error - reaction_low)
        length = 1 / max(1.0, kernels.fastest(way, *state, *aims) / _MOST_OF_THE_WAY)
        if not length > 0:  # numbers have overflowed
            self.at_rest = True
            return
        held = np.empty_like(self._fixed), np.empty_like(self._fixed)
        kernels.go(length, way, way_low, *self.omega, *self._bounds, *state, *aims, *held)
        self.held = held[0] | self._fixed, held[1]
        self._mean = self._measured()
        self.at_rest = not 0 < self._mean < np.inf

    def _measured(self) -> float:
        """Return the mean product of distances and reactions, and see to distances and springs."""
        from .interior_point_kernels import measure

        products = measure(*self.omega, *self._bounds, *self._reactions, *self._distances, self._springs)
        return float(products) / self._pairs

    def _start(self, origin: Vector) -> tuple[tuple[Vector, Vector], tuple[Vector, Vector]]:
        """Return a gap between the bounds, and reactions that balance it as far as may be."""
        lifted = self._lifted()
        if lifted is not None:
            return lifted
        lower, upper = self._bounds
        scale = float(np.abs(self._q).max()) or 1.0
        with np.errstate(invalid="ignore"):
            room = np.where(np.isfinite(upper - lower), _ROOM * (upper - lower), scale)
        gap = np.minimum(np.maximum(origin, lower + room), upper - room)
        reaction, _ = self._matrix.product(gap, np.zeros_like(gap), self._q)
        typical = float(np.median(np.abs(reaction))) or scale
        press = np.where(np.isfinite(lower), np.maximum(reaction, 0.0) + typical, 0.0)
        pull = np.where(np.isfinite(upper), np.maximum(-reaction, 0.0) + typical, 0.0)
        return (gap, np.zeros_like(gap)), (press, pull)

    def _lifted(self) -> tuple[tuple[Vector, Vector], tuple[Vector, Vector]] | None:
        """Return the gap that a uniform force lifts from all bounds, whose reaction it is; None where that fails.

        There must be no upper bounds, and the matrix must give way everywhere to the side that it is pushed to.
        """
        lower, upper = self._bounds
        bounded = np.isfinite(lower)
        if np.isfinite(upper).any() or self._fixed.any() or not bounded.any():
            return None
        factors = self._matrix.factors()
        if factors is None:
            return None
        push = bounded.astype(np.float64)
        free, bent = factors.solve(-self._q)[0], factors.solve(push)[0]
        if not (bent[bounded] > 0).all():
            return None
        least = max(0.0, float(((lower - free) / bent)[bounded].max()))
        force = least + float(np.abs(free + least * bent).max()) / float(np.abs(bent).max())
        gap = factors.solve(*two_sum(force * push, -self._q))
        if not (force > 0 and (gap[0] > lower)[bounded].all()):
            return None
        return gap, (force * push, np.zeros_like(push))
