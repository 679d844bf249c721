"""A point between bounds, and moves of it against its gradient: what gradient projection methods consist of."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..algebra.power import generic_start, largest_growth
from ..algebra.sparse import SparseStiffness
from ..foundation.checks import Mask, Vector

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_POWER_STEPS = 20
_SAFETY = 1.05
"""The power method finds the largest eigenvalue from below."""


class Face:
    """A point ω with l ≤ ω ≤ u, and the gradient g = Gω + q of the energy ½ωᵀGω + qᵀω there.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        G, symmetric positive definite.
    q, lower, upper : array, shape (n,)
    start : array, shape (n,)
        The point at first, between the bounds.
    expansion : float
        Length of gradient steps, in parts of one over the largest eigenvalue; the energy falls below two.

    Attributes
    ----------
    x, gradient : array, shape (n,)
        ω and g.

    Examples
    --------
    >>> from scipy.sparse import csr_array
    >>> bounds = np.zeros(2), np.full(2, np.inf)
    >>> face = Face(csr_array([[2.0, -1.0], [-1.0, 2.0]]), np.array([-1.0, 3.0]), *bounds, np.zeros(2), 1.0)
    >>> free, pulled = face.split()
    >>> free, pulled
    (array([False, False]), array([-1.,  0.]))
    >>> face.move(pulled)
    array([-2.,  1.])
    >>> face.x, face.gradient
    (array([0.5, 0. ]), array([0. , 2.5]))
    """

    def __init__(
        self, matrix: csr_array, q: Vector, lower: Vector, upper: Vector, start: Vector, expansion: float
    ) -> None:
        self._matrix, self._q, self._lower, self._upper = matrix, q, lower, upper
        largest = largest_growth(lambda x: np.asarray(matrix @ x), generic_start(q.size), _POWER_STEPS)
        self._length = expansion / (_SAFETY * largest)
        self.x, self.gradient = start, matrix @ start + q

    def renew(self) -> None:
        """Compute the gradient anew, in twice the precision."""
        self.gradient, _ = SparseStiffness(self._matrix).accurate_product(self.x, np.zeros_like(self.x), self._q)

    def energy(self, x: Vector) -> float:
        """Return the energy of a point."""
        return float(x @ (0.5 * (self._matrix @ x) + self._q))

    def split(self) -> tuple[Mask, Vector]:
        """Return which unknowns are free, and the gradient of those that it pulls from the bound at which they are."""
        above, below = self.x > self._lower, self.x < self._upper
        inwards = np.minimum(self.gradient, 0.0) * below + np.maximum(self.gradient, 0.0) * above
        free = above & below
        return free, np.where(free, 0.0, inwards)

    def reduced(self, free: Mask) -> float:
        """Return the product of the free gradient with what the bounds leave of it in a gradient step."""
        most, least = (self.x - self._lower) / self._length, (self.x - self._upper) / self._length
        return float((np.clip(self.gradient, least, most) * self.gradient)[free].sum())

    def move(self, direction: Vector) -> Vector | None:
        """Go against a direction to the least energy, and return G times the direction.

        Where that would leave the bounds, the end is projected, or the way up to the first bound is followed by a
        projected gradient step of the free unknowns, whichever has less energy; None is returned then.
        """
        image = self._matrix @ direction
        length, reach = float(self.gradient @ direction) / float(direction @ image), self._reach(direction)
        if length < reach:
            # What is clipped here is rounding.
            self.x, self.gradient = self._projected(self.x - length * direction), self.gradient - length * image
            return np.asarray(image)
        half, gradient = self.x - reach * direction, self.gradient - reach * image
        moving = np.where((half > self._lower) & (half < self._upper), gradient, 0.0)
        ends = self._projected(self.x - length * direction), self._projected(half - self._length * moving)
        self.x = min(ends, key=self.energy)
        self.gradient = self._matrix @ self.x + self._q
        return None

    def _reach(self, direction: Vector) -> float:
        """Return how far a step against a direction goes before it meets a bound."""
        room = np.where(direction > 0, self.x - self._lower, self.x - self._upper)
        moving = direction != 0
        return float((room[moving] / direction[moving]).min())

    def _projected(self, x: Vector) -> Vector:
        return np.minimum(self._upper, np.maximum(self._lower, x))
