"""Whether a symmetric matrix is positive definite, in double precision."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..foundation.checks import Vector
from ..foundation.loading import load_modules

if TYPE_CHECKING:
    from scipy.sparse import csr_array


def weakly_dominant(matrix: csr_array) -> bool:
    """Whether a Z-matrix is diagonally dominant to rounding, strictly in a row of each connected part.

    Then it is positive definite up to rounding (Taussky 1949). That is enough to put off the proof to the barrier,
    which every use of the matrix needs anyway.
    """
    load_modules("scipy.sparse.csgraph")
    from scipy.sparse import csgraph

    entries = matrix.tocoo()
    i, j = entries.coords
    off = i != j
    if (entries.data[off] > 0).any():
        return False
    diagonal = matrix.diagonal()
    radius = np.bincount(i[off], weights=-entries.data[off], minlength=matrix.shape[0])
    if not (radius <= diagonal * (1 + 1e-13)).all():
        return False
    strict = radius < diagonal * (1 - 1e-10)
    count, part = csgraph.connected_components(matrix, directed=False)
    return bool(np.bincount(part, weights=strict, minlength=count).all())


def refuse_indefinite(matrix: csr_array) -> None:
    """Raise a ValueError unless the symmetric ``matrix`` is numerically positive definite.

    The signs of the pivots of a symmetric factorisation are counted (Sylvester's law of inertia); an exchange of rows,
    which only a zero pivot makes necessary, also tells against it.
    """
    entries = matrix.tocoo()
    i, j = entries.coords
    root = np.sqrt(matrix.diagonal())
    off = i != j
    excess = np.abs(entries.data[off]) / root[i[off]] / root[j[off]]
    if excess.size and excess.max() >= 1:
        worst = int(np.argmax(excess))
        row, column, value = int(i[off][worst]), int(j[off][worst]), entries.data[off][worst]
        raise ValueError(
            f"G must be positive definite, but |G[{row}, {column}]| = {abs(value):g} is not below the geometric mean "
            f"of G[{row}, {row}] = {root[row] ** 2:g} and G[{column}, {column}] = {root[column] ** 2:g}"
        )
    negative = _negative_pivots(matrix, 1 / root)
    if negative:
        raise ValueError(
            f"G must be positive definite, but numerically it is not: a factorisation finds {negative} pivot(s) <= 0"
        )


def _negative_pivots(matrix: csr_array, balance: Vector) -> int:
    load_modules("scipy.sparse", "scipy.sparse.linalg")
    from scipy import sparse
    from scipy.sparse import linalg

    scaling = sparse.diags_array(balance)
    unit = (scaling @ matrix @ scaling).tocsc()
    try:
        factors = linalg.splu(unit, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:
        return 1
    if not np.array_equal(factors.perm_r, factors.perm_c):
        return 1
    rounding = 4 * np.finfo(float).eps * matrix.shape[0]
    return int(np.count_nonzero(factors.U.diagonal() <= rounding))
