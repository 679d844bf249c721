r"""Harmonic functions about the corners of a polygon: what a membrane has there that no spline can follow.

With z = ρe^{iθ}, θ counted from one of the sides at a corner of the angle ω, and β = kπ/ω for k = 1, 2, ..., the
functions ℑz^β = ρ^β sin βθ vanish along both sides. A membrane whose frame is straight there consists, near the corner,
of such functions and of smooth ones (Grisvard, *Elliptic Problems in Nonsmooth Domains*, 1985, ch. 5): with β < 2 its
second derivatives have no bound. Where kπ/ω = 2, as at right angles, a load brings in ℑz² log z, for no polynomial
takes it and vanishes along both sides.

All of them are harmonic, whatever β is as a double, away from the corner and from a ray from it on which θ jumps, which
must not meet the region. They are imaginary parts of functions f of z, all of whose derivatives are known:

.. math:: f = z^β: \; |f^{(m)}| = |β(β - 1) \cdots (β - m + 1)| ρ^{β - m}, \qquad
          f = z² \log z: \; |f″| ≤ 2|\log ρ| + 2|θ| + 3, \; |f‴| = 2/ρ,

and no derivative of ℑf of order m in any direction is larger than |f^{(m)}|.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..foundation.loading import load_modules
from ..foundation.rounding import UNIT_ROUNDOFF
from ..geometry.outline import Outline

Places = NDArray[np.float64]

_LARGEST_EXPONENT = 2.9
"""Functions with larger ones have third derivatives that splines follow well."""

_WHOLE = 1e-9
"""Exponents that are so near to a whole number count as one: then the function is a polynomial."""

_RESONANT = 1e-6
"""So near to two a power is of no use: the load takes it up by a logarithm."""

_SHARPEST, _FLATTEST = math.radians(50), math.radians(4)
"""Corners that are sharper, or turn by less, are left to splines."""

_SHORTEST = 4.0
"""A side that is shorter, in spacings, is no straight side about a corner."""

_MOST_CORNERS = 100

_TRIES = 9

_ROUNDINGS = 64 * UNIT_ROUNDOFF


@dataclass(frozen=True)
class CornerFunction:
    """A harmonic function about a corner.

    Attributes
    ----------
    corner : (float, float)
        x and y (length).
    direction : float
        Angle of the side from which θ is counted counterclockwise, to the x axis.
    angle : float
        ω: θ of the other side.
    jump : float
        θ of the ray on which θ jumps, between ω and 2π.
    exponent : float
        β.
    logarithmic : bool
        Whether it is ℑz² log z; then β = 2.
    scale : float
        Length that ρ is one at.
    sides : (int, int)
        Numbers of the sides that meet there, see `contactqp.geometry.outline.Outline.segments`: θ = 0, and θ = ω.
    """

    corner: tuple[float, float]
    direction: float
    angle: float
    jump: float
    exponent: float
    logarithmic: bool
    scale: float
    sides: tuple[int, int]

    def _polar(self, x: Places, y: Places) -> tuple[Places, Places]:
        """Return ρ and θ."""
        across, up = (x - self.corner[0]) / self.scale, (y - self.corner[1]) / self.scale
        turned = np.arctan2(up, across) - self.direction
        low = self.jump - 2 * math.pi
        return np.hypot(across, up), low + np.mod(turned - low, 2 * math.pi)

    def __call__(self, x: Places, y: Places) -> Places:
        """Return the function's values."""
        rho, theta = self._polar(x, y)
        if not self.logarithmic:
            return np.asarray(np.maximum(rho, 1e-100) ** self.exponent * np.sin(self.exponent * theta))
        logarithm = np.log(np.maximum(rho, 1e-300))
        return np.asarray(rho**2 * (logarithm * np.sin(2 * theta) + theta * np.cos(2 * theta)))

    def bend(self, x: Places, y: Places) -> Places:
        """Return its second derivative along x, the opposite of that along y (one over length squared)."""
        rho, theta = self._polar(x, y)
        rho = np.maximum(rho, 1e-300)
        beta, turned = self.exponent, -2 * self.direction
        if self.logarithmic:
            # f″ = 2 log z + 3, turned back into x and y.
            found = 2 * theta * math.cos(turned) + (2 * np.log(rho) + 3) * math.sin(turned)
        else:
            found = beta * (beta - 1) * rho ** (beta - 2) * np.sin((beta - 2) * theta + turned)
        return np.asarray(found / self.scale**2)

    def size(self, order: int, near: Places, far: Places) -> Places:
        """Return a bound of all derivatives of an order, 0 to 3, between two distances from the corner (length)."""
        near, far = (np.maximum(distance / self.scale, 1e-300) for distance in (near, far))
        with np.errstate(over="ignore", divide="ignore"):
            if self.logarithmic:
                turn = 2 * math.pi
                logarithm = np.maximum(np.abs(np.log(near)), np.abs(np.log(far)))
                found = (
                    far**2 * (logarithm + turn),
                    far * (2 * (logarithm + turn) + 1),
                    2 * (logarithm + turn) + 3,
                    2 / near,
                )[order]
            else:
                power = self.exponent - order
                factor = math.prod(abs(self.exponent - m) for m in range(order))
                found = factor * (near if power < 0 else far) ** power
            return np.asarray(found / self.scale**order * (1 + _ROUNDINGS))

    def rounding(self, near: Places, far: Places, off: float) -> Places:
        """Return how far values may be off, at places that are off by a length, between two distances (length)."""
        logarithm = sum(np.abs(np.log(np.maximum(distance / self.scale, 1e-300))) for distance in (near, far))
        turns = 1 + (1 + self.exponent) * (2 * math.pi + logarithm)
        moved = self.size(1, np.maximum(near, 4 * off) / 2, far + off) * off
        # Next to the corner a function changes by no more than it is.
        beside = 2 * self.size(0, np.zeros_like(near), np.full_like(near, 8 * off))
        moved = moved + np.where(near > 4 * off, 0.0, beside)
        return np.asarray(_ROUNDINGS * turns * self.size(0, near, far) + moved)

    @property
    def along_other_side(self) -> tuple[float, float]:
        """Along θ = ω, what is left of the part that should vanish, times ρ^β or ρ² log ρ; and the factor of ρ²."""
        if self.logarithmic:
            return abs(math.sin(2 * self.angle)) + _ROUNDINGS, self.angle * math.cos(2 * self.angle)
        return abs(math.sin(self.exponent * self.angle)) + _ROUNDINGS, 0.0


