"""Compiled Galerkin products for equal arms: Pᵀ A P of an operator A that is truncated at the contact nodes.

P is bilinear interpolation by a factor 2 or 1 in each direction, and these are the coarse operators. A coarse entry
depends on the finer operator within a window of as many points as the factor to each side. Where the finer operator is
the same everywhere in the window, the entry is a constant that is known beforehand; only the surroundings of the frame
and of the free boundary are computed.

``kind`` is 0 where the operator's row is zero (a contact node, a frame point, a coarse point without a basis function),
1 where it is the constant one, and 2 elsewhere; stencils are those of `level_kernels`.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numba import njit

from ...geometry.arm_kernels import spring_at
from .lattice_kernels import ArmKind, stiffness_types

_DAMPING = 16.0 / 9.0
_TINY = float(np.finfo(np.float32).tiny)
"""Below it a diagonal entry has no inverse in single precision; its point goes without a correction."""
_STENCIL = "float32[:, :, ::1]"
_KIND = "uint8[:, ::1]"
_ROWS = "uint8[::1]"


@njit
def _window_kind(kind, i, j, row_reach, column_reach):  # type: ignore[no-untyped-def]
    """Return 0 or 1 where the whole window is of that kind, else 2."""
    first = kind[i, j]
    if first == 2:
        return 2
    low_i, high_i = i - row_reach, i + row_reach
    low_j, high_j = j - column_reach, j + column_reach
    if first == 1 and (low_i < 0 or low_j < 0 or high_i >= kind.shape[0] or high_j >= kind.shape[1]):
        return 2
    for a in range(max(low_i, 0), min(high_i + 1, kind.shape[0])):
        for b in range(max(low_j, 0), min(high_j + 1, kind.shape[1])):
            if kind[a, b] != first:
                return 2
    return first


@njit
def _hat(distance, coarsening):  # type: ignore[no-untyped-def]
    return max(0.0, 1.0 - abs(distance) / coarsening)


@njit
def _project(image, row_coarsening, column_coarsening, out, i, j):  # type: ignore[no-untyped-def]
    """Write the inner products of ``image`` = A φ, a 7 x 7 window, with φ and its four later neighbours."""
    for k in range(5):
        down, right = (0, 0) if k == 0 else (0, 1) if k == 1 else (1, 0) if k == 2 else (1, 1) if k == 3 else (1, -1)
        total = 0.0
        for a in range(-2, 3):
            for b in range(-2, 3):
                weight = _hat(a - row_coarsening * down, row_coarsening) * _hat(
                    b - column_coarsening * right, column_coarsening
                )
                if weight > 0.0:
                    total += weight * image[a + 3, b + 3]
        out[k, i, j] = np.float32(total)


@njit
def _touched(changed, i, reach):  # type: ignore[no-untyped-def]
    """Whether a row within ``reach`` of row i has changed."""
    return changed[max(i - reach, 0) : i + reach + 1].any()


def _coarsen_lattice(  # type: ignore[no-untyped-def]
    free,
    changed,
    across,
    along,
    ground,
    constant,
    stencil,
    kind,
    coarse_changed,
    row_coarsening,
    column_coarsening,
    use_constant,
    lo,
    hi,
):
    """Write those of the rows [lo, hi) of the first coarse operator that a changed row of the lattice has a share in.

    Which they are is written to ``coarse_changed``. The rows of free nodes with 2 in ``free`` have springs.
    """
    basis, image = np.zeros((7, 7)), np.zeros((7, 7))
    rows, columns = free.shape
    for coarse_i in range(lo, hi):
        coarse_changed[coarse_i] = _touched(changed, row_coarsening * coarse_i, row_coarsening)
        if not coarse_changed[coarse_i]:
            continue
        for coarse_j in range(1, stencil.shape[2] - 1):
            i, j = row_coarsening * coarse_i, column_coarsening * coarse_j
            window = _window_kind(free, i, j, row_coarsening, column_coarsening)
            if window == 0 or (window == 1 and use_constant):
                kind[coarse_i, coarse_j] = window
                for k in range(6):
                    stencil[k, coarse_i, coarse_j] = constant[k] if window else np.float32(0.0)
                continue
            for a in range(-2, 3):
                for b in range(-2, 3):
                    inside = 0 <= i + a < rows and 0 <= j + b < columns and free[i + a, j + b]
                    basis[a + 3, b + 3] = _hat(a, row_coarsening) * _hat(b, column_coarsening) if inside else 0.0
            for a in range(-2, 3):
                for b in range(-2, 3):
                    image[a + 3, b + 3] = 0.0
                    if 0 <= i + a < rows and 0 <= j + b < columns and free[i + a, j + b]:
                        w, e, s, n = across, across, along, along
                        held = w + e + s + n + spring_at(ground, i + a - 1, j + b - 1)
                        image[a + 3, b + 3] = held * basis[a + 3, b + 3] - (
                            w * basis[a + 3, b + 2]
                            + e * basis[a + 3, b + 4]
                            + s * basis[a + 2, b + 3]
                            + n * basis[a + 4, b + 3]
                        )
            _project(image, row_coarsening, column_coarsening, stencil, coarse_i, coarse_j)
            kind[coarse_i, coarse_j] = 2 if stencil[0, coarse_i, coarse_j] > _TINY else 0


@njit(
    f"void({_STENCIL}, {_KIND}, {_ROWS}, float32[::1], {_STENCIL}, {_KIND}, {_ROWS}, int64, int64, int64, int64)",
    cache=True,
    nogil=True,
    error_model="numpy",
)
def coarsen_level(  # type: ignore[no-untyped-def]
    fine, fine_kind, changed, constant, stencil, kind, coarse_changed, row_coarsening, column_coarsening, lo, hi
):
    """Write those of the rows [lo, hi) of the next coarser operator that a changed row of the finer has a share in."""
    basis, image = np.zeros((7, 7)), np.zeros((7, 7))
    rows, columns = fine_kind.shape
    for coarse_i in range(lo, hi):
        coarse_changed[coarse_i] = _touched(changed, row_coarsening * coarse_i, row_coarsening)
        if not coarse_changed[coarse_i]:
            continue
        for coarse_j in range(1, stencil.shape[2] - 1):
            i, j = row_coarsening * coarse_i, column_coarsening * coarse_j
            window = _window_kind(fine_kind, i, j, row_coarsening, column_coarsening)
            if window < 2:
                kind[coarse_i, coarse_j] = window
                for k in range(6):
                    stencil[k, coarse_i, coarse_j] = constant[k] if window else np.float32(0.0)
                continue
            for a in range(-2, 3):
                for b in range(-2, 3):
                    inside = 1 <= i + a < rows - 1 and 1 <= j + b < columns - 1
                    basis[a + 3, b + 3] = _hat(a, row_coarsening) * _hat(b, column_coarsening) if inside else 0.0
            for a in range(-2, 3):
                for b in range(-2, 3):
                    y, x = i + a, j + b
                    image[a + 3, b + 3] = 0.0
                    if 1 <= y < rows - 1 and 1 <= x < columns - 1 and fine_kind[y, x]:
                        image[a + 3, b + 3] = (
                            fine[0, y, x] * basis[a + 3, b + 3]
                            + fine[1, y, x] * basis[a + 3, b + 4]
                            + fine[1, y, x - 1] * basis[a + 3, b + 2]
                            + fine[2, y, x] * basis[a + 4, b + 3]
                            + fine[2, y - 1, x] * basis[a + 2, b + 3]
                            + fine[3, y, x] * basis[a + 4, b + 4]
                            + fine[3, y - 1, x - 1] * basis[a + 2, b + 2]
                            + fine[4, y, x] * basis[a + 4, b + 2]
                            + fine[4, y - 1, x + 1] * basis[a + 2, b + 4]
                        )
            _project(image, row_coarsening, column_coarsening, stencil, coarse_i, coarse_j)
            kind[coarse_i, coarse_j] = 2 if stencil[0, coarse_i, coarse_j] > _TINY else 0


@njit(f"void({_STENCIL}, {_KIND}, {_ROWS}, float32[::1], int64, int64)", cache=True, nogil=True, error_model="numpy")
def set_factors(stencil, kind, changed, constant, lo, hi):  # type: ignore[no-untyped-def]
    """Write the factors of Jacobi's method on those of the rows [lo, hi) that have changed, or the one before has.

    Where a row's moduli sum to twice the diagonal, as they do for a Laplacian, the factor is 8/9 over the diagonal:
    best for bilinear elements, whose rough modes have eigenvalues in [3/4, 3/2]. Where a basis function is truncated,
    the sum can be larger, and the factor is smaller by as much; so no eigenvalue of factor x operator exceeds 16/9 < 2
    (Gershgorin), and the method always converges.
    """
    for i in range(lo, hi):
        if not (changed[i] or changed[i - 1]):
            continue
        for j in range(1, stencil.shape[2] - 1):
            if kind[i, j] < 2:
                stencil[5, i, j] = constant[5] if kind[i, j] else np.float32(0.0)
                continue
            total = (
                abs(stencil[1, i, j])
                + abs(stencil[1, i, j - 1])
                + abs(stencil[2, i, j])
                + abs(stencil[2, i - 1, j])
                + abs(stencil[3, i, j])
                + abs(stencil[3, i - 1, j - 1])
                + abs(stencil[4, i, j])
                + abs(stencil[4, i - 1, j + 1])
            )
            stencil[5, i, j] = np.float32(_DAMPING) / (stencil[0, i, j] + max(stencil[0, i, j], total))


@cache
def coarsen_lattice(kind: ArmKind) -> Any:
    """Compile the first coarsening for arms of a kind, or load it."""
    signature = (
        f"void({_KIND}, {_ROWS}, {stiffness_types(kind)}, float32[::1], {_STENCIL}, {_KIND}, {_ROWS}, "
        "int64, int64, boolean, int64, int64)"
    )
    return njit(signature, cache=True, nogil=True, error_model="numpy")(_coarsen_lattice)
