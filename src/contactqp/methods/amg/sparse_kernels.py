"""Compiled Gauss-Seidel sweeps over the rows of a sparse matrix, and over blocks of them, which threads share.

What a block needs of the others is as it was before the sweep, so that no result depends on how fast a thread is.
"""

from __future__ import annotations

from numba import njit

from ...geometry.numbering_kernels import READ_ONLY_VECTOR

_ROWS = f"int32[::1], int32[::1], {READ_ONLY_VECTOR}"
_FAST = {"contract", "nsz"}


@njit(
    f"void({_ROWS}, float64[::1], {READ_ONLY_VECTOR}, float64[::1], int64, int64)",
    cache=True,
    nogil=True,
    fastmath=_FAST,
)
def sweep_from_zero(indptr, indices, data, inverse_diagonal, right, x, first, last):  # type: ignore[no-untyped-def]
    """Sweep once forwards over a block of rows of A x = right, from x = 0 in this block and in all others.

    Columns are in ascending order, so only those of the block before the diagonal count.
    """
    for i in range(first, last):
        residual = right[i]
        for entry in range(indptr[i], indptr[i + 1]):
            j = indices[entry]
            if j >= i:
                break
            if j >= first:
                residual -= data[entry] * x[j]
        x[i] = residual * inverse_diagonal[i]


@njit(f"void({_ROWS}, float64[::1], float64[::1], float64[::1], int64, int64)", cache=True, nogil=True, fastmath=_FAST)
def residual_after_sweep(indptr, indices, data, inverse_diagonal, x, out, first, last):  # type: ignore[no-untyped-def]
    """Write right - A x after `sweep_from_zero`, and zero for unknowns that are held, whose inverse diagonal is zero.

    The sweep has met the equation of row i with what it knew: the diagonal and the entries of the block before it. So
    only the others are left.
    """
    for i in range(first, last):
        total = 0.0
        if inverse_diagonal[i] != 0.0:
            for entry in range(indptr[i + 1] - 1, indptr[i] - 1, -1):
                j = indices[entry]
                if j <= i:
                    break
                total -= data[entry] * x[j]
            if first > 0:
                for entry in range(indptr[i], indptr[i + 1]):
                    j = indices[entry]
                    if j >= first:
                        break
                    total -= data[entry] * x[j]
        out[i] = total


@njit(
    f"void({_ROWS}, float64[::1], {READ_ONLY_VECTOR}, float64[::1], float64[::1], int64, int64)",
    cache=True,
    nogil=True,
    fastmath=_FAST,
)
def add_prolongation(indptr, indices, data, inverse_diagonal, coarse, x, copy, first, last):  # type: ignore[no-untyped-def]
    """Add P times a coarse vector to x, but to no unknown that is held, whose inverse diagonal is zero; copy it."""
    for i in range(first, last):
        if inverse_diagonal[i] != 0.0:
            total = 0.0
            for entry in range(indptr[i], indptr[i + 1]):
                total += data[entry] * coarse[indices[entry]]
            x[i] += total
        copy[i] = x[i]


@njit(
    f"void({_ROWS}, float64[::1], {READ_ONLY_VECTOR}, float64[::1], float64[::1], int64, int64)",
    cache=True,
    nogil=True,
    fastmath=_FAST,
)
def sweep_backwards(indptr, indices, data, inverse_diagonal, right, before, x, first, last):  # type: ignore[no-untyped-def]
    """Sweep once backwards over a block of rows of A x = right, with x as it was ``before`` in all other blocks."""
    for i in range(last - 1, first - 1, -1):
        residual = right[i]
        entry, end = indptr[i], indptr[i + 1]
        while entry < end and indices[entry] < first:
            residual -= data[entry] * before[indices[entry]]
            entry += 1
        while entry < end and indices[entry] < last:
            residual -= data[entry] * x[indices[entry]]
            entry += 1
        while entry < end:
            residual -= data[entry] * before[indices[entry]]
            entry += 1
        x[i] += residual * inverse_diagonal[i]


@njit(
    f"int64({_ROWS}, float64[::1], {READ_ONLY_VECTOR}, {READ_ONLY_VECTOR}, {READ_ONLY_VECTOR}, float64[::1], int64)",
    cache=True,
    nogil=True,
    fastmath=_FAST,
)
def projected_sweeps(  # type: ignore[no-untyped-def]
    indptr, indices, data, inverse_diagonal, q, lower, upper, omega, sweeps
):
    """Relax G ω + q by projected Gauss-Seidel, forwards and backwards in turn; return how often ω met a bound.

    ``upper`` is empty where there is no upper bound.
    """
    held, capped = 0, upper.size > 0
    for count in range(sweeps):
        held = 0
        for k in range(omega.size):
            i = omega.size - 1 - k if count % 2 else k
            reaction = q[i]
            for entry in range(indptr[i], indptr[i + 1]):
                reaction += data[entry] * omega[indices[entry]]
            candidate = omega[i] - reaction * inverse_diagonal[i]
            held += candidate <= lower[i]
            candidate = max(lower[i], candidate)
            if capped:
                held += candidate >= upper[i]
                candidate = min(upper[i], candidate)
            omega[i] = candidate
    return held
