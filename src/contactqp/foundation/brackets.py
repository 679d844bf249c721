"""Brackets: numbers that are known to lie between two others, and sums that are rounded outwards."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple


class Bracket(NamedTuple):
    """A number that is known to lie between two others.

    Attributes
    ----------
    lower, upper : float
    """

    lower: float
    upper: float


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
