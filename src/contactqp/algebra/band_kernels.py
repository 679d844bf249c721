"""A compiled Cholesky factorisation in a band, which leaves the interpreter to others and starts no threads."""

from __future__ import annotations

from numba import njit

PANEL = 4
"""Columns that are subtracted together; as many rows of zeros, less one, stand below the band."""


@njit("int64(float64[:, ::1], int64)", cache=True, nogil=True)
def factorise(band, width):  # type: ignore[no-untyped-def]
    """Overwrite a matrix by its lower factor; return 0, or the number of the first pivot that is not positive.

    ``band[j, d]`` is the entry in column j and row j + d, zero for d > ``width``, shape (n, width + PANEL).
    """
    size = band.shape[0]
    for first in range(0, size, PANEL):
        end = min(first + PANEL, size)
        for j in range(first, end):
            pivot = band[j, 0]
            if not 0.0 < pivot < 1e308:
                return j + 1
            root = pivot**0.5
            for d in range(width + 1):
                band[j, d] /= root
            for other in range(j + 1, end):
                factor = band[j, other - j]
                for d in range(width + 1 - (other - j)):
                    band[other, d] -= factor * band[j, d + other - j]
        if end - first < PANEL:
            break
        for column in range(end, min(end + width, size)):
            k = column - first
            count = width + PANEL - k
            a, b = band[first, k], band[first + 1, k - 1]
            c, e = band[first + 2, k - 2], band[first + 3, k - 3]
            target = band[column]
            one, two = band[first, k:], band[first + 1, k - 1 :]
            three, four = band[first + 2, k - 2 :], band[first + 3, k - 3 :]
            for d in range(count):
                target[d] -= (a * one[d] + b * two[d]) + (c * three[d] + e * four[d])
    return 0
