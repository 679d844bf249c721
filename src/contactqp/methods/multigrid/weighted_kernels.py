"""Compiled passes for arms that differ: interpolation that follows the arms, and Galerkin products with it.

Where arms jump, the solution has kinks that bilinear interpolation does not know. The interpolation here lets the
forces balance instead (Alcouffe, Brandt, Dendy and Painter 1981; Dendy 1982): between two coarse points a point takes
the value that balances it when the couplings of the lines across are joined to it; a point in the middle of four takes
the value that balances its own equation, once the points around it are known.

A cell (I, J) has the coarse points (I, J), (I, J + 1), (I + 1, J) and (I + 1, J + 1) at its corners. ``weights[0:2]``
are those of its lower side's middle for (I, J) and (I, J + 1), ``weights[2:4]`` those of its left side's middle for (I,
J) and (I + 1, J), ``weights[4:8]`` those of its own middle for the four corners, in this order. With a factor 1 in a
direction the points between are missing, and so are their weights. Stencils are those of `level_kernels`, in double
precision: rounded to single precision, stiff arms would leave more than soft ones are.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from .level_kernels import _apply_row

_FAST = {"contract", "nsz", "nnan", "reassoc"}
_STENCIL = "float64[:, :, ::1]"
WEIGHTS = "float32[:, :, ::1]"
_VECTOR = "float64[:, ::1]"
_MARKS = "uint8[:, ::1]"
_ROWS = "uint8[::1]"
_DAMPING = 16.0 / 9.0
_TINY = 1e-200
_NEGLIGIBLE = 1e-13
"""A pivot below this part of its diagonal entry is nothing but rounding errors."""


@njit(error_model="numpy", fastmath=_FAST)
def spread_row(row, coarse, i, row_coarsening, column_coarsening, weights, lo, hi):  # type: ignore[no-untyped-def]
    """Add the fine row i, restricted by the transpose of interpolation, to those of the coarse rows within [lo, hi)."""
    below, between = i // row_coarsening, row_coarsening == 2 and i % 2 == 1
    for above in range(2 if between else 1):
        target = below + above
        if target < lo or target >= hi:
            continue
        out = coarse[target]
        if not between:
            one, other = weights[0, below], weights[1, below]
            if column_coarsening == 1:
                for j in range(1, out.size - 1):
                    out[j] += row[j]
            else:
                for j in range(1, out.size - 1):
                    out[j] += row[2 * j] + (one[j] * row[2 * j + 1] + other[j - 1] * row[2 * j - 1])
        else:
            side, one, other = weights[2 + above, below], weights[4 + 2 * above, below], weights[5 + 2 * above, below]
            if column_coarsening == 1:
                for j in range(1, out.size - 1):
                    out[j] += side[j] * row[j]
            else:
                for j in range(1, out.size - 1):
                    out[j] += side[j] * row[2 * j] + (one[j] * row[2 * j + 1] + other[j - 1] * row[2 * j - 1])


@njit(error_model="numpy", fastmath=_FAST)
def expand_row(coarse, i, row_coarsening, column_coarsening, weights, row):  # type: ignore[no-untyped-def]
    """Write the fine row i, interpolated; beyond the last node it may be anything."""
    below = i // row_coarsening
    lower, last = coarse[below], coarse.shape[1] - 1
    if row_coarsening == 1 or i % 2 == 0:
        if column_coarsening == 1:
            for j in range(last + 1):
                row[j] = lower[j]
        else:
            one, other = weights[0, below], weights[1, below]
            for j in range(last):
                row[2 * j] = lower[j]
                row[2 * j + 1] = one[j] * lower[j] + other[j] * lower[j + 1]
    else:
        upper = coarse[below + 1]
        down, up = weights[2, below], weights[3, below]
        if column_coarsening == 1:
            for j in range(last + 1):
                row[j] = down[j] * lower[j] + up[j] * upper[j]
        else:
            a, b, c, d = weights[4, below], weights[5, below], weights[6, below], weights[7, below]
            for j in range(last):
                row[2 * j] = down[j] * lower[j] + up[j] * upper[j]
                row[2 * j + 1] = (a[j] * lower[j] + b[j] * lower[j + 1]) + (c[j] * upper[j] + d[j] * upper[j + 1])


def _restrict(stencil, r, e, coarse, row_coarsening, column_coarsening, weights, lo, hi):  # type: ignore[no-untyped-def]
    """Restrict r - A e to the coarse rows [lo, hi)."""
    row = np.zeros(r.shape[1])
    coarse[lo:hi] = 0.0
    reach = row_coarsening - 1
    for i in range(row_coarsening * lo - reach, min(row_coarsening * (hi - 1) + reach, r.shape[0] - 2) + 1):
        _apply_row(stencil, e, i, row)
        right = r[i]
        for j in range(1, row.size - 1):
            row[j] = right[j] - row[j]
        spread_row(row, coarse, i, row_coarsening, column_coarsening, weights, lo, hi)


def _add_interpolated(e, coarse, row_coarsening, column_coarsening, weights, lo, hi):  # type: ignore[no-untyped-def]
    """Add the interpolant of ``coarse`` to the rows [lo, hi) of e."""
    row = np.zeros(e.shape[1])
    for i in range(lo, hi):
        expand_row(coarse, i, row_coarsening, column_coarsening, weights, row)
        own = e[i]
        for j in range(1, own.size - 1):
            own[j] += row[j]


@njit
def _shares(one, other, own):  # type: ignore[no-untyped-def]
    """Return the weights of two neighbours that pull with ``one`` and ``other`` at a point that ``own`` holds."""
    one, other = max(one, 0.0), max(other, 0.0)
    held = max(own, one + other)
    if held <= 0.0:
        return 0.0, 0.0
    return one / held, other / held


@njit
def _shares_of_corners(first, second, third, fourth, own, weights, i, j):  # type: ignore[no-untyped-def]
    """Write the weights of the middle of a cell, whose corners pull with these forces."""
    first, second, third, fourth = max(first, 0.0), max(second, 0.0), max(third, 0.0), max(fourth, 0.0)
    held = max(own, (first + second) + (third + fourth))
    factor = 1.0 / held if held > 0.0 else 0.0
    weights[4, i, j] = first * factor
    weights[5, i, j] = second * factor
    weights[6, i, j] = third * factor
    weights[7, i, j] = fourth * factor


def _weigh_lattice(  # type: ignore[no-untyped-def]
    mask, across, along, ground, weights, row_coarsening, column_coarsening, lo, hi
):
    """Write the weights of the cells of the rows [lo, hi) of a lattice.

    A point that is no node lies midway between its coarse neighbours.
    """
    rows, columns = mask.shape
    for cell in range(lo, hi):
        for step in range(weights.shape[2]):
            i, j = row_coarsening * cell, column_coarsening * step
            below, above = i - 1, i  # of mask and arms, whose first row is that of the first nodes
            left, right = j - 1, j
            weights[0:4, cell, step] = 0.5
            weights[4:8, cell, step] = 0.25
            if column_coarsening == 2 and 1 <= i <= rows and right < columns and mask[below, right]:
                w, e = across[below, right], across[below, right + 1]
                weights[0, cell, step], weights[1, cell, step] = _shares(w, e, w + e + ground[below, right])
            if row_coarsening == 2 and 1 <= j <= columns and above < rows and mask[above, left]:
                s, n = along[above, left], along[above + 1, left]
                weights[2, cell, step], weights[3, cell, step] = _shares(s, n, s + n + ground[above, left])


def _weigh_lattice_cells(mask, across, along, ground, weights, lo, hi):  # type: ignore[no-untyped-def]
    """Write the weights of the middles of the cells of the rows [lo, hi), for factors of 2."""
    rows, columns = mask.shape
    for cell in range(lo, min(hi, weights.shape[1] - 1)):
        for step in range(weights.shape[2] - 1):
            i, j = 2 * cell, 2 * step
            if i >= rows or j >= columns or not mask[i, j]:
                continue
            w, e, s, n = across[i, j], across[i, j + 1], along[i, j], along[i + 1, j]
            _shares_of_corners(
                w * weights[2, cell, step] + s * weights[0, cell, step],
                e * weights[2, cell, step + 1] + s * weights[1, cell, step],
                w * weights[3, cell, step] + n * weights[0, cell + 1, step],
                e * weights[3, cell, step + 1] + n * weights[1, cell + 1, step],
                w + e + s + n + ground[i, j],
                weights,
                cell,
                step,
            )


def _weigh_level(stencil, weights, row_coarsening, column_coarsening, lo, hi):  # type: ignore[no-untyped-def]
    """Write the weights of the sides of the cells of the rows [lo, hi) of a level."""
    rows, columns = stencil.shape[1] - 2, stencil.shape[2] - 2
    for cell in range(lo, hi):
        for step in range(weights.shape[2]):
            i, j = row_coarsening * cell, column_coarsening * step
            weights[:, cell, step] = 0.0
            if column_coarsening == 2 and 1 <= i <= rows and j + 1 <= columns:
                x = j + 1
                west = stencil[1, i, x - 1] + stencil[4, i, x] + stencil[3, i - 1, x - 1]
                east = stencil[1, i, x] + stencil[3, i, x] + stencil[4, i - 1, x + 1]
                own = stencil[0, i, x] + stencil[2, i, x] + stencil[2, i - 1, x]
                weights[0, cell, step], weights[1, cell, step] = _shares(-west, -east, own)
            if row_coarsening == 2 and 1 <= j <= columns and i + 1 <= rows:
                y = i + 1
                south = stencil[2, y - 1, j] + stencil[3, y - 1, j - 1] + stencil[4, y - 1, j + 1]
                north = stencil[2, y, j] + stencil[3, y, j] + stencil[4, y, j]
                own = stencil[0, y, j] + stencil[1, y, j] + stencil[1, y, j - 1]
                weights[2, cell, step], weights[3, cell, step] = _shares(-south, -north, own)


def _weigh_level_cells(stencil, weights, lo, hi):  # type: ignore[no-untyped-def]
    """Write the weights of the middles of the cells of the rows [lo, hi) of a level, for factors of 2."""
    rows, columns = stencil.shape[1] - 2, stencil.shape[2] - 2
    for cell in range(lo, min(hi, weights.shape[1] - 1)):
        for step in range(weights.shape[2] - 1):
            y, x = 2 * cell + 1, 2 * step + 1
            if y > rows or x > columns:
                continue
            w, e, s, n = stencil[1, y, x - 1], stencil[1, y, x], stencil[2, y - 1, x], stencil[2, y, x]
            _shares_of_corners(
                -(stencil[3, y - 1, x - 1] + w * weights[2, cell, step] + s * weights[0, cell, step]),
                -(stencil[4, y - 1, x + 1] + e * weights[2, cell, step + 1] + s * weights[1, cell, step]),
                -(stencil[4, y, x] + w * weights[3, cell, step] + n * weights[0, cell + 1, step]),
                -(stencil[3, y, x] + e * weights[3, cell, step + 1] + n * weights[1, cell + 1, step]),
                stencil[0, y, x],
                weights,
                cell,
                step,
            )


@njit
def _touched(changed, i, reach):  # type: ignore[no-untyped-def]
    """Whether a row within ``reach`` of row i has changed."""
    return changed[max(i - reach, 0) : i + reach + 1].any()


@njit
def _write_basis(basis, weights, cell, step, row_coarsening, column_coarsening):  # type: ignore[no-untyped-def]
    """Write the values of the corners' basis functions at a cell's points, [row, column, corner]; none on the ring."""
    basis[:] = 0.0
    down, right = row_coarsening, column_coarsening
    basis[0, 0, 0] = basis[0, right, 1] = basis[down, 0, 2] = basis[down, right, 3] = 1.0
    if right == 2:
        for k in range(2):
            basis[0, 1, k] = weights[k, cell, step]
            basis[down, 1, 2 + k] = weights[k, cell + 1, step]
    if down == 2:
        for k in range(2):
            basis[1, 0, 2 * k] = weights[2 + k, cell, step]
            basis[1, right, 2 * k + 1] = weights[2 + k, cell, step + 1]
    if down == 2 and right == 2:
        for k in range(4):
            basis[1, 1, k] = weights[4 + k, cell, step]
    for corner in range(4):
        i, j = cell + corner // 2, step + corner % 2
        if i == 0 or j == 0 or i == weights.shape[1] - 1 or j == weights.shape[2] - 1:
            basis[:, :, corner] = 0.0


@njit
def _add_arm(products, arm, first, second):  # type: ignore[no-untyped-def]
    """Add what an arm between two points has to do with each pair of corners."""
    a, b, c, d = first[0] - second[0], first[1] - second[1], first[2] - second[2], first[3] - second[3]
    _add_square(products, arm, a, b, c, d)


@njit
def _add_square(products, factor, a, b, c, d):  # type: ignore[no-untyped-def]
    products[0] += factor * a * a
    products[1] += factor * a * b
    products[2] += factor * a * c
    products[3] += factor * a * d
    products[4] += factor * b * b
    products[5] += factor * b * c
    products[6] += factor * b * d
    products[7] += factor * c * c
    products[8] += factor * c * d
    products[9] += factor * d * d


@njit
def _add_cell(products, stencil, cell, step, use_lower, use_upper):  # type: ignore[no-untyped-def]
    """Add a cell's products to the rows of its lower and of its upper corners."""
    if use_lower:
        stencil[0, cell, step] += products[0]
        stencil[1, cell, step] += products[1]
        stencil[2, cell, step] += products[2]
        stencil[3, cell, step] += products[3]
        stencil[0, cell, step + 1] += products[4]
        stencil[4, cell, step + 1] += products[5]
        stencil[2, cell, step + 1] += products[6]
    if use_upper:
        stencil[0, cell + 1, step] += products[7]
        stencil[1, cell + 1, step] += products[8]
        stencil[0, cell + 1, step + 1] += products[9]


