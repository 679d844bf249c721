r"""A function about a corner on a lattice: the spline that follows it, and how far from that it may be.

Let b be harmonic in the region, Qb the spline whose coefficients are the values of b at the points, and e = b - Qb.

*In squares.* With Ie for the bilinear interpolant of e's values at the corners of a square, \|e - Ie\| ≤ ⅛h²(max
\|e_xx\| + max \|e_yy\|). There h²(Qb)_xx is a convex combination of second differences of the coefficients, and b_xx
that in the middle of the square, but for h/√2 times a bound of b's third derivatives. Next to the corner, and where θ
jumps beyond the contour, nothing is known of e: such squares are *hidden*.

*Along the contour.* On a piece of length l, b differs from the parabola through its values at both ends and halfway by
no more than l³/(72√3) times its third derivatives, and by less than four times its largest modulus, as the parabola is
no larger than 5/4 of that: this tells more where another side meets the corner. Along the two sides of the corner the
function is a power of the distance times what its sine leaves, which is nothing but rounding, or, with a logarithm,
ρ²ω cos 2ω, which the parabola is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..foundation.rounding import UNIT_ROUNDOFF, gamma
from ..geometry.numbering import Grid
from .contour import Contour
from .corner_functions import CornerFunction
from .splines import at_points

_ERROR = gamma(64)

_BESIDE_PARABOLA = 1.0 / (72.0 * math.sqrt(3.0)) * (1 + 8 * UNIT_ROUNDOFF)

_NEAR_CORNER, _NEAR_JUMP = 1.0, 2.25
"""Squares whose middles are nearer, in spacings, to a corner, or to the ray on which its angle jumps, are hidden.

