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
from ..foundation.intervals import Interval
from ..foundation.surfaces import Curvature, Ranged

_Array = NDArray[np.float64]


class Profile(ABC):
    """A rigid surface that returns depths: heights, positive downwards."""

    @abstractmethod
    def __call__(self, x: ArrayLike, y: ArrayLike) -> _Array:
        """Return the depths at the points (x, y)."""

    def range(self, x: Interval, y: Interval) -> Interval | None:
        """Return what holds the depths on rectangles, rounded outwards; None if it is not known.

        Parameters
        ----------
        x, y : Interval
            Sides of the rectangles, of shapes that fit each other (length).
        """
        return None

    def curvature(self, x: Interval, y: Interval) -> Curvature | None:
        """Return what holds the second derivatives of the depths on rectangles; None if it is not known."""
        return None

    def laplacian_range(self, x: Interval, y: Interval) -> Interval | None:
        """Return what holds the Laplacian of the depths on rectangles, infinite at kinks; None if it is not known."""
        known = self.curvature(x, y)
        return None if known is None else known.xx + known.yy


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

    def range(self, x: Interval, y: Interval) -> Interval:
        """See `Profile.range`."""
        return self.depth + self.slope_x * x + self.slope_y * y

    def curvature(self, x: Interval, y: Interval) -> Curvature:
        """See `Profile.curvature`: none."""
        return _same(_like(0.0, x, y))


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

    def range(self, x: Interval, y: Interval) -> Interval:
        """See `Profile.range`."""
        across, along = x - self.center[0], y - self.center[1]
        return self.depth + (across.square() + along.square()) / (2 * self.radius)

    def curvature(self, x: Interval, y: Interval) -> Curvature:
        """See `Profile.curvature`: 1/radius in all directions."""
        bend = Interval.of(1.0) / self.radius
        return Curvature(_like(bend, x, y), _like(0.0, x, y), _like(bend, x, y))


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

    def range(self, x: Interval, y: Interval) -> Interval:
        """See `Profile.range`."""
        across, along = x - self.center[0], y - self.center[1]
        return self.depth + self.slope * (across.square() + along.square()).sqrt()

    def curvature(self, x: Interval, y: Interval) -> Curvature:
        """See `Profile.curvature`: slope/r along circles, none along rays, a kink at the tip."""
        across, along = (x - self.center[0]).square(), (y - self.center[1]).square()
        bend = self.laplacian_range(x, y)
        half = Interval.between(-0.5, 0.5)
        return Curvature(bend * _part(along, across), bend * half, bend * _part(across, along))

    def laplacian_range(self, x: Interval, y: Interval) -> Interval:
        """See `Profile.laplacian_range`: slope/r."""
        across, along = x - self.center[0], y - self.center[1]
        distance = (across.square() + along.square()).sqrt()
        return self.slope * _reciprocal(distance)


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

    def range(self, x: Interval, y: Interval) -> Interval:
        """See `Profile.range`."""
        return _arc_range(self.depth, self.radius, _like(self._beside(x, y), x, y))

    def curvature(self, x: Interval, y: Interval) -> Curvature:
        """See `Profile.curvature`: radius²/(radius² - distance²)^(3/2) across the axis."""
        beside = self._beside(x, y)
        height = _height_of_arc(self.radius, beside)
        bend, none = _like(_reciprocal(height) * (self.radius / height).square(), x, y), _like(0.0, x, y)
        bend = Interval(bend.lower, np.where(height.lower > 0, bend.upper, np.inf))
        return Curvature(bend, none, none) if self.axis == "y" else Curvature(none, none, bend)

    def _beside(self, x: Interval, y: Interval) -> Interval:
        return (x - self.center[0] if self.axis == "y" else y - self.center[1]).absolute()


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

    def range(self, x: Interval, y: Interval) -> Interval:
        """See `Profile.range`."""
        across, along = x - self.center[0], y - self.center[1]
        return _arc_range(self.depth, self.radius, (across.square() + along.square()).sqrt())

    def curvature(self, x: Interval, y: Interval) -> Curvature:
        """See `Profile.curvature`: f_xx = 1/z + x²/z³ and f_xy = xy/z³ with z² = radius² - r²."""
        across, along = x - self.center[0], y - self.center[1]
        height = _height_of_arc(self.radius, (across.square() + along.square()).sqrt())
        once = _reciprocal(height)
        thrice = once * once.square()
        parts = (once + across.square() * thrice, across * along * thrice, once + along.square() * thrice)
        inside = height.lower > 0
        steep = Interval.between(-np.inf, np.inf)
        convex = [Interval(part.lower, np.where(inside, part.upper, np.inf)) for part in parts]
        return Curvature(convex[0], parts[1].where(inside, _like(steep, x, y)), convex[2])


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

    def range(self, x: Interval, y: Interval) -> Interval:
        """See `Profile.range`."""
        flank, ridge = self._slopes(x, y)
        return _like(self.floor, x, y).minimum(self.hill * flank.maximum(ridge).square())

    def curvature(self, x: Interval, y: Interval) -> Curvature:
        """See `Profile.curvature`: of the two faces of the hill and of the floor, with kinks where they meet."""
        flank, ridge = self._slopes(x, y)
        none = _like(0.0, x, y)
        on_flank, on_ridge = (
            _like(2 * self.hill * (Interval.of(part) / 96 / self.scale).square(), x, y) for part in (4.0, 3.0)
        )
        # (|x| + |y|)² bends upwards in a kink at either axis.
        across, along = (_like(each, x, y).empty_of_zero for each in (x, y))
        either = Interval(-on_ridge.upper, on_ridge.upper)
        of_ridge = Curvature(
            Interval(on_ridge.lower, np.where(across, on_ridge.upper, np.inf)),
            _kinked(either, ~(across & along)),
            Interval(on_ridge.lower, np.where(along, on_ridge.upper, np.inf)),
        )
        hill = _of_several(
            [Curvature(none, none, on_flank), of_ridge],
            [flank.upper >= ridge.lower, ridge.upper >= flank.lower],
            downwards=False,
        )
        height = self.hill * flank.maximum(ridge).square()
        return _of_several(
            [_same(none), hill], [height.upper >= self.floor, height.lower <= self.floor], downwards=True
        )

    def _slopes(self, x: Interval, y: Interval) -> tuple[Interval, Interval]:
        across, along = _like(y, x, y).absolute() / self.scale, _like(x, x, y).absolute() / self.scale
        return 4.0 * across / 96, 3.0 * (along + across) / 96


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

    def range(self, x: Interval, y: Interval) -> Interval | None:
        """See `Profile.range`: of the uppermost of its profiles."""
        known = self._ranges(x, y)
        if known is None:
            return None
        least, *others = known
        for other in others:
            least = least.minimum(other)
        return least

    def curvature(self, x: Interval, y: Interval) -> Curvature | None:
        """See `Profile.curvature`: of those that may be uppermost, with kinks downwards where they meet."""
        known = self._ranges(x, y)
        bends = [bend for one in self._ranged if (bend := one.curvature(x, y)) is not None]
        if known is None or len(bends) < len(self.profiles):
            return None
        top = np.minimum.reduce([one.upper for one in known])
        return _of_several(bends, [one.lower <= top for one in known], downwards=True)

    def _ranges(self, x: Interval, y: Interval) -> list[Interval] | None:
        """Return what holds each of the profiles, None if that of one is not known."""
        known = [_like(whole, x, y) for one in self._ranged if (whole := one.range(x, y)) is not None]
        return known if len(known) == len(self.profiles) else None

    @property
    def _ranged(self) -> list[Ranged]:
        """Those of the profiles that tell what they do on rectangles."""
        several: tuple[Any, ...] = self.profiles
        return [one for one in several if isinstance(one, Ranged)]

    def __repr__(self) -> str:
        return f"Uppermost({', '.join(map(repr, self.profiles))})"


