"""The power method."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ..foundation.checks import Vector


def largest_growth(apply: Callable[[Vector], Vector], start: Vector, steps: int) -> float:
    """Return by how much a matrix lengthens a vector that its own powers have turned towards the largest eigenvalue.

    It estimates the modulus of that eigenvalue, for a symmetric matrix from below.

    Parameters
    ----------
    apply : callable
        Returns the matrix times a vector.
    start : array, shape (n,)
        Not zero.
    steps : int
        Fewer are made where a product vanishes or overflows.

    Examples
    --------
    >>> round(largest_growth(lambda vector: np.array([3.0, 1.0]) * vector, np.ones(2), 20), 9)
    3.0
    """
    vector, norm = start, _norm(start)
    for _ in range(steps):
        vector = apply(vector / norm)
        norm = _norm(vector)
        if not 0 < norm < math.inf:
            break
    return norm


def generic_start(size: int) -> Vector:
    """Return a vector to start from that no symmetry of a matrix makes orthogonal to the one that is looked for."""
    return np.asarray(np.cos(np.arange(size) ** 2.0))


def _norm(vector: Vector) -> float:
    return math.sqrt(float((vector * vector).sum()))
