"""Compiled passes over the finest lattice.

Arrays have a ring of frame points about the nodes. ``runs`` lists nodes of one kind that follow each other in a row
(see `contactqp.geometry.runs`); ``row_start[i]`` is the first run of row i. ``floor`` and ``ceiling`` are the bounds of
the nodes that are `BOUNDED`, and empty where there are none. ``across`` and ``along`` are the stiffnesses of the arms
along a row and along a column: numbers where all are equal, else arrays, ``across[i - 1, j - 1]`` west and
``along[i - 1, j - 1]`` south of the point [i, j]. ``ground[i - 1, j - 1]`` is the stiffness of an arm between the point
and the ground, which is looked at in runs that are not `LOOSE`: a number where there are none. Nodes that are `STIFF`
take no corrections from the coarse levels, which treat them as frame. ``weights`` are those of `weighted_kernels` where
arms differ, and a number, which is not looked at, where interpolation is bilinear.

A kernel works on the rows, or coarse rows, [lo, hi), so that threads can share a pass. No certificate rests on these
kernels, so they may contract products and sums.
"""

from __future__ import annotations

from functools import cache
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numba import njit, types
from numba.extending import overload

from ...geometry.arm_kernels import arm_at, spring_at
from ...geometry.numbering_kernels import GRID, RUNS
from ...geometry.runs import BOUNDED, FIRST, HOLD, KIND, LAST, LOOSE, ROW, STIFF, SUPPORTED
from .weighted_kernels import WEIGHTS, expand_row, spread_row

ArmKind: TypeAlias = Literal["equal", "rimmed", "varying"]
"""Arms that are equal in each direction; those, and springs at some nodes; arms and springs that vary."""

_FAST = {"contract", "nsz", "nnan"}

_FEW = 8
"""Nodes of a run up to which they are visited one by one: vectors of so few cost more than they save."""


@njit(error_model="numpy", fastmath=_FAST)
def _relax_run(omega, q, across, along, ground, lower, i, first, last, odd, buffer):  # type: ignore[no-untyped-def]
    """Write what the nodes of a run are relaxed to, or for those of the other colour what they are, to ``buffer``."""
    own, drive = omega[i, first:last], q[i, first:last]
    west, east = omega[i, first - 1 : last - 1], omega[i, first + 1 : last + 1]
    south, north = omega[i - 1, first:last], omega[i + 1, first:last]
    for k in range(last - first):
        j = first + k
        w, e = arm_at(across, i - 1, j - 1), arm_at(across, i - 1, j)
        s, n = arm_at(along, i - 1, j - 1), arm_at(along, i, j - 1)
        pull = w * west[k] + e * east[k] + s * south[k] + n * north[k] - drive[k]
        relaxed = max(lower, pull * (1.0 / (w + e + s + n + spring_at(ground, i - 1, j - 1))))
        buffer[k] = own[k] if (k + odd) & 1 else relaxed


@njit(error_model="numpy", fastmath=_FAST)
def _relax_few(omega, q, across, along, ground, lower, floor, ceiling, i, first, last, bounded):  # type: ignore[no-untyped-def]
    """Relax every second node of a short run, from the first one on."""
    for j in range(first, last, 2):
        w, e = arm_at(across, i - 1, j - 1), arm_at(across, i - 1, j)
        s, n = arm_at(along, i - 1, j - 1), arm_at(along, i, j - 1)
        pull = w * omega[i, j - 1] + e * omega[i, j + 1] + s * omega[i - 1, j] + n * omega[i + 1, j] - q[i, j]
        relaxed = max(lower, pull * (1.0 / (w + e + s + n + spring_at(ground, i - 1, j - 1))))
        omega[i, j] = min(ceiling[i, j], max(floor[i, j], relaxed)) if bounded else relaxed


def _spread_row(
    row: Any, coarse: Any, i: int, row_coarsening: int, column_coarsening: int, weights: Any, lo: int, hi: int
) -> None:
    """Add the fine row i, restricted, to those of the coarse rows within [lo, hi): bilinearly, or by weights."""
    if np.ndim(weights) == 0:
        _spread_row_bilinearly(row, coarse, i, row_coarsening, column_coarsening, lo, hi)
    else:
        spread_row(row, coarse, i, row_coarsening, column_coarsening, weights, lo, hi)


