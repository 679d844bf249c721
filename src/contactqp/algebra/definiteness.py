"""Whether a symmetric matrix is positive definite, in double precision."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..foundation.checks import Mask, Vector
from ..foundation.loading import load_modules
from ..foundation.text import counted
from .balanced import balanced
from .band import Band

if TYPE_CHECKING:
    from scipy.sparse import csr_array

FEW = 4000
"""Up to this many unknowns a factorisation is affordable, whatever its fill."""

_LANCZOS_STEPS = 60
_LANCZOS_ENDS = 1e-12
"""A next vector of this length is rounding: the vectors span all that the first one reaches."""


NO_MORE_THAN_ROUNDING = 2.0**-47
"""A positive off-diagonal entry up to this times the geometric mean of the two diagonal entries counts as zero.

Assembled from some elements, entries that should be zero are some units of the diagonal's rounding.
"""


def positive_beyond_rounding(matrix: csr_array) -> Mask:
    """Return which of the stored entries stand off the diagonal and are positive by more than rounding."""
    entries = matrix.tocoo()
    i, j = entries.coords
    found = np.asarray((i != j) & (entries.data > 0))
    if found.any():
        root = np.sqrt(matrix.diagonal())
        found[found] = entries.data[found] > NO_MORE_THAN_ROUNDING * root[i[found]] * root[j[found]]
    return found


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
    if positive_beyond_rounding(matrix).any():
        return False
    diagonal = matrix.diagonal()
    radius = np.bincount(i[off], weights=np.abs(entries.data[off]), minlength=matrix.shape[0])
    if not (radius <= diagonal * (1 + 1e-13)).all():
        return False
    strict = radius < diagonal * (1 - 1e-10)
    count, part = csgraph.connected_components(matrix, directed=False)
    return bool(np.bincount(part, weights=strict, minlength=count).all())


def refuse_indefinite(matrix: csr_array) -> None:
    """Raise a ValueError if the symmetric ``matrix`` is found to be not positive definite, numerically.

    Up to some thousand unknowns the signs of the pivots of a symmetric factorisation are counted (Sylvester's law of
    inertia); an exchange of rows, which only a zero pivot makes necessary, also tells against it. Above, where nobody
    knows how many entries such factors would have, Cholesky's factorisation is tried in a band, and where the band is
    too wide for that, some vectors x are, whether xᵀGx is > 0: then a matrix that passes is not proven to be positive
    definite.
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
    found = _objection(matrix, 1 / root)
    if found:
        raise ValueError(f"G must be positive definite, but numerically it is not: {found}")


def _objection(matrix: csr_array, balance: Vector) -> str:
    """Return what tells against the matrix; nothing if nothing does."""
    if matrix.shape[0] <= FEW:
        return _told_pivots(_pivots(matrix, balance), 4 * np.finfo(float).eps * matrix.shape[0])
    unit = balanced(matrix, balance)
    band, rounding = Band(unit), 4 * np.finfo(float).eps * matrix.shape[0]
    if band.affordable:
        factors = band.factors()
        definite = factors is not None and float((factors.pivots**2).min()) > rounding
        return "" if definite else "a Cholesky factorisation finds a pivot <= 0"
    ones = 1 / balance
    for least in (ritz_value(matrix), float(ones @ (unit @ ones)) / float(ones @ ones)):
        if least <= rounding:
            return f"a vector x is found with x·Gx = {least:.2g} x·x, for a diagonal of ones"
    return ""


def ritz_value(matrix: csr_array) -> float:
    """Return an estimate of the smallest eigenvalue of a symmetric matrix with its diagonal scaled to ones.

    It is the least Ritz value of some steps of Lanczos' iteration, and above the eigenvalue but for rounding: where it
    is negative, the matrix is not positive definite.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Symmetric, with a positive diagonal.

    Examples
    --------
    >>> from scipy.sparse import csr_array
    >>> round(ritz_value(csr_array([[4.0, 1.0], [1.0, 1.0]])), 12)
    0.5
    """
    load_modules("scipy.linalg")
    from scipy.linalg import eigvalsh_tridiagonal

    root = np.sqrt(matrix.diagonal())
    vector = np.random.default_rng(0).uniform(-1, 1, root.size)
    vector /= np.sqrt((vector * vector).sum())
    before, beta = np.zeros_like(vector), 0.0
    diagonal: list[float] = []
    beside: list[float] = []
    for _ in range(min(_LANCZOS_STEPS, root.size)):
        image = (matrix @ (vector / root)) / root - beta * before
        diagonal.append(float((image * vector).sum()))
        image -= diagonal[-1] * vector
        beta = float(np.sqrt((image * image).sum()))
        if not beta > _LANCZOS_ENDS:
            break
        beside.append(beta)
        before, vector = vector, image / beta
    return float(eigvalsh_tridiagonal(diagonal, beside[: len(diagonal) - 1]).min())


def _told_pivots(pivots: Vector | None, rounding: float) -> str:
    """Return what the pivots tell against a matrix with a diagonal of ones; nothing if all are above rounding."""
    if pivots is None:
        return "a factorisation finds a pivot <= 0"
    low = pivots <= rounding
    if not low.any():
        return ""
    if (pivots < -rounding).any():
        return f"a factorisation finds {counted(int(np.count_nonzero(low)), 'pivot')} <= 0"
    return (
        f"the smallest pivot of a factorisation is {pivots.min():.1g}, for a diagonal of ones, and rounding alone may "
        f"make it {rounding:.1g}: G is singular, or too ill-conditioned for double precision to tell"
    )


def _pivots(matrix: csr_array, balance: Vector) -> Vector | None:
    """Return the pivots of a symmetric factorisation with a diagonal of ones; None where rows must be exchanged."""
    load_modules("scipy.sparse.linalg")
    from scipy.sparse import linalg

    unit = balanced(matrix, balance).tocsc()
    try:
        factors = linalg.splu(unit, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:  # exactly singular
        return np.zeros(1)
    return np.asarray(factors.U.diagonal()) if np.array_equal(factors.perm_r, factors.perm_c) else None