def _coarsen_lattice(  # type: ignore[no-untyped-def]
    free,
    changed,
    across,
    along,
    ground,
    weights,
    stencil,
    coarse_changed,
    row_coarsening,
    column_coarsening,
    lo,
    hi,
):
    """Write those of the rows [lo, hi) of the first coarse operator that a changed row of the lattice has a share in.

    Which they are is written to ``coarse_changed``. The energy is summed arm by arm, so no digits cancel.
    """
    down, right = row_coarsening, column_coarsening
    rows, columns = free.shape[0] - 2, free.shape[1] - 2
    basis, products = np.zeros((3, 3, 4)), np.zeros(10)
    for target in range(lo, hi):
        coarse_changed[target] = _touched(changed, down * target, down)
        if coarse_changed[target]:
            stencil[0:5, target] = 0.0
    for cell in range(lo - 1, hi):
        use_lower, use_upper = cell >= lo and coarse_changed[cell] > 0, cell + 1 < hi and coarse_changed[cell + 1] > 0
        if not (use_lower or use_upper):
            continue
        for step in range(stencil.shape[2] - 1):
            _write_basis(basis, weights, cell, step, down, right)
            for a in range(down + 1):
                for b in range(right + 1):
                    y, x = down * cell + a, right * step + b
                    if y > rows or x > columns or not free[y, x]:
                        basis[a, b] = 0.0
            products[:] = 0.0
            for a in range(down):
                for b in range(right):
                    y, x, own = down * cell + a, right * step + b, basis[a, b]
                    if y >= 1 and y <= rows and x <= columns:
                        _add_arm(products, across[y - 1, x], own, basis[a, b + 1])
                    if x >= 1 and x <= columns and y <= rows:
                        _add_arm(products, along[y, x - 1], own, basis[a + 1, b])
                        if y >= 1:
                            _add_square(products, ground[y - 1, x - 1], own[0], own[1], own[2], own[3])
            _add_cell(products, stencil, cell, step, use_lower, use_upper)