@overload(_spread_row, inline="always")
def _compiled_spread_row(row, coarse, i, row_coarsening, column_coarsening, weights, lo, hi):  # type: ignore[no-untyped-def]
    if isinstance(weights, types.Float):
        return lambda row, coarse, i, row_coarsening, column_coarsening, weights, lo, hi: _spread_row_bilinearly(
            row, coarse, i, row_coarsening, column_coarsening, lo, hi
        )
    return lambda row, coarse, i, row_coarsening, column_coarsening, weights, lo, hi: spread_row(
        row, coarse, i, row_coarsening, column_coarsening, weights, lo, hi
    )


def _expand_row(coarse: Any, i: int, row_coarsening: int, column_coarsening: int, weights: Any, row: Any) -> None:
    """Interpolate the fine row i from the coarse lattice: bilinearly, or by weights."""
    if np.ndim(weights) == 0:
        _expand_row_bilinearly(coarse, i, row_coarsening, column_coarsening, row)
    else:
        expand_row(coarse, i, row_coarsening, column_coarsening, weights, row)


@overload(_expand_row, inline="always")
def _compiled_expand_row(coarse, i, row_coarsening, column_coarsening, weights, row):  # type: ignore[no-untyped-def]
    if isinstance(weights, types.Float):
        return lambda coarse, i, row_coarsening, column_coarsening, weights, row: _expand_row_bilinearly(
            coarse, i, row_coarsening, column_coarsening, row
        )
    return lambda coarse, i, row_coarsening, column_coarsening, weights, row: expand_row(
        coarse, i, row_coarsening, column_coarsening, weights, row
    )


@njit(error_model="numpy", fastmath=_FAST)
def _relax_row(omega, q, across, along, ground, floor, ceiling, runs, row_start, i, colour, buffer):  # type: ignore[no-untyped-def]
    """Relax the nodes of row i whose row + column + colour is even, by projected Gauss-Seidel.

    The whole row is computed, contiguously, and then blended with the old one: twice the arithmetic, but in vectors.
    """
    for run in range(row_start[i], row_start[i + 1]):
        first, last = runs[run, FIRST], runs[run, LAST]
        odd = (i + first + colour) & 1
        lower = 0.0 if runs[run, KIND] == SUPPORTED else -np.inf
        if last - first <= _FEW and runs[run, HOLD] != LOOSE:
            bounded = runs[run, KIND] == BOUNDED
            _relax_few(omega, q, across, along, ground, lower, floor, ceiling, i, first + odd, last, bounded)
            continue
        if runs[run, HOLD] == LOOSE:
            _relax_run(omega, q, across, along, 0.0, lower, i, first, last, odd, buffer)
        else:
            _relax_run(omega, q, across, along, ground, lower, i, first, last, odd, buffer)
        own = omega[i, first:last]
        if runs[run, KIND] == BOUNDED:
            low, high = floor[i, first:last], ceiling[i, first:last]
            for k in range(last - first):
                own[k] = min(high[k], max(low[k], buffer[k]))
        else:
            for k in range(last - first):
                own[k] = buffer[k]


def _sweep(  # type: ignore[no-untyped-def]
    omega, q, across, along, ground, floor, ceiling, runs, row_start, begin, count, lo, hi
):
    """Do ``count`` half-sweeps of projected Gauss-Seidel from number ``begin`` on, even red and odd black, on [lo, hi).

    Each follows the one before a row behind, while the rows are in the cache. A half-sweep of a row needs the one
    before on both neighbouring rows; the k-th of the rows within k of a border to another strip is left out,
    therefore, and has to be done when both strips have come so far.
    """
    buffer = np.empty(omega.shape[1])
    last_row = omega.shape[0] - 2
    for front in range(lo, hi + count - 1):
        for k in range(count):
            i = front - k
            if i < lo or i >= hi:
                continue
            if (i - lo >= k or lo == 1) and (hi - 1 - i >= k or hi == last_row + 1):
                _relax_row(omega, q, across, along, ground, floor, ceiling, runs, row_start, i, (begin + k) & 1, buffer)


