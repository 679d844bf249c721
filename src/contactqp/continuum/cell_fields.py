r"""Cell fields: a model's load, support and other data between the points of its lattice.

On each square K a field f is told by its values at the corners, and by how far it lies from their bilinear interpolant
If,

.. math:: If - below_K ≤ f ≤ If + above_K.

What was given decides them. A number is its own interpolant; an array *is meant as* its bilinear interpolant,
continued to points of the frame where it has no value. Of a profile, and of a `contactqp.Smooth` function, second
derivatives are known to lie between bounds. On a segment of length h, f - If = -½f''(ξ)x(h - x), and on a square If =
I_x I_y f, so that f - If = (f - I_x f) + I_x(f - I_y f), where I_x neither raises nor lowers bounds. With x(h - x) ≤
h²/4:

.. math:: above_K = \frac{h²}{8}(\max(0, -\min f_xx) + \max(0, -\min f_yy)), \quad
          below_K = \frac{h²}{8}(\max(0, \max f_xx) + \max(0, \max f_yy)),

and in the mean over a square, or over a quarter of it, where x(h - x)/2 has the mean h²/12, f - If is at most -h²/12
(min f_xx + min f_yy). The second derivatives may be those of distributions: f less a parabola of their upper end is
concave, which is all that is used of them, so that the minimum of smooth surfaces is enclosed with its kinks. Where the
range of f on the square tells more, it is taken; in squares with kinks, of which there are few, that on parts of it.
Any other function is known at the points alone; it is *sampled*: taken for the interpolant of its values there, of
which nothing is proven.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from ..foundation.checks import Mask, Vector
from ..foundation.intervals import Interval
from ..foundation.surfaces import Ranged
from ..geometry.numbering import Grid
from ..profiles.analytic import Profile
from .plan import Plan

_PARTS = 6
"""Into how many parts the sides of a quarter are cut where second derivatives tell nothing."""

_FEW_KINKED = 8
"""Squares are cut if there are no more of them than along a few curves."""

_GROW = 1 + 1e-14
"""What bounds are multiplied by for the few roundings of what they consist of."""


class Cells(Protocol):
    """What a region is cut into: squares, see `contactqp.continuum.plan.Plan`, or stretches of a line."""

    @property
    def spacing(self) -> float:
        """Side h (length)."""

    @property
    def nodes(self) -> Mask:
        """Which points are nodes."""

    @property
    def squares(self) -> Mask:
        """Which cells belong to the region."""

    @property
    def around_points(self) -> tuple[Interval, Interval]:
        """What holds x and y of each point."""

    @property
    def around_squares(self) -> tuple[Interval, Interval]:
        """What holds x and y in each cell."""

    def at_corner(self, points: Any, corner: int) -> Any:
        """Return what an array of points has at one of the four corners of each cell."""


@dataclass(frozen=True, eq=False)
class CellField:
    """A field on the squares of a plan: its values at their corners, and how far it lies from their interpolant.

    Attributes
    ----------
    values : array, shape (rows + 2, columns + 2)
        At the points; nan where the plan has none.
    below, above : array, shape (rows + 1, columns + 1)
        How far the field lies below and above the interpolant in each square at most, >= 0.
    mean_below, mean_above : array, shape (rows + 1, columns + 1)
        The same in the mean over a quarter of the square, of either sign.
    exact : bool
        Whether that is proven of what was given; else the field is sampled.
    range_lower, range_upper : array, shape (rows + 1, columns + 1)
        What holds the field on each square.
    bent_below, bent_above : array, shape (rows + 1, columns + 1)
        What second derivatives alone say of ``below`` and ``above``, which may be less; infinite at kinks.
    rounding : array, shape (rows + 1, columns + 1)
        The part of all of these that comes from how the values at the corners are rounded.
    """

    values: Grid
    below: Grid
    above: Grid
    mean_below: Grid
    mean_above: Grid
    exact: bool
    range_lower: Grid
    range_upper: Grid
    bent_below: Grid
    bent_above: Grid
    rounding: Grid

    def __neg__(self) -> CellField:
        return CellField(
            *(-self.values, self.above, self.below, self.mean_above, self.mean_below, self.exact),
            *(-self.range_upper, -self.range_lower, self.bent_above, self.bent_below, self.rounding),
        )

    @property
    def straight(self) -> bool:
        """Whether the field is its own interpolant."""
        return not (self.below.any() or self.above.any())

    @cached_property
    def apart(self) -> Grid:
        """How far the field lies from the interpolant in each square at most, shape (rows + 1, columns + 1)."""
        return np.maximum(self.below, self.above)


def number_field(plan: Cells, number: float) -> CellField:
    """Return the field that is a number everywhere."""
    squares: Grid = np.broadcast_to(np.float64(0.0), plan.squares.shape)
    same: Grid = np.broadcast_to(np.float64(number), plan.squares.shape)
    return CellField(np.broadcast_to(number, plan.nodes.shape), *(squares,) * 4, True, same, same, *(squares,) * 3)


def array_field(plan: Cells, values: Grid, *, exact: bool = True) -> CellField:
    """Return the field that is the bilinear interpolant of values at the points, shape (rows + 2, columns + 2)."""
    corners = [plan.at_corner(values, corner) for corner in range(4)]
    none: Grid = np.broadcast_to(np.float64(0.0), plan.squares.shape)
    lower: Grid = np.asarray(np.minimum.reduce(corners))
    upper: Grid = np.asarray(np.maximum.reduce(corners))
    # Where a corner has no support, the square has none.
    return CellField(
        *(values, none, none, none, none, exact),
        range_lower=np.where(np.isposinf(upper), upper, lower),
        range_upper=np.where(np.isneginf(lower), lower, upper),
        bent_below=none,
        bent_above=none,
        rounding=none,
    )


def continued(plan: Plan, at_nodes: Vector, given: Grid) -> Grid:
    """Return values at all points: at nodes their own, on the frame what is given there, else those of points near.

    A frame point without a value has the mean of the nodes beside it, and where there are none, as at a corner, the
    mean of the frame points beside it.

    Parameters
    ----------
    plan : Plan
    at_nodes : array, shape (n,)
    given : array, shape (rows + 2, columns + 2)
        Values on the frame, nan where none is known.
    """
    values = plan.lattice.numbering.to_grid(at_nodes, ring=1, fill=np.nan)
    values = np.where(plan.frame & ~np.isnan(given), given, values)
    for sources in (plan.nodes, plan.points):
        open_points = plan.points & np.isnan(values)
        if not open_points.any():
            break
        known = np.pad(np.where(sources & ~np.isnan(values), values, np.nan), 1, constant_values=np.nan)
        beside = np.stack([known[:-2, 1:-1], known[2:, 1:-1], known[1:-1, :-2], known[1:-1, 2:]])
        there = ~np.isnan(beside)
        count = there.sum(axis=0)
        with np.errstate(invalid="ignore"):
            mean = np.where(there, beside, 0.0).sum(axis=0) / np.maximum(count, 1)
        values = np.where(open_points & (count > 0), mean, values)
    return values


def function_field(plan: Cells, function: Any, values: Grid) -> CellField:
    """Return the field of a function of (x, y), of which the values at the points are known.

    Parameters
    ----------
    plan : Plan or other Cells
    function : callable
        With what `contactqp.foundation.surfaces.Ranged` tells, or without.
    values : array, shape (rows + 2, columns + 2)
    """
    whole = function.range(*plan.around_squares) if isinstance(function, Ranged) else None
    if whole is None:
        return array_field(plan, values, exact=False)
    shape = plan.squares.shape
    lower, upper = (np.broadcast_to(end, shape) for end in (whole.lower, whole.upper))
    corners = np.stack([plan.at_corner(values, corner) for corner in range(4)])
    off = _rounding_of(plan, function, values)
    off = np.maximum.reduce([plan.at_corner(off, corner) for corner in range(4)])
    with np.errstate(invalid="ignore"):
        below, above = corners.max(axis=0) - lower, upper - corners.min(axis=0)
    bends = function.curvature(*plan.around_squares)
    mean_below, mean_above = below, above
    bent_below = bent_above = np.full(shape, np.inf)
    if bends is not None:
        eighth, twelfth = (plan.spacing**2 / part * _GROW for part in (8, 12))
        highest = [np.broadcast_to(part.upper, shape) for part in (bends.xx, bends.yy)]
        lowest = [np.broadcast_to(part.lower, shape) for part in (bends.xx, bends.yy)]
        bent_below = eighth * (np.maximum(highest[0], 0.0) + np.maximum(highest[1], 0.0))
        bent_above = eighth * (np.maximum(-lowest[0], 0.0) + np.maximum(-lowest[1], 0.0))
        below, above = np.minimum(below, bent_below), np.minimum(above, bent_above)
        with np.errstate(invalid="ignore"):
            room = 1e-14 * (np.abs(highest[0]) + np.abs(highest[1]) + np.abs(lowest[0]) + np.abs(lowest[1]))
            means = twelfth * (highest[0] + highest[1] + room), twelfth * (room - lowest[0] - lowest[1])
        mean_below, mean_above = (
            np.where(np.isfinite(mean), np.minimum(mean, bound), bound)
            for mean, bound in zip(means, (below, above), strict=True)
        )
    kinked = plan.squares & ~(np.isfinite(bent_below) & np.isfinite(bent_above)) & np.isfinite(below + above)
    if 0 < np.count_nonzero(kinked) <= _FEW_KINKED * sum(shape):
        finer = _parts_of_squares(plan, function, [corner[kinked] for corner in corners], kinked)
        for part, found in zip((below, above, mean_below, mean_above), finer, strict=True):
            part[kinked] = np.minimum(part[kinked], found)
    below, above, mean_below, mean_above, bent_below, bent_above = (
        np.where(plan.squares, _unknown_as_infinite(_grown(part) + off), 0.0)
        for part in (below, above, mean_below, mean_above, bent_below, bent_above)
    )
    most = np.maximum(below, 0.0), np.maximum(above, 0.0)
    return CellField(values, *most, mean_below, mean_above, True, lower, upper, bent_below, bent_above, off)


def _parts_of_squares(plan: Cells, function: Ranged, corners: list[Grid], where: Mask) -> list[Grid]:
    """Return how far a function lies below and above its interpolant at most, and in the mean over quarters.

    The squares are cut into parts, on which a bilinear function lies between its values at their corners.
    """
    count = corners[0].size
    sides = [
        (np.broadcast_to(side.lower, where.shape)[where], np.broadcast_to(side.upper, where.shape)[where])
        for side in plan.around_squares
    ]
    cuts = np.linspace(0.0, 1.0, 2 * _PARTS + 1)
    inner = np.stack(
        [
            (1 - t) * ((1 - s) * corners[0] + s * corners[1]) + t * ((1 - s) * corners[3] + s * corners[2])
            for t in cuts
            for s in cuts
        ]
    ).reshape(cuts.size, cuts.size, count)
    quads = np.stack([inner[:-1, :-1], inner[1:, :-1], inner[:-1, 1:], inner[1:, 1:]])
    least, most = quads.min(axis=0), quads.max(axis=0)
    room = 1e-14 * np.abs(np.stack(corners)).max(axis=0)
    # Where a part begins and ends is rounded, as are the places of the corners, by as much as the largest of them is.
    ends = [
        Interval.around(
            low + (high - low) * cuts[:, None],
            32 * np.spacing(max(float(np.abs(side.lower).max()), float(np.abs(side.upper).max()))),
        )
        for (low, high), side in zip(sides, plan.around_squares, strict=True)
    ]
    x, y = (Interval(end.lower[:-1], end.upper[1:]) for end in ends)
    held = function.range(
        Interval(np.broadcast_to(x.lower, most.shape), np.broadcast_to(x.upper, most.shape)),
        Interval(
            np.broadcast_to(y.lower[:, None], most.shape),
            np.broadcast_to(y.upper[:, None], most.shape),
        ),
    )
    if held is None:
        return [np.full(count, np.inf)] * 4
    found = [most - held.lower + room, held.upper - least + room]
    means = [part.reshape(2, _PARTS, 2, _PARTS, count).mean(axis=(1, 3)).max(axis=(0, 1)) for part in found]
    return [part.max(axis=(0, 1)) for part in found] + means


def _grown(part: Grid) -> Grid:
    return np.where(part > 0, part * _GROW, part / _GROW)


def _unknown_as_infinite(part: Grid) -> Grid:
    return np.where(np.isnan(part), np.inf, part)


def _rounding_of(plan: Cells, function: Any, values: Grid) -> Grid:
    """Return how far values at the points may lie from the function there; a declared function is what it returns."""
    if not isinstance(function, Profile):
        return np.zeros(values.shape)
    held: Interval = function.range(*plan.around_points)  # type: ignore[assignment]
    with np.errstate(invalid="ignore"):
        off = np.maximum(values - held.lower, held.upper - values)
    return np.where(np.isfinite(values), np.maximum(off, 0.0) * _GROW, 0.0)
