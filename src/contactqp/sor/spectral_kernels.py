"""Compiled passes of the estimates of a spectral radius: coarser nets, interpolation and Lanczos steps.

Nets and vectors have a ring of points about them that are no nodes, so that no neighbour needs a test; vectors are zero
wherever there is no node. ``ranges`` holds for each row the first node's column and one past the last node's, and
``across`` and ``along`` are the elements of the Jacobi matrix that join nodes side by side and one above the other.

Rows are cut to slices, whose loops count from zero: only such are vectorised. Estimates need no certain rounding, so
that sums may be taken in any order.
"""

from __future__ import annotations

import numpy as np
from numba import njit

_SUMS = {"contract", "nsz", "reassoc"}
_NET = "boolean[:, ::1]"
_RANGES = "int64[:, ::1]"
_GRID = "float64[:, ::1]"
_LINE = "float64[::1]"

_NEGLIGIBLE = 1e-10
"""A unit vector's product with the matrix that is so close to the Krylov space lies in it."""
_SHIFT = 1e-14
"""Distance of inverse iteration's shift from the eigenvalue: well above the rounding errors of a factorisation."""


@njit(f"void({_NET}, {_RANGES})", cache=True, error_model="numpy")
def row_ranges(net, ranges):  # type: ignore[no-untyped-def]
    """Write each row's range of nodes; that of an empty row is (1, 1)."""
    for i in range(net.shape[0]):
        first, last = 1, net.shape[1] - 1
        while first < last and not net[i, first]:
            first += 1
        if first == last:
            first, last = 1, 1
        while last > first and not net[i, last - 1]:
            last -= 1
        ranges[i, 0], ranges[i, 1] = first, last


@njit(f"int64({_NET}, int64, int64, {_NET})", cache=True, error_model="numpy")
def coarsen(net, high, wide, coarser):  # type: ignore[no-untyped-def]
    """Mark the blocks of ``high`` by ``wide`` points of which three quarters are nodes; return how many they are."""
    marked = 0
    for i in range(1, coarser.shape[0] - 1):
        # The last block of an odd length reaches into the ring. Four points are counted whatever the block: twice a
        # point, or four times, if it has fewer.
        upper, lower, blocks = net[high * (i - 1) + 1], net[high * i], coarser[i, 1:-1]
        for j in range(blocks.size):
            west, east = wide * j + 1, wide * (j + 1)
            nodes = upper[west] + upper[east] + lower[west] + lower[east]
            blocks[j] = nodes >= 3
            marked += nodes >= 3
    return marked


@njit(f"float64({_GRID}, int64, int64, {_NET}, {_RANGES}, {_GRID})", cache=True, fastmath=_SUMS, error_model="numpy")
def prolong(coarse, high, wide, net, ranges, fine):  # type: ignore[no-untyped-def]
    """Interpolate linearly between the middles of the blocks; write the moduli at the nodes of ``net``.

    Returns their sum of squares.
    """
    blocks = coarse.shape[1] - 2
    line = np.empty(blocks + 2)
    finer = np.empty(2 * blocks + 2) if wide == 2 else line
    squares = 0.0
    for i in range(1, net.shape[0] - 1):
        first, last = ranges[i, 0], ranges[i, 1]
        if first == last:
            continue
        near, far = i, i
        if high == 2:
            near = (i + 1) // 2
            far = near + 1 - 2 * (i % 2)
        for k in range(line.size):
            line[k] = 0.75 * coarse[near, k] + 0.25 * coarse[far, k]
        if wide == 2:
            for k in range(blocks):
                finer[2 * k + 1] = 0.75 * line[k + 1] + 0.25 * line[k]
                finer[2 * k + 2] = 0.75 * line[k + 1] + 0.25 * line[k + 2]
        node, values, here = net[i, first:last], finer[first:last], fine[i, first:last]
        for k in range(here.size):
            value = abs(values[k]) if node[k] else 0.0
            here[k] = value
            squares += value * value
    return squares


@njit(f"float64({_RANGES}, {_GRID}, float64, float64)", cache=True, fastmath=_SUMS, error_model="numpy")
def moment(ranges, vector, across, along):  # type: ignore[no-untyped-def]
    """Return the product of a vector with the Jacobi matrix times itself."""
    total = 0.0
    for i in range(1, vector.shape[0] - 1):
        first, last = ranges[i, 0], ranges[i, 1]
        here, east = vector[i, first:last], vector[i, first + 1 : last + 1]
        south = vector[i + 1, first:last]
        # Each arm once, from its western or northern end.
        for j in range(here.size):
            total += here[j] * (across * east[j] + along * south[j])
    return 2 * total


@njit(
    f"float64({_NET}, {_RANGES}, {_GRID}, {_GRID}, {_GRID}, float64, float64, float64, float64)",
    cache=True,
    fastmath=_SUMS,
    error_model="numpy",
)
def _multiplied(net, ranges, vector, before, product, across, along, scale, back):  # type: ignore[no-untyped-def]
    """Write scale times the matrix times ``vector``, less back times ``before``; return the `moment` of ``vector``."""
    total = 0.0
    for i in range(1, net.shape[0] - 1):
        first, last = ranges[i, 0], ranges[i, 1]
        node, old, new = net[i, first:last], before[i, first:last], product[i, first:last]
        here, north, south = vector[i, first:last], vector[i - 1, first:last], vector[i + 1, first:last]
        west, east = vector[i, first - 1 : last - 1], vector[i, first + 1 : last + 1]
        for j in range(here.size):
            value = across * (west[j] + east[j]) + along * (north[j] + south[j])
            value = value if node[j] else 0.0
            total += here[j] * value
            new[j] = scale * value - back * old[j]
    return total


