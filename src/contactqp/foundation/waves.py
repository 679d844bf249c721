"""Sines, cosines and logarithms of intervals, rounded outwards.

A library's sine, cosine and logarithm are off by a few units in the last place (numpy's tests allow four); sixteen are
taken. A sine is 1 where the interval holds π/2 + 2πk, for which is looked with room to spare, -1 where it holds 3π/2 +
2πk, and between its ends' values otherwise.
"""

from __future__ import annotations

import numpy as np

from .intervals import Ends, Interval

_UNITS = 16 * 2.0**-52

_ROOM = 1e-12


def sine(angle: Interval) -> Interval:
    """Return what holds the sines of angles (radian).

    Examples
    --------
    >>> held = sine(Interval.between([0.1, 1.0], [0.2, 2.0]))
    >>> held.upper[1], bool(held.lower[0] < np.sin(0.1) < np.sin(0.2) < held.upper[0])
    (np.float64(1.0), True)
    """
    ends = np.sin(angle.lower), np.sin(angle.upper)
    lower, upper = np.minimum(*ends) - _UNITS, np.maximum(*ends) + _UNITS
    lower = np.where(_holds(angle, 1.5 * np.pi), -1.0, np.maximum(lower, -1.0))
    return Interval(lower, np.where(_holds(angle, 0.5 * np.pi), 1.0, np.minimum(upper, 1.0)))


def cosine(angle: Interval) -> Interval:
    """Return what holds the cosines of angles (radian)."""
    ends = np.cos(angle.lower), np.cos(angle.upper)
    lower, upper = np.minimum(*ends) - _UNITS, np.maximum(*ends) + _UNITS
    lower = np.where(_holds(angle, np.pi), -1.0, np.maximum(lower, -1.0))
    return Interval(lower, np.where(_holds(angle, 0.0), 1.0, np.minimum(upper, 1.0)))


def logarithm(positive: Interval) -> Interval:
    """Return what holds the natural logarithms of numbers >= 0."""
    with np.errstate(divide="ignore"):
        ends = np.log(np.maximum(positive.lower, 0.0)), np.log(np.maximum(positive.upper, 0.0))
    room = [np.where(np.isfinite(end), _UNITS * np.abs(end), 0.0) for end in ends]
    return Interval(ends[0] - room[0], ends[1] + room[1])


def _holds(angle: Interval, phase: float) -> Ends:
    """Whether an interval may hold the phase plus a multiple of 2π."""
    room = _ROOM * (1 + angle.magnitude)
    first = np.ceil((angle.lower - room - phase) / (2 * np.pi))
    return np.asarray(first * (2 * np.pi) + phase <= angle.upper + room)
