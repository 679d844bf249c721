"""Compiled Gauss-Seidel sweeps over the rows of a sparse matrix."""

from __future__ import annotations

from numba import njit

from ...geometry.numbering_kernels import READ_ONLY_VECTOR

_ROWS = f"int32[::1], int32[::1], {READ_ONLY_VECTOR}"
_FAST = {"contract", "nsz"}


@njit(f"void({_ROWS}, float64[::1], {READ_ONLY_VECTOR}, float64[::1], boolean)", cache=True, nogil=True, fastmath=_FAST)
def sweep(indptr, indices, data, inverse_diagonal, right, x, backwards):  # type: ignore[no-untyped-def]
    """Sweep once over A x = right, forwards or backwards."""
    for k in range(x.size):
        i = x.size - 1 - k if backwards else k
        residual = right[i]
        for entry in range(indptr[i], indptr[i + 1]):
            residual -= data[entry] * x[indices[entry]]
        x[i] += residual * inverse_diagonal[i]


@njit(f"void({_ROWS}, float64[::1], {READ_ONLY_VECTOR}, float64[::1])", cache=True, nogil=True, fastmath=_FAST)
def sweep_from_zero(indptr, indices, data, inverse_diagonal, right, x):  # type: ignore[no-untyped-def]
    """Sweep once forwards from x = 0; columns are in ascending order, so only those before the diagonal count."""
    for i in range(x.size):
        residual = right[i]
        for entry in range(indptr[i], indptr[i + 1]):
            j = indices[entry]
            if j >= i:
                break
            residual -= data[entry] * x[j]
        x[i] = residual * inverse_diagonal[i]


@njit(
    f"void({_ROWS}, float64[::1], {READ_ONLY_VECTOR}, float64[::1], float64[::1])",
    cache=True,
    nogil=True,
    fastmath=_FAST,
)
def residual(indptr, indices, data, inverse_diagonal, right, x, out):  # type: ignore[no-untyped-def]
    """Write right - A x, and zero for unknowns that are held, whose inverse diagonal is zero."""
    for i in range(x.size):
        total = 0.0
        if inverse_diagonal[i] != 0.0:
            total = right[i]
            for entry in range(indptr[i], indptr[i + 1]):
                total -= data[entry] * x[indices[entry]]
        out[i] = total


@njit(
    f"void({_ROWS}, float64[::1], {READ_ONLY_VECTOR}, float64[::1])",
    cache=True,
    nogil=True,
    fastmath=_FAST,
)
def add_prolongation(indptr, indices, data, inverse_diagonal, coarse, x):  # type: ignore[no-untyped-def]
    """Add P times a coarse vector to x, but to no unknown that is held, whose inverse diagonal is zero."""
    for i in range(x.size):
        if inverse_diagonal[i] != 0.0:
            total = 0.0
            for entry in range(indptr[i], indptr[i + 1]):
                total += data[entry] * coarse[indices[entry]]
            x[i] += total


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
