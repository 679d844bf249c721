"""Analytic profiles: rigid surfaces f(x, y) given by a formula.

Every profile is a small callable that returns depths in the unit of its lengths: heights, positive downwards from the
plane of the frame; infinite where there is no surface. A model whose heights are positive upwards takes them as depths
all the same.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..foundation.checks import finite_number, one_of, positive_number

_Array = NDArray[np.float64]


class Profile(ABC):
    """A rigid surface that returns depths: heights, positive downwards."""

    @abstractmethod
    def __call__(self, x: ArrayLike, y: ArrayLike) -> _Array:
        """Return the depths at the points (x, y)."""


@dataclass(frozen=True)
class Plane(Profile):
    """A plane: f = depth + slope_x x + slope_y y.

    Parameters
    ----------
    depth : float
        Height at the origin, positive downwards (length).
    slope_x, slope_y : float
        Slopes, positive where the plane falls.

    Examples
    --------
    >>> Plane(depth=1.3)(0.0, 0.0)
    array(1.3)
    """

    depth: float
    slope_x: float = 0.0
    slope_y: float = 0.0

    def __post_init__(self) -> None:
        for name in ("depth", "slope_x", "slope_y"):
            finite_number(getattr(self, name), name)

    def __call__(self, x: ArrayLike, y: ArrayLike) -> _Array:
        """Return the depths f at the points (x, y)."""
        return np.asarray(self.depth + self.slope_x * np.asarray(x) + self.slope_y * np.asarray(y))


@dataclass(frozen=True)
class Paraboloid(Profile):
    """A paraboloid of revolution: f = depth + r²/(2 radius).

    Parameters
    ----------
    depth : float
        Height of the vertex, positive downwards (length).
    radius : float
        Radius of curvature at the vertex (length), positive for a hill, negative for a bowl.
    center : (float, float)
        The vertex's x and y (length).

    Examples
    --------
    >>> Paraboloid(depth=0.5, radius=2.0)(np.array([0.0, 2.0]), 0.0)
    array([0.5, 1.5])
    """

    depth: float
    radius: float
    center: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        finite_number(self.depth, "depth")
        if finite_number(self.radius, "radius") == 0:
            raise ValueError("radius must not be 0")
        _check_center(self.center)

    def __call__(self, x: ArrayLike, y: ArrayLike) -> _Array:
        """Return the depths f at the points (x, y)."""
        return np.asarray(self.depth + _distance(x, y, self.center) ** 2 / (2 * self.radius))


@dataclass(frozen=True)
class Cone(Profile):
    """A cone: f = depth + slope r.

    Parameters
    ----------
    depth : float
        Height of the tip, positive downwards (length).
    slope : float
        Fall per length; negative for a funnel.
    center : (float, float)
        The tip's x and y (length).

    Examples
    --------
    >>> Cone(depth=0.1, slope=0.5)(3.0, 4.0)
    array(2.6)
    """

    depth: float
    slope: float
    center: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        finite_number(self.depth, "depth")
        finite_number(self.slope, "slope")
        _check_center(self.center)

    def __call__(self, x: ArrayLike, y: ArrayLike) -> _Array:
        """Return the depths f at the points (x, y)."""
        return np.asarray(self.depth + self.slope * _distance(x, y, self.center))


@dataclass(frozen=True)
class Cylinder(Profile):
    """The upper half of a lying circular cylinder; infinite beside it.

    Parameters
    ----------
    depth : float
        Height of the crown, positive downwards (length).
    radius : float
        Radius (length), > 0.
    center : (float, float)
        A point below which the axis passes (length).
    axis : "x" or "y"
        Direction of the axis.

    Examples
    --------
    >>> Cylinder(depth=1.0, radius=5.0, axis="y")(np.array([0.0, 3.0, 6.0]), 0.0)
    array([ 1.,  2., inf])
    """

    depth: float
    radius: float
    center: tuple[float, float] = (0.0, 0.0)
    axis: Literal["x", "y"] = "y"

    def __post_init__(self) -> None:
        finite_number(self.depth, "depth")
        positive_number(self.radius, "radius")
        _check_center(self.center)
        one_of(self.axis, ("x", "y"), "axis")

    def __call__(self, x: ArrayLike, y: ArrayLike) -> _Array:
        """Return the depths f at the points (x, y)."""
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        distance = np.abs(x - self.center[0]) if self.axis == "y" else np.abs(y - self.center[1])
        return _circular_arc(self.depth, self.radius, distance)


@dataclass(frozen=True)
class Hemisphere(Profile):
    """The upper half of a sphere; infinite beside it.

    Parameters
    ----------
    depth : float
        Height of the summit, positive downwards (length).
    radius : float
        Radius (length), > 0.
    center : (float, float)
        The summit's x and y (length).

    Examples
    --------
    >>> Hemisphere(depth=0.0, radius=5.0)(np.array([0.0, 4.0]), 0.0)
    array([0., 2.])
    """

    depth: float
    radius: float
    center: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        finite_number(self.depth, "depth")
        positive_number(self.radius, "radius")
        _check_center(self.center)

    def __call__(self, x: ArrayLike, y: ArrayLike) -> _Array:
        """Return the depths f at the points (x, y)."""
        return _circular_arc(self.depth, self.radius, _distance(x, y, self.center))


@dataclass(frozen=True)
class HillAndFloor(Profile):
    """A flat floor with a hexagonal hill whose summit touches the plane of the frame.

    With m = max(4|y|, 3(|x| + |y|)) / 96, which is 1 on the contour of the paper's hexagon
    (|y| ≤ 24, |x| + |y| ≤ 32), f = min(floor, hill m²). With the default numbers it is a *surrogate consistent
    with Table 1* of the paper that contactqp starts from, not a reproduction: the paper's own surface, its
    Fig. 4, is lost.

    Parameters
    ----------
    floor : float
        Depth of the floor (length).
    hill : float
        Depth that the hill would reach on the contour (length).
    scale : float
        Size of the hill relative to the paper's hexagon with unit spacing.

    Examples
    --------
    >>> HillAndFloor()(np.array([0.0, 8.0, 16.0, 32.0]), 0.0)
    array([0.    , 0.3125, 1.25  , 1.25  ])
    """

    floor: float = 1.25
    hill: float = 5.0
    scale: float = 1.0

    def __post_init__(self) -> None:
        finite_number(self.floor, "floor")
        positive_number(self.hill, "hill")
        positive_number(self.scale, "scale")

    def __call__(self, x: ArrayLike, y: ArrayLike) -> _Array:
        """Return the depths f at the points (x, y)."""
        across, along = np.abs(y) / self.scale, np.abs(x) / self.scale
        m = np.maximum(4 * across, 3 * (along + across)) / 96
        return np.asarray(np.minimum(self.floor, self.hill * m**2))


@dataclass(frozen=True, init=False)
class Uppermost(Profile):
    """The uppermost of several profiles at each point: f = min of theirs.

    Examples
    --------
    >>> ground = Uppermost(Plane(2.0), Hemisphere(depth=0.5, radius=1.0))
    >>> ground(np.array([0.0, 3.0]), 0.0)
    array([0.5, 2. ])
    """

    profiles: tuple[Callable[[Any, Any], Any], ...]

    def __init__(self, *profiles: Callable[[Any, Any], Any]) -> None:
        if not profiles or not all(callable(profile) for profile in profiles):
            raise TypeError(f"Uppermost takes one or more profiles, got {profiles!r}")
        object.__setattr__(self, "profiles", profiles)

    def __call__(self, x: ArrayLike, y: ArrayLike) -> _Array:
        """Return the depths f at the points (x, y)."""
        return np.asarray(np.minimum.reduce([np.asarray(profile(x, y)) for profile in self.profiles]))

    def __repr__(self) -> str:
        return f"Uppermost({', '.join(map(repr, self.profiles))})"


def _distance(x: ArrayLike, y: ArrayLike, center: tuple[float, float]) -> _Array:
    return np.asarray(np.hypot(np.asarray(x) - center[0], np.asarray(y) - center[1]))


def _circular_arc(depth: float, radius: float, distance: _Array) -> _Array:
    # radius - sqrt(radius² - distance²), in a form whose terms neither cancel nor overflow.
    inside = np.minimum(distance / radius, 1.0)
    fall = radius * (inside / (1.0 + np.sqrt((1.0 - inside) * (1.0 + inside))) * inside)
    return np.asarray(np.where(distance <= radius, depth + fall, np.inf))


def _check_center(center: tuple[float, float]) -> None:
    if np.shape(center) != (2,):
        raise ValueError(f"center must be a pair (x, y), got {center!r}")
    for k in range(2):
        finite_number(center[k], f"center[{k}]")
