"""Rounding of the short sums and products that bounds of the continuum are made of."""

from __future__ import annotations

import math

import numpy as np

from ..foundation.rounding import UNDERFLOW, gamma
from ..geometry.numbering import Grid

FEW = gamma(40)
"""More roundings than any of the short sums has in a chain."""

GROW = 1 + gamma(64)

LESS_THAN_PI = 3.141592653589793

TWELFTH_ROOT = 0.28867513459481292
"""No less than the square root of a twelfth."""


def rounded_up(value: float) -> float:
    """Return an upper bound of a number >= 0 that has been rounded a few times; of what is no number, infinity.

    Examples
    --------
    >>> rounded_up(1.0) > 1.0, rounded_up(float("nan"))
    (True, inf)
    """
    return math.inf if math.isnan(value) else float(value) * GROW + UNDERFLOW


def or_infinite(bound: float, away: int) -> float:
    """Return a bound, the infinite one on the side ``away`` (1 or -1) where it is not a number."""
    return away * math.inf if math.isnan(bound) else bound


def finite_or_nan(values: Grid) -> Grid:
    """Return numbers that are to be bounded, no numbers where they have overflowed: an infinity is not their value.

    Examples
    --------
    >>> finite_or_nan(np.array([1.0, -np.inf]))
    array([ 1., nan])
    """
    return np.where(np.isfinite(values), values, np.nan)
