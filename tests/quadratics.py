"""Surfaces of constant second derivatives that tell all of themselves."""

import numpy as np

from contactqp.foundation.intervals import Interval
from contactqp.foundation.surfaces import Curvature


class Quadratic:
    """mean + axx + bxy + dyy, with the parts a, b and d."""

    def __init__(self, mean, square_x, both, square_y):
        self.mean, self.parts = mean, (square_x, both, square_y)

    def __call__(self, x, y):
        a, b, d = self.parts
        return self.mean + a * x * x + b * x * y + d * y * y

    def range(self, x, y):
        a, b, d = map(Interval.of, self.parts)
        return Interval.of(self.mean) + a * x.square() + b * (x * y) + d * y.square()

    def curvature(self, x, y):
        shape = np.broadcast_shapes(x.lower.shape, y.lower.shape)
        a, b, d = (Interval.of(np.full(shape, part)) for part in self.parts)
        return Curvature(a + a, b, d + d)