def _coarsen_level(  # type: ignore[no-untyped-def]
    fine, changed, weights, stencil, coarse_changed, row_coarsening, column_coarsening, lo, hi
):
    """Write those of the rows [lo, hi) of the next coarser operator that a changed row of the finer has a share in."""
    down, right = row_coarsening, column_coarsening
    rows, columns = fine.shape[1] - 2, fine.shape[2] - 2
    basis, products = np.zeros((3, 3, 4)), np.zeros(10)
    for target in range(lo, hi):
        coarse_changed[target] = _touched(changed, down * target, down)
        if coarse_changed[target]:
            stencil[0:5, target] = 0.0
    for cell in range(lo - 1, hi):
        use_lower, use_upper = cell >= lo and coarse_changed[cell] > 0, cell + 1 < hi and coarse_changed[cell + 1] > 0
        if not (use_lower or use_upper):
            continue
        for step in range(stencil.shape[2] - 1):
            _write_basis(basis, weights, cell, step, down, right)
            products[:] = 0.0
            for a in range(down):
                for b in range(right):
                    y, x, own = down * cell + a, right * step + b, basis[a, b]
                    if y > rows or x > columns:
                        continue
                    if y >= 1:
                        _add_arm(products, -fine[1, y, x], own, basis[a, b + 1])
                    if x >= 1:
                        _add_arm(products, -fine[2, y, x], own, basis[a + 1, b])
                    if y >= 1 and x >= 1:
                        around = (fine[1, y, x] + fine[1, y, x - 1]) + (fine[2, y, x] + fine[2, y - 1, x])
                        around += (fine[3, y, x] + fine[3, y - 1, x - 1]) + (fine[4, y, x] + fine[4, y - 1, x + 1])
                        _add_square(products, fine[0, y, x] + around, own[0], own[1], own[2], own[3])
                    _add_arm(products, -fine[3, y, x], own, basis[a + 1, b + 1])
                    _add_arm(products, -fine[4, y, x + 1], basis[a, b + 1], basis[a + 1, b])
            _add_cell(products, stencil, cell, step, use_lower, use_upper)


