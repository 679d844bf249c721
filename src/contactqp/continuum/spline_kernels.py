"""Compiled passes over the cells of a bicubic spline: ranges of the spline, and of its Laplacian less a bilinear field.

See `contactqp.continuum.splines` for what is computed, and for how its roundings are bounded.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ..foundation.rounding import UNDERFLOW, gamma
from ..geometry.numbering_kernels import GRID

_ERROR = gamma(24)
_UNDERFLOW = UNDERFLOW
_NINTH, _THIRTY_SIXTH = 1.0 / 9.0, 1.0 / 36.0


@njit(inline="always")
def _larger(first, second):  # type: ignore[no-untyped-def]
    """Return the larger of two numbers, none of them nan, in a form that is compiled for several cells at once."""
    return first if first > second else second


@njit(inline="always")
def _smaller(first, second):  # type: ignore[no-untyped-def]
    return first if first < second else second


@njit(inline="always")
def _in_bernstein_form(part, first, second, third, fourth):  # type: ignore[no-untyped-def]
    """Return six times one of the Bernstein coefficients of a cubic spline between its second and third coefficient."""
    if part == 0:
        return (first + 4.0 * second) + third
    if part == 1:
        return 4.0 * second + 2.0 * third
    if part == 2:
        return 2.0 * second + 4.0 * third
    return (second + 4.0 * third) + fourth


@njit(
    f"void({GRID}, {GRID}, boolean[:, ::1], float64, {GRID}, {GRID}, {GRID}, {GRID}, int64, int64)",
    cache=True,
    nogil=True,
    error_model="numpy",
)
def ranges(c, q, inside, factor, least_excess, most_excess, least, most, first, last):  # type: ignore[no-untyped-def]
    """Write, for the cells in rows [first, last), ranges of TΔs - q and of s, nan for cells outside.

    What neighbours in a row have in common is computed once; loops along the row are compiled for several cells at
    once. Nothing may overflow.
    """
    cells = inside.shape[1]
    bends_x, bends_y = np.empty((4, cells + 1)), np.empty((2, cells + 3))
    size_x, size_y, size = np.empty(cells + 1), np.empty(cells + 3), np.empty(cells + 3)
    column, loads = np.empty(cells + 3), np.empty(cells + 1)
    along, across = np.empty(cells + 1), np.empty((2, cells))
    low, high, low_value, high_value = np.empty(cells), np.empty(cells), np.empty(cells), np.empty(cells)
    for i in range(first, last):
        size_x[:], size_y[:], size[:] = 0.0, 0.0, 0.0
        low[:], high[:], low_value[:], high_value[:] = np.inf, -np.inf, np.inf, -np.inf
        for k in range(4):
            for j in range(cells + 1):
                back, ahead = c[i + k, j] - c[i + k, j + 1], c[i + k, j + 2] - c[i + k, j + 1]
                bends_x[k, j] = back + ahead
                size_x[j] = _larger(size_x[j], abs(back) + abs(ahead))
            for j in range(cells + 3):
                size[j] = _larger(size[j], abs(c[i + k, j]))
        for k in range(2):
            for j in range(cells + 3):
                back, ahead = c[i + k, j] - c[i + k + 1, j], c[i + k + 2, j] - c[i + k + 1, j]
                bends_y[k, j] = back + ahead
                size_y[j] = _larger(size_y[j], abs(back) + abs(ahead))
        for a in range(4):
            left_weight, right_weight = 3.0 - a, 1.0 * a
            for j in range(cells + 1):
                along[j] = _in_bernstein_form(a, bends_x[0, j], bends_x[1, j], bends_x[2, j], bends_x[3, j])
                loads[j] = left_weight * q[i, j] + right_weight * q[i + 1, j]
            for j in range(cells + 3):
                column[j] = _in_bernstein_form(a, c[i, j], c[i + 1, j], c[i + 2, j], c[i + 3, j])
            for b in range(4):
                before, after = 3.0 - b, 1.0 * b
                for k in range(2):
                    row = bends_y[k]
                    for j in range(cells):
                        across[k, j] = _in_bernstein_form(b, row[j], row[j + 1], row[j + 2], row[j + 3])
                for j in range(cells):
                    bend_x = before * along[j] + after * along[j + 1]
                    bend_y = left_weight * across[0, j] + right_weight * across[1, j]
                    excess = factor * (bend_x + bend_y) - (before * loads[j] + after * loads[j + 1]) * _NINTH
                    low[j], high[j] = _smaller(excess, low[j]), _larger(excess, high[j])
                for j in range(cells):
                    value = _in_bernstein_form(b, column[j], column[j + 1], column[j + 2], column[j + 3])
                    low_value[j], high_value[j] = _smaller(value, low_value[j]), _larger(value, high_value[j])
        for j in range(cells):
            if inside[i, j]:
                bends = _larger(size_x[j], size_x[j + 1]) + _larger(
                    _larger(size_y[j], size_y[j + 1]), _larger(size_y[j + 2], size_y[j + 3])
                )
                force = _larger(
                    _larger(abs(q[i, j]), abs(q[i, j + 1])), _larger(abs(q[i + 1, j]), abs(q[i + 1, j + 1]))
                )
                error = _ERROR * (18.0 * factor * bends + force) + _UNDERFLOW
                least_excess[i, j], most_excess[i, j] = low[j] - error, high[j] + error
                length = _larger(_larger(size[j], size[j + 1]), _larger(size[j + 2], size[j + 3]))
                error = _ERROR * length + _UNDERFLOW
                least[i, j], most[i, j] = low_value[j] * _THIRTY_SIXTH - error, high_value[j] * _THIRTY_SIXTH + error
            else:
                least_excess[i, j] = most_excess[i, j] = least[i, j] = most[i, j] = np.nan


@njit(
    f"void({GRID}, {GRID}, boolean[:, ::1], {GRID}, {GRID}, int64, int64)",
    cache=True,
    nogil=True,
    error_model="numpy",
)
def excesses(c, f, inside, least, most, first, last):  # type: ignore[no-untyped-def]
    """Write, for the cells in rows [first, last), the least and largest Bernstein coefficient of s - f, nan outside.

    They are rounded as they come; f is bilinear on each cell.
    """
    cells = inside.shape[1]
    column, beside = np.empty(cells + 3), np.empty(cells + 1)
    low, high = np.empty(cells), np.empty(cells)
    for i in range(first, last):
        low[:], high[:] = np.inf, -np.inf
        for a in range(4):
            for j in range(cells + 3):
                column[j] = _in_bernstein_form(a, c[i, j], c[i + 1, j], c[i + 2, j], c[i + 3, j])
            for j in range(cells + 1):
                beside[j] = (3.0 - a) * f[i, j] + a * f[i + 1, j]
            for b in range(4):
                for j in range(cells):
                    value = _in_bernstein_form(b, column[j], column[j + 1], column[j + 2], column[j + 3])
                    field = (3.0 - b) * beside[j] + b * beside[j + 1]
                    excess = value * _THIRTY_SIXTH - field * _NINTH
                    low[j], high[j] = _smaller(excess, low[j]), _larger(excess, high[j])
        for j in range(cells):
            if inside[i, j]:
                least[i, j], most[i, j] = low[j], high[j]
            else:
                least[i, j] = most[i, j] = np.nan
