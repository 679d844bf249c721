"""Compiled primal-dual active sets for many small load cases of one matrix, some of them side by side.

It is the iteration of `primal_dual` with Gauss-Seidel sweeps, and without what few unknowns do not need: coarser
problems, iterative solutions, and the plain method where the energy's safeguard leaves next to nothing of the steps. A
case that would need that is left unfinished.

The innermost loops run over the cases that stand side by side, in lanes, so that a processor does some of them in one
instruction. So does the factorisation, though each case has its own free nodes: the rows and columns of held ones are
those of a unit matrix. A case that is finished makes place for the next. Arrays have shape (n, lanes); the lower
factors, (n, width + PANEL, lanes), have in [j, d] the entry of column j and row j + d, and zeros where there is none.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ...geometry.numbering_kernels import READ_ONLY_VECTOR

_FAST = {"contract", "nsz"}
_ROUNDING = float(np.finfo(np.float64).eps)
_SWEEPS = 5

PANEL = 4
"""Columns that are subtracted together, see `contactqp.algebra.band_kernels`."""

_ROWS = f"int32[::1], int32[::1], {READ_ONLY_VECTOR}"
_READ_ONLY_ROWS = "Array(float64, 2, 'C', readonly=True)"


@njit(fastmath=_FAST)
def _product(indptr, indices, data, i, vectors, out):  # type: ignore[no-untyped-def]
    """Add row i of the matrix times each vector."""
    for entry in range(indptr[i], indptr[i + 1]):
        value, other = data[entry], vectors[indices[entry]]
        for lane in range(out.size):
            out[lane] += value * other[lane]


@njit(fastmath=_FAST)
def _clip(numbers, low, high):  # type: ignore[no-untyped-def]
    for lane in range(numbers.size):
        numbers[lane] = min(high, max(low, numbers[lane]))


@njit(fastmath=_FAST)
def _sweep(indptr, indices, data, lower, upper, diagonal, q, omega):  # type: ignore[no-untyped-def]
    """Relax by projected Gauss-Seidel, forwards and backwards in turn."""
    size = omega.shape[0]
    reaction = np.empty(omega.shape[1])
    for count in range(_SWEEPS):
        for k in range(size):
            i = size - 1 - k if count % 2 else k
            reaction[:] = q[i]
            _product(indptr, indices, data, i, omega, reaction)
            own, inverse = omega[i], 1 / diagonal[i]
            for lane in range(own.size):
                own[lane] -= reaction[lane] * inverse
            _clip(own, lower[i], upper[i])


@njit(fastmath=_FAST)
def _take(lower, upper, omega, side, free):  # type: ignore[no-untyped-def]
    """Take nodes for held by their lower (-1) or upper bound (1), or for free."""
    for i in range(omega.shape[0]):
        low, high = lower[i], upper[i]
        for lane in range(omega.shape[1]):
            below, above = omega[i, lane] <= low, omega[i, lane] >= high
            side[i, lane] = -1.0 if below else (1.0 if above else 0.0)
            free[i, lane] = 0.0 if below or above else 1.0


@njit(fastmath=_FAST)
def _lay_out(indptr, indices, data, free, factors, begin, end):  # type: ignore[no-untyped-def]
    """Write some columns of the free nodes' matrices where their factors will be."""
    lanes = factors.shape[2]
    for j in range(begin, end):
        factors[j] = 0.0
        one = free[j]
        for entry in range(indptr[j], indptr[j + 1]):
            if indices[entry] >= j:
                value, other, target = data[entry], free[indices[entry]], factors[j, indices[entry] - j]
                for lane in range(lanes):
                    target[lane] = value * one[lane] * other[lane]
        pivot = factors[j, 0]
        for lane in range(lanes):
            pivot[lane] += 1.0 - one[lane]


