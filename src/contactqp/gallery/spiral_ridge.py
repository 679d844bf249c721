r"""The spiral ridge of Gräser and Kornhuber as a surface that tells what it does between the nodes.

With φ = 2π/r and the angle θ, its height is ψ = cos(φ - θ) + k(r), k = 6.6 - 2r - 6/(2 - r), and f = -ψ. For C = cos(φ
- θ) = cos φ x/r + sin φ y/r and S = sin(φ - θ), the second derivatives of C along the ray, across it and mixed are

.. math:: H_{rr} = -Cφ'^2 - Sφ'', \quad H_{tt} = -Sφ'/r - C/r², \quad H_{rt} = Cφ'/r - S/r²,

φ′ = -2π/r², φ″ = 4π/r³; those of k are k″ = -12/(2 - r)³ and k′/r, k′ = -2 - 6/(2 - r)². Turned by θ they are f_xx,
f_xy and f_yy. Towards the middle the ridge winds ever faster, about the height k: all that is known there is -k ± 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..foundation.checks import Vector
from ..foundation.intervals import Interval
from ..foundation.surfaces import Curvature
from ..foundation.waves import cosine, sine
from ..profiles.analytic import Profile

_NEAREST = 1e-300
"""Distances from the middle at which the ridge has no more turns, each of which no double could tell from the next."""

_WHOLE_TURN = Interval.around(2 * math.pi, 1e-15)


@dataclass(frozen=True)
class SpiralRidge(Profile):
    """The spiral ridge, for r < 2.

    Examples
    --------
    >>> float(SpiralRidge()(0.0, 0.0))
    -3.6
    """

    def __call__(self, x: ArrayLike, y: ArrayLike) -> Vector:
        """Return the depths at the points (x, y)."""
        r, angle = np.hypot(x, y), np.arctan2(y, x)
        summit = r < _NEAREST
        r = np.where(summit, 1.0, r)
        height = np.sin(2 * np.pi / r + np.pi / 2 - angle) + r * (r + 1) / (r - 2) - 3 * r + 3.6
        return np.asarray(-np.where(summit, 3.6, height))

    def range(self, x: Interval, y: Interval) -> Interval:
        """See `Profile.range`."""
        r = (x.square() + y.square()).sqrt()
        wave, _ = _waves(x, y, r)
        return -(wave + (6.6 - 2.0 * r - 6.0 / (2.0 - r)))

    def curvature(self, x: Interval, y: Interval) -> Curvature:
        """See `Profile.curvature`: not known in the middle."""
        r = (x.square() + y.square()).sqrt()
        away = r.lower > _NEAREST
        wave, shifted = _waves(x, y, r)
        inverse = 1.0 / r.where(away, Interval.of(np.ones(())))
        square, far = inverse.square(), 1.0 / (2.0 - r)
        once, twice = -_WHOLE_TURN * square, 2.0 * (_WHOLE_TURN * square * inverse)
        along = -(wave * once.square()) - shifted * twice - 12.0 * (far * far.square())
        across = -(shifted * once * inverse) - wave * square - (2.0 + 6.0 * far.square()) * inverse
        mixed = wave * once * inverse - shifted * square
        cos, sin = _within_one(x * inverse), _within_one(y * inverse)
        both, turned = cos * sin, cos.square() - sin.square()
        parts = (
            cos.square() * along - 2.0 * (both * mixed) + sin.square() * across,
            both * (along - across) + turned * mixed,
            sin.square() * along + 2.0 * (both * mixed) + cos.square() * across,
        )
        anything = Interval.between(-np.inf, np.inf)
        return Curvature(*((-part).where(away, anything) for part in parts))


def _waves(x: Interval, y: Interval, r: Interval) -> tuple[Interval, Interval]:
    """Return what holds cos(2π/r - θ) and sin(2π/r - θ)."""
    away, one = r.lower > _NEAREST, Interval.of(np.ones(()))
    inverse = 1.0 / r.where(away, one)
    phase = _WHOLE_TURN * inverse
    cos, sin = _within_one(x * inverse), _within_one(y * inverse)
    waves = cosine(phase) * cos + sine(phase) * sin, sine(phase) * cos - cosine(phase) * sin
    whole = Interval.between(-1.0, 1.0)
    return _within_one(waves[0]).where(away, whole), _within_one(waves[1]).where(away, whole)


def _within_one(part: Interval) -> Interval:
    return Interval(np.maximum(part.lower, -1.0), np.minimum(part.upper, 1.0))
