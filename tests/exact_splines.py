"""Bicubic splines in rational arithmetic."""

from fractions import Fraction

import numpy as np


def hat(x):
    """The linear B-spline."""
    return max(Fraction(0), 1 - abs(x))


def bump(x):
    """The cubic B-spline."""
    x = abs(x)
    if x >= 2:
        return Fraction(0)
    if x >= 1:
        return (2 - x) ** 3 / 6
    return Fraction(2, 3) - x * x + x**3 / 2


def fractions(array):
    return np.vectorize(Fraction, otypes=[object])(np.asarray(array, dtype=float))


def value(c, row, column):
    """Return the spline at a place counted from point [0, 0] in spacings; c are the coefficients as fractions."""
    i, j = int(row // 1), int(column // 1)
    return sum(
        c[k + 1, m + 1] * bump(row - k) * bump(column - m)
        for k in range(i - 1, i + 3)
        for m in range(j - 1, j + 3)
        if k + 1 < c.shape[0] and m + 1 < c.shape[1]
    )


def laplacian(c, row, column, spacing):
    """Return the spline's Laplacian there."""
    i, j = int(row // 1), int(column // 1)
    total = Fraction(0)
    for k in range(i - 1, i + 3):
        for m in range(j, j + 2):
            if k + 1 < c.shape[0] and m + 2 < c.shape[1]:
                bend = c[k + 1, m] - 2 * c[k + 1, m + 1] + c[k + 1, m + 2]
                total += bend * hat(column - m) * bump(row - k)
    for k in range(i, i + 2):
        for m in range(j - 1, j + 3):
            if k + 2 < c.shape[0] and m + 1 < c.shape[1]:
                bend = c[k, m + 1] - 2 * c[k + 1, m + 1] + c[k + 2, m + 1]
                total += bend * bump(column - m) * hat(row - k)
    return total / Fraction(spacing) ** 2


def bilinear(field, row, column):
    """Return the bilinear interpolant of values at the points."""
    i, j = min(int(row // 1), field.shape[0] - 2), min(int(column // 1), field.shape[1] - 2)
    return sum(field[k, m] * hat(row - k) * hat(column - m) for k in (i, i + 1) for m in (j, j + 1))


def places_in(rng, i, j, count=3):
    """Return places in the cell [i, j], some of them on its rim, as fractions."""
    i, j = int(i), int(j)
    corners = [(Fraction(i + a), Fraction(j + b)) for a in (0, 1) for b in (0, 1)]
    inner = [(i + Fraction(int(a), 64), j + Fraction(int(b), 64)) for a, b in rng.integers(0, 65, (count, 2))]
    return [corners[rng.integers(4)], *inner]
