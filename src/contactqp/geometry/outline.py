"""Outline: the contour of a frame as closed lines, from which the frame itself is nowhere farther than it says."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask
from ..foundation.loading import load_modules

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

_STRAIGHT = 1e-12
"""A corner that points inwards by less than this angle is one of a straight side, to rounding."""

CHORD = 0.25
"""Longest chord of a circle, in spacings of the lattice that is fitted to it."""


@dataclass(frozen=True, eq=False)
class Outline:
    """Closed lines for the contour of a frame.

    Attributes
    ----------
    rings : tuple of arrays, shape (k, 2)
        Corners x, y of each (length), the region to the left; the last is joined to the first.
    sagitta : float
        How far the contour lies from them at most (length): zero for polygons, and for a circle what its arcs rise
        above their chords, which it lies outside of.

    Examples
    --------
    >>> import contactqp as cq
    >>> outline = cq.Frame.rectangle(2, 1).outline(spacing=0.5)
    >>> outline.rings[0].tolist(), outline.sagitta, outline.convex
    ([[1.0, -0.5], [1.0, 0.5], [-1.0, 0.5], [-1.0, -0.5]], 0.0, True)
    """

    rings: tuple[NDArray[np.float64], ...]
    sagitta: float = 0.0

    @classmethod
    def of(cls, geometry: BaseGeometry, sagitta: float = 0.0) -> Outline:
        """Return the outline of a shapely Polygon or MultiPolygon."""
        load_modules("shapely")
        import shapely

        parts = shapely.orient_polygons(shapely.get_parts(geometry))
        rings = [shapely.get_coordinates(ring)[:-1] for part in parts for ring in (part.exterior, *part.interiors)]
        return cls(tuple(rings), sagitta)

    def combined(self, other: Outline, combine: Callable[[Any, Any], Any]) -> Outline:
        """Return the outline of what two regions make up together.

        Where their contours are apart, each line of it is one of theirs, and stands for the same arcs. Where they meet,
        it is taken as it is.

        Parameters
        ----------
        other : Outline
        combine : callable
            Returns the shapely geometry of two.
        """
        apart = self.geometry.boundary.distance(other.geometry.boundary) > 4 * (self.sagitta + other.sagitta)
        geometry = combine(self.geometry, other.geometry)
        return Outline.of(geometry, max(self.sagitta, other.sagitta) if apart else 0.0)

    @property
    def segments(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Where each straight piece begins and ends, arrays of shape (k, 2), length."""
        ends = [np.roll(ring, -1, axis=0) for ring in self.rings]
        return np.concatenate(self.rings), np.concatenate(ends)

    @cached_property
    def geometry(self) -> BaseGeometry:
        """The region within the lines, a shapely geometry."""
        load_modules("shapely")
        import shapely

        rings = shapely.polygons([shapely.linearrings(ring) for ring in self.rings])
        # The region is inside an odd number of rings: holes lie in parts, and no two rings cross.
        joined: BaseGeometry = rings[0]
        for ring in rings[1:]:
            joined = shapely.symmetric_difference(joined, ring)
        shapely.prepare(joined)
        return joined

    def holds(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> Mask:
        """Return which points, none of them next to the contour, lie in the region."""
        load_modules("shapely")
        import shapely

        return np.asarray(shapely.contains_xy(self.geometry, x, y))

    def nearly_holds(self, x: NDArray[np.float64], y: NDArray[np.float64], distance: float) -> Mask:
        """Return which points lie in the region, or no farther from it than a distance (length)."""
        load_modules("shapely")
        import shapely

        return np.asarray(shapely.dwithin(self.geometry, shapely.points(x, y), distance + self.sagitta))

    @cached_property
    def convex(self) -> bool:
        """Whether the region is convex, to rounding: in one part, no corner of which points inwards."""
        return len(self.rings) == 1 and not self.inward_corners

    @cached_property
    def inward_corners(self) -> list[tuple[float, float]]:
        """Places x, y of the corners that point inwards by more than rounding (length)."""
        found = []
        for ring in self.rings:
            step, before = np.roll(ring, -1, axis=0) - ring, ring - np.roll(ring, 1, axis=0)
            turned = before[:, 0] * step[:, 1] - before[:, 1] * step[:, 0]
            inwards = turned < -_STRAIGHT * np.hypot(*step.T) * np.hypot(*before.T)
            found += [(float(x), float(y)) for x, y in ring[inwards]]
        return found


def circle(radius: float, center: tuple[float, float], spacing: float) -> Outline:
    """Return the outline of a circle by chords that are no longer than a part of a spacing.

    Examples
    --------
    >>> outline = circle(1.0, (0.0, 0.0), spacing=0.1)
    >>> len(outline.rings[0]), bool(outline.sagitta < 1e-4)
    (256, True)
    """
    count = 4 * max(64, math.ceil(math.pi * radius / (2 * CHORD * spacing)))
    angles = np.arange(count) * (2 * math.pi / count)
    ring = np.array(center) + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    # Half an angle is a quarter of it twice: 1 - cos is 2 sin², without cancellation. Corners are rounded by little.
    rise = 2 * radius * math.sin(math.pi / (2 * count)) ** 2
    room = 8 * float(np.spacing(np.abs(ring).max()))
    return Outline((ring,), rise * (1 + 1e-12) + room)