def _set_factors(stencil, changed, lo, hi):  # type: ignore[no-untyped-def]
    """Write the factors of Jacobi's method, see `contactqp.methods.multigrid.galerkin_kernels.set_factors`."""
    for i in range(lo, hi):
        if not (changed[i] or changed[i - 1]):
            continue
        for j in range(1, stencil.shape[2] - 1):
            own = stencil[0, i, j]
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
            stencil[5, i, j] = _DAMPING / (own + max(own, total)) if own > _TINY else 0.0


def _apply(stencil, e, image, r, lo, hi):  # type: ignore[no-untyped-def]
    """Write the rows [lo, hi) of A e, and return their share of e·Ae and of e·r."""
    energy = work = 0.0
    for i in range(lo, hi):
        out = image[i]
        _apply_row(stencil, e, i, out)
        own, right = e[i], r[i]
        for j in range(1, out.size - 1):
            energy += own[j] * out[j]
            work += own[j] * right[j]
    return energy, work


def _apply_again(stencil, e, image, r, row, lo, hi):  # type: ignore[no-untyped-def]
    """Return the share of the rows [lo, hi) of e·Ae, of e·image and of e·r; ``row`` is overwritten."""
    energy = common = work = 0.0
    for i in range(lo, hi):
        out = row[i]
        _apply_row(stencil, e, i, out)
        own, other, right = e[i], image[i], r[i]
        for j in range(1, out.size - 1):
            energy += own[j] * out[j]
            common += own[j] * other[j]
            work += own[j] * right[j]
    return energy, common, work


