"""Reactions of a gap that is held as a sum of two doubles, nearly as accurate as if computed in twice the precision.

Sums and products of doubles are split into a rounded result and its exact error (Knuth's and Dekker's transformations,
see Ogita, Rump and Oishi, *Accurate sum and dot product*, SIAM J. Sci. Comput. 26, 2005). The results are
added up in a chain whose own errors are kept as well, so that what is rounded at all are small numbers: the
errors, and the products with the low part of the gap.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..algebra.stencil import Stencil
from ..foundation.checks import Vector
from ..foundation.rounding import UNDERFLOW, UNIT_ROUNDOFF, gamma

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from ..problem.contact_qp import ContactQP

_Array = NDArray[np.float64]

_SPLITTER = 2.0**27 + 1
_POINTS_AT_ONCE = 1 << 15
"""Points of a lattice whose intermediate results stay in the processor's cache."""

_SMALL_OPERATIONS = 12
"""Roundings of a small number before it is added, twice over for those that cancel, and of the sum of moduli."""


def two_sum(first: _Array, second: _Array) -> tuple[_Array, _Array]:
    """Return the rounded sum and its error: both together are the exact sum (Knuth).

    Examples
    --------
    >>> two_sum(1.0, 2.0**-60) == (1.0, 2.0**-60)
    True
    """
    total = first + second
    part = total - first
    return total, (first - (total - part)) + (second - part)


def two_product(first: Any, second: _Array) -> tuple[_Array, _Array]:
    """Return the rounded product and its error (Dekker, with Veltkamp's splitting).

    Both together are the exact product if nothing under- or overflows.

    Examples
    --------
    >>> two_product(1.0 + 2.0**-30, 1.0 + 2.0**-30)[1] == 2.0**-60
    True
    """
    product = first * second
    first_high, second_high = _upper_half(first), _upper_half(second)
    first_low, second_low = first - first_high, second - second_high
    error = first_low * second_low - (
        ((product - first_high * second_high) - first_low * second_high) - first_high * second_low
    )
    return product, error


def _upper_half(number: Any) -> Any:
    scaled = _SPLITTER * number
    return scaled - (scaled - number)


class _Chain:
    """Sums whose roundings are kept, and the moduli of the small numbers that were rounded on the way."""

    def __init__(self, first: _Array) -> None:
        self._high = first.copy()
        self._low = np.zeros_like(first)
        self._rounded = np.zeros_like(first)

    def add(self, product: _Array, *small: _Array) -> None:
        """Add a number to each of the first sums, and small ones that may be rounded."""
        chosen = slice(product.shape[0])
        self._high[chosen], error = two_sum(self._high[chosen], product)
        for number in (error, *small):
            self._low[chosen] += number
            self._rounded[chosen] += np.abs(number)

    def take_into_account(self, modulus: _Array) -> None:
        """Let the bound cover numbers that cancelled before they were added."""
        self._rounded += modulus

    def result(self, terms: int) -> tuple[_Array, _Array]:
        """Return the sums of so many terms and a bound of their errors.

        Each small number is rounded a few times in its own making and once in each of the at most three sums a term
        that follow (Higham 2002, lemma 3.1).
        """
        total = self._high + self._low
        bound = gamma(3 * terms + _SMALL_OPERATIONS) * self._rounded
        bound += 2 * UNIT_ROUNDOFF * np.abs(total) + UNDERFLOW
        return total, bound


def accurate_reaction(problem: ContactQP, high: Vector, low: Vector) -> tuple[Vector, Vector]:
    """Return R = G(high + low) + q, and a bound of its error that shrinks with R and ``low``.

    Parameters
    ----------
    problem : ContactQP
    high, low : array, shape (n,)
        The gap is their unrounded sum (length).

    Returns
    -------
    reaction, bound : array, shape (n,)
        Force; not finite where numbers are too large to be split.

    Examples
    --------
    >>> import numpy as np
    >>> import contactqp as cq
    >>> problem = cq.ContactQP(np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([-1.0, -1.0]))
    >>> reaction, bound = accurate_reaction(problem, np.array([1.0, 1.0]), np.array([1e-20, 0.0]))
    >>> reaction.tolist(), bool(bound.max() < 1e-34)
    ([2e-20, -1e-20], True)
    """
    with np.errstate(over="ignore", invalid="ignore"):
        if problem.stencil is not None:
            return _on_lattice(problem.stencil, problem.q, high, low)
        return _of_matrix(problem.G, problem.q, high, low)


def _on_lattice(stencil: Stencil, q: Vector, high: Vector, low: Vector) -> tuple[Vector, Vector]:
    """Add stiffness times difference for the four arms of every point of the net, some rows at a time."""
    rows, columns = stencil.mask.shape
    padded_high, padded_low = stencil.pad(high), stencil.pad(low)
    force = stencil.pad(q)[1:-1, 1:-1]
    weights = [np.broadcast_to(arm, stencil.mask.shape) for arm in stencil.weights()]
    reaction, bound = np.empty((rows, columns)), np.empty((rows, columns))
    step = max(1, _POINTS_AT_ONCE // columns)
    for first in range(0, rows, step):
        last = min(first + step, rows)
        chain = _Chain(force[first:last])
        own = slice(first + 1, last + 1), slice(1, columns + 1)
        for arm, (down, right) in zip(weights, ((0, -1), (0, 1), (-1, 0), (1, 0)), strict=True):
            other = slice(first + 1 + down, last + 1 + down), slice(1 + right, columns + 1 + right)
            stiffness = arm[first:last]
            difference, rest = two_sum(padded_high[own], -padded_high[other])
            rest += padded_low[own] - padded_low[other]
            product, error = two_product(stiffness, difference)
            chain.add(product, error, stiffness * rest)
            chain.take_into_account(stiffness * (np.abs(padded_low[own]) + np.abs(padded_low[other])))
        reaction[first:last], bound[first:last] = chain.result(5)
    return stencil.take(reaction), stencil.take(bound)


def _of_matrix(matrix: csr_array, q: Vector, high: Vector, low: Vector) -> tuple[Vector, Vector]:
    """Add entry times gap, the first entry of every row, then the second of those that have one, and so on."""
    length = np.diff(matrix.indptr)
    order = np.argsort(-length, kind="stable")
    starts = matrix.indptr[:-1][order]
    ascending = np.sort(length)
    chain = _Chain(q[order])
    for k in range(int(ascending[-1])):
        count = int(length.size - np.searchsorted(ascending, k, side="right"))
        places = starts[:count] + k
        entry, column = matrix.data[places], matrix.indices[places]
        product, error = two_product(entry, high[column])
        chain.add(product, error, entry * low[column])
    total, error_bound = chain.result(int(ascending[-1]) + 1)
    reaction, bound = np.empty_like(total), np.empty_like(total)
    reaction[order], bound[order] = total, error_bound
    return reaction, bound
