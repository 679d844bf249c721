"""Bounds of rounding errors: Higham, *Accuracy and Stability of Numerical Algorithms* (2002), ch. 3."""

from __future__ import annotations

import math
from collections.abc import Iterable
from decimal import ROUND_UP, Decimal, localcontext
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .stiffness import Stiffness

UNIT_ROUNDOFF = 2.0**-53

UNDERFLOW = 1e-300
"""Added to every error bound: more than what gradual underflow can take from a short sum of products.

Underflow is taken to be gradual, as IEEE 754 has it; a library that makes the processor flush subnormal numbers to zero
would take the ground from under the smallest of numbers.
"""


DIFFERENCES = 12
"""Operations by which the reaction of a lattice's node, and the bound of its error, are formed from differences.

Each of the four differences is rounded once, multiplied by its arm, and added to the others and to q: five roundings
in a chain (Higham 2002, lemma 3.1); as many for the bound, and two to spare.
"""


def at_most(value: float, digits: int = 2) -> str:
    """Return ``value`` rounded upwards to some significant digits, so that ``<=`` before it is true.

    Examples
    --------
    >>> at_most(0.00173158), at_most(0.01), at_most(0.0), at_most(999.5, 3)
    ('0.0018', '0.01', '0', '1e+03')
    """
    if not (math.isfinite(value) and value > 0):
        return f"{value:.{digits}g}"
    with localcontext() as context:
        context.prec, context.rounding = digits, ROUND_UP
        return f"{float(+Decimal(repr(float(value)))):.{digits}g}"


def sum_below(numbers: Iterable[float]) -> float:
    """Return a lower bound of the sum, -inf where it overflows on the way."""
    try:
        return math.nextafter(math.fsum(numbers), -math.inf)
    except OverflowError:
        return -math.inf


def sum_above(numbers: Iterable[float]) -> float:
    """Return an upper bound of the sum, inf where it overflows on the way."""
    try:
        return math.nextafter(math.fsum(numbers), math.inf)
    except OverflowError:
        return math.inf


def gamma(operations: int) -> float:
    """Return gamma_k = k u / (1 - k u), Higham (2002), lemma 3.1."""
    error = operations * UNIT_ROUNDOFF
    return error / (1 - error)


def growth_bound(stiffness: Stiffness) -> float:
    """Return c such that a computed row of G x + q is within c (|G| |x| + |q|) of the exact one.

    A row with m entries takes m products and m sums (Higham 2002, eq. 3.5); four operations are added for the
    evaluation of the bound itself.
    """
    return gamma(longest_row(stiffness) + 6)


def longest_row(stiffness: Stiffness) -> int:
    """Return the largest number of entries in a row of G."""
    from .stencil import Stencil

    return 5 if isinstance(stiffness, Stencil) else int(np.diff(stiffness.tocsr().indptr).max())
