"""Compiled sweeps of projected over-relaxation.

All lattice kernels work on arrays with a ring of frame points about the net, so that no neighbour needs a test, and
on runs: (row, first column, one past the last column) of the nodes of a row that follow each other without a gap.
``drive`` is q_i/G_ii, ``lower`` is 0 at supported nodes and -inf at others, ``across`` and ``along`` are the
stiffnesses of a horizontal and of a vertical arm over G_ii.

The answer's certificate is computed elsewhere from the result, so the sweeps may contract products and sums.
"""

from __future__ import annotations

from numba import njit

_CONTRACT = {"contract", "nsz"}
_GRID = "float64[:, ::1]"
_LATTICE = f"{_GRID}, {_GRID}, {_GRID}, int64[:, ::1], float64, float64, float64"


@njit(f"Tuple((int64, float64))({_LATTICE}, int64, float64)", cache=True, fastmath=_CONTRACT, error_model="numpy")
def lexicographic_sweeps(omega, drive, lower, runs, across, along, beta, sweeps, small):  # type: ignore[no-untyped-def]
    """Sweep row by row; return the number of sweeps done and the largest step of the last one.

    Cryer (1971): ω_i ← max(lower_i, ω_i - β R_i/G_ii) with the newest values. Stops early once the largest step of
    a sweep is below ``small``.
    """
    # The western neighbour is the only operand that waits for the node before: one product and sum and the clip.
    keep, west_weight = 1.0 - beta, beta * across
    step = 0.0
    for sweep in range(sweeps):
        step = 0.0
        for run in range(runs.shape[0]):
            i, first, last = runs[run, 0], runs[run, 1], runs[run, 2]
            west = omega[i, first - 1]
            for j in range(first, last):
                old = omega[i, j]
                others = across * omega[i, j + 1] + along * (omega[i - 1, j] + omega[i + 1, j]) - drive[i, j]
                candidate = (keep * old + beta * others) + west_weight * west
                bound = lower[i, j]
                west = candidate if candidate > bound else bound
                omega[i, j] = west
                change = abs(west - old)
                step = change if change > step else step
        if step < small:
            return sweep + 1, step
    return sweeps, step


@njit(f"Tuple((int64, float64))({_LATTICE}, int64, float64)", cache=True, fastmath=_CONTRACT, error_model="numpy")
def red_black_sweeps(omega, drive, lower, runs, across, along, beta, sweeps, small):  # type: ignore[no-untyped-def]
    """Sweep over the points with even row + column, then over the others; otherwise as `lexicographic_sweeps`."""
    keep = 1.0 - beta
    step = 0.0
    for sweep in range(sweeps):
        step = 0.0
        for colour in range(2):
            for run in range(runs.shape[0]):
                i, first, last = runs[run, 0], runs[run, 1], runs[run, 2]
                for j in range(first + (i + first + colour) % 2, last, 2):
                    old = omega[i, j]
                    others = (
                        across * (omega[i, j - 1] + omega[i, j + 1])
                        + along * (omega[i - 1, j] + omega[i + 1, j])
                        - drive[i, j]
                    )
                    candidate = keep * old + beta * others
                    new = candidate if candidate > lower[i, j] else lower[i, j]
                    omega[i, j] = new
                    change = abs(new - old)
                    step = change if change > step else step
        if step < small:
            return sweep + 1, step
    return sweeps, step


@njit(f"float64({_GRID}, {_GRID}, {_GRID}, int64[:, ::1], float64, float64, float64)", cache=True, error_model="numpy")
def lattice_residual(omega, drive, lower, runs, across, along, weight):  # type: ignore[no-untyped-def]
    """Return max |min(ω_i - lower_i, weight R_i/G_ii)| over the nodes."""
    worst = 0.0
    for run in range(runs.shape[0]):
        i, first, last = runs[run, 0], runs[run, 1], runs[run, 2]
        for j in range(first, last):
            pull = across * (omega[i, j - 1] + omega[i, j + 1]) + along * (omega[i - 1, j] + omega[i + 1, j])
            force = weight * (omega[i, j] + drive[i, j] - pull)
            worst = max(worst, abs(min(omega[i, j] - lower[i, j], force)))
    return worst


_ROWS = "int32[::1], int32[::1], float64[::1]"
_VECTORS = "float64[::1], float64[::1], float64[::1], float64[::1], float64[::1]"


@njit(
    f"Tuple((int64, float64))({_ROWS}, {_VECTORS}, float64, int64, float64)",
    cache=True,
    fastmath=_CONTRACT,
    error_model="numpy",
)
def sparse_sweeps(indptr, indices, data, diagonal, q, lower, unit, omega, beta, sweeps, small):  # type: ignore[no-untyped-def]
    """Sweep over the rows of a sparse G in their order; otherwise as `lexicographic_sweeps`.

    Steps are measured in units of ``unit``, one for each unknown.
    """
    step = 0.0
    for sweep in range(sweeps):
        step = 0.0
        for i in range(q.size):
            reaction = q[i]
            for k in range(indptr[i], indptr[i + 1]):
                reaction += data[k] * omega[indices[k]]
            old = omega[i]
            candidate = old - beta * reaction / diagonal[i]
            new = candidate if candidate > lower[i] else lower[i]
            omega[i] = new
            change = unit[i] * abs(new - old)
            step = change if change > step else step
        if step < small:
            return sweep + 1, step
    return sweeps, step


@njit(f"float64({_ROWS}, {_VECTORS}, float64)", cache=True, error_model="numpy")
def sparse_residual(indptr, indices, data, diagonal, q, lower, unit, omega, weight):  # type: ignore[no-untyped-def]
    """Return max |min(ω_i - lower_i, weight R_i/G_ii)| over the rows."""
    worst = 0.0
    for i in range(q.size):
        reaction = q[i]
        for k in range(indptr[i], indptr[i + 1]):
            reaction += data[k] * omega[indices[k]]
        worst = max(worst, unit[i] * abs(min(omega[i] - lower[i], weight * reaction / diagonal[i])))
    return worst
