"""Compiled passes over the coarse levels: nine-point operators in single precision.

``stencil[0]`` is the diagonal, ``stencil[1:]`` are the couplings of a point to its neighbours east, north, north-east
and north-west; the other four follow by symmetry. A row of zeros belongs to a point without a basis function. Arrays
have a ring of zeros. Single precision is enough because the levels only compute corrections: they lower the error by a
factor, and the residual that drives them is computed in double precision.
"""

from __future__ import annotations

import numpy as np
from numba import njit

_FAST = {"contract", "nsz", "nnan"}
_GRID = "float32[:, ::1]"
_STENCIL = "float32[:, :, ::1]"


@njit(error_model="numpy", fastmath=_FAST, inline="always")
def _apply_row(stencil, e, i, out):  # type: ignore[no-untyped-def]
    """Write row i of the operator times e; the first and the last entry are left alone."""
    size = out.size - 2
    below, own, above = e[i - 1], e[i], e[i + 1]
    centre, east, west = stencil[0, i, 1:], stencil[1, i, 1:], stencil[1, i]
    north, south = stencil[2, i, 1:], stencil[2, i - 1, 1:]
    north_east, south_west = stencil[3, i, 1:], stencil[3, i - 1]
    north_west, south_east = stencil[4, i, 1:], stencil[4, i - 1, 2:]
    for k in range(size):
        middle = centre[k] * own[k + 1] + east[k] * own[k + 2] + west[k] * own[k]
        upper = north[k] * above[k + 1] + north_east[k] * above[k + 2] + north_west[k] * above[k]
        lower = south[k] * below[k + 1] + south_west[k] * below[k] + south_east[k] * below[k + 2]
        out[k + 1] = middle + (upper + lower)


@njit(
    f"void({_STENCIL}, {_GRID}, {_GRID}, float32, int64, int64)",
    cache=True,
    nogil=True,
    error_model="numpy",
    fastmath=_FAST,
)
def smooth_from_zero(stencil, r, e, damping, lo, hi):  # type: ignore[no-untyped-def]
    """Write e = damping r / diagonal, a step of Jacobi's method from zero."""
    for i in range(lo, hi):
        centre, right, out = stencil[0, i], r[i], e[i]
        for j in range(centre.size):
            out[j] = damping * right[j] / centre[j] if centre[j] > 0 else np.float32(0.0)


@njit(
    f"void({_STENCIL}, {_GRID}, {_GRID}, {_GRID}, float32, int64, int64)",
    cache=True,
    nogil=True,
    error_model="numpy",
    fastmath=_FAST,
)
def smooth(stencil, r, e, smoothed, damping, lo, hi):  # type: ignore[no-untyped-def]
    """Write e + damping (r - A e) / diagonal, a step of Jacobi's method."""
    for i in range(lo, hi):
        out = smoothed[i]
        _apply_row(stencil, e, i, out)
        centre, right, old = stencil[0, i], r[i], e[i]
        for j in range(1, out.size - 1):
            out[j] = old[j] + damping * (right[j] - out[j]) / centre[j] if centre[j] > 0 else np.float32(0.0)


@njit(
    f"void({_STENCIL}, {_GRID}, {_GRID}, {_GRID}, int64, int64, int64, int64)",
    cache=True,
    nogil=True,
    error_model="numpy",
    fastmath=_FAST,
)
def restrict(stencil, r, e, coarse, row_coarsening, column_coarsening, lo, hi):  # type: ignore[no-untyped-def]
    """Restrict r - A e to the coarse rows [lo, hi)."""
    row = np.zeros(r.shape[1], dtype=np.float32)
    half = np.float32(0.5)
    for row_i in range(lo, hi):
        coarse[row_i] = np.float32(0.0)
    reach = row_coarsening - 1
    for i in range(row_coarsening * lo - reach, min(row_coarsening * (hi - 1) + reach, r.shape[0] - 2) + 1):
        _apply_row(stencil, e, i, row)
        right = r[i]
        for j in range(1, row.size - 1):
            row[j] = right[j] - row[j]
        for target in range(max(lo, i // row_coarsening), min(hi, (i + reach) // row_coarsening + 1)):
            weight = half if row_coarsening == 2 and i % 2 else np.float32(1.0)
            out = coarse[target]
            if column_coarsening == 1:
                for j in range(1, out.size - 1):
                    out[j] += weight * row[j]
            else:
                for j in range(1, out.size - 1):
                    out[j] += weight * (row[2 * j] + half * (row[2 * j - 1] + row[2 * j + 1]))


@njit(f"void({_GRID}, {_GRID}, int64, int64, int64, int64)", cache=True, nogil=True, fastmath=_FAST)
def add_interpolated(e, coarse, row_coarsening, column_coarsening, lo, hi):  # type: ignore[no-untyped-def]
    """Add the bilinear interpolant of ``coarse`` to the rows [lo, hi) of e."""
    half = np.float32(0.5)
    row = np.empty(coarse.shape[1], dtype=np.float32)
    columns = e.shape[1] - 2
    for i in range(lo, hi):
        below = coarse[i // row_coarsening]
        above = coarse[(i + row_coarsening - 1) // row_coarsening]
        for j in range(row.size):
            row[j] = half * (below[j] + above[j])
        own = e[i]
        if column_coarsening == 1:
            for j in range(1, columns + 1):
                own[j] += row[j]
        else:
            for j in range(1, columns // 2 + 1):
                own[2 * j - 1] += half * (row[j - 1] + row[j])
                own[2 * j] += row[j]
            if columns % 2:
                own[columns] += half * (row[columns // 2] + row[columns // 2 + 1])


@njit(f"void({_STENCIL}, {_GRID}, {_GRID}, int64)", cache=True, nogil=True, error_model="numpy")
def solve_coarsest(stencil, r, e, sweeps):  # type: ignore[no-untyped-def]
    """Write e after ``sweeps`` forward and backward sweeps of Gauss-Seidel from zero."""
    e[:] = np.float32(0.0)
    rows, columns = e.shape[0] - 2, e.shape[1] - 2
    for sweep in range(2 * sweeps):
        for k in range(rows * columns):
            at = k if sweep % 2 == 0 else rows * columns - 1 - k
            i, j = at // columns + 1, at % columns + 1
            if stencil[0, i, j] > 0:
                middle = stencil[1, i, j] * e[i, j + 1] + stencil[1, i, j - 1] * e[i, j - 1]
                upper = (
                    stencil[2, i, j] * e[i + 1, j]
                    + stencil[3, i, j] * e[i + 1, j + 1]
                    + stencil[4, i, j] * e[i + 1, j - 1]
                )
                lower = (
                    stencil[2, i - 1, j] * e[i - 1, j]
                    + stencil[3, i - 1, j - 1] * e[i - 1, j - 1]
                    + stencil[4, i - 1, j + 1] * e[i - 1, j + 1]
                )
                e[i, j] = (r[i, j] - (middle + upper + lower)) / stencil[0, i, j]
