"""Compiled passes over the coarse levels, whose operators are nine-point stencils in single precision.

``stencil[0]`` is the diagonal, ``stencil[1:5]`` are the couplings of a point to its neighbours east, north, north-east
and north-west; the other four follow by symmetry. ``stencil[5]`` is the point's factor in Jacobi's method, zero at a
point without a basis function. Arrays have a ring of zeros. Single precision is enough where a level only lowers the
error by a factor. The vectors, however, are in double precision on the finest levels of large lattices: there the
rounding of a smooth correction is a rough error, and its residual a good part of the smooth one's.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import njit

_FAST = {"contract", "nsz", "nnan"}
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


def _smooth_from_zero(stencil, r, e, lo, hi):  # type: ignore[no-untyped-def]
    """Write a step of Jacobi's method from e = 0."""
    for i in range(lo, hi):
        factor, right, out = stencil[5, i], r[i], e[i]
        for j in range(out.size):
            out[j] = factor[j] * right[j]


def _smooth(stencil, r, e, smoothed, lo, hi):  # type: ignore[no-untyped-def]
    """Write a step of Jacobi's method from e."""
    for i in range(lo, hi):
        out = smoothed[i]
        _apply_row(stencil, e, i, out)
        factor, right, old = stencil[5, i], r[i], e[i]
        for j in range(1, out.size - 1):
            out[j] = old[j] + factor[j] * (right[j] - out[j])


def _restrict(stencil, r, e, coarse, row_coarsening, column_coarsening, lo, hi):  # type: ignore[no-untyped-def]
    """Restrict r - A e to the coarse rows [lo, hi)."""
    row = np.zeros(r.shape[1], dtype=r.dtype)
    half, one = r.dtype.type(0.5), r.dtype.type(1.0)
    for target in range(lo, hi):
        coarse[target] = coarse.dtype.type(0.0)
    reach = row_coarsening - 1
    for i in range(row_coarsening * lo - reach, min(row_coarsening * (hi - 1) + reach, r.shape[0] - 2) + 1):
        _apply_row(stencil, e, i, row)
        right = r[i]
        for j in range(1, row.size - 1):
            row[j] = right[j] - row[j]
        for target in range(max(lo, i // row_coarsening), min(hi, (i + reach) // row_coarsening + 1)):
            weight = half if row_coarsening == 2 and i % 2 else one
            out = coarse[target]
            if column_coarsening == 1:
                for j in range(1, out.size - 1):
                    out[j] += weight * row[j]
            else:
                for j in range(1, out.size - 1):
                    out[j] += weight * (row[2 * j] + half * (row[2 * j - 1] + row[2 * j + 1]))


def _add_interpolated(e, coarse, row_coarsening, column_coarsening, lo, hi):  # type: ignore[no-untyped-def]
    """Add the bilinear interpolant of ``coarse`` to the rows [lo, hi) of e."""
    half = coarse.dtype.type(0.5)
    row = np.empty(coarse.shape[1], dtype=coarse.dtype)
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


def _solve_coarsest(stencil, r, e, sweeps):  # type: ignore[no-untyped-def]
    """Write e after ``sweeps`` forward and backward sweeps of Gauss-Seidel from zero."""
    e[:] = e.dtype.type(0.0)
    rows, columns = e.shape[0] - 2, e.shape[1] - 2
    for sweep in range(2 * sweeps):
        for k in range(rows * columns):
            at = k if sweep % 2 == 0 else rows * columns - 1 - k
            i, j = at // columns + 1, at % columns + 1
            if stencil[5, i, j] > 0:
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


class LevelKernels(NamedTuple):
    """The passes over one level, compiled."""

    smooth_from_zero: Any
    smooth: Any
    solve_coarsest: Any


class TransferKernels(NamedTuple):
    """The passes between a level and the next, compiled."""

    restrict: Any
    add_interpolated: Any


@cache
def level_kernels(precision: str, stencil_precision: str) -> LevelKernels:
    """Compile the passes for vectors and stencils of "float32" or "float64", or load them."""
    vector, stencil = f"{precision}[:, ::1]", f"{stencil_precision}[:, :, ::1]"
    return LevelKernels(
        smooth_from_zero=_compiled(_smooth_from_zero, f"{stencil}, {vector}, {vector}, int64, int64"),
        smooth=_compiled(_smooth, f"{stencil}, {vector}, {vector}, {vector}, int64, int64"),
        solve_coarsest=_compiled(_solve_coarsest, f"{stencil}, {vector}, {vector}, int64"),
    )


@cache
def transfer_kernels(own: str, coarser: str) -> TransferKernels:
    """Compile the passes for vectors of these precisions on a level and the next, or load them."""
    vector, coarse = f"{own}[:, ::1]", f"{coarser}[:, ::1]"
    return TransferKernels(
        restrict=_compiled(_restrict, f"{_STENCIL}, {vector}, {vector}, {coarse}, int64, int64, int64, int64"),
        add_interpolated=_compiled(_add_interpolated, f"{vector}, {coarse}, int64, int64, int64, int64"),
    )


def _compiled(function: Any, signature: str) -> Any:
    return njit(f"void({signature})", cache=True, nogil=True, error_model="numpy", fastmath=_FAST)(function)
