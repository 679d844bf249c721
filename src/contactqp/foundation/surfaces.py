"""What is known of a function of (x, y) between the points at which it is asked: ranges, and second derivatives."""

from __future__ import annotations

from typing import NamedTuple, Protocol, runtime_checkable

from .intervals import Interval


class Curvature(NamedTuple):
    """What holds the second derivatives of a function on rectangles.

    Where the function has a kink they are those of distributions: an upper end is infinite where it bends upwards in a
    kink, a lower one where it bends downwards. So the function less a parabola of the upper end is concave along x, and
    along y, in either case.

    Attributes
    ----------
    xx, xy, yy : Interval
        One over length, of heights.
    """

    xx: Interval
    xy: Interval
    yy: Interval

    def hull(self, other: Curvature) -> Curvature:
        """Return what holds either of two."""
        return Curvature(*(one.hull(two) for one, two in zip(self, other, strict=True)))


@runtime_checkable
class Ranged(Protocol):
    """A function of (x, y) that tells what it does on whole rectangles."""

    def range(self, x: Interval, y: Interval) -> Interval | None:
        """Return what holds its values where x and y lie in intervals; None if it is not known."""

    def curvature(self, x: Interval, y: Interval) -> Curvature | None:
        """Return what holds its second derivatives there; None if they are not known."""
