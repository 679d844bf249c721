"""Sides: the straight sides of a contour, which of them a lattice moves, and the spacings that divide all of them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..foundation.loading import load_modules

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

_WHOLE = 1e-9
"""A ratio that is so near to a whole number, relative to itself, counts as one."""

_PARTS = 10_000
"""Largest number of spacings along a side among those that are tried."""

_ROUND_DIGITS = 4
"""Significant digits up to which a spacing is one that people write."""


@dataclass(frozen=True)
class Moved:
    """A side along an axis that does not lie on the lattice.

    Attributes
    ----------
    axis : {"x", "y"}
        The coordinate that the side has.
    at, to : float
        Where the side lies, and where the lattice has it (length).
    outwards : {-1, 1}
        Whether the outside lies at smaller or at larger coordinates.
    """

    axis: str
    at: float
    to: float
    outwards: int

    @property
    def distance(self) -> float:
        """How far it is moved (length)."""
        return abs(self.to - self.at)

    def __str__(self) -> str:
        return f"{self.axis} = {self.at:.6g} at {self.to:.6g}"


class Sides:
    """The straight sides of a contour.

    Parameters
    ----------
    geometry : shapely Polygon or MultiPolygon
    """

    def __init__(self, geometry: BaseGeometry) -> None:
        load_modules("shapely")
        import shapely

        left, bottom, right, top = map(float, geometry.bounds)
        self.corner = np.array([left, bottom])
        self.extent = max(right - left, top - bottom)
        # The inside lies to the left of each side.
        parts = shapely.orient_polygons(shapely.get_parts(geometry))
        rings = [shapely.get_coordinates(ring) for part in parts for ring in (part.exterior, *part.interiors)]
        self._from = np.concatenate([ring[:-1] for ring in rings])
        self._to = np.concatenate([ring[1:] for ring in rings])
        self._step = self._to - self._from

    @cached_property
    def _level(self) -> float:
        """Length that is nothing beside the contour's extent."""
        return _WHOLE * self.extent

    def _along(self, axis: int) -> NDArray[np.bool_]:
        """Return which sides lie along an axis: 0 for x, 1 for y."""
        return np.asarray(np.abs(self._step[:, 1 - axis]) <= self._level)

    def _outwards(self, across: int) -> NDArray[np.float64]:
        """Return where the outside of each side across an axis lies: one that goes up has it at larger x."""
        return np.asarray(np.sign(self._step[:, 1] if across == 0 else -self._step[:, 0]))

    def moved(self, spacing: float, origin: tuple[float, float]) -> list[Moved]:
        """Return the sides along the axes that a lattice moves, the farthest first; those on a line are one.

        Parameters
        ----------
        spacing : float
        origin : (float, float)
            A point of the lattice (length).
        """
        found = set[Moved]()
        for across, axis in enumerate("xy"):
            # A side that is shorter than a spacing may lie between two lines of the lattice.
            sides = self._along(1 - across) & (np.abs(self._step[:, 1 - across]) >= spacing)
            pairs = np.unique(np.column_stack([self._from[sides, across], self._outwards(across)[sides]]), axis=0)
            for at, outwards in pairs.tolist():
                steps = (at - origin[across]) / spacing
                if not is_whole(steps):
                    to = origin[across] + spacing * (math.ceil(steps) if outwards > 0 else math.floor(steps))
                    found.add(Moved(axis, at, to, int(outwards)))
        return sorted(found, key=lambda side: (-round(side.distance / spacing, 9), side.axis, side.at))

    def width(self, side: Moved) -> float:
        """Return how far inwards of a side the next one lies that faces it, at most the contour's extent (length)."""
        across = "xy".index(side.axis)
        senses, places = self._outwards(across), self._from[:, across]
        low, high = np.sort(np.stack([self._from, self._to])[:, :, 1 - across], axis=0)
        inwards = side.outwards * (side.at - places)
        facing = self._along(1 - across) & (senses == -side.outwards) & (inwards > self._level)
        own = self._along(1 - across) & (senses == side.outwards) & (np.abs(inwards) <= self._level)
        nearest = self.extent
        for first, last in zip(low[own], high[own], strict=True):
            beside = facing & (np.minimum(high, last) - np.maximum(low, first) > self._level)
            nearest = min(nearest, float(inwards[beside].min(initial=nearest)))
        return nearest

    def fitting(self, spacing: float) -> list[float]:
        """Return the spacings next to a given one, below and above it, that divide all sides.

        Spacings that people write come first, if they are within a factor of two. There are none where a side lies
        neither along an axis nor at 45°.

        Examples
        --------
        >>> import contactqp as cq
        >>> cq.Frame.rectangle(3, 2).sides.fitting(0.3), cq.Frame.rectangle(2, 3**0.5).sides.fitting(0.3)
        ([0.25, 0.5], [])
        >>> cq.Frame.polygon([(0, 0), (5, 0), (5, 2.5), (2.5, 2.5), (2.5, 5), (0, 5)]).sides.fitting(0.3)
        [0.25, 0.3125]
        """
        distances = self._distances()
        if distances is None:
            return []
        candidates = distances.min() / np.arange(2, _PARTS)
        for distance in distances:
            ratios = distance / candidates
            candidates = candidates[np.abs(ratios - np.round(ratios)) <= _WHOLE * ratios]
        below, above = candidates[candidates <= spacing], candidates[candidates > spacing][::-1]
        return [_best(each, spacing) for each in (below, above) if each.size]

    def on_diagonals(self, spacing: float, origin: tuple[float, float]) -> bool:
        """Return whether all sides lie on lines of a lattice, or on lines at 45° through its points.

        Parameters
        ----------
        spacing : float
        origin : (float, float)
            A point of the lattice (length).
        """
        x, y = ((self._from - np.array(origin)) / spacing).T
        rising, falling = self._diagonal
        fit = np.zeros(x.shape, dtype=bool)
        for sides, places in ((self._along(0), y), (self._along(1), x), (rising, x - y), (falling, x + y)):
            fit |= sides & (np.abs(places - np.round(places)) <= _WHOLE * np.maximum(1.0, np.abs(x) + np.abs(y)))
        return bool(fit.all())

    @cached_property
    def _diagonal(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Which sides are at 45°: those along which x - y stays the same, and those along which x + y does."""
        rising, falling = (np.abs(self._step[:, 0] + sign * self._step[:, 1]) <= self._level for sign in (-1, 1))
        return rising, falling

    def _distances(self) -> NDArray[np.float64] | None:
        """Return what a spacing must divide for all sides to lie on the lattice through the corner of the box, or None.

        Those are the places of sides along the axes, and of sides at 45° where they cross an axis.
        """
        flat, upright = self._along(0), self._along(1)
        rising, falling = self._diagonal
        if not (flat | upright | rising | falling).all():
            return None
        x, y = (self._from - self.corner).T
        places = np.abs(np.concatenate([y[flat], x[upright], (x - y)[rising], (x + y)[falling], [self.extent]]))
        places = np.sort(places[places > self._level])
        return places[np.diff(places, prepend=0.0) > self._level]


def is_whole(ratio: float) -> bool:
    """Whether a ratio is a whole number, to rounding."""
    return abs(ratio - round(ratio)) <= _WHOLE * max(1.0, abs(ratio))


def _best(near: NDArray[np.float64], spacing: float) -> float:
    """Return the first of some spacings, the nearest first, that people write; else the first of all."""
    for each in near[np.maximum(near / spacing, spacing / near) <= 2].tolist():
        if is_short(each):
            return float(f"{each:.{_ROUND_DIGITS}g}")
    return float(near[0])


def is_short(value: float) -> bool:
    """Whether a few digits say a value, to rounding."""
    return abs(float(f"{value:.{_ROUND_DIGITS}g}") - value) <= 1e-12 * abs(value)
