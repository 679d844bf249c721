"""Compiled passes of the interior-point iteration, see `contactqp.methods.active_set.interior_point`.

``above`` and ``below`` are the distances of the gap from its lower and from its upper bound, infinite where there is
none; ``press`` and ``pull`` are the reactions of these bounds, zero where there is none. What a reaction changes by
follows from the change of the gap, ``way``, so that its product with the distance comes to an aim.
"""

from __future__ import annotations

from numba import njit

from ...algebra.double_word_kernels import product_with_double, word_sum

_V = "float64[::1]"
_MASK = "boolean[::1]"


@njit(inline="always")
def _changes(i, way, above, below, press, pull, press_aim, pull_aim):  # type: ignore[no-untyped-def]
    """Return how both reactions of a node change."""
    return (press_aim - press[i] * way) / above[i] - press[i], (pull_aim + pull[i] * way) / below[i] - pull[i]


@njit(f"float64({', '.join([_V] * 9)})", cache=True, nogil=True, error_model="numpy")
def measure(high, low, lower, upper, press, pull, above, below, springs):  # type: ignore[no-untyped-def]
    """Set distances and springs, reactions over distances; return the sum of the products of both."""
    total = 0.0
    for i in range(high.size):
        above[i] = (high[i] - lower[i]) + low[i]
        below[i] = (upper[i] - high[i]) - low[i]
        springs[i] = press[i] / above[i] + pull[i] / below[i]
        if press[i] > 0:
            total += press[i] * above[i]
        if pull[i] > 0:
            total += pull[i] * below[i]
    return total


@njit(f"float64({', '.join([_V] * 7)})", cache=True, nogil=True, error_model="numpy")
def fastest(way, above, below, press, pull, press_aim, pull_aim):  # type: ignore[no-untyped-def]
    """Return the largest part of its size by which a distance or a reaction decreases."""
    most = 0.0
    for i in range(way.size):
        first, second = _changes(i, way[i], above, below, press, pull, press_aim[i], pull_aim[i])
        most = max(most, -way[i] / above[i], way[i] / below[i])
        if press[i] > 0:
            most = max(most, -first / press[i])
        if pull[i] > 0:
            most = max(most, -second / pull[i])
    return most


@njit(f"float64(float64, {', '.join([_V] * 5)})", cache=True, nogil=True, error_model="numpy")
def left(length, way, above, below, press, pull):  # type: ignore[no-untyped-def]
    """Return the sum of the products after a part of a way on which both aims are zero."""
    total = 0.0
    for i in range(way.size):
        first, second = _changes(i, way[i], above, below, press, pull, 0.0, 0.0)
        if press[i] > 0:
            total += (above[i] + length * way[i]) * (press[i] + length * first)
        if pull[i] > 0:
            total += (below[i] - length * way[i]) * (pull[i] + length * second)
    return total


@njit(f"void(float64, {', '.join([_V] * 8)})", cache=True, nogil=True, error_model="numpy")
def aim_at(mean, way, above, below, press, pull, press_aim, pull_aim, force):  # type: ignore[no-untyped-def]
    """Set aims of which second-order terms of the way are taken, and the force that they amount to."""
    for i in range(way.size):
        first, second = _changes(i, way[i], above, below, press, pull, 0.0, 0.0)
        press_aim[i] = mean - way[i] * first if press[i] > 0 else 0.0
        pull_aim[i] = mean + way[i] * second if pull[i] > 0 else 0.0
        force[i] = press_aim[i] / above[i] - pull_aim[i] / below[i]


@njit(f"void(float64, {', '.join([_V] * 12)}, {_MASK}, {_MASK})", cache=True, nogil=True, error_model="numpy")
def go(  # type: ignore[no-untyped-def]
    length, way, way_low, high, low, lower, upper, above, below, press, pull, press_aim, pull_aim, at_lower, at_upper
):
    """Go a part of the way, and mark nodes whose distance shrinks more than their reaction, in proportion."""
    for i in range(way.size):
        first, second = _changes(i, way[i], above, below, press, pull, press_aim[i], pull_aim[i])
        step, step_low = product_with_double(way[i], way_low[i], length)
        high[i], low[i] = word_sum(high[i], low[i], step, step_low)
        at_lower[i] = at_upper[i] = False
        if press[i] > 0:
            new = press[i] + length * first
            at_lower[i] = ((high[i] - lower[i]) + low[i]) * press[i] < new * above[i]
            press[i] = new
        if pull[i] > 0:
            new = pull[i] + length * second
            at_upper[i] = ((upper[i] - high[i]) - low[i]) * pull[i] < new * below[i] and not at_lower[i]
            pull[i] = new