@njit(error_model="numpy", fastmath=_FAST)
def _restrict_row(row, coarse, coarsening, weight):  # type: ignore[no-untyped-def]
    """Add ``weight`` times a restricted row to ``coarse``."""
    if coarsening == 1:
        for j in range(1, coarse.size - 1):
            coarse[j] += weight * row[j]
    else:
        for j in range(1, coarse.size - 1):
            coarse[j] += weight * (row[2 * j] + 0.5 * (row[2 * j - 1] + row[2 * j + 1]))


@njit(error_model="numpy", fastmath=_FAST)
def _pull_run(omega, q, across, along, ground, i, first, last, out):  # type: ignore[no-untyped-def]
    """Write -R of the nodes of a run.

    Differences keep the digits that products with the diagonal would lose.
    """
    own, drive = omega[i, first:last], q[i, first:last]
    west, east = omega[i, first - 1 : last - 1], omega[i, first + 1 : last + 1]
    south, north = omega[i - 1, first:last], omega[i + 1, first:last]
    for k in range(last - first):
        j = first + k
        horizontal = arm_at(across, i - 1, j - 1) * (own[k] - west[k]) + arm_at(across, i - 1, j) * (own[k] - east[k])
        vertical = arm_at(along, i - 1, j - 1) * (own[k] - south[k]) + arm_at(along, i, j - 1) * (own[k] - north[k])
        out[k] = -((horizontal + vertical) + drive[k] + spring_at(ground, i - 1, j - 1) * own[k])


