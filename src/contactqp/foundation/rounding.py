"""Bounds of rounding errors: Higham, *Accuracy and Stability of Numerical Algorithms* (2002), ch. 3."""

from __future__ import annotations

import math

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


def gamma(operations: int) -> float:
    """Return gamma_k = k u / (1 - k u), Higham (2002), lemma 3.1."""
    error = operations * UNIT_ROUNDOFF
    return error / (1 - error)


def quotient_below(first: float, second: float) -> float:
    """Return a number that is no more than the quotient of two, the first not negative, the second positive.

    The rounded quotient is off by half a unit in its last place at most.

    Examples
    --------
    >>> quotient_below(1.0, 3.0) < 1 / 3 < quotient_above(1.0, 3.0), quotient_below(0.0, 3.0)
    (True, 0.0)
    """
    return max(0.0, math.nextafter(first / second, 0.0))


def quotient_above(first: float, second: float) -> float:
    """Return a number that is no less than the quotient of two, the first not negative, the second positive."""
    return math.nextafter(first / second, math.inf)
