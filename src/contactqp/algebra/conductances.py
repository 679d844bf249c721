r"""An M-matrix below a symmetric matrix, whose positive off-diagonal entries are paid by paths beside them.

With the row sums r_i and the conductances c_ij = -A_ij it is

.. math:: xᵀAx = \sum_i r_i x_i² + \sum_{i<j} c_{ij} (x_i - x_j)².

A positive entry A_ij = g is a negative conductance -g. For any k and any α, β > 0 with 1/α + 1/β ≤ 1/γ it is
γ(x_i - x_j)² ≤ α(x_i - x_k)² + β(x_k - x_j)², as for resistors in series (the minimum of the right-hand side over x_k
is (x_i - x_j)²/(1/α + 1/β)). So g can be split into parts γ_k, one for each neighbour k of both i and j whose
conductances a = c_ik and b = c_kj are positive, and each part be paid by α off a and β off b. With γ_k = gw_k/W,
w_k = ab/(a + b), W = Σw_k, all these conductances lose the same part t = g/W of themselves, α = ta and β = tb; and if
t < 1 they remain positive. What is left has the same row sums and no positive entry beside the diagonal, and what was
taken away is positive semidefinite, so that Ã ≼ A (support-graph theory: Vaidya; Gremban; Boman and Hendrickson,
*Support theory for preconditioning*, SIAM J. Matrix Anal. Appl. 25, 2003). Payments are made one after the other, each
from what those before have left, which changes nothing of this. Entries for which too little is left come first when
all payments are made anew, some times at most.

*Rounding.* A conductance that is made smaller, and a diagonal entry that is made smaller, only take more away. So t is
rounded upwards (W has at most m terms of three roundings each, and m - 1 sums of positive numbers), what is left of a
conductance downwards, and Ã_ii = A_ii - Σ_j (c_ij - c̃_ij) downwards by the bound of a sum in any order (Higham,
*Accuracy and Stability of Numerical Algorithms*, 2002, section 4.2). Conductances below 1e-280 are given up, so that
nothing underflows.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Vector
from ..foundation.loading import load_modules
from ..foundation.rounding import UNDERFLOW, UNIT_ROUNDOFF, gamma

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_MOST_PAID, _LEAST_CONDUCTANCE = 0.999, 1e-280

_ROUNDS, _FEW, _FEW_OF = 6, 10, 0.01
"""So often are all payments made, and so many entries, or this part of them, may be unpaid for it to be worth it."""

_CHUNK = 200_000
"""Payments between two moments at which Ctrl-C is answered."""

_WORTH_COMPILING = 2_000
"""Payments that take plain Python less time than loading compiled code takes."""


def m_matrix_below(matrix: csr_array) -> csr_array | None:
    """Return a symmetric Z-matrix Ã such that A - Ã is positive semidefinite; None where an entry cannot be paid.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        A: symmetric, in what is stored too, with entries of moderate size, a positive diagonal, and ascending column
        numbers, none of them twice in a row.

    Returns
    -------
    csr_array or None
        With a positive diagonal. Whether it is an M-matrix, a barrier has to prove.

    Examples
    --------
    Three springs of stiffness 1, 1 and -0.25 in a triangle, and three to the ground:

    >>> from scipy.sparse import csr_array
    >>> below = m_matrix_below(csr_array([[1.75, 0.25, -1.0], [0.25, 1.75, -1.0], [-1.0, -1.0, 3.0]]))
    >>> below.toarray().round(12)
    array([[ 1.5,  0. , -0.5],
           [ 0. ,  1.5, -0.5],
           [-0.5, -0.5,  2. ]])
    """
    load_modules("scipy.sparse")
    from scipy import sparse

    size = matrix.shape[0]
    indptr, indices = matrix.indptr.astype(np.int64), matrix.indices.astype(np.int64)
    rows = np.repeat(np.arange(size), np.diff(indptr))
    beside = rows != indices
    given = np.where(beside, -matrix.data, 0.0)
    left = np.where(given < _LEAST_CONDUCTANCE, np.minimum(given, 0.0), given)
    owed = np.flatnonzero((left < 0) & (rows < indices))
    if owed.size:
        paid = _paid(indptr, indices, rows, left, owed)
        if paid is None:
            return None
        left = paid
    lost = given - left
    diagonal = matrix.diagonal()
    total = diagonal - np.bincount(rows, weights=lost, minlength=size)
    modulus = np.abs(diagonal) + np.bincount(rows, weights=np.abs(lost), minlength=size)
    longest = int(np.diff(indptr).max())
    total -= 1.01 * gamma(longest + 4) * modulus + UNDERFLOW
    if not total.min() > 0:
        return None
    kept = np.where(beside, -left, total[rows])
    below = sparse.csr_array((kept, indices, indptr), shape=matrix.shape)
    below.eliminate_zeros()
    return below


def _paid(
    indptr: NDArray[np.int64],
    indices: NDArray[np.int64],
    rows: NDArray[np.int64],
    given: Vector,
    owed: NDArray[np.int64],
) -> Vector | None:
    """Return the conductances after all payments, None where an entry cannot be paid."""
    # Where the entry (j, i) stands for each entry (i, j): the pattern is symmetric, and in ascending order.
    mirrored = np.lexsort((rows, indices))
    pay: Any = pay_in_python
    if owed.size > _WORTH_COMPILING:
        load_modules("contactqp.algebra.conductance_kernels", kernels="smallest eigenvalue")
        from .conductance_kernels import pay
    for _ in range(_ROUNDS):
        left, unpaid = given.copy(), np.zeros(owed.size, dtype=bool)
        for first in range(0, owed.size, _CHUNK):
            chosen = slice(first, first + _CHUNK)
            pay(indptr, indices, rows, left, mirrored, owed[chosen], unpaid[chosen], _MOST_PAID, _LEAST_CONDUCTANCE)
        if not unpaid.any():
            return left
        if np.count_nonzero(unpaid) > max(_FEW, _FEW_OF * owed.size):
            return None
        owed = np.concatenate([owed[unpaid], owed[~unpaid]])
    return None


def pay_in_python(
    indptr: NDArray[np.int64],
    indices: NDArray[np.int64],
    rows: NDArray[np.int64],
    left: Vector,
    mirrored: NDArray[np.int64],
    owed: NDArray[np.int64],
    unpaid: NDArray[np.bool_],
    most: float,
    least: float,
) -> None:
    """Pay negative conductances from those of the paths beside them, in place, but for those that cannot be paid.

    Parameters
    ----------
    indptr, indices, rows, mirrored : array of int
        Pointers, columns and rows of the entries, and where each one's mirror image stands.
    left : array
        The conductances, of which those paid become zero.
    owed : array of int
        Where the negative ones stand, each pair of unknowns once.
    unpaid : array of bool
        Becomes true for those that cannot be paid.
    most : float
        Part of a conductance that may go into a payment, so that something is left of it.
    least : float
        Conductances below this are given up.
    """
    for debt, place in enumerate(owed):
        i, j = rows[place], indices[place]
        at_i, at_j = np.arange(indptr[i], indptr[i + 1]), np.arange(indptr[j], indptr[j + 1])
        _, in_i, in_j = np.intersect1d(indices[at_i], indices[at_j], assume_unique=True, return_indices=True)
        first, second = at_i[in_i], at_j[in_j]
        paying = (left[first] > 0) & (left[second] > 0)
        first, second = first[paying], second[paying]
        a, b = left[first], left[second]
        capacity = float((np.minimum(a, b) * (np.maximum(a, b) / (a + b))).sum())
        capacity *= 1 - 2 * (a.size + 8) * UNIT_ROUNDOFF
        if not -left[place] < most * capacity:
            unpaid[debt] = True
            continue
        part = (1 - (-left[place] / capacity) * (1 + 4 * UNIT_ROUNDOFF)) * (1 - 8 * UNIT_ROUNDOFF)
        for entries in (first, second):
            rest = left[entries] * part
            left[entries] = left[mirrored[entries]] = np.where(rest < least, 0.0, rest)
        left[place] = left[mirrored[place]] = 0.0