def corner_functions(outline: Outline, spacing: float) -> list[CornerFunction]:
    """Return the functions that a membrane within an outline of straight sides consists of at its corners.

    Parameters
    ----------
    outline : Outline
    spacing : float
        That of the lattice (length).
    """
    if outline.sagitta:
        return []
    found: list[CornerFunction] = []
    first, last = outline.segments
    step = last - first
    before = np.concatenate([np.roll(np.arange(len(ring)), 1) + start for ring, start in _rings(outline)])
    lengths = np.hypot(*step.T)
    back = -step[before]
    turned = np.mod(np.arctan2(back[:, 1], back[:, 0]) - np.arctan2(step[:, 1], step[:, 0]), 2 * math.pi)
    chosen = (np.minimum(lengths, lengths[before]) >= _SHORTEST * spacing) & (turned > _SHARPEST)
    chosen &= np.abs(turned - math.pi) > _FLATTEST
    for number in np.flatnonzero(chosen)[:_MOST_CORNERS].tolist():
        corner, direction = first[number], math.atan2(step[number, 1], step[number, 0])
        angle = float(turned[number])
        jump = _jump(outline, corner, direction, angle)
        if jump is None:
            continue
        scale = float(min(lengths[number], lengths[before[number]]))
        for exponent, logarithmic in _exponents(angle):
            found.append(
                CornerFunction(
                    *((float(corner[0]), float(corner[1])), direction, angle, jump, exponent, logarithmic, scale),
                    sides=(number, int(before[number])),
                )
            )
    return found


def _rings(outline: Outline) -> Iterator[tuple[NDArray[np.float64], int]]:
    start = 0
    for ring in outline.rings:
        yield ring, start
        start += len(ring)


def _exponents(angle: float) -> Iterator[tuple[float, bool]]:
    """Return β of the functions that are no polynomials, and whether there is a logarithm."""
    for k in range(1, 8):
        exponent = k * math.pi / angle
        if exponent > _LARGEST_EXPONENT:
            return
        if abs(exponent - 2) < _RESONANT:
            yield 2.0, True
        elif abs(exponent - round(exponent)) > _WHOLE:
            yield exponent, False


def _jump(outline: Outline, corner: NDArray[np.float64], direction: float, angle: float) -> float | None:
    """Return θ of a ray from a corner that leaves the region and does not meet it again; None if none is found."""
    load_modules("shapely")
    import shapely

    extent = float(np.ptp(np.concatenate(outline.rings), axis=0).sum())
    outside = 2 * math.pi - angle
    for part in sorted(np.arange(1, _TRIES + 1) / (_TRIES + 1), key=lambda part: abs(part - 0.5)):
        theta = angle + float(part) * outside
        way = np.array([math.cos(direction + theta), math.sin(direction + theta)])
        ray = shapely.LineString([corner + 1e-6 * extent * way, corner + 2 * extent * way])
        if not shapely.intersects(outline.geometry, ray):
            return theta
    return None
