"""Along: a surface along a straight line in plan, as a cable or a beam over it has for its ground."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..foundation.checks import finite_number
from ..foundation.intervals import Interval
from ..foundation.surfaces import Curvature, Ranged
from .analytic import Profile


class Along(Profile):
    """A surface along a straight line in plan: x is the distance from where the line starts.

    Parameters
    ----------
    surface : profile or function of (x, y)
        Returns depths at points in plan, such as `Gridded` and `Scattered`.
    start, end : (float, float)
        Where the line starts and ends in plan, length. Beyond its end, and before its start, it goes straight on.
    abscissa : float
        What x is at the start, length, such as the ``start`` of a cable.

    Raises
    ------
    TypeError, ValueError
        If the surface cannot be called, or start and end are no two different points.

    Attributes
    ----------
    span : float
        Length of the line.

    Notes
    -----
    A y other than 0 lies beside the line, to the left of who looks along it: the profile is the surface, moved and
    turned as a whole. A model asks for the depths at its nodes only, so these should lie at least as close as the
    surface's samples.

    Examples
    --------
    >>> from contactqp.profiles import Plane
    >>> line = Along(Plane(depth=80.0, slope_x=0.5), start=(100.0, 0.0), end=(400.0, 400.0))
    >>> line.span
    500.0
    >>> line([0.0, 100.0, 500.0])
    array([130., 160., 280.])
    >>> import contactqp as cq
    >>> cable = cq.Cable(line.span, spacing=5.0, tension=400.0, load=0.7, support=line, frame_height=line)
    """

    def __init__(
        self,
        surface: Callable[[Any, Any], Any],
        start: tuple[float, float],
        end: tuple[float, float],
        *,
        abscissa: float = 0.0,
    ) -> None:
        if not callable(surface):
            raise TypeError(
                f"surface must be a profile or a function of (x, y), got {type(surface).__name__}; profiles.Gridded "
                "and profiles.Scattered are made of arrays"
            )
        self.surface = surface
        self.start, self.end = _point(start, "start"), _point(end, "end")
        self.abscissa = finite_number(abscissa, "abscissa")
        along = np.subtract(self.end, self.start)
        self.span = float(np.hypot(*along))
        if not 0 < self.span < np.inf:
            raise ValueError(f"start and end must be different points, got {self.start} and {self.end}")
        self._direction = along / self.span

    def __call__(self, x: ArrayLike, y: ArrayLike = 0.0) -> NDArray[np.float64]:
        """Return the depths f at distances x from the start, y beside the line."""
        far, beside = np.asarray(x, dtype=np.float64) - self.abscissa, np.asarray(y, dtype=np.float64)
        (towards_x, towards_y), (start_x, start_y) = self._direction, self.start
        points = start_x + far * towards_x - beside * towards_y, start_y + far * towards_y + beside * towards_x
        return np.asarray(self.surface(*points), dtype=np.float64)

    def range(self, x: Interval, y: Interval) -> Interval | None:
        """See `Profile.range`: that of the surface."""
        surface: Any = self.surface
        return surface.range(*self._in_plan(x, y)) if isinstance(surface, Ranged) else None

    def curvature(self, x: Interval, y: Interval) -> Curvature | None:
        """See `Profile.curvature`: that of the surface, turned."""
        surface: Any = self.surface
        known = surface.curvature(*self._in_plan(x, y)) if isinstance(surface, Ranged) else None
        if known is None:
            return None
        a, b = (float(part) for part in self._direction)
        mixed = 2 * Interval.of(a) * b * known.xy
        return Curvature(
            a * (a * known.xx) + mixed + b * (b * known.yy),
            a * (b * (known.yy - known.xx)) + (Interval.of(a).square() - Interval.of(b).square()) * known.xy,
            b * (b * known.xx) - mixed + a * (a * known.yy),
        )

    def _in_plan(self, x: Interval, y: Interval) -> tuple[Interval, Interval]:
        far, (a, b), (start_x, start_y) = x - self.abscissa, map(float, self._direction), self.start
        return start_x + far * a - y * b, start_y + far * b + y * a

    def __repr__(self) -> str:
        (x0, y0), (x1, y1) = self.start, self.end
        return f"Along({self.surface!r}, from ({x0:g}, {y0:g}) to ({x1:g}, {y1:g}), span={self.span:g})"


def _point(value: Any, name: str) -> tuple[float, float]:
    if np.shape(value) != (2,):
        raise ValueError(f"{name} must be a pair (x, y), got {value!r}")
    return finite_number(value[0], f"{name}[0]"), finite_number(value[1], f"{name}[1]")