@njit(fastmath=_FAST)
def _factorise(indptr, indices, data, free, factors, definite):  # type: ignore[no-untyped-def]
    """Write the lower factors of the free nodes' matrices, and say in which lanes these exist."""
    size, _, lanes = factors.shape
    width = factors.shape[1] - PANEL
    definite[:] = True
    root = np.empty(lanes)
    laid_out = 0
    for first in range(0, size, PANEL):
        end = min(first + PANEL, size)
        # Columns are laid out when they are first needed, so that they are still in the processor's cache.
        ahead = min(end + width, size)
        _lay_out(indptr, indices, data, free, factors, laid_out, ahead)
        laid_out = ahead
        for j in range(first, end):
            pivot = factors[j, 0]
            for lane in range(lanes):
                good = 0.0 < pivot[lane] < 1e308
                definite[lane] &= good
                root[lane] = 1 / np.sqrt(pivot[lane] if good else 1.0)
            for d in range(width + 1):
                own = factors[j, d]
                for lane in range(lanes):
                    own[lane] *= root[lane]
            for other in range(j + 1, end):
                factor = factors[j, other - j]
                for d in range(width + 1 - (other - j)):
                    target, source = factors[other, d], factors[j, other - j + d]
                    for lane in range(lanes):
                        target[lane] -= factor[lane] * source[lane]
        for column in range(end, min(first + PANEL + width, size)):
            k = column - first
            a, b, c, e = (
                factors[first, k],
                factors[first + 1, k - 1],
                factors[first + 2, k - 2],
                factors[first + 3, k - 3],
            )
            for d in range(width + PANEL - k):
                target = factors[column, d]
                one, two = factors[first, k + d], factors[first + 1, k - 1 + d]
                three, four = factors[first + 2, k - 2 + d], factors[first + 3, k - 3 + d]
                for lane in range(lanes):
                    target[lane] -= (a[lane] * one[lane] + b[lane] * two[lane]) + (
                        c[lane] * three[lane] + e[lane] * four[lane]
                    )


@njit(fastmath=_FAST)
def _solve(factors, force):  # type: ignore[no-untyped-def]
    """Overwrite forces by the solutions of the equations whose factors are given."""
    size, _, lanes = factors.shape
    width = factors.shape[1] - PANEL + 1
    for j in range(size):
        last, own, pivot = min(width, size - j), force[j], factors[j, 0]
        for lane in range(lanes):
            own[lane] /= pivot[lane]
        for d in range(1, last):
            target, factor = force[j + d], factors[j, d]
            for lane in range(lanes):
                target[lane] -= factor[lane] * own[lane]
    for j in range(size - 1, -1, -1):
        last, own, pivot = min(width, size - j), force[j], factors[j, 0]
        for d in range(1, last):
            other, factor = force[j + d], factors[j, d]
            for lane in range(lanes):
                own[lane] -= factor[lane] * other[lane]
        for lane in range(lanes):
            own[lane] /= pivot[lane]


@njit(fastmath=_FAST)
def _correct(indptr, indices, data, q, free, factors, target, force):  # type: ignore[no-untyped-def]
    """Take the reaction of the free nodes away."""
    size, lanes = target.shape
    for i in range(size):
        own, chosen = force[i], free[i]
        own[:] = q[i]
        _product(indptr, indices, data, i, target, own)
        for lane in range(lanes):
            own[lane] *= chosen[lane]
    _solve(factors, force)
    for i in range(size):
        for lane in range(lanes):
            target[i, lane] -= force[i, lane]


@njit(fastmath=_FAST)
def _judge(indptr, indices, data, lower, upper, diagonal, q, side, omega, solved):  # type: ignore[no-untyped-def]
    """Say in which lanes no node is beyond its bound, and none in contact pulled from it, by more than rounding."""
    size, lanes = omega.shape
    beyond, pulled, reaction = np.zeros(lanes), np.zeros(lanes), np.empty(lanes)
    for i in range(size):
        for lane in range(lanes):
            beyond[lane] = max(beyond[lane], 4 * _ROUNDING * abs(omega[i, lane]))
            pulled[lane] = max(pulled[lane], 8 * _ROUNDING * diagonal[i] * abs(omega[i, lane]))
    solved[:] = True
    for i in range(size):
        reaction[:] = q[i]
        _product(indptr, indices, data, i, omega, reaction)
        low, high = lower[i], upper[i]
        for lane in range(lanes):
            within = low - beyond[lane] <= omega[i, lane] <= high + beyond[lane]
            pressed = side[i, lane] * reaction[lane] <= pulled[lane]
            solved[lane] &= within & pressed