@njit(f"float64({_RANGES}, {_GRID}, {_GRID}, float64)", cache=True, fastmath=_SUMS, error_model="numpy")
def _less(ranges, product, vector, share):  # type: ignore[no-untyped-def]
    """Take share times ``vector`` off ``product``; return the sum of squares left."""
    squares = 0.0
    for i in range(1, product.shape[0] - 1):
        first, last = ranges[i, 0], ranges[i, 1]
        here, new = vector[i, first:last], product[i, first:last]
        for j in range(here.size):
            value = new[j] - share * here[j]
            new[j] = value
            squares += value * value
    return squares


@njit(f"boolean({_LINE}, {_LINE}, int64, float64)", cache=True, error_model="numpy")
def _all_below(diagonal, beside, size, bound):  # type: ignore[no-untyped-def]
    """Whether all eigenvalues of a symmetric tridiagonal matrix are below a bound, by its pivots (Sturm)."""
    pivot = diagonal[0] - bound
    for k in range(1, size):
        if pivot >= 0.0:
            return False
        pivot = diagonal[k] - bound - beside[k - 1] ** 2 / pivot
    return pivot < 0.0


@njit(f"float64({_LINE}, {_LINE}, int64, {_LINE})", cache=True, error_model="numpy")
def largest_eigenpair(diagonal, beside, size, vector):  # type: ignore[no-untyped-def]
    """Return the largest eigenvalue of a symmetric tridiagonal matrix and write its unit vector.

    The elements beside the diagonal are positive, so the vector's are, too: inverse iteration from ones finds it, and
    subtracts nothing.
    """
    low = high = diagonal[0]
    for k in range(size):
        beside_both = (beside[k - 1] if k > 0 else 0.0) + (beside[k] if k < size - 1 else 0.0)
        low, high = max(low, diagonal[k]), max(high, diagonal[k] + beside_both)
    while high - low > 2.3e-16 * (abs(low) + abs(high)):
        middle = 0.5 * (low + high)
        if _all_below(diagonal, beside, size, middle):
            high = middle
        else:
            low = middle
    shift = high + _SHIFT * max(1.0, abs(high))
    pivots = np.empty(size)
    vector[:size] = 1.0
    for _ in range(3):
        pivots[0] = shift - diagonal[0]
        for k in range(1, size):
            pivots[k] = shift - diagonal[k] - beside[k - 1] ** 2 / pivots[k - 1]
            vector[k] += vector[k - 1] * beside[k - 1] / pivots[k - 1]
        vector[size - 1] /= pivots[size - 1]
        squares = vector[size - 1] ** 2
        for k in range(size - 2, -1, -1):
            vector[k] = (vector[k] + beside[k] * vector[k + 1]) / pivots[k]
            squares += vector[k] ** 2
        vector[:size] /= np.sqrt(squares)
    return low


@njit(
    f"Tuple((float64, int64))({_NET}, {_RANGES}, float64[:, :, ::1], float64, float64, int64, int64, float64, {_GRID})",
    cache=True,
    fastmath=_SUMS,
    error_model="numpy",
)
def lanczos(net, ranges, basis, across, along, fewest, most, ratio, ritz):  # type: ignore[no-untyped-def]
    """Do Lanczos steps from ``basis[0]``; return the largest Ritz value μ and the number of steps.

    Steps go on until they are ``ratio``/√(1 - μ), within ``fewest`` and ``most``. The vectors of the basis keep their
    lengths, so that no pass scales them. With ``most`` + 1 grids in ``basis`` the Ritz vector is written to ``ritz``;
    with fewer, of which three are enough, they are used in turn, and no vector is made.
    """
    slots = basis.shape[0]
    diagonal, beside, scales = np.empty(most), np.empty(most), np.empty(most)
    length = np.sqrt(_less(ranges, basis[0], basis[0], 0.0))
    steps, back = 0, 0.0
    while True:
        vector, product = basis[steps % slots], basis[(steps + 1) % slots]
        before = basis[(steps + slots - 1) % slots]
        scale = 1.0 / length
        total = _multiplied(net, ranges, vector, before, product, across, along, scale, back)
        scales[steps] = scale
        diagonal[steps] = scale * scale * total
        steps += 1
        if steps == most or (
            steps >= fewest and _all_below(diagonal, beside, steps, 1.0 - (ratio / steps) * (ratio / steps))
        ):
            break
        length = np.sqrt(_less(ranges, product, vector, scale * diagonal[steps - 1]))
        if length <= _NEGLIGIBLE:
            break
        beside[steps - 1] = length
        back = length * scale
    weights = np.empty(steps)
    mu = largest_eigenpair(diagonal, beside, steps, weights)
    if slots > most:
        for i in range(1, net.shape[0] - 1):
            first, last = ranges[i, 0], ranges[i, 1]
            here = ritz[i, first:last]
            here[:] = 0.0
            for k in range(steps):
                share, vector_row = weights[k] * scales[k], basis[k, i, first:last]
                for j in range(here.size):
                    here[j] += share * vector_row[j]
    return mu, steps
