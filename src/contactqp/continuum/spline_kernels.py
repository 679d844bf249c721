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


@njit(inline="always")
def _in_bernstein_form(first, second, third, fourth):  # type: ignore[no-untyped-def]
    """Return six times the Bernstein coefficients of a cubic spline between its second and third coefficient."""
    middle = 4.0 * second + 2.0 * third, 2.0 * second + 4.0 * third
    return (first + 4.0 * second) + third, middle[0], middle[1], (second + 4.0 * third) + fourth


@njit(inline="always")
def _bend(before, at, after):  # type: ignore[no-untyped-def]
    """Return a second difference, and the sum of the moduli of the differences it is formed from."""
    back, ahead = before - at, after - at
    return back + ahead, abs(back) + abs(ahead)


@njit(
    f"void({GRID}, {GRID}, boolean[:, ::1], float64, {GRID}, {GRID}, {GRID}, {GRID}, int64, int64)",
    cache=True,
    nogil=True,
    error_model="numpy",
)
def ranges(c, q, inside, factor, least_excess, most_excess, least, most, first, last):  # type: ignore[no-untyped-def]
    """Write, for the cells in rows [first, last), ranges of TΔs - q and of s; cells outside are left as they are."""
    bends_x, bends_y = np.empty((4, 2)), np.empty((2, 4))
    part_x, part_y, values = np.empty((4, 2)), np.empty((2, 4)), np.empty((4, 4))
    for i in range(first, last):
        for j in range(inside.shape[1]):
            if not inside[i, j]:
                continue
            size_x = size_y = size = 0.0
            for k in range(4):
                for m in range(2):
                    bends_x[k, m], moduli = _bend(c[i + k, j + m], c[i + k, j + m + 1], c[i + k, j + m + 2])
                    size_x = max(size_x, moduli)
                    bends_y[m, k], moduli = _bend(c[i + m, j + k], c[i + m + 1, j + k], c[i + m + 2, j + k])
                    size_y = max(size_y, moduli)
                    size = max(size, max(abs(c[i + k, j + 2 * m]), abs(c[i + k, j + 2 * m + 1])))
            for m in range(2):
                part_x[0, m], part_x[1, m], part_x[2, m], part_x[3, m] = _in_bernstein_form(
                    bends_x[0, m], bends_x[1, m], bends_x[2, m], bends_x[3, m]
                )
                part_y[m, 0], part_y[m, 1], part_y[m, 2], part_y[m, 3] = _in_bernstein_form(
                    bends_y[m, 0], bends_y[m, 1], bends_y[m, 2], bends_y[m, 3]
                )
            for k in range(4):
                values[0, k], values[1, k], values[2, k], values[3, k] = _in_bernstein_form(
                    c[i, j + k], c[i + 1, j + k], c[i + 2, j + k], c[i + 3, j + k]
                )
            low, high, low_value, high_value = np.inf, -np.inf, np.inf, -np.inf
            for a in range(4):
                left, right = (3 - a) * q[i, j] + a * q[i + 1, j], (3 - a) * q[i, j + 1] + a * q[i + 1, j + 1]
                row = _in_bernstein_form(values[a, 0], values[a, 1], values[a, 2], values[a, 3])
                for b in range(4):
                    along = (3 - b) * part_x[a, 0] + b * part_x[a, 1]
                    across = (3 - a) * part_y[0, b] + a * part_y[1, b]
                    excess = factor * (along + across) - ((3 - b) * left + b * right) / 9.0
                    low, high = min(low, excess), max(high, excess)
                    low_value, high_value = min(low_value, row[b]), max(high_value, row[b])
            forces = max(max(abs(q[i, j]), abs(q[i, j + 1])), max(abs(q[i + 1, j]), abs(q[i + 1, j + 1])))
            error = _ERROR * (18.0 * factor * (size_x + size_y) + forces) + _UNDERFLOW
            least_excess[i, j], most_excess[i, j] = low - error, high + error
            error = _ERROR * size + _UNDERFLOW
            least[i, j], most[i, j] = low_value / 36.0 - error, high_value / 36.0 + error
