"""Compiled arithmetic of double words, and factors in a band by it.

A double word is the unrounded sum of two doubles, high + low, with |low| at most half a unit in the last place of high:
106 bits. The operations are those of Joldes, Muller and Popescu, *Tight and rigorous error bounds for basic building
blocks of double-word arithmetic*, ACM Trans. Math. Softw. 44 (2017), algorithms 6, 11, 9 and 17, for processors with a
fused multiplication; others call a function for it. Where nothing under- or overflows, the relative error is at most
3u²/(1 - 4u) of a sum, 6u² of a product, 2u² of one with a double, and less than 16u² of a quotient, u = 2⁻⁵³: less than
`RELATIVE_ERROR` each, which leaves room for what low words lose to underflow where high ones are far from it.

Bands and vectors of double words are held as two arrays. ``[j, d]`` is the entry in column j and row j + d of a band.
"""

from __future__ import annotations

from numba import njit, types
from numba.extending import intrinsic

RELATIVE_ERROR = 2.0**-101
"""Of any operation on double words."""

SMALLEST = 2.0**-300
"""Entries of a factor below this count as zero, so that nothing underflows; see `contactqp.algebra.narrow_band`."""

SMALLEST_PIVOT, LARGEST_PIVOT = 2.0**-200, 2.0**200

_MATRIX = "float64[:, ::1]"
_VECTOR = "float64[::1]"


@njit(inline="always")
def two_sum(a, b):  # type: ignore[no-untyped-def]
    """Return the sum and its error."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@njit(inline="always")
def ordered_sum(a, b):  # type: ignore[no-untyped-def]
    """Return the sum and its error, for a the larger one."""
    total = a + b
    return total, b - (total - a)


@intrinsic
def _fused(typing_context, a, b, c):  # type: ignore[no-untyped-def]
    """Return ab + c, rounded once."""

    def generate(context, builder, signature, values):  # type: ignore[no-untyped-def]
        return builder.fma(*values)

    return types.float64(types.float64, types.float64, types.float64), generate


@njit(inline="always")
def two_product(a, b):  # type: ignore[no-untyped-def]
    """Return the product and its error."""
    product = a * b
    return product, _fused(a, b, -product)  # type: ignore[call-arg]


@njit(inline="always")
def word_sum(a, a_low, b, b_low):  # type: ignore[no-untyped-def]
    """Return the sum of two double words."""
    high, rest = two_sum(a, b)
    low, last = two_sum(a_low, b_low)
    high, rest = ordered_sum(high, rest + low)
    return ordered_sum(high, last + rest)


@njit(inline="always")
def word_product(a, a_low, b, b_low):  # type: ignore[no-untyped-def]
    """Return the product of two double words."""
    high, rest = two_product(a, b)
    return ordered_sum(high, rest + _fused(a, b_low, a_low * b))  # type: ignore[call-arg]


@njit(inline="always")
def product_with_double(a, a_low, b):  # type: ignore[no-untyped-def]
    """Return the product of a double word and a double."""
    high, rest = two_product(a, b)
    return ordered_sum(high, _fused(a_low, b, rest))  # type: ignore[call-arg]


@njit(inline="always")
def quotient(a, a_low, b, b_low):  # type: ignore[no-untyped-def]
    """Return the quotient of two double words."""
    high = a / b
    product, product_low = product_with_double(b, b_low, high)
    return ordered_sum(high, ((a - product) + (a_low - product_low)) / b)


@njit(f"int64({_MATRIX}, {_MATRIX}, int64, int64)", cache=True, nogil=True)
def factorise(band, low, first, end):  # type: ignore[no-untyped-def]
    """Overwrite columns of A = LDLᵀ by D (at d = 0) and L; return 0, or the number of the first pivot that is bad.

    The columns before ``first`` have been done. Entries beyond the last row are never read.
    """
    size, width = band.shape[0], band.shape[1] - 1
    for j in range(first, end):
        pivot, pivot_low = band[j, 0], low[j, 0]
        if not SMALLEST_PIVOT < pivot < LARGEST_PIVOT:
            return j + 1
        reach, least = min(width, size - 1 - j), SMALLEST * max(1.0, pivot)
        for d in range(1, reach + 1):
            if abs(band[j, d]) < least:
                band[j, d] = low[j, d] = 0.0
        for d in range(reach, 0, -1):
            entry, entry_low = band[j, d], low[j, d]
            if entry == 0.0:
                continue
            factor, factor_low = quotient(entry, entry_low, pivot, pivot_low)
            for e in range(1, d + 1):
                other, other_low = band[j, e], low[j, e]
                if other != 0.0:
                    high, rest = word_product(factor, factor_low, other, other_low)
                    band[j + e, d - e], low[j + e, d - e] = word_sum(
                        band[j + e, d - e], low[j + e, d - e], -high, -rest
                    )
            band[j, d], low[j, d] = factor, factor_low
    return 0


@njit(f"void({_MATRIX}, {_MATRIX}, {_VECTOR}, {_VECTOR}, int64, int64)", cache=True, nogil=True)
def forwards(band, low, force, force_low, first, end):  # type: ignore[no-untyped-def]
    """Overwrite f by L⁻¹f, for the columns from ``first`` to ``end``."""
    size, width = band.shape[0], band.shape[1] - 1
    for j in range(first, end):
        own, own_low = force[j], force_low[j]
        for d in range(1, min(width, size - 1 - j) + 1):
            high, rest = word_product(band[j, d], low[j, d], own, own_low)
            force[j + d], force_low[j + d] = word_sum(force[j + d], force_low[j + d], -high, -rest)


@njit(f"void({_MATRIX}, {_MATRIX}, {_VECTOR}, {_VECTOR}, int64, int64)", cache=True, nogil=True)
def backwards(band, low, force, force_low, first, end):  # type: ignore[no-untyped-def]
    """Overwrite f by L⁻ᵀD⁻¹f, from row ``end`` - 1 down to ``first``."""
    size, width = band.shape[0], band.shape[1] - 1
    for j in range(end - 1, first - 1, -1):
        own, own_low = quotient(force[j], force_low[j], band[j, 0], low[j, 0])
        for d in range(1, min(width, size - 1 - j) + 1):
            high, rest = word_product(band[j, d], low[j, d], force[j + d], force_low[j + d])
            own, own_low = word_sum(own, own_low, -high, -rest)
        force[j], force_low[j] = own, own_low


@njit(f"void({_MATRIX}, {_VECTOR}, {_VECTOR}, {_VECTOR}, {_VECTOR}, int64, int64)", cache=True, nogil=True)
def add_product(band, vector, vector_low, total, total_low, first, end):  # type: ignore[no-untyped-def]
    """Add Ax to a vector, by the columns from ``first`` to ``end`` of a symmetric band of doubles."""
    size, width = band.shape[0], band.shape[1] - 1
    for j in range(first, end):
        own, own_low = vector[j], vector_low[j]
        sum_, sum_low = total[j], total_low[j]
        high, rest = product_with_double(own, own_low, band[j, 0])
        sum_, sum_low = word_sum(sum_, sum_low, high, rest)
        for d in range(1, min(width, size - 1 - j) + 1):
            entry = band[j, d]
            if entry != 0.0:
                high, rest = product_with_double(own, own_low, entry)
                total[j + d], total_low[j + d] = word_sum(total[j + d], total_low[j + d], high, rest)
                high, rest = product_with_double(vector[j + d], vector_low[j + d], entry)
                sum_, sum_low = word_sum(sum_, sum_low, high, rest)
        total[j], total_low[j] = sum_, sum_low
