r"""Majorants on halves of squares: what `majorant` and `energy` sum up, where the frame halves squares.

The half of a square is the triangle ABC with the legs h of `contactqp.continuum.half_squares`; v is linear there, so
that with the differences d_x = v_B - v_A and d_y = v_C - v_A

.. math:: \int ½(T_x v_x² + T_y v_y²) = ½ \sum_P |P| (T_x d_x² + T_y d_y²)/h²

over its parts P, the quarter of A with the area h²/4 and two triangles with h²/8, with the mean tensions there. The
quarter is summed up with those of other nodes; here are the triangles. Products of linear functions are integrated by
the mass matrix of the triangle, h²/24 (1 + δ_ij), and are off from their linear interpolant by

.. math:: kv - I(kv) = -\sum_{i<j} λ_i λ_j (k_i - k_j)(v_i - v_j), \quad \sum_{i<j} λ_i λ_j ≤ 1/3.

**Misfit.** In A's quarter as in any other one. In the triangle of B, with its right angle in the middle of AB and legs
a = h/2, T v_x and T v_y are constant for an even T, and both components of y change at the rate f_B/2, see `fluxes`:
from the leg, by f_B a/6 in the mean, and by f_B² a²/72 in the mean square about that, because coordinates along the
legs have the mean a/3 and the variance a²/18.

**What λ leaves.** div y = -f_B there, so that ν = f - f_B with f = p - kv. It vanishes at B, and for linear f has, with
the values m in the middle of AB and z in that of BC, the mean square (m² + mz + z²)/6.

**What that costs.** u = w* - v vanishes on the hypotenuse, and each line along x or y through the triangle meets that
within h/2: ∫u² ≤ (h/π)² ∫|∇u|² over it. A quarter of a whole square beside it that has no edge on the frame is met by
lines along one direction that go on through the triangle, to the hypotenuse, within h: over both ∫u² ≤ (2h/π)² ∫|∇u|².
So the squares of norms of ν count four times in such a quarter, and in all triangles, which may belong to one.

**Above a surface.** On a ray from A to a point P of the diagonal v goes straight from v_A to the frame's height,
whether that is bent or not. If a surface f leaves room for the frame, f(P) ≥ g(P), and f falls below the chord from A
to P by r(1 - r)M/2 at most, at the part r of the way, with M the most of its second derivative along AP, times the
square of AP: for P at the part q of the way from B to C M = h² ((1 - q)² f_xx + 2q(1 - q) f_xy + q² f_yy), with x and y
counted from A, and the weights add up to one. So v_A ≤ f_A - h²/2 max(0, f_xx, f_xy, f_yy) is enough for v ≤ f on the
half.

**Frame.** Where it leaves the chord BC by e, with -γ ≤ e″ ≤ γ along it, v has E = r e added on rays from A, r from 0 at
A to 1 on the diagonal. With the length l = √2 h of the diagonal, on which s is counted from the middle, and the
distance d = l/2 of A from it, E changes along the diagonal by e′ and across by (e - s e′)/d, and the area is r d dr ds.
So, integrating by parts, for e vanishes at both ends,

.. math:: \int |∇E|² = \frac{d}{2} \int e'² + \frac{(e - s e')²}{d²} = \frac{d}{2} \int e'² (1 + s²/d²) + 2e²/d²
          ≤ d \int e'² + \frac1d \int e² ≤ γ² \Big(\frac{d l³}{12} + \frac{l⁵}{120 d}\Big) = \frac{7}{30} γ² h⁴,

because \|e| ≤ γ(l²/4 - s²)/2, whose square has the integral γ²l⁵/120, and ∫e′² = -∫e e″ ≤ γ²l³/12. In the same way ∫E²
= (d/4) ∫e² ≤ γ²h⁶/120, ∫\|E| ≤ γh⁴/18 and \|E| ≤ γh²/4.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.numbering import Grid
from .cell_fields import CellField
from .data import Data
from .fluxes import Flux
from .frame_room import room_along_diagonals
from .half_squares import CORNERS, HalfSquares
from .plan import Plan
from .rounded import FEW, GROW

BENT, BENT_SQUARED, BENT_MEAN = 7 / 30 * GROW, GROW / 120, GROW / 18
"""∫|∇E|² over γ²h⁴, ∫E² over γ²h⁶, and ∫|E| over γh⁴."""

_Part = NDArray[np.float64]


class Triangle(NamedTuple):
    """The part that belongs to B, or to C, of halves whose nodes are at the same corner.

    Attributes
    ----------
    halves : HalfSquares
    corner : int
        Which corner of the squares B or C is.
    axis : int
        Along which its leg on AB or AC lies: 1 along x, 0 along y.
    """

    halves: HalfSquares
    corner: int
    axis: int

    @property
    def steps(self) -> tuple[int, int]:
        """Which corner its own leg, and the other one of the half, leads to from A, numbered as `HalfSquares.of`."""
        return (1, 2) if self.axis == 1 else (2, 1)

    def at(self, values: float | Grid) -> _Part:
        """Return what their squares have, or a number."""
        own: _Part = np.asarray(values, dtype=np.float64)
        return own[self.halves.place] if own.ndim else np.broadcast_to(own, self.halves.row.shape)

    def flux(self, flux: Flux, axis: int) -> _Part:
        """Return y along x (axis 1) or y (axis 0) on the leg that it does not flow along, times h.

        Out of A's quarter it is that through the line between the two points, on A's side.
        """
        if axis == self.axis:
            return flux.through[1 - axis][CORNERS[self.halves.corner][1 - axis]][self.halves.place]
        return flux.at_corners[self.corner][1 - axis][self.halves.place]


def triangles(plan: Plan) -> Iterator[Triangle]:
    """Yield the triangles of all halves, in up to eight groups."""
    for halves in plan.halves:
        _, at_b, at_c = halves.corners
        yield Triangle(halves, at_b, 1)
        yield Triangle(halves, at_c, 0)


def stretch_of_triangles(data: Data, points: Grid) -> tuple[Grid, Grid]:
    """Return what the tension stores in the triangles of each square, and how far that is off without rounding."""
    stored, error = np.zeros(data.plan.squares.shape), np.zeros(data.plan.squares.shape)
    for triangle in triangles(data.plan):
        at_a, at_b, at_c = triangle.halves.of(points)
        for axis, step in ((1, at_b - at_a), (0, at_c - at_a)):
            tension = data.tensions(axis, triangle.corner)
            stored[triangle.halves.place] += triangle.at(tension.middle) / 16 * step**2
            error[triangle.halves.place] += triangle.at(tension.mean_apart) / 16 * step**2
    return stored, error


def misfit_of_triangles(data: Data, points: Grid, flux: Flux) -> tuple[Grid, Grid]:
    """Return squares of norms of T∇v - y on the triangles of each square: for a mean tension, and how it varies."""
    misfit, swing = np.zeros(data.plan.squares.shape), np.zeros(data.plan.squares.shape)
    square = data.plan.spacing**2
    for triangle in triangles(data.plan):
        halves, three = triangle.halves, triangle.halves.of(points)
        force = halves.of(flux.force)[triangle.steps[0]]
        for axis, which, outwards in ((1, 1, halves.outwards[0]), (0, 2, halves.outwards[1])):
            tension = data.tensions(axis, triangle.corner)
            step, leg = outwards * (three[which] - three[0]), triangle.flux(flux, axis)
            stretch, mean = triangle.at(tension.middle) * step, leg - outwards * force * (square / 12)
            sizes = triangle.at(tension.middle) * (np.abs(three[which]) + np.abs(three[0]))
            sizes += np.abs(leg) + np.abs(force) * square
            least = triangle.at(tension.least)
            found = (np.abs(stretch - mean) + FEW * sizes) ** 2 + (force * square) ** 2 / 288 * GROW
            misfit[halves.place] += found / (8 * least)
            swing[halves.place] += triangle.at(tension.spread) ** 2 / (8 * least) * step**2
    return misfit, swing


def unevenness_of_triangles(plan: Plan, force: Grid, apart: Grid) -> float:
    """Return ∫ν² over the triangles, bounded: of the difference of p - kv from its values at the frame."""
    found = 0.0
    for triangle in triangles(plan):
        three = triangle.halves.of(force)
        own, other = (three[which] for which in triangle.steps)
        middle, end = (three[0] - own) / 2, (other - own) / 2
        square = (middle**2 + middle * end + end**2) / 6
        rounding = FEW * sum(np.abs(each) for each in three)
        uneven = (np.sqrt(np.maximum(square, 0.0)) + triangle.at(apart) + rounding) ** 2
        found += float(uneven.sum()) * plan.spacing**2 / 8
    return found * GROW


def fall_on_halves(data: Data, surface: CellField, sign: float, found: Grid) -> None:
    """Lay down how far below a surface the nodes of halves are to be so that v stays above it, infinity if not known.

    It is enough where the surface leaves room for the frame all along the diagonal.
    """
    if not data.plan.halves:
        return
    bends, room = data.bends_of(surface, sign), room_along_diagonals(data, surface, sign)
    for halves in data.plan.halves:
        if bends is None:
            found[halves.place] = np.inf
            continue
        x, y = halves.outwards
        across = bends.xy.upper if x * y > 0 else -bends.xy.lower
        most = np.maximum.reduce([each[halves.place] for each in (bends.xx.upper, bends.yy.upper, across)])
        fall = data.plan.spacing**2 / 2 * np.maximum(most, 0.0) + 4 * surface.rounding[halves.place]
        found[halves.place] = np.where(np.isnan(fall) | ~room[halves.place], np.inf, fall * GROW)


def product_on_halves(plan: Plan, one: Grid, two: Grid, found: Grid) -> None:
    """Lay down the integrals over halves of products of functions that are linear there, over h²."""
    for halves in plan.halves:
        own, other = halves.of(one), halves.of(two)
        found[halves.place] = (sum(own) * sum(other) + sum(a * b for a, b in zip(own, other, strict=True))) / 24


def mean_on_halves(plan: Plan, points: Grid, found: Grid) -> None:
    """Lay down the integrals over halves of functions that are linear there, over h²."""
    for halves in plan.halves:
        found[halves.place] = sum(halves.of(points)) / 6


def apart_on_halves(plan: Plan, stiffness: Grid, points: Grid, found: Grid) -> None:
    """Lay down how far products of functions that are linear on halves lie from their linear interpolants at most."""
    for halves in plan.halves:
        steps = [np.abs(at - np.roll(at, 1, axis=0)) for at in map(np.stack, (halves.of(stiffness), halves.of(points)))]
        found[halves.place] = (steps[0] * steps[1]).max(axis=0) / 3
