"""Compiled passes of the estimates of a spectral radius: interpolation and Lanczos steps.

Nets and vectors have a ring of points about them that are no nodes, so that no neighbour needs a test; vectors are zero
wherever there is no node. ``across`` and ``along`` are the elements of the Jacobi matrix that join nodes side by side
and one above the other.

Compiling takes longer than most solves (these two: half a second), so only what would pass over nets many times is
compiled, and in as few loops as will do. They run over slices and count from zero: only such are vectorised. Estimates
need no certain rounding, so that sums may be taken in any order.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

_SUMS = {"contract", "nsz", "reassoc"}
_NET = "boolean[::1]"
_GRID = "float64[:, ::1]"
_LINE = "float64[::1]"


@njit(f"float64({_GRID}, int64, int64, boolean[:, ::1], {_GRID})", cache=True, fastmath=_SUMS, error_model="numpy")
def prolong(coarse, high, wide, net, fine):  # type: ignore[no-untyped-def]
    """Interpolate linearly between the middles of the blocks; write the moduli at the nodes of ``net``.

    Returns their sum of squares. Blocks are of ``high`` by ``wide`` points, at most two by two. The last one of an odd
    length reaches into the ring.
    """
    blocks = coarse.shape[1] - 2
    line = np.empty(blocks + 2)
    finer = np.empty(2 * blocks + 2) if wide == 2 else line
    squares = 0.0
    for i in range(1, net.shape[0] - 1):
        near = (i + high - 1) // high
        # The other row of blocks that the point is next to: the one above for the upper point of a block.
        far = near + (high - 1) * (1 - 2 * (i % 2))
        one, other = coarse[near], coarse[far]
        for k in range(line.size):
            line[k] = 0.75 * one[k] + 0.25 * other[k]
        if wide == 2:
            for k in range(blocks):
                finer[2 * k + 1] = 0.75 * line[k + 1] + 0.25 * line[k]
                finer[2 * k + 2] = 0.75 * line[k + 1] + 0.25 * line[k + 2]
        node, values, here = net[i, 1:-1], finer[1:], fine[i, 1:-1]
        for k in range(here.size):
            value = abs(values[k]) if node[k] else 0.0
            here[k] = value
            squares += value * value
    return squares


@njit(
    f"UniTuple(float64, 2)({_NET}, int64, {_LINE}, {_LINE}, {_LINE}, float64, float64, float64, float64)",
    cache=True,
    fastmath=_SUMS,
    error_model="numpy",
)
def lanczos_step(net, width, vector, before, product, across, along, scale, back):  # type: ignore[no-untyped-def]
    """Write the next vector of a Lanczos basis; return the new diagonal element and the vector's length.

    Grids are given row after row, ``width`` points each. With v = ``scale`` times ``vector``, a unit vector, and B the
    Jacobi matrix, the element is α = v'Bv, and Bv - αv - ``back`` times ``before`` is written to ``product``. Vectors
    keep their lengths, so that no pass scales them.
    """
    size = vector.size - 2 * width
    here, north, south = vector[width:], vector[:size], vector[2 * width :]
    west, east = vector[width - 1 :], vector[width + 1 :]
    node, old, new = net[width:], before[width:], product[width:]
    total = squares = 0.0
    for k in range(size):
        value = across * (west[k] + east[k]) + along * (north[k] + south[k])
        value = value if node[k] else 0.0
        total += here[k] * value
        new[k] = scale * value - back * old[k]
    diagonal = scale * scale * total
    share = scale * diagonal
    for k in range(size):
        value = new[k] - share * here[k]
        new[k] = value
        squares += value * value
    return diagonal, math.sqrt(squares)
