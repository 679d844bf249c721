"""Payment of negative conductances, compiled; see `contactqp.algebra.conductances`."""

from __future__ import annotations

import numpy as np
from numba import njit

_UNIT = 2.0**-53


@njit
def _paths(indptr, indices, left, i, j, from_i, from_j):  # type: ignore[no-untyped-def]
    """Write where the conductances stand of the paths from i to j over one other node; return how many there are."""
    count = 0
    first, second = indptr[i], indptr[j]
    while first < indptr[i + 1] and second < indptr[j + 1]:
        if indices[first] < indices[second]:
            first += 1
        elif indices[first] > indices[second]:
            second += 1
        else:
            if left[first] > 0 and left[second] > 0:
                from_i[count], from_j[count] = first, second
                count += 1
            first += 1
            second += 1
    return count


@njit(
    "void(int64[::1], int64[::1], int64[::1], float64[::1], int64[::1], int64[::1], boolean[::1], float64, float64)",
    cache=True,
    nogil=True,
)
def pay(indptr, indices, rows, left, mirrored, owed, unpaid, most, least):  # type: ignore[no-untyped-def]
    """Do what `contactqp.algebra.conductances.pay_in_python` does."""
    longest = 0
    for i in range(indptr.size - 1):
        longest = max(longest, indptr[i + 1] - indptr[i])
    from_i, from_j = np.empty(longest, dtype=np.int64), np.empty(longest, dtype=np.int64)
    for debt in range(owed.size):
        place = owed[debt]
        paths = _paths(indptr, indices, left, rows[place], indices[place], from_i, from_j)
        capacity = 0.0
        for path in range(paths):
            a, b = left[from_i[path]], left[from_j[path]]
            capacity += min(a, b) * (max(a, b) / (a + b))
        capacity *= 1 - 2 * (paths + 8) * _UNIT
        if not -left[place] < most * capacity:
            unpaid[debt] = True
            continue
        part = (1 - (-left[place] / capacity) * (1 + 4 * _UNIT)) * (1 - 8 * _UNIT)
        for path in range(paths):
            for entry in (from_i[path], from_j[path]):
                rest = left[entry] * part
                left[entry] = left[mirrored[entry]] = 0.0 if rest < least else rest
        left[place] = left[mirrored[place]] = 0.0
