"""Payment of negative conductances, compiled; see `contactqp.algebra.conductances`."""

from __future__ import annotations

from numba import njit

_UNIT = 2.0**-53


@njit(
    "boolean(int64[::1], int64[::1], int64[::1], float64[::1], int64[::1], int64[::1], float64, float64)",
    cache=True,
    nogil=True,
)
def pay(indptr, indices, rows, left, mirrored, owed, most, least):  # type: ignore[no-untyped-def]
    """Do what `contactqp.algebra.conductances.pay_in_python` does."""
    for count in range(owed.size):
        place = owed[count]
        i, j = rows[place], indices[place]
        capacity, terms = 0.0, 0
        first, second = indptr[i], indptr[j]
        while first < indptr[i + 1] and second < indptr[j + 1]:
            if indices[first] < indices[second]:
                first += 1
            elif indices[first] > indices[second]:
                second += 1
            else:
                a, b = left[first], left[second]
                if a > 0 and b > 0:
                    capacity += min(a, b) * (max(a, b) / (a + b))
                    terms += 1
                first += 1
                second += 1
        capacity *= 1 - 2 * (terms + 8) * _UNIT
        if not -left[place] < most * capacity:
            return False
        part = (1 - (-left[place] / capacity) * (1 + 4 * _UNIT)) * (1 - 8 * _UNIT)
        first, second = indptr[i], indptr[j]
        while first < indptr[i + 1] and second < indptr[j + 1]:
            if indices[first] < indices[second]:
                first += 1
            elif indices[first] > indices[second]:
                second += 1
            else:
                a, b = left[first], left[second]
                if a > 0 and b > 0:
                    a *= part
                    b *= part
                    a = 0.0 if a < least else a
                    b = 0.0 if b < least else b
                    left[first] = a
                    left[mirrored[first]] = a
                    left[second] = b
                    left[mirrored[second]] = b
                first += 1
                second += 1
        left[place] = 0.0
        left[mirrored[place]] = 0.0
    return True
