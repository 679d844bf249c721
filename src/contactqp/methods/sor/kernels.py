"""Compiled sweeps of projected over-relaxation.

All lattice kernels work on arrays with a ring of frame points about the nodes, so that no neighbour needs a test, and
on runs of nodes of one kind (see `contactqp.geometry.runs`). ``drive`` is q_i/G_ii, ``across`` and ``along`` are the
stiffnesses of a horizontal and of a vertical arm over G_ii, ``floor`` and ``ceiling`` the bounds of the nodes that are
`BOUNDED`; they are empty where there are none.

The answer's certificate is computed elsewhere from the result, so the sweeps may contract products and sums.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ...geometry.numbering_kernels import GRID, READ_ONLY_VECTOR, RUNS
from ...geometry.runs import BOUNDED, FIRST, KIND, LAST, ROW, SUPPORTED

_CONTRACT = {"contract", "nsz"}
_LATTICE = f"{GRID}, {GRID}, {GRID}, {GRID}, {RUNS}, float64, float64, float64"


@njit(f"Tuple((int64, float64))({_LATTICE}, int64, float64)", cache=True, fastmath=_CONTRACT, error_model="numpy")
def lexicographic_sweeps(  # type: ignore[no-untyped-def]
    omega, drive, floor, ceiling, runs, across, along, beta, sweeps, small
):
    """Sweep row by row; return the number of sweeps done and the largest step of the last one.

    Cryer (1971): ω_i ← max(l_i, min(u_i, ω_i - β R_i/G_ii)) with the newest values. Stops early once the largest step
    of a sweep is below ``small``.
    """
    # The western neighbour is the only operand that waits for the node before: one product and sum and the clip.
    keep, west_weight = 1.0 - beta, beta * across
    step = 0.0
    for sweep in range(sweeps):
        step = 0.0
        for run in range(runs.shape[0]):
            i, first, last, kind = runs[run, ROW], runs[run, FIRST], runs[run, LAST], runs[run, KIND]
            west = omega[i, first - 1]
            bound = 0.0 if kind == SUPPORTED else -np.inf
            if kind == BOUNDED:
                for j in range(first, last):
                    old = omega[i, j]
                    others = across * omega[i, j + 1] + along * (omega[i - 1, j] + omega[i + 1, j]) - drive[i, j]
                    candidate = (keep * old + beta * others) + west_weight * west
                    west = min(ceiling[i, j], max(floor[i, j], candidate))
                    omega[i, j] = west
                    step = max(step, abs(west - old))
                continue
            for j in range(first, last):
                old = omega[i, j]
                others = across * omega[i, j + 1] + along * (omega[i - 1, j] + omega[i + 1, j]) - drive[i, j]
                candidate = (keep * old + beta * others) + west_weight * west
                west = candidate if candidate > bound else bound
                omega[i, j] = west
                change = abs(west - old)
                step = change if change > step else step
        if step < small:
            return sweep + 1, step
    return sweeps, step


@njit(f"Tuple((int64, float64))({_LATTICE}, int64, float64)", cache=True, fastmath=_CONTRACT, error_model="numpy")
def red_black_sweeps(  # type: ignore[no-untyped-def]
    omega, drive, floor, ceiling, runs, across, along, beta, sweeps, small
):
    """Sweep over the points with even row + column, then over the others; otherwise as `lexicographic_sweeps`."""
    keep = 1.0 - beta
    step = 0.0
    for sweep in range(sweeps):
        step = 0.0
        for colour in range(2):
            for run in range(runs.shape[0]):
                i, first, last, kind = runs[run, ROW], runs[run, FIRST], runs[run, LAST], runs[run, KIND]
                bound = 0.0 if kind == SUPPORTED else -np.inf
                for j in range(first + (i + first + colour) % 2, last, 2):
                    old = omega[i, j]
                    others = (
                        across * (omega[i, j - 1] + omega[i, j + 1])
                        + along * (omega[i - 1, j] + omega[i + 1, j])
                        - drive[i, j]
                    )
                    candidate = keep * old + beta * others
                    new = candidate if candidate > bound else bound
                    if kind == BOUNDED:
                        new = min(ceiling[i, j], max(floor[i, j], candidate))
                    omega[i, j] = new
                    change = abs(new - old)
                    step = change if change > step else step
        if step < small:
            return sweep + 1, step
    return sweeps, step


@njit(f"float64({GRID}, {GRID}, {GRID}, {GRID}, {RUNS}, float64, float64, float64)", cache=True, error_model="numpy")
def lattice_residual(omega, drive, floor, ceiling, runs, across, along, weight):  # type: ignore[no-untyped-def]
    """Return the largest modulus of the natural residual, with ``weight`` times R_i/G_ii in place of R_i/G_ii.

    Of nodes that have the lower bound 0 alone it is min(ω_i, weight R_i/G_ii).
    """
    worst = 0.0
    for run in range(runs.shape[0]):
        i, first, last, kind = runs[run, ROW], runs[run, FIRST], runs[run, LAST], runs[run, KIND]
        for j in range(first, last):
            pull = across * (omega[i, j - 1] + omega[i, j + 1]) + along * (omega[i - 1, j] + omega[i + 1, j])
            force = weight * (omega[i, j] + drive[i, j] - pull)
            if kind == SUPPORTED:
                force = min(omega[i, j], force)
            elif kind == BOUNDED:
                force = max(min(omega[i, j] - floor[i, j], force), omega[i, j] - ceiling[i, j])
            worst = max(worst, abs(force))
    return worst


_ROWS = f"int32[::1], int32[::1], {READ_ONLY_VECTOR}"
_VECTORS = f"{READ_ONLY_VECTOR}, {READ_ONLY_VECTOR}, {READ_ONLY_VECTOR}, {READ_ONLY_VECTOR}, float64[::1], float64[::1]"


@njit(
    f"Tuple((int64, float64))({_ROWS}, {_VECTORS}, float64, int64, float64)",
    cache=True,
    fastmath=_CONTRACT,
    error_model="numpy",
)
def sparse_sweeps(  # type: ignore[no-untyped-def]
    indptr, indices, data, diagonal, q, lower, upper, unit, omega, beta, sweeps, small
):
    """Sweep over the rows of a sparse G in their order; otherwise as `lexicographic_sweeps`.

    Steps are measured in units of ``unit``, one for each unknown. ``upper`` is empty where there is no upper bound.
    """
    capped, step = upper.size > 0, 0.0
    for sweep in range(sweeps):
        step = 0.0
        for i in range(q.size):
            reaction = q[i]
            for k in range(indptr[i], indptr[i + 1]):
                reaction += data[k] * omega[indices[k]]
            old = omega[i]
            candidate = old - beta * reaction / diagonal[i]
            new = candidate if candidate > lower[i] else lower[i]
            if capped:
                new = min(new, upper[i])
            omega[i] = new
            change = unit[i] * abs(new - old)
            step = change if change > step else step
        if step < small:
            return sweep + 1, step
    return sweeps, step


@njit(f"float64({_ROWS}, {_VECTORS}, float64)", cache=True, error_model="numpy")
def sparse_residual(  # type: ignore[no-untyped-def]
    indptr, indices, data, diagonal, q, lower, upper, unit, omega, weight
):
    """Return the largest modulus of the natural residual over the rows; see `lattice_residual`."""
    worst = 0.0
    for i in range(q.size):
        reaction = q[i]
        for k in range(indptr[i], indptr[i + 1]):
            reaction += data[k] * omega[indices[k]]
        residual = min(omega[i] - lower[i], weight * reaction / diagonal[i])
        if upper.size > 0:
            residual = max(residual, omega[i] - upper[i])
        worst = max(worst, unit[i] * abs(residual))
    return worst