def _subtract(r, factor, image, lo, hi):  # type: ignore[no-untyped-def]
    """Subtract a multiple of ``image`` from the rows [lo, hi) of r."""
    for i in range(lo, hi):
        own, other = r[i], image[i]
        for j in range(own.size):
            own[j] -= factor * other[j]


def _combine(e, factor, kept, share, lo, hi):  # type: ignore[no-untyped-def]
    """Replace e by a combination of e and ``kept`` on the rows [lo, hi)."""
    for i in range(lo, hi):
        own, other = e[i], kept[i]
        for j in range(own.size):
            own[j] = factor * own[j] + share * other[j]


def _factorise(stencil, band):  # type: ignore[no-untyped-def]
    """Write Cholesky's factor of the operator: ``band[k, m]`` is its entry [k, k - m], and 1 / [k, k] for m = 0.

    What the operator has no say in is left out, as is what elimination leaves nothing of but rounding errors.
    """
    columns, width = stencil.shape[2] - 2, band.shape[1]
    for k in range(band.shape[0]):
        i, j = k // columns + 1, k % columns + 1
        band[k, :] = 0.0
        own = stencil[0, i, j]
        # At the ends of rows these reach around to other rows; there, the ring's zeros are met.
        if j > 1:
            band[k, 1] = stencil[1, i, j - 1]
        if i > 1:
            band[k, columns] += stencil[2, i - 1, j]
            if j > 1:
                band[k, columns + 1] = stencil[3, i - 1, j - 1]
            if j < columns:
                band[k, columns - 1] += stencil[4, i - 1, j + 1]
        rest = own
        for m in range(min(width - 1, k), 0, -1):
            other = k - m
            total = band[k, m]
            for n in range(m + 1, min(width - 1, k) + 1):
                total -= band[k, n] * band[other, n - m]
            total *= band[other, 0]
            band[k, m] = total
            rest -= total * total
        band[k, 0] = 1.0 / np.sqrt(rest) if rest > max(_NEGLIGIBLE * own, _TINY) else 0.0