@njit(fastmath=_FAST)
def _move(indptr, indices, data, lower, upper, q, target, way, omega):  # type: ignore[no-untyped-def]
    """Go to the projected targets, or to the points of least energy on the way."""
    size, lanes = omega.shape
    slope, curvature, product = np.zeros(lanes), np.zeros(lanes), np.empty(lanes)
    for i in range(size):
        own, goal, start = way[i], target[i], omega[i]
        own[:] = goal
        _clip(own, lower[i], upper[i])
        for lane in range(lanes):
            own[lane] -= start[lane]
    for i in range(size):
        product[:] = q[i]
        _product(indptr, indices, data, i, omega, product)
        for lane in range(lanes):
            slope[lane] += way[i, lane] * product[lane]
        product[:] = 0.0
        _product(indptr, indices, data, i, way, product)
        for lane in range(lanes):
            curvature[lane] += way[i, lane] * product[lane]
    for lane in range(lanes):
        whole = slope[lane] + curvature[lane] <= 0 or curvature[lane] <= 0
        product[lane] = 1.0 if whole else max(0.0, -slope[lane] / curvature[lane])
    for i in range(size):
        for lane in range(lanes):
            omega[i, lane] += product[lane] * way[i, lane]
        _clip(omega[i], lower[i], upper[i])


@njit(
    f"void({_ROWS}, {READ_ONLY_VECTOR}, {READ_ONLY_VECTOR}, {READ_ONLY_VECTOR}, {_READ_ONLY_ROWS}, int64, int64, "
    "int64, float64[:, ::1], int64[::1], int64, int64)",
    cache=True,
    nogil=True,
    fastmath=_FAST,
    error_model="numpy",
)
def solve_cases(  # type: ignore[no-untyped-def]
    indptr, indices, data, lower, upper, diagonal, forces, width, lanes, most, gaps, steps, begun, end
):
    """Write the gaps of the cases [begun, end), and their numbers of steps: 0 where ``most`` did not finish one.

    ``forces`` and ``gaps`` have shape (cases, n); ``width`` is that of the matrix's band, counted beside the diagonal.
    Zero lies between the bounds.
    """
    size = forces.shape[1]
    shape = size, lanes
    q, omega, side, free = np.zeros(shape), np.zeros(shape), np.zeros(shape), np.zeros(shape)
    target, other = np.zeros(shape), np.zeros(shape)
    factors = np.empty((size, width + PANEL, lanes))
    definite, solved = np.ones(lanes, dtype=np.bool_), np.ones(lanes, dtype=np.bool_)
    at_work, done = np.full(lanes, -1), np.zeros(lanes, dtype=np.int64)
    under_way = 0
    while True:
        for lane in range(lanes):
            case = at_work[lane]
            if case >= 0 and (solved[lane] or not definite[lane] or done[lane] == most):
                steps[case] = done[lane] if solved[lane] and definite[lane] else 0
                for i in range(size):
                    gaps[case, i] = min(upper[i], max(lower[i], target[i, lane]))
                at_work[lane] = -1
                under_way -= 1
            if at_work[lane] < 0 and begun < end:
                for i in range(size):
                    q[i, lane], omega[i, lane] = forces[begun, i], 0.0
                at_work[lane], done[lane] = begun, 0
                begun, under_way = begun + 1, under_way + 1
        if under_way == 0:
            return
        _sweep(indptr, indices, data, lower, upper, diagonal, q, omega)
        _take(lower, upper, omega, side, free)
        _factorise(indptr, indices, data, free, factors, definite)
        target[:] = omega
        # Twice, as the first correction has the rounding errors of what it took away.
        _correct(indptr, indices, data, q, free, factors, target, other)
        _correct(indptr, indices, data, q, free, factors, target, other)
        _judge(indptr, indices, data, lower, upper, diagonal, q, side, target, solved)
        _move(indptr, indices, data, lower, upper, q, target, other, omega)
        for lane in range(lanes):
            done[lane] += 1