@njit(error_model="numpy", fastmath=_FAST)
def _spread_row_bilinearly(row, coarse, i, row_coarsening, column_coarsening, lo, hi):  # type: ignore[no-untyped-def]
    """Add the fine row i, restricted, to those of the coarse rows within [lo, hi)."""
    if row_coarsening == 1:
        _restrict_row(row, coarse[i], column_coarsening, 1.0)
    elif i % 2 == 0:
        _restrict_row(row, coarse[i // 2], column_coarsening, 1.0)
    else:
        if i // 2 >= lo:
            _restrict_row(row, coarse[i // 2], column_coarsening, 0.5)
        if i // 2 + 1 < hi:
            _restrict_row(row, coarse[i // 2 + 1], column_coarsening, 0.5)


def _restrict_residual(  # type: ignore[no-untyped-def]
    omega,
    q,
    across,
    along,
    ground,
    floor,
    ceiling,
    runs,
    row_start,
    free,
    changed,
    coarse,
    row_coarsening,
    column_coarsening,
    weights,
    slope,
    lo,
    hi,
):
    """Restrict -R of the free nodes, those strictly between their bounds, to the coarse rows [lo, hi).

    ``free`` is 1 at free nodes that are `LOOSE`, 2 at others, and 0 at those that the coarse levels treat as frame.
    Returns how many nodes became free or ceased to be since it was written last, and the largest force that is
    out of balance: |R| where there is no bound, and else no more than ``slope`` times the way to the bound that it
    pulls towards; max(-R, min(R, slope ω)) where the lower bound 0 is the only one. Rows with such nodes are marked in
    ``changed``.
    """
    row = np.zeros(omega.shape[1])
    changes = 0
    worst = 0.0
    coarse[lo:hi] = 0.0
    reach = row_coarsening - 1
    rows, last_row = omega.shape[0] - 2, row_coarsening * (hi - 1) + reach
    first_own = row_coarsening * lo - reach if lo == 1 else row_coarsening * lo
    for i in range(row_coarsening * lo - reach, min(last_row, rows) + 1):
        row[:] = 0.0
        before = changes
        for run in range(row_start[i], row_start[i + 1]):
            first, last = runs[run, FIRST], runs[run, LAST]
            own, out, hold = omega[i, first:last], row[first:last], runs[run, HOLD]
            if hold == LOOSE:
                _pull_run(omega, q, across, along, 0.0, i, first, last, out)
            else:
                _pull_run(omega, q, across, along, ground, i, first, last, out)
            if i >= first_own:
                flags, mark = free[i, first:last], np.uint8(1 if hold == LOOSE else 2)
                if hold == STIFF:
                    mark = np.uint8(0)
                if runs[run, KIND] == SUPPORTED:
                    for k in range(last - first):
                        flag = mark if own[k] > 0.0 else np.uint8(0)
                        changes += flag != flags[k]
                        flags[k] = flag
                    for k in range(last - first):
                        worst = max(worst, max(out[k], min(-out[k], slope * own[k])))
                elif runs[run, KIND] == BOUNDED:
                    low, high = floor[i, first:last], ceiling[i, first:last]
                    for k in range(last - first):
                        flag = mark if (own[k] > low[k]) & (own[k] < high[k]) else np.uint8(0)
                        changes += flag != flags[k]
                        flags[k] = flag
                        upwards = min(out[k], slope * (high[k] - own[k]))
                        worst = max(worst, max(upwards, min(-out[k], slope * (own[k] - low[k]))))
                else:
                    for k in range(last - first):
                        changes += flags[k] != mark
                        flags[k] = mark
                        worst = max(worst, abs(out[k]))
            if hold == STIFF:
                out[:] = 0.0
            elif runs[run, KIND] == SUPPORTED:
                for k in range(last - first):
                    out[k] = out[k] if own[k] > 0.0 else 0.0
            elif runs[run, KIND] == BOUNDED:
                low, high = floor[i, first:last], ceiling[i, first:last]
                for k in range(last - first):
                    out[k] = out[k] if own[k] > low[k] and own[k] < high[k] else 0.0
        if changes > before:
            changed[i] = 1
        _spread_row(row, coarse, i, row_coarsening, column_coarsening, weights, lo, hi)
    return changes, worst


@njit(error_model="numpy", fastmath=_FAST)
def _expand_row_bilinearly(coarse, i, row_coarsening, column_coarsening, row):  # type: ignore[no-untyped-def]
    """Interpolate the fine row i bilinearly from the coarse lattice."""
    below = coarse[i // row_coarsening]
    above = coarse[min((i + row_coarsening - 1) // row_coarsening, coarse.shape[0] - 1)]
    last = below.size - 1
    if column_coarsening == 1:
        for j in range(min(row.size, below.size)):
            row[j] = 0.5 * (below[j] + above[j])
    else:
        for j in range(1, last + 1):
            here = 0.5 * (below[j] + above[j])
            row[2 * j - 1] = 0.5 * (here + 0.5 * (below[j - 1] + above[j - 1]))
            if 2 * j < row.size:
                row[2 * j] = here


def _correct(  # type: ignore[no-untyped-def]
    omega, corrected, coarse, row_coarsening, column_coarsening, weights, floor, ceiling, runs, row_start, lo, hi
):
    """Write ω + interpolated correction, within the bounds, of the free nodes; return how many were cut short."""
    row = np.zeros(omega.shape[1])
    cut = 0
    for i in range(lo, hi):
        _expand_row(coarse, i, row_coarsening, column_coarsening, weights, row)
        for run in range(row_start[i], row_start[i + 1]):
            first, last = runs[run, FIRST], runs[run, LAST]
            old, new, step = omega[i, first:last], corrected[i, first:last], row[first:last]
            if runs[run, HOLD] == STIFF:
                for k in range(last - first):
                    new[k] = old[k]
            elif runs[run, KIND] == SUPPORTED:
                for k in range(last - first):
                    wanted = old[k] + step[k]
                    cut += (wanted < 0.0) & (old[k] > 0.0)
                    new[k] = max(wanted, 0.0) if old[k] > 0.0 else 0.0
            elif runs[run, KIND] == BOUNDED:
                low, high = floor[i, first:last], ceiling[i, first:last]
                for k in range(last - first):
                    free = old[k] > low[k] and old[k] < high[k]
                    wanted = old[k] + step[k]
                    cut += free and (wanted < low[k] or wanted > high[k])
                    new[k] = min(high[k], max(low[k], wanted)) if free else old[k]
            else:
                for k in range(last - first):
                    new[k] = old[k] + step[k]
    return cut


def _energy_slope(omega, corrected, q, across, along, ground, runs, row_start, lo, hi):  # type: ignore[no-untyped-def]
    """Return d·R and d·Gd of the step d = corrected - ω: the energy changes by α d·R + ½ α² d·Gd along α d."""
    slope = curvature = 0.0
    for run in range(row_start[lo], row_start[hi]):
        i, first, last = runs[run, ROW], runs[run, FIRST], runs[run, LAST]
        for j in range(first, last):
            step = corrected[i, j] - omega[i, j]
            if step == 0.0:
                continue
            spring = 0.0 if runs[run, HOLD] == LOOSE else spring_at(ground, i - 1, j - 1)
            reaction, change = q[i, j] + spring * omega[i, j], spring * step
            for k in range(4):
                if k == 0:
                    arm, a, b = arm_at(across, i - 1, j - 1), i, j - 1
                elif k == 1:
                    arm, a, b = arm_at(across, i - 1, j), i, j + 1
                elif k == 2:
                    arm, a, b = arm_at(along, i - 1, j - 1), i - 1, j
                else:
                    arm, a, b = arm_at(along, i, j - 1), i + 1, j
                reaction += arm * (omega[i, j] - omega[a, b])
                change += arm * (step - (corrected[a, b] - omega[a, b]))
            slope += step * reaction
            curvature += step * change
    return slope, curvature


def _directions(  # type: ignore[no-untyped-def]
    omega, before, older, floor, ceiling, runs, row_start, lo, hi
):
    """Turn ``older`` into before - older and ``before`` into ω - before, at nodes between their bounds; else into 0."""
    for run in range(row_start[lo], row_start[hi]):
        i, first, last, kind = runs[run, ROW], runs[run, FIRST], runs[run, LAST], runs[run, KIND]
        for j in range(first, last):
            own = omega[i, j]
            free = own > 0.0 if kind == SUPPORTED else True
            if kind == BOUNDED:
                free = own > floor[i, j] and own < ceiling[i, j]
            older[i, j] = before[i, j] - older[i, j] if free else 0.0
            before[i, j] = own - before[i, j] if free else 0.0


def _plane(omega, first_way, second_way, q, across, along, ground, runs, row_start, lo, hi):  # type: ignore[no-untyped-def]
    """Return a·R, b·R, a·Ga, a·Gb and b·Gb for two directions a and b, which are zero at contact nodes."""
    slope_a = slope_b = aa = ab = bb = 0.0
    for run in range(row_start[lo], row_start[hi]):
        i, first, last = runs[run, ROW], runs[run, FIRST], runs[run, LAST]
        for j in range(first, last):
            w, e = arm_at(across, i - 1, j - 1), arm_at(across, i - 1, j)
            s, n = arm_at(along, i - 1, j - 1), arm_at(along, i, j - 1)
            spring = 0.0 if runs[run, HOLD] == LOOSE else spring_at(ground, i - 1, j - 1)
            own, a, b = omega[i, j], first_way[i, j], second_way[i, j]
            reaction = w * (own - omega[i, j - 1]) + e * (own - omega[i, j + 1])
            reaction += s * (own - omega[i - 1, j]) + n * (own - omega[i + 1, j]) + q[i, j] + spring * own
            image_a = w * (a - first_way[i, j - 1]) + e * (a - first_way[i, j + 1])
            image_a += s * (a - first_way[i - 1, j]) + n * (a - first_way[i + 1, j]) + spring * a
            image_b = w * (b - second_way[i, j - 1]) + e * (b - second_way[i, j + 1])
            image_b += s * (b - second_way[i - 1, j]) + n * (b - second_way[i + 1, j]) + spring * b
            slope_a += a * reaction
            slope_b += b * reaction
            aa += a * image_a
            ab += b * image_a
            bb += b * image_b
    return slope_a, slope_b, aa, ab, bb


def _advance(  # type: ignore[no-untyped-def]
    omega, moved, first_way, first_length, second_way, second_length, floor, ceiling, runs, row_start, lo, hi
):
    """Write ω + a combination of two directions; return at how many nodes that leaves the bounds."""
    beyond = 0
    for run in range(row_start[lo], row_start[hi]):
        i, first, last, kind = runs[run, ROW], runs[run, FIRST], runs[run, LAST], runs[run, KIND]
        for j in range(first, last):
            value = omega[i, j] + (first_length * first_way[i, j] + second_length * second_way[i, j])
            moved[i, j] = value
            if kind == SUPPORTED:
                beyond += value < 0.0
            elif kind == BOUNDED:
                beyond += value < floor[i, j] or value > ceiling[i, j]
    return beyond


@njit(
    [
        f"void({GRID}, {GRID}, {GRID}, int64, int64, {weights}, {GRID}, {GRID}, {RUNS}, int64[::1], int64, int64)"
        for weights in ("float64", WEIGHTS)
    ],
    cache=True,
    nogil=True,
    error_model="numpy",
)
def start_from_coarse(  # type: ignore[no-untyped-def]
    omega, height, coarse, row_coarsening, column_coarsening, weights, floor, ceiling, runs, row_start, lo, hi
):
    """Write ω = height - interpolated coarse deflection, within the bounds."""
    row = np.zeros(omega.shape[1])
    for i in range(lo, hi):
        _expand_row(coarse, i, row_coarsening, column_coarsening, weights, row)
        for run in range(row_start[i], row_start[i + 1]):
            first, last = runs[run, FIRST], runs[run, LAST]
            lower = 0.0 if runs[run, KIND] == SUPPORTED else -np.inf
            for j in range(first, last):
                omega[i, j] = max(lower, height[i, j] - row[j])
            if runs[run, KIND] == BOUNDED:
                for j in range(first, last):
                    omega[i, j] = min(ceiling[i, j], max(floor[i, j], omega[i, j]))


class LatticeKernels(NamedTuple):
    """The passes over the lattice, compiled for equal or for varying arms."""

    sweep: Any
    energy_slope: Any
    directions: Any
    plane: Any
    advance: Any


class ExchangeKernels(NamedTuple):
    """The passes between the lattice and the first coarse level, compiled."""

    restrict_residual: Any
    correct: Any


@cache
def lattice_kernels(kind: ArmKind) -> LatticeKernels:
    """Compile the passes for arms of a kind (see `stiffness_types`), or load them."""
    problem = f"{GRID}, {GRID}, {stiffness_types(kind)}, {_PLACE}"
    return LatticeKernels(
        sweep=_compiled(_sweep, f"void({_bounded(kind)}, int64, int64, int64, int64)"),
        energy_slope=_compiled(_energy_slope, f"UniTuple(float64, 2)({GRID}, {problem}, int64, int64)"),
        directions=_compiled(_directions, f"void({GRID}, {GRID}, {GRID}, {GRID}, {GRID}, {_PLACE}, int64, int64)"),
        plane=_compiled(_plane, f"UniTuple(float64, 5)({GRID}, {GRID}, {problem}, int64, int64)"),
        advance=_compiled(
            _advance,
            f"int64({GRID}, {GRID}, {GRID}, float64, {GRID}, float64, {GRID}, {GRID}, {_PLACE}, int64, int64)",
        ),
    )


@cache
def exchange_kernels(kind: ArmKind, coarser: str) -> ExchangeKernels:
    """Compile the passes for arms of a kind and vectors of "float32" or "float64" below, or load them."""
    weights = WEIGHTS if kind == "varying" else "float64"
    coarse, exchange = f"{coarser}[:, ::1]", f"int64, int64, {weights}, float64, int64, int64"
    correction = f"{GRID}, {GRID}, {coarse}, int64, int64, {weights}, {GRID}, {GRID}, {_PLACE}, int64, int64"
    return ExchangeKernels(
        restrict_residual=_compiled(
            _restrict_residual,
            f"Tuple((int64, float64))({_bounded(kind)}, uint8[:, ::1], uint8[::1], {coarse}, {exchange})",
        ),
        correct=_compiled(_correct, f"int64({correction})"),
    )


_PLACE = f"{RUNS}, int64[::1]"


def stiffness_types(kind: ArmKind) -> str:
    """Return the types of the stiffnesses across, along and to the ground, as a signature has them."""
    arms = GRID if kind == "varying" else "float64"
    ground = "float64" if kind == "equal" else GRID
    return f"{arms}, {arms}, {ground}"


def _bounded(kind: ArmKind) -> str:
    return f"{GRID}, {GRID}, {stiffness_types(kind)}, {GRID}, {GRID}, {_PLACE}"


def _compiled(function: Any, signature: str) -> Any:
    return njit(signature, cache=True, nogil=True, error_model="numpy", fastmath=_FAST)(function)
