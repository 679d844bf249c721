"""Functions of (x, y) with a declared constant, so that what they do between the nodes is known."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..foundation.checks import finite_number
from ..foundation.intervals import Interval
from ..foundation.surfaces import Curvature
from .fields import of_x_and_y

_ROUNDING = 1 + 1e-12
"""A declared constant is taken to be so many times as large, which covers how places are rounded."""


class Smooth:
    """A function of (x, y), or of x on a cable, with bounds of its derivatives that its author answers for.

    A program sees a function at points only. With a bound of its slope, or of its second derivatives, what it does
    between them is known as well, and `Solution.continuum` proves what it says of the membrane.

    Parameters
    ----------
    function : function of (x, y)
        As a model takes it for a load, a support, a ceiling, a foundation, a tension or a frame's height.
    lipschitz : float, optional
        No less than the slope: |f(P) - f(Q)| is at most so many times the distance of P and Q.
    second_derivative : float, optional
        No less than the modulus of its second derivative in any direction; f may have jumps of it, no kinks. Give this
        one where it is known: the bounds that follow are of second order in the spacing.

    Raises
    ------
    TypeError, ValueError
        If the function cannot be called, or neither constant is given, or one is negative or not finite.

    Examples
    --------
    >>> import contactqp as cq
    >>> ground = cq.Smooth(lambda x, y: 0.2 + 0.1 * np.sin(x) * np.cos(y), second_derivative=0.2)
    >>> ground(0.0, 0.0), ground
    (np.float64(0.2), Smooth(<lambda>, second_derivative=0.2))
    """

    def __init__(
        self,
        function: Callable[..., Any],
        *,
        lipschitz: float | None = None,
        second_derivative: float | None = None,
    ) -> None:
        if not callable(function):
            raise TypeError(
                f"function must be a function of (x, y), got {type(function).__name__}: numbers, arrays and "
                "profiles need no such declaration"
            )
        if lipschitz is None and second_derivative is None:
            raise ValueError(
                "give lipschitz, or second_derivative, or both: without them nothing is known of a function"
            )
        self.function = function
        self.lipschitz = _constant(lipschitz, "lipschitz")
        self.second_derivative = _constant(second_derivative, "second_derivative")
        self._of_both = of_x_and_y(function)

    def __call__(self, x: ArrayLike, y: ArrayLike = 0.0) -> Any:
        """Return what the function does."""
        return self._of_both(x, y)

    def range(self, x: Interval, y: Interval) -> Interval:
        """Return what holds the function on rectangles; see `contactqp.foundation.surfaces.Ranged`."""
        corners = [self._at(a, b) for a in (x.lower, x.upper) for b in (y.lower, y.upper)]
        least, most = np.minimum.reduce(corners), np.maximum.reduce(corners)
        width, height = x.upper - x.lower, y.upper - y.lower
        room = np.full(least.shape, np.inf)
        if self.second_derivative is not None:
            room = np.minimum(room, _ROUNDING * self.second_derivative / 8 * (width**2 + height**2))
        if self.lipschitz is not None:
            # A weighted mean of the corners' distances from a point is at most half the diagonal.
            room = np.minimum(room, _ROUNDING * self.lipschitz / 2 * np.hypot(width, height))
        return Interval.around(least, room).hull(Interval.around(most, room))

    def curvature(self, x: Interval, y: Interval) -> Curvature | None:
        """Return what holds the second derivatives; see `contactqp.foundation.surfaces.Ranged`."""
        if self.second_derivative is None:
            return None
        shape = np.broadcast_shapes(x.lower.shape, y.lower.shape)
        most = np.full(shape, _ROUNDING * self.second_derivative)
        either = Interval(-most, most)
        return Curvature(either, either, either)

    def _at(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        x, y = np.broadcast_arrays(x, y)
        values = np.asarray(self._of_both(x.ravel(), y.ravel()), dtype=np.float64)
        return np.broadcast_to(values, x.size).reshape(x.shape)

    def __repr__(self) -> str:
        told = [getattr(self.function, "__name__", repr(self.function))]
        constants = {"lipschitz": self.lipschitz, "second_derivative": self.second_derivative}
        told += [f"{name}={value:g}" for name, value in constants.items() if value is not None]
        return f"Smooth({', '.join(told)})"


def _constant(value: float | None, name: str) -> float | None:
    if value is None:
        return None
    number = finite_number(value, name)
    if number < 0:
        raise ValueError(f"{name} must be >= 0, got {number:g}")
    return number
