r"""Surfaces, loads and frames of the gallery that tell what they do between the nodes, as profiles do.

All return depths. With x, y and r² = x² + y² in intervals, their ranges are those of the formulas, and their second
derivatives are, with s = r² - R²:

.. list-table::
   :header-rows: 1

   * - f
     - f_xx
     - f_xy
     - f_yy
   * - a ln r + br² + c
     - a(y² - x²)/r⁴ + 2b
     - -2axy/r⁴
     - a(x² - y²)/r⁴ + 2b
   * - cs²
     - c(8x² + 4s)
     - 8cxy
     - c(8y² + 4s)
   * - c (x⁺)ⁿ
     - cn(n - 1)(x⁺)ⁿ⁻²
     - 0
     - 0
   * - a sin kx sin ly
     - -ak² sin kx sin ly
     - akl cos kx cos ly
     - -al² sin kx sin ly
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..foundation.checks import Vector
from ..foundation.intervals import Interval
from ..foundation.surfaces import Curvature
from ..foundation.waves import cosine, logarithm, sine
from ..profiles.analytic import Profile


@dataclass(frozen=True)
class Mirrored(Profile):
    """A surface with its heights turned over: elevations as depths, or the ceiling that mirrors a support."""

    surface: Profile

    def __call__(self, x: ArrayLike, y: ArrayLike) -> Vector:
        """Return the depths at the points (x, y)."""
        return -self.surface(x, y)

    def range(self, x: Interval, y: Interval) -> Interval | None:
        """See `Profile.range`."""
        known = self.surface.range(x, y)
        return None if known is None else -known

    def curvature(self, x: Interval, y: Interval) -> Curvature | None:
        """See `Profile.curvature`."""
        known = self.surface.curvature(x, y)
        return None if known is None else Curvature(*(-part for part in known))


@dataclass(frozen=True)
class CappedBall(Profile):
    """The unit ball below the plane of the frame up to r = e, and its tangent beyond: f = -√(1 - r²), then a cone.

    With h = √(1 - e²) the cone is -h + (e/h)(r - e). Second derivatives are those of a hemisphere and of a cone, with a
    jump where both meet.
    """

    edge: float

    def __call__(self, x: ArrayLike, y: ArrayLike) -> Vector:
        """Return the depths at the points (x, y)."""
        r, height = np.hypot(x, y), math.sqrt(1 - self.edge**2)
        tangent = height - self.edge / height * (r - self.edge)
        return np.asarray(-np.where(r <= self.edge, np.sqrt(np.maximum(1 - r**2, 0.0)), tangent))

    def range(self, x: Interval, y: Interval) -> Interval:
        """See `Profile.range`: it grows with r."""
        square = _squared_distance(x, y)
        ends = [self._at(Interval.of(end)) for end in (square.lower, square.upper)]
        return ends[0].hull(ends[1])

    def curvature(self, x: Interval, y: Interval) -> Curvature:
        """See `Profile.curvature`."""
        square, least = _squared_distance(x, y), Interval.of(self.edge).square()
        once = 1.0 / (1.0 - square.minimum(least)).sqrt()
        thrice = once * once.square()
        most = Interval.between(np.zeros(()), least.upper)
        xx, yy = (side.square().minimum(most) for side in (x, y))
        xy = Interval.between(-least.upper / 2, least.upper / 2)
        both = x * y
        xy = Interval(np.maximum(both.lower, xy.lower), np.minimum(both.upper, xy.upper))
        ball = Curvature(once + xx * thrice, xy * thrice, once + yy * thrice)
        r = square.maximum(least).sqrt()
        slope = self.edge / self._height() / (r * r.square())
        cone = Curvature(y.square() * slope, -(x * y) * slope, x.square() * slope)
        within, beyond = square.upper <= least.lower, square.lower >= least.upper
        return Curvature(
            *(one.hull(two).where(~within, one).where(~beyond, two) for one, two in zip(ball, cone, strict=True))
        )

    def _height(self) -> Interval:
        return (1.0 - Interval.of(self.edge).square()).sqrt()

    def _at(self, square: Interval) -> Interval:
        """Return what holds the depths at squares of distances that are known, whichever formula is the right one."""
        least, height = Interval.of(self.edge).square(), self._height()
        ball = -(1.0 - square.minimum(least)).sqrt()
        cone = self.edge / height * (square.maximum(least).sqrt() - self.edge) - height
        within, beyond = square.upper <= least.lower, square.lower >= least.upper
        return ball.hull(cone).where(~within, ball).where(~beyond, cone)


@dataclass(frozen=True)
class Logarithmic(Profile):
    """f = a ln r + br² + c for r no less than ``least``, what hangs about a disk: Δf = 4b."""

    a: float
    b: float
    c: float
    least: float

    def __call__(self, x: ArrayLike, y: ArrayLike) -> Vector:
        """Return the depths at the points (x, y)."""
        r = np.maximum(np.hypot(x, y), self.least)
        return np.asarray(self.a * np.log(r) + self.b * r**2 + self.c)

    def range(self, x: Interval, y: Interval) -> Interval:
        """See `Profile.range`."""
        square = self._square(x, y)
        return self.a / 2 * logarithm(square) + self.b * square + self.c

    def curvature(self, x: Interval, y: Interval) -> Curvature:
        """See `Profile.curvature`."""
        per_fourth = Interval.of(self.a) / self._square(x, y).square()
        apart, twice = (y.square() - x.square()) * per_fourth, Interval.of(2 * self.b)
        return Curvature(apart + twice, -2.0 * (x * y * per_fourth), twice - apart)

    def _square(self, x: Interval, y: Interval) -> Interval:
        square, least = _squared_distance(x, y), Interval.of(self.least).square()
        return square.maximum(least)


@dataclass(frozen=True)
class Quartic(Profile):
    """f = c(r² - R²)²."""

    c: float
    radius: float

    def __call__(self, x: ArrayLike, y: ArrayLike) -> Vector:
        """Return the depths at the points (x, y)."""
        return np.asarray(self.c * (np.asarray(x) ** 2 + np.asarray(y) ** 2 - self.radius**2) ** 2)

    def range(self, x: Interval, y: Interval) -> Interval:
        """See `Profile.range`."""
        return self.c * self._beyond(x, y).square()

    def curvature(self, x: Interval, y: Interval) -> Curvature:
        """See `Profile.curvature`."""
        beyond = 4.0 * self._beyond(x, y)
        return Curvature(
            self.c * (8.0 * x.square() + beyond), 8.0 * self.c * (x * y), self.c * (8.0 * y.square() + beyond)
        )

    def _beyond(self, x: Interval, y: Interval) -> Interval:
        return _squared_distance(x, y) - Interval.of(self.radius).square()


@dataclass(frozen=True)
class HalfPower(Profile):
    """f = c (x⁺)ⁿ with an even n >= 2: zero for x < 0."""

    c: float
    power: int

    def __call__(self, x: ArrayLike, y: ArrayLike) -> Vector:
        """Return the depths at the points (x, y)."""
        x, _ = np.broadcast_arrays(np.asarray(x, dtype=np.float64), y)
        return np.asarray(self.c * np.maximum(x, 0.0) ** self.power)

    def range(self, x: Interval, y: Interval) -> Interval:
        """See `Profile.range`."""
        return self.c * _power(x, self.power) + _none(x, y)

    def curvature(self, x: Interval, y: Interval) -> Curvature:
        """See `Profile.curvature`: for n = 2 it jumps at x = 0."""
        none = _none(x, y)
        bend = self.power * (self.power - 1) * self.c * _power(x, self.power - 2)
        return Curvature(bend + none, none, none)


@dataclass(frozen=True)
class DentedBowl(Profile):
    """f = 0.15 + 0.3((x - 0.5)² + (y - 0.45)²) + 0.03 sin 9x sin 7y."""

    def __call__(self, x: ArrayLike, y: ArrayLike) -> Vector:
        """Return the depths at the points (x, y)."""
        x, y = np.asarray(x), np.asarray(y)
        dents = 0.03 * np.sin(9 * x) * np.sin(7 * y)
        return np.asarray(0.15 + 0.3 * ((x - 0.5) ** 2 + (y - 0.45) ** 2) + dents)

    def range(self, x: Interval, y: Interval) -> Interval:
        """See `Profile.range`."""
        bowl = 0.15 + 0.3 * ((x - 0.5).square() + (y - 0.45).square())
        return bowl + 0.03 * (sine(9.0 * x) * sine(7.0 * y))

    def curvature(self, x: Interval, y: Interval) -> Curvature:
        """See `Profile.curvature`."""
        sines = 0.03 * (sine(9.0 * x) * sine(7.0 * y))
        mixed = 0.03 * (63.0 * (cosine(9.0 * x) * cosine(7.0 * y)))
        return Curvature(0.6 - 81.0 * sines, mixed, 0.6 - 49.0 * sines)


@dataclass(frozen=True)
class DamHead(Profile):
    """Baiocchi's w on the faces of a dam of a width, between waters of heights a and b, as a depth, carried on within.

    f = -(1 - x/L)((a - y)⁺)²/2 - (x/L)((b - y)⁺)²/2, which is linear in x at the foot, and zero at the top.
    """

    width: float
    above: float
    below: float

    def __call__(self, x: ArrayLike, y: ArrayLike) -> Vector:
        """Return the depths at the points (x, y)."""
        x, y = np.asarray(x), np.asarray(y)
        upper, lower = (np.maximum(head - y, 0.0) ** 2 / 2 for head in (self.above, self.below))
        return np.asarray(-(upper * (self.width - x) + lower * x) / self.width)

    def range(self, x: Interval, y: Interval) -> Interval:
        """See `Profile.range`."""
        upper, lower = (_power(head - y, 2) / 2.0 for head in (self.above, self.below))
        return -(upper * (self.width - x) + lower * x) / self.width

    def curvature(self, x: Interval, y: Interval) -> Curvature:
        """See `Profile.curvature`: it jumps at the heights of the waters."""
        none = _none(x, y)
        slopes = [_power(head - y, 1) for head in (self.above, self.below)]
        bends = [_power(head - y, 0) for head in (self.above, self.below)]
        along = (bends[0] * (self.width - x) + bends[1] * x) / self.width
        return Curvature(none, (slopes[1] - slopes[0]) / self.width + none, -along)


def _squared_distance(x: Interval, y: Interval) -> Interval:
    return x.square() + y.square()


def _power(x: Interval, power: int) -> Interval:
    """Return what holds (x⁺)ⁿ, for n = 0 the step from 0 to 1."""
    if power == 0:
        return Interval(np.where(x.lower > 0, 1.0, 0.0), np.where(x.upper >= 0, 1.0, 0.0))
    positive = x.maximum(Interval.of(np.zeros(())))
    found = positive
    for _ in range(power - 1):
        found = found * positive
    return Interval(np.maximum(found.lower, 0.0), np.where(positive.upper > 0, found.upper, 0.0))


def _none(x: Interval, y: Interval) -> Interval:
    """Return zero on each rectangle."""
    return Interval.of(np.zeros(np.broadcast_shapes(x.lower.shape, y.lower.shape)))
