"""Numbers and values as short text."""

from __future__ import annotations

import math
import textwrap
from decimal import ROUND_CEILING, ROUND_DOWN, ROUND_FLOOR, ROUND_UP, Decimal, localcontext

import numpy as np
from numpy.typing import NDArray


def at_most(value: float, digits: int = 2) -> str:
    """Return ``value`` rounded upwards to some significant digits, so that ``<=`` before it is true.

    Examples
    --------
    >>> at_most(0.00173158), at_most(0.01), at_most(0.0), at_most(999.5, 3), at_most(5e-324)
    ('0.0018', '0.01', '0', '1e+03', '1e-300')
    """
    # A number whose digits are none of the problem's, but of where doubles end.
    return _rounded(_SMALLEST if 0 < value < _SMALLEST else value, digits, ROUND_UP)


_SMALLEST = 1e-300
"""Bounds that are less are told as this."""


def rounded_outwards(lower: float, upper: float, digits: int = 12) -> tuple[float, float]:
    """Return two numbers that enclose two others, rounded away from each other to some significant digits.

    Examples
    --------
    >>> rounded_outwards(1.0100000000000002, 1.0100000000000005), rounded_outwards(-0.5, math.inf)
    ((1.01, 1.01000000001), (-0.5, inf))
    """
    return _towards(lower, digits, ROUND_FLOOR), _towards(upper, digits, ROUND_CEILING)


def _towards(value: float, digits: int, rounding: str) -> float:
    if not math.isfinite(value):
        return value
    with localcontext() as context:
        context.prec, context.rounding = digits, rounding
        shorter = float(+Decimal(value))
    # To read a decimal rounds it once more, to the nearest double.
    return shorter if (shorter <= value) == (rounding == ROUND_FLOOR) or shorter == value else value


def at_least(value: float, digits: int = 2) -> str:
    """Return ``value`` rounded downwards to some significant digits, so that ``>=`` before it is true.

    Examples
    --------
    >>> at_least(0.00179), at_least(0.01), at_least(0.0)
    ('0.0017', '0.01', '0')
    """
    return _rounded(value, digits, ROUND_DOWN)


def _rounded(value: float, digits: int, rounding: str) -> str:
    if not (math.isfinite(value) and value > 0):
        return f"{value:.{digits}g}"
    with localcontext() as context:
        context.prec, context.rounding = digits, rounding
        return f"{float(+Decimal(repr(float(value)))):.{digits}g}"


def folded(text: str, room: int, hanging: int) -> str:
    """Return text of which lines that are longer than there is room for go on below, between words.

    Parameters
    ----------
    text : str
    room : int
        Characters of a line.
    hanging : int
        Blanks before what goes on.

    Examples
    --------
    >>> print(folded("caution  it is much too wide", 18, 9))
    caution  it is
             much too
             wide
    """
    fold = textwrap.TextWrapper(
        width=max(room, hanging + 20),
        subsequent_indent=" " * hanging,
        break_long_words=False,
        break_on_hyphens=False,
        drop_whitespace=True,
        replace_whitespace=False,
    )
    return "\n".join("\n".join(fold.wrap(line)) for line in text.splitlines())


def known_number(value: float | None, digits: int = 2) -> str:
    """Return a number as `number` does, ``-`` for an infinite one as well: the least of none."""
    return number(None if value is None or math.isinf(value) else value, digits)


def number(value: float | None, digits: int = 2) -> str:
    """Return a number with so many significant digits, ``-`` for none."""
    return "-" if value is None else f"{value:.{digits}g}"


def count(value: int | None) -> str:
    """Return a count, ``-`` for none."""
    return "-" if value is None else str(value)


def counted(value: int, noun: str, several: str | None = None) -> str:
    """Return a count with what is counted.

    Examples
    --------
    >>> counted(1, "node"), counted(2, "node"), counted(3, "family", "families")
    ('1 node', '2 nodes', '3 families')
    """
    return f"{value} {noun if value == 1 else several or f'{noun}s'}"


def at_upper_bound(nodes: int | None) -> str:
    """Return how many of some nodes in contact the upper bound holds, ``""`` if there is no upper bound."""
    return "" if nodes is None else f" ({nodes} of them at the upper bound)"


def seconds(value: float | None) -> str:
    """Return a time with three significant digits, ``-`` for none."""
    return "-" if value is None else f"{value:#.3g}"


def shortened(value: object, length: int = 60) -> str:
    """Return a value as text of at most so many characters."""
    text = " ".join(str(value).split())
    return text if len(text) <= length else text[: length - 1] + "…"


def span_of(values: NDArray[np.float64], digits: int = 4) -> str:
    """Return the range of the finite values, ``none`` if there is none.

    Examples
    --------
    >>> span_of(np.array([2.0, 0.5, np.inf])), span_of(np.array([3.0, 3.0])), span_of(np.array([np.inf]))
    ('0.5 to 2', '3', 'none')
    """
    known = values[np.isfinite(values)]
    if not known.size:
        return "none"
    low, high = (f"{float(bound):.{digits}g}" for bound in (known.min(), known.max()))
    return low if low == high else f"{low} to {high}"