def _distance(x: ArrayLike, y: ArrayLike, center: tuple[float, float]) -> _Array:
    return np.asarray(np.hypot(np.asarray(x) - center[0], np.asarray(y) - center[1]))


def _circular_arc(depth: float, radius: float, distance: _Array) -> _Array:
    # radius - sqrt(radius² - distance²), in a form whose terms neither cancel nor overflow.
    inside = np.minimum(distance / radius, 1.0)
    fall = radius * (inside / (1.0 + np.sqrt((1.0 - inside) * (1.0 + inside))) * inside)
    return np.asarray(np.where(distance <= radius, depth + fall, np.inf))


def _arc_range(depth: float, radius: float, distance: Interval) -> Interval:
    """Return what holds the depths of an arc at distances from its crown: they grow with the distance."""
    near, far = Interval.of(np.minimum(distance.lower, radius)), Interval.of(np.minimum(distance.upper, radius))
    ends = [depth + one.square() / (radius + _height_of_arc(radius, one)) for one in (near, far)]
    beside = distance.lower > radius
    return Interval(np.where(beside, np.inf, ends[0].lower), np.where(distance.upper > radius, np.inf, ends[1].upper))


def _height_of_arc(radius: float, distance: Interval) -> Interval:
    """Return what holds the height of an arc above its springing line."""
    return ((radius - distance) * (radius + distance)).sqrt()