def _solve_coarsest(band, r, e):  # type: ignore[no-untyped-def]
    """Write e = A⁻¹ r by Cholesky's factor; what A has no say in is zero."""
    columns, width = e.shape[1] - 2, band.shape[1]
    x = np.zeros(band.shape[0])
    for k in range(x.size):
        total = r[k // columns + 1, k % columns + 1]
        for m in range(1, min(width - 1, k) + 1):
            total -= band[k, m] * x[k - m]
        x[k] = total * band[k, 0]
    for k in range(x.size - 1, -1, -1):
        value = x[k] * band[k, 0]
        x[k] = value
        for m in range(1, min(width - 1, k) + 1):
            x[k - m] -= band[k, m] * value
        e[k // columns + 1, k % columns + 1] = value


class WeightedKernels(NamedTuple):
    """The passes, compiled."""

    weigh_lattice: Any
    weigh_lattice_cells: Any
    weigh_level: Any
    weigh_level_cells: Any
    coarsen_lattice: Any
    coarsen_level: Any
    set_factors: Any
    restrict: Any
    add_interpolated: Any
    apply: Any
    apply_again: Any
    subtract: Any
    combine: Any
    factorise: Any
    solve_coarsest: Any


@cache
def weighted_kernels() -> WeightedKernels:
    """Compile the passes, or load them."""
    arms, rows, factors = f"{_VECTOR}, {_VECTOR}, {_VECTOR}", "int64, int64", "int64, int64"
    return WeightedKernels(
        weigh_lattice=_compiled(_weigh_lattice, f"boolean[:, ::1], {arms}, {WEIGHTS}, {factors}, {rows}"),
        weigh_lattice_cells=_compiled(_weigh_lattice_cells, f"boolean[:, ::1], {arms}, {WEIGHTS}, {rows}"),
        weigh_level=_compiled(_weigh_level, f"{_STENCIL}, {WEIGHTS}, {factors}, {rows}"),
        weigh_level_cells=_compiled(_weigh_level_cells, f"{_STENCIL}, {WEIGHTS}, {rows}"),
        coarsen_lattice=_compiled(
            _coarsen_lattice, f"{_MARKS}, {_ROWS}, {arms}, {WEIGHTS}, {_STENCIL}, {_ROWS}, {factors}, {rows}"
        ),
        coarsen_level=_compiled(
            _coarsen_level, f"{_STENCIL}, {_ROWS}, {WEIGHTS}, {_STENCIL}, {_ROWS}, {factors}, {rows}"
        ),
        set_factors=_compiled(_set_factors, f"{_STENCIL}, {_ROWS}, {rows}"),
        restrict=_compiled(
            _restrict, f"{_STENCIL}, {_VECTOR}, {_VECTOR}, {_VECTOR}, {factors}, {WEIGHTS}, {rows}", fast=True
        ),
        add_interpolated=_compiled(_add_interpolated, f"{_VECTOR}, {_VECTOR}, {factors}, {WEIGHTS}, {rows}", fast=True),
        apply=_compiled(
            _apply, f"{_STENCIL}, {_VECTOR}, {_VECTOR}, {_VECTOR}, {rows}", "UniTuple(float64, 2)", fast=True
        ),
        apply_again=_compiled(
            _apply_again,
            f"{_STENCIL}, {_VECTOR}, {_VECTOR}, {_VECTOR}, {_VECTOR}, {rows}",
            "UniTuple(float64, 3)",
            fast=True,
        ),
        subtract=_compiled(_subtract, f"{_VECTOR}, float64, {_VECTOR}, {rows}", fast=True),
        combine=_compiled(_combine, f"{_VECTOR}, float64, {_VECTOR}, float64, {rows}", fast=True),
        factorise=_compiled(_factorise, f"{_STENCIL}, {_VECTOR}"),
        solve_coarsest=_compiled(_solve_coarsest, f"{_VECTOR}, {_VECTOR}, {_VECTOR}", fast=True),
    )


def _compiled(function: Any, signature: str, result: str = "void", *, fast: bool = False) -> Any:
    options: dict[str, Any] = {"fastmath": _FAST} if fast else {}
    return njit(f"{result}({signature})", cache=True, nogil=True, error_model="numpy", **options)(function)
