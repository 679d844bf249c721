"""Mixing: Anderson's acceleration of fixed-point iterations."""

from __future__ import annotations

import numpy as np

from ..foundation.checks import Vector


class Mixing:
    """Anderson's acceleration of an iteration x -> x + f(x).

    Of the places so far a combination is taken whose residuals f cancel best (Anderson, *Iterative procedures for
    nonlinear integral equations*, J. ACM 12, 1965).

    Parameters
    ----------
    depth : int
        How many of the last places it looks at.

    Examples
    --------
    >>> mixing, x = Mixing(), np.array([1.0, 1.0])
    >>> for _ in range(4):
    ...     x = mixing.next(x, np.array([[-0.1, 0.02], [0.0, -0.3]]) @ x)
    >>> bool(np.abs(x).max() < 1e-12)
    True
    """

    def __init__(self, depth: int = 6) -> None:
        self._depth = depth
        self._places: list[Vector] = []
        self._residuals: list[Vector] = []

    def next(self, place: Vector, residual: Vector) -> Vector:
        """Return where to go on from a place x with its residual f(x)."""
        self._places.append(place)
        self._residuals.append(residual)
        del self._places[: -self._depth], self._residuals[: -self._depth]
        if len(self._places) == 1:
            return place + residual
        steps = np.diff(np.stack(self._residuals, axis=1), axis=1)
        moves = np.diff(np.stack(self._places, axis=1), axis=1)
        weights, *_ = np.linalg.lstsq(steps, residual, rcond=1e-8)
        return np.asarray(place + residual - (moves + steps) @ weights)
