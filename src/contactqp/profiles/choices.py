"""What profiles of samples leave to choose: what holds beyond the samples, and which of several at one place counts."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Vector

Outside = Literal["error", "hold", "none"]
OUTSIDE = ("error", "hold", "none")

Decimal = Literal[".", ","]

Duplicates = Literal["error", "mean", "first", "last", "shallowest", "deepest"]
DUPLICATES = ("error", "mean", "first", "last", "shallowest", "deepest")

KEEP_ONE = f"keep one by duplicates = {', '.join(map(repr, DUPLICATES[1:]))}"
"""What to do about several samples at one place, for messages."""

REACH = 1e-9
"""Points outside the samples by less than this part of their extent are taken for rounding."""


def one_of_each(depth: Vector, starts: NDArray[np.intp], kept: str) -> Vector:
    """Return one depth for each run of samples at one place.

    Parameters
    ----------
    depth : array, shape (m,)
        Depths of the samples, those at one place one after the other.
    starts : array of int, shape (places,)
        Where each run begins.
    kept : str
        One of `DUPLICATES`, but "error".

    Returns
    -------
    array, shape (places,)

    Examples
    --------
    >>> one_of_each(np.array([1.0, 2.0, 6.0]), np.array([0, 1]), "mean")
    array([1., 4.])
    """
    ends = np.append(starts[1:], depth.size)
    chosen: dict[str, Callable[[], Vector]] = {
        "mean": lambda: np.add.reduceat(depth, starts) / (ends - starts),
        "first": lambda: depth[starts],
        "last": lambda: depth[ends - 1],
        "shallowest": lambda: np.minimum.reduceat(depth, starts),
        "deepest": lambda: np.maximum.reduceat(depth, starts),
    }
    return chosen[kept]()