Of the sixteen coefficients on a square none is farther from its middle than 2.13.
"""

Ends = list[tuple[Vector, Vector]]


@dataclass(frozen=True, eq=False)
class CornerOnLattice:
    """A function about a corner of a contour, on the squares and along the pieces that the lattice cuts it into.

    Attributes
    ----------
    contour : Contour
    function : CornerFunction
    """

    contour: Contour
    function: CornerFunction

    @cached_property
    def _lines(self) -> tuple[Vector, Vector]:
        """X and y of the lines of the points, and of one beyond on either side (length)."""
        rows, columns = self.contour.inside.shape
        x, y = self.contour.first
        return (
            x + self.contour.spacing * np.arange(-1, columns + 2),
            y + self.contour.spacing * np.arange(-1, rows + 2),
        )

    @property
    def _middles(self) -> tuple[Vector, Vector]:
        """X and y of the middles of the squares (length)."""
        x, y = (line[1:-2] + self.contour.spacing / 2 for line in self._lines)
        return x, y

    @property
    def _off(self) -> float:
        """How far places may be off by rounding (length)."""
        return 16 * float(np.spacing(max(np.abs(line).max() for line in self._lines)))

    @cached_property
    def spline(self) -> Grid:
        """Coefficients of Qb, shape (rows + 4, columns + 4): b at the points and about them."""
        x, y = self._lines
        return self.function(x[None, :], y[:, None])

    @cached_property
    def points_error(self) -> Grid:
        """How far b may be off at the points by rounding, shape (rows + 2, columns + 2)."""
        distance = self._from_corner(*(line[1:-1] for line in self._lines))
        return self.function.rounding(distance, distance, self._off) + _ERROR * np.abs(self.spline[1:-1, 1:-1])

    def _from_corner(self, x: Vector, y: Vector) -> Grid:
        return np.hypot(x[None, :] - self.function.corner[0], y[:, None] - self.function.corner[1])

    @cached_property
    def _distances(self) -> tuple[Grid, Grid]:
        """The least and the largest distance of each square from the corner, or less and more (length)."""
        middle = self._from_corner(*self._middles)
        half = self.contour.spacing / math.sqrt(2) * (1 + 1e-12) + self._off
        return np.maximum(middle - half, 0.0), middle + half

    @cached_property
    def hidden(self) -> Mask:
        """The squares in which Qb does not follow b: about the corner, and where θ jumps."""
        x, y = self._middles
        way, spacing = self.function.direction + self.function.jump, self.contour.spacing
        across, up = x[None, :] - self.function.corner[0], y[:, None] - self.function.corner[1]
        along = across * math.cos(way) + up * math.sin(way)
        to_ray = np.abs(up * math.cos(way) - across * math.sin(way))
        from_corner = np.hypot(across, up)
        to_ray = np.where(along > 0, to_ray, from_corner)
        return np.asarray((from_corner < _NEAR_CORNER * spacing) | (to_ray < _NEAR_JUMP * spacing))

    @cached_property
    def beside(self) -> Grid:
        """How far b may lie from Qb in each square; in hidden ones, how large b may be."""
        spacing, function = self.contour.spacing, self.function
        x, y = self._middles
        near, far = self._distances
        bend = spacing**2 * function.bend(x[None, :], y[:, None])
        across, up = (np.diff(self.spline, n=2, axis=axis) for axis in (1, 0))
        apart = _farthest(across, bend, (4, 2)) + _farthest(up, -bend, (2, 4))
        third = spacing**3 / math.sqrt(2) * function.size(3, near, far)
        on_points, error = at_points(self.spline)
        off = np.abs(self.spline[1:-1, 1:-1] - on_points) + self.points_error
        sizes = _window(np.abs(self.spline), (4, 4), np.maximum) + spacing**2 * function.size(2, near, far)
        known = _window(off, (2, 2), np.maximum) + error + (apart + 2 * third) / 8 + _ERROR * sizes
        return np.where(self.hidden, function.size(0, far, far), known)

    @cached_property
    def along(self) -> tuple[NDArray[np.float64], Vector]:
        """Bernstein coefficients of parabolas on the pieces of the contour, shape (3, k), and how far b is off."""
        contour, function = self.contour, self.function
        reach = self._off + contour.reach * contour.spacing
        near, far = self._distances_of_pieces(reach)
        values = np.stack([function(*end) for end in self._ends])
        with np.errstate(over="ignore"):
            third = _BESIDE_PARABOLA * contour.length**3 * function.size(3, near, far)
        off = np.minimum(third, 4 * function.size(0, far, far))
        for side, (left, kept) in zip(function.sides, ((0.0, 0.0), function.along_other_side), strict=True):
            on_side = contour.segment == side
            rho = np.stack([np.hypot(x - function.corner[0], y - function.corner[1])[on_side] for x, y in self._ends])
            values[:, on_side] = kept * np.square(rho / function.scale)
            off[on_side] = (4 * left + _ERROR) * function.size(0, near, far)[on_side]
        first, halfway, last = values
        off = off + 4 * function.rounding(near, far, reach) + _ERROR * np.abs(values).max(axis=0)
        return np.stack([first, 2 * halfway - (first + last) / 2, last]), off

    @cached_property
    def halfway(self) -> Vector:
        """The function in the middles of the pieces of the contour."""
        return self.function(*self._ends[1])

    @cached_property
    def _ends(self) -> Ends:
        contour = self.contour
        return [contour.places(place) for place in (contour.start, (contour.start + contour.end) / 2, contour.end)]

    def _distances_of_pieces(self, off: float) -> tuple[Vector, Vector]:
        """Return the least and the largest distance of each piece from the corner, or less and more (length)."""
        (x, y), _, (far_x, far_y) = self._ends
        step = np.stack([far_x - x, far_y - y])
        back = np.stack([self.function.corner[0] - x, self.function.corner[1] - y])
        part = np.clip((back * step).sum(axis=0) / np.maximum((step**2).sum(axis=0), 1e-300), 0.0, 1.0)
        near = np.hypot(*(back - part * step))
        far = np.maximum(np.hypot(*back), np.hypot(*(back - step)))
        return np.maximum(near * (1 - 1e-12) - 4 * off, 0.0), far * (1 + 1e-12) + 4 * off


def _window(values: Grid, shape: tuple[int, int], extreme: np.ufunc) -> Grid:
    """Return the extreme over each window of a shape."""
    rows, columns = values.shape[0] - shape[0] + 1, values.shape[1] - shape[1] + 1
    down = extreme.reduce([values[i : i + rows] for i in range(shape[0])])
    return np.asarray(extreme.reduce([down[:, j : j + columns] for j in range(shape[1])]))


def _farthest(values: Grid, wanted: Grid, shape: tuple[int, int]) -> Grid:
    """Return how far numbers in each window are from a wanted one at most."""
    most, least = (_window(values, shape, extreme) for extreme in (np.maximum, np.minimum))
    return np.maximum(np.abs(most - wanted), np.abs(least - wanted))
