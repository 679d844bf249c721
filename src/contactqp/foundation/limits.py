"""The largest number of points that is taken, asked before any memory is."""

from __future__ import annotations

import math
import os

MAX_POINTS = 150_000_000
"""Points of a lattice, entries of an array and pixels of a picture that are taken unless `MAX_POINTS_VARIABLE` is set.

It is beyond what a workstation solves: 10⁸ nodes take 8 GB.
"""

MAX_POINTS_VARIABLE = "CONTACTQP_MAX_POINTS"
"""The environment variable that sets another limit."""

BYTES_TO_SOLVE = 80
"""What solving takes for each point of a lattice at least, as `benchmarks/speed.py` measures it."""

BYTES_OF_A_NUMBER = 8

BYTES_OF_A_PIXEL = 32
"""Four channels of four bytes, and two arrays of double precision."""


def max_points() -> int:
    """Return the largest number of points that is taken.

    Raises
    ------
    ValueError
        If the environment variable holds no whole number above 0.

    Examples
    --------
    >>> max_points()
    150000000
    """
    text = os.environ.get(MAX_POINTS_VARIABLE, "")
    if not text:
        return MAX_POINTS
    if not (text.isdecimal() and len(text) < 20 and int(text) > 0):
        raise ValueError(f"the environment variable {MAX_POINTS_VARIABLE} must be a whole number > 0, got {text!r}")
    return int(text)


def refuse_too_many(count: float, what: str, bytes_each: int, remedy: str) -> None:
    """Raise a ValueError that tells count and memory, if there are more points than are taken.

    Parameters
    ----------
    count : float
        How many there would be, however large.
    what : str
        What they are, after the count.
    bytes_each : int
        Memory that each takes.
    remedy : str
        What to do.

    Examples
    --------
    >>> refuse_too_many(2e10, "lattice points", BYTES_TO_SOLVE, "choose a larger spacing")
    Traceback (most recent call last):
    ...
    ValueError: 2e+10 lattice points would need 1.6 TB of memory; at most 150,000,000 are taken: choose a larger spacing
    """
    most = max_points()
    if count <= most:
        return
    count = float(min(count, 10**300))
    raise ValueError(
        f"{counted(count)} {what} would need {memory(count * bytes_each)} of memory; "
        f"at most {most:,} are taken: {remedy}"
    )


def counted(count: float) -> str:
    """Return a count as text: in full up to a thousand million, by its magnitude beyond.

    Examples
    --------
    >>> counted(1857), counted(300_000_000), counted(1e18)
    ('1,857', '300,000,000', '1e+18')
    """
    return f"{round(count):,}" if count < 1e9 else f"{count:.2g}"


def memory(size: float) -> str:
    """Return a number of bytes as text.

    Examples
    --------
    >>> memory(800.0), memory(4.1e9), memory(1e30)
    ('800 B', '4.1 GB', '1e+12 EB')
    """
    units = ("B", "kB", "MB", "GB", "TB", "PB", "EB")
    step = min(len(units) - 1, max(0, int(math.log10(max(size, 1.0)) // 3)))
    scaled = size / 1000.0**step
    return f"{scaled:.3g} {units[step]}" if scaled >= 100 else f"{scaled:.2g} {units[step]}"
