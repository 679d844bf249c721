"""Intervals: arrays of numbers of which each is known to lie between two others, rounded outwards.

Sums, products, quotients and square roots of doubles are off by half a unit in the last place at most (IEEE 754), so
that the neighbouring double outwards bounds them: Moore, Kearfott and Cloud, *Introduction to Interval Analysis*
(2009), ch. 2. An end that is not a number, as of 0 times infinity, is taken as infinite.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Ends: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Interval:
    """An array of intervals.

    Attributes
    ----------
    lower, upper : array
        Of shapes that fit each other, ``lower <= upper``.

    Examples
    --------
    >>> third = Interval.of(1.0) / Interval.of(3.0)
    >>> bool(third.lower < 1 / 3 < third.upper)
    True
    >>> Interval.between([-1.0, 2.0], [2.0, 3.0]).square()
    Interval(lower=array([0., 4.]), upper=array([4., 9.]))
    """

    lower: Ends
    upper: Ends

    @classmethod
    def of(cls, values: ArrayLike) -> Interval:
        """Return the intervals that consist of one number each."""
        ends = np.asarray(values, dtype=np.float64)
        return cls(ends, ends)

    @classmethod
    def between(cls, lower: ArrayLike, upper: ArrayLike) -> Interval:
        """Return the intervals between numbers."""
        return cls(np.asarray(lower, dtype=np.float64), np.asarray(upper, dtype=np.float64))

    @classmethod
    def around(cls, values: ArrayLike, error: ArrayLike) -> Interval:
        """Return the intervals that hold all numbers within an error >= 0 of some values."""
        middle, room = np.asarray(values, dtype=np.float64), np.asarray(error, dtype=np.float64)
        return _outwards(middle - room, middle + room)

    @property
    def magnitude(self) -> Ends:
        """The largest modulus of a number in each interval."""
        return np.maximum(np.abs(self.lower), np.abs(self.upper))

    @property
    def empty_of_zero(self) -> NDArray[np.bool_]:
        """Which intervals do not hold zero."""
        return np.asarray((self.lower > 0) | (self.upper < 0))

    def __neg__(self) -> Interval:
        return Interval(-self.upper, -self.lower)

    def __add__(self, other: Interval | float) -> Interval:
        other = _interval(other)
        with np.errstate(invalid="ignore", over="ignore"):
            return _outwards(self.lower + other.lower, self.upper + other.upper)

    __radd__ = __add__

    def __sub__(self, other: Interval | float) -> Interval:
        return self + -_interval(other)

    def __rsub__(self, other: Interval | float) -> Interval:
        return -self + other

    def __mul__(self, other: Interval | float) -> Interval:
        other = _interval(other)
        with np.errstate(invalid="ignore", over="ignore"):
            products = [a * b for a in (self.lower, self.upper) for b in (other.lower, other.upper)]
        # 0 times infinity is 0: an infinite end stands for numbers without a bound, of which none is infinite.
        lower = np.minimum.reduce([np.where(np.isnan(product), 0.0, product) for product in products])
        upper = np.maximum.reduce([np.where(np.isnan(product), 0.0, product) for product in products])
        return _outwards(lower, upper)

    __rmul__ = __mul__

    def __truediv__(self, other: Interval | float) -> Interval:
        other = _interval(other)
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            above = np.where(other.empty_of_zero, 1 / other.lower, np.inf)
            below = np.where(other.empty_of_zero, 1 / other.upper, -np.inf)
        return self * _outwards(below, above)

    def __rtruediv__(self, other: float) -> Interval:
        return _interval(other) / self

    def square(self) -> Interval:
        """Return the squares."""
        with np.errstate(over="ignore"):
            least = np.square(np.minimum(np.abs(self.lower), np.abs(self.upper)))
            most = np.square(self.magnitude)
        least = np.where(self.empty_of_zero, least, 0.0)
        return Interval(np.maximum(_outwards(least, least).lower, 0.0), _outwards(most, most).upper)

    def sqrt(self) -> Interval:
        """Return the square roots of the numbers that are not negative."""
        lower, upper = np.sqrt(np.maximum(self.lower, 0.0)), np.sqrt(np.maximum(self.upper, 0.0))
        return Interval(np.maximum(_outwards(lower, lower).lower, 0.0), _outwards(upper, upper).upper)

    def absolute(self) -> Interval:
        """Return the moduli."""
        least = np.where(self.empty_of_zero, np.minimum(np.abs(self.lower), np.abs(self.upper)), 0.0)
        return Interval(least, self.magnitude)

    def minimum(self, other: Interval) -> Interval:
        """Return what holds the lesser of two numbers."""
        return Interval(np.minimum(self.lower, other.lower), np.minimum(self.upper, other.upper))

    def maximum(self, other: Interval) -> Interval:
        """Return what holds the greater of two numbers."""
        return Interval(np.maximum(self.lower, other.lower), np.maximum(self.upper, other.upper))

    def hull(self, other: Interval) -> Interval:
        """Return the least interval that holds both."""
        return Interval(np.minimum(self.lower, other.lower), np.maximum(self.upper, other.upper))

    def where(self, chosen: NDArray[np.bool_], other: Interval) -> Interval:
        """Return these intervals where a condition holds, and others elsewhere."""
        return Interval(np.where(chosen, self.lower, other.lower), np.where(chosen, self.upper, other.upper))


def _interval(value: Any) -> Interval:
    return value if isinstance(value, Interval) else Interval.of(value)


def _outwards(lower: Ends, upper: Ends) -> Interval:
    """Return the neighbouring doubles outwards; a result that is exact zero or infinite needs none of them."""
    below = np.where(np.isnan(lower), -np.inf, np.nextafter(lower, -np.inf))
    above = np.where(np.isnan(upper), np.inf, np.nextafter(upper, np.inf))
    return Interval(below, above)