def _reciprocal(positive: Interval) -> Interval:
    """Return what holds 1/z for numbers z >= 0, infinite where z may be 0."""
    found = 1.0 / positive.where(positive.lower > 0, Interval.of(np.ones(positive.lower.shape)))
    with np.errstate(divide="ignore", over="ignore"):
        least = np.nextafter(1 / positive.upper, 0.0)
    return Interval(np.where(positive.lower > 0, found.lower, least), np.where(positive.lower > 0, found.upper, np.inf))


def _part(own: Interval, other: Interval) -> Interval:
    """Return what holds a/(a + b) of numbers >= 0, which grows with a and falls with b."""
    ends = []
    for a, b in ((own.lower, other.upper), (own.upper, other.lower)):
        a, b = np.broadcast_arrays(a, b)
        whole = Interval.of(a) + Interval.of(b)
        ends.append(Interval.of(a) / whole.where(whole.lower > 0, Interval.of(np.ones(a.shape))))
    return Interval(np.maximum(ends[0].lower, 0.0), np.clip(ends[1].upper, ends[0].lower, 1.0))


def _of_several(pieces: list[Curvature], there: list[NDArray[np.bool_]], *, downwards: bool) -> Curvature:
    """Return what holds the second derivatives of the least, or of the greatest, of several functions.

    Parameters
    ----------
    pieces : list of Curvature
    there : list of array of bool
        Where each may be the least, or the greatest.
    downwards : bool
        Whether it is the least that counts: where two meet, it bends downwards in a kink, the greatest upwards.
    """
    several = np.add.reduce([np.asarray(one, dtype=np.int64) for one in there]) > 1
    found = []
    for parts in zip(*pieces, strict=True):
        lower = np.minimum.reduce([np.where(one, part.lower, np.inf) for one, part in zip(there, parts, strict=True)])
        upper = np.maximum.reduce([np.where(one, part.upper, -np.inf) for one, part in zip(there, parts, strict=True)])
        found.append(Interval(lower, upper))
    if downwards:
        straight = [Interval(np.where(several, -np.inf, part.lower), part.upper) for part in found]
    else:
        straight = [Interval(part.lower, np.where(several, np.inf, part.upper)) for part in found]
    return Curvature(straight[0], _kinked(found[1], several), straight[2])


def _kinked(part: Interval, where: NDArray[np.bool_]) -> Interval:
    return Interval(np.where(where, -np.inf, part.lower), np.where(where, np.inf, part.upper))


def _same(part: Interval) -> Curvature:
    return Curvature(part, part, part)


def _like(value: Interval | float, x: Interval, y: Interval) -> Interval:
    """Return an interval for each of the rectangles."""
    part = value if isinstance(value, Interval) else Interval.of(value)
    shape = np.broadcast_shapes(x.lower.shape, y.lower.shape)
    return Interval(np.broadcast_to(part.lower, shape), np.broadcast_to(part.upper, shape))


def _check_center(center: tuple[float, float]) -> None:
    if np.shape(center) != (2,):
        raise ValueError(f"center must be a pair (x, y), got {center!r}")
    for k in range(2):
        finite_number(center[k], f"center[{k}]")
