"""Aggregation: group the unknowns of a sparse matrix by its strong couplings.

Vaněk, Mandel and Brezina, *Algebraic multigrid by smoothed aggregation for second and fourth order elliptic problems*,
Computing 56 (1996). The function is compiled where that pays; small matrices are grouped without waiting
for a compiler.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...foundation.loading import once

Indices = NDArray[np.int32]

_WORTH_COMPILING = 20_000


def aggregate(indptr: Indices, indices: Indices) -> tuple[NDArray[np.int32], int]:
    """Return the group of every unknown (-1 for one without neighbours) and the number of groups.

    Parameters
    ----------
    indptr, indices : array of int32
        The strong couplings, a symmetric graph in compressed rows, without the diagonal.
    """
    group = np.full(indptr.size - 1, -1, dtype=np.int32)
    work: Any = _aggregate
    if group.size >= _WORTH_COMPILING:
        once("aggregation", _compiled, "active-set")
        work = _compiled()
    return group, int(work(indptr, indices, group))


def _aggregate(indptr, indices, group):  # type: ignore[no-untyped-def]
    """Fill ``group``; return the number of groups."""
    count = 0
    # An unknown with its neighbours is a group, if none of them belongs to one yet.
    for i in range(group.size):
        first, last = indptr[i], indptr[i + 1]
        if group[i] >= 0 or first == last:
            continue
        taken = False
        for k in range(first, last):
            if group[indices[k]] >= 0:
                taken = True
                break
        if not taken:
            group[i] = count
            for k in range(first, last):
                group[indices[k]] = count
            count += 1
    # Others join a neighbour's group; -2 - group, so that they attract no others in the same pass.
    for i in range(group.size):
        if group[i] == -1:
            for k in range(indptr[i], indptr[i + 1]):
                if group[indices[k]] >= 0:
                    group[i] = -2 - group[indices[k]]
                    break
    for i in range(group.size):
        if group[i] < -1:
            group[i] = -2 - group[i]
    # What is left has neighbours that are left.
    for i in range(group.size):
        if group[i] == -1 and indptr[i] < indptr[i + 1]:
            group[i] = count
            for k in range(indptr[i], indptr[i + 1]):
                if group[indices[k]] == -1:
                    group[indices[k]] = count
            count += 1
    return count


@cache
def _compiled() -> Any:
    from numba import njit

    return njit("int64(int32[::1], int32[::1], int32[::1])", cache=True, nogil=True)(_aggregate)
