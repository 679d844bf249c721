"""Sums whose roundings are kept: results nearly as accurate as if computed in twice the precision.

Sums and products of doubles are split into a rounded result and its exact error (Knuth's and Dekker's transformations,
see Ogita, Rump and Oishi, *Accurate sum and dot product*, SIAM J. Sci. Comput. 26, 2005). The results are
added up in a chain whose own errors are kept as well, so that what is rounded at all are small numbers: the
errors, and the products with the low part of a vector that is held as a sum of two doubles.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.rounding import UNDERFLOW, UNIT_ROUNDOFF, gamma

_Array = NDArray[np.float64]

_SPLITTER = 2.0**27 + 1

_SMALL_OPERATIONS = 12
"""Roundings of a small number on its way into the chain, and of the modulus that bounds it.

Three make the longest way: a difference of low parts, its sum with the error of the difference of the high parts, and
the product with the arm. Three make its modulus: the sum of two moduli, the product with the arm, and the sum with the
other moduli. They are counted twice, for numbers that cancel are covered by their moduli alone: twelve.
"""


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


class Chain:
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
