"""Brackets: numbers that are known to lie between two others, and sums that are rounded outwards."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .checks import Vector
from .rounding import gamma
from .text import rounded_outwards


class Bracket(NamedTuple):
    """A number that is known to lie between two others.

    Attributes
    ----------
    lower, upper : float

    Examples
    --------
    >>> Bracket(1.0100000000000002, 1.0100000000000005)
    Bracket(lower=1.01, upper=1.01000000001)
    """

    lower: float
    upper: float

    def __repr__(self) -> str:
        lower, upper = rounded_outwards(self.lower, self.upper)
        return f"Bracket(lower={lower!r}, upper={upper!r})"


def sum_below(numbers: Iterable[float]) -> float:
    """Return a lower bound of the sum, -inf where it overflows on the way."""
    try:
        return math.nextafter(math.fsum(numbers), -math.inf)
    except OverflowError:
        return -math.inf


def sum_above(numbers: Iterable[float]) -> float:
    """Return an upper bound of the sum, inf where it overflows on the way."""
    try:
        return math.nextafter(math.fsum(numbers), math.inf)
    except OverflowError:
        return math.inf


def sum_within(numbers: NDArray[np.float64]) -> Bracket:
    """Return a bracket of the sum of an array's n numbers; infinite where it overflows.

    The sum is rounded in whatever order numpy takes, so that it is off by no more than γₙ₋₁ times the sum of the moduli
    (Higham, *Accuracy and Stability of Numerical Algorithms*, 2002, eq. (4.4)); the sum of these is too small by no
    more than the same part, and γ₂ₙ covers both. It is far faster than the closer `sum_below` and `sum_above`.

    Examples
    --------
    >>> bracket = sum_within(np.full((100, 100), 0.1))
    >>> bracket.lower < 1000 < bracket.upper < 1000 + 1e-8
    True
    """
    with np.errstate(over="ignore", invalid="ignore"):
        total = float(numbers.sum())
        off = gamma(2 * numbers.size + 8) * float(np.abs(numbers).sum())
        low, high = total - off, total + off
    if not (math.isfinite(low) and math.isfinite(high)):
        return Bracket(-math.inf, math.inf)
    return Bracket(math.nextafter(low, -math.inf), math.nextafter(high, math.inf))


def sum_between(lower: Vector, upper: Vector) -> Bracket:
    """Return a bracket of the sum of numbers that lie between ``lower`` and ``upper``, rounded outwards.

    Where no number is negative (positive), the sum is not either.

    Examples
    --------
    >>> import numpy as np
    >>> bracket = sum_between(np.array([0.0, 0.1]), np.array([0.0, 0.2]))
    >>> bracket.lower < 0.1 <= 0.2 < bracket.upper
    True
    >>> sum_between(np.zeros(3), np.zeros(3))
    Bracket(lower=0.0, upper=0.0)
    """
    low, high = sum_below(lower), sum_above(upper)
    return Bracket(
        max(0.0, low) if (lower >= 0).all() else low,
        min(0.0, high) if (upper <= 0).all() else high,
    )
