r"""Splines along a contour that cuts the squares of a lattice anywhere, less what is known there of heights.

*Along a piece.* In its square a bicubic spline is a polynomial, cubic in x and in y, and on a piece that goes on
straight with t from 0 to 1 one of degree six in t. A cubic polynomial of a place ξ that goes from ξ₀ to ξ₁ has, by t,
the Bernstein coefficients F(ξ₀, ξ₀, ξ₀), F(ξ₀, ξ₀, ξ₁), F(ξ₀, ξ₁, ξ₁) and F(ξ₁, ξ₁, ξ₁), where F, its blossom, is
found by de Casteljau's steps with one argument each (Ramshaw, *Blossoms are polar forms*, Computer Aided Geometric
Design 6, 1989). Those of a product of two follow as in `contactqp.continuum.splines`, and the spline along the piece
lies between the least and the largest of the seven.

*Beside the piece* the contour is no farther than ``reach``. There a spline differs by no more than reach times the sum
of the largest differences of its coefficients along x and along y, of which the first derivatives are convex
combinations, in squares that the contour cuts.

*Roundings.* The places on a piece lie in [0, 1] to rounding, so that the weights of the coefficients, formed by three
steps of two products each, are off by less than 16 units of rounding, four of them in either direction add up to less
than 128, and the products and sums of seven coefficients have fewer than 40: γ₂₅₆ times the largest modulus of a
coefficient holds all of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import comb

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Vector
from ..foundation.rounding import UNDERFLOW, UNIT_ROUNDOFF, gamma
from ..geometry.numbering import Grid
from .contour import Contour
from .splines import TO_BERNSTEIN

_ERROR = gamma(256)

_RAISED = np.array(
    [[comb(2, k) * comb(4, m - k) / comb(6, m) if 0 <= m - k <= 4 else 0.0 for k in range(3)] for m in range(7)]
)
"""Bernstein coefficients of degree six of a parabola from those of degree two."""


@dataclass(frozen=True, eq=False)
class ContourRim:
    """What is known of heights along a contour.

    Attributes
    ----------
    contour : Contour
    lower, upper : array, shape (3, k)
        The heights lie, on each piece, between two parabolas of which these are the Bernstein coefficients (length).
    """

    contour: Contour
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]

    @classmethod
    def between_chords(cls, contour: Contour, lower: NDArray[np.float64], upper: NDArray[np.float64]) -> ContourRim:
        """Return heights between what is linear between the two ends of each piece, shape (2, k)."""
        found = [np.stack([ends[0], ends.mean(axis=0), ends[1]]) for ends in (lower, upper)]
        off = 2 * UNIT_ROUNDOFF * np.maximum(np.abs(lower), np.abs(upper)).max(axis=0)
        return cls(contour, found[0] - off, found[1] + off)

    @property
    def halfway(self) -> Vector:
        """About the heights in the middle of each piece (length)."""
        return np.asarray(np.array([1.0, 2.0, 1.0]) @ (self.lower + self.upper) / 8.0)

    def __neg__(self) -> ContourRim:
        return ContourRim(self.contour, -self.upper, -self.lower)

    def __add__(self, other: ContourRim) -> ContourRim:
        lower, upper = self.lower + other.lower, self.upper + other.upper
        off = 2 * UNIT_ROUNDOFF * (np.abs(lower) + np.abs(upper)) + UNDERFLOW
        return ContourRim(self.contour, lower - off, upper + off)

    def excess(self, coefficients: Grid) -> tuple[Vector, Vector]:
        """Return the least and the largest of a spline less the heights along each piece of the contour, shape (k,)."""
        values, error = self.values(coefficients)
        high, low = (np.tensordot(_RAISED, ends, axes=1) for ends in (self.upper, self.lower))
        size = np.maximum(np.abs(self.lower), np.abs(self.upper)).max(axis=0)
        off = error + _ERROR * size + UNDERFLOW
        return (values - high).min(axis=0) - off, (values - low).max(axis=0) + off

    def values(self, coefficients: Grid) -> tuple[NDArray[np.float64], float]:
        """Return the seven Bernstein coefficients of a spline along each piece, and how far it may lie beside them."""
        largest = float(np.abs(coefficients.ravel()[self._block]).max(initial=0.0))
        steps = sum(float(np.abs(np.diff(coefficients.ravel()[pair], axis=0)).max(initial=0.0)) for pair in self._pairs)
        along_x, along_y = self._weights
        block = coefficients.ravel()[self._block]
        inner = np.einsum("kjx,ijk->kix", along_x, block)
        net = np.einsum("kiy,kix->yxk", along_y, inner)
        values = np.stack(
            [
                sum(comb(3, a) * comb(3, m - a) * net[a, m - a] for a in range(max(0, m - 3), min(3, m) + 1))
                / comb(6, m)
                for m in range(7)
            ]
        )
        return values, _ERROR * largest + self.contour.reach * (1 + _ERROR) * steps + UNDERFLOW

    @property
    def _width(self) -> int:
        width: int = self.contour.inside.shape[1] + 3
        return width

    @cached_property
    def _block(self) -> NDArray[np.intp]:
        """Places of the sixteen coefficients on the square of each piece, shape (4, 4, k)."""
        return _blocks(self.contour.row, self.contour.column, self._width)

    @cached_property
    def _pairs(self) -> list[NDArray[np.intp]]:
        """Places of coefficients next to each other, along x and along y, on squares that are cut, shape (2, m)."""
        row, column = np.nonzero(self.contour.cut)
        blocks = _blocks(row, column, self._width)
        blocks = np.concatenate([blocks, self._block], axis=2)
        return [
            np.stack([first.ravel(), second.ravel()])
            for first, second in ((blocks[:, :-1], blocks[:, 1:]), (blocks[:-1], blocks[1:]))
        ]

    @cached_property
    def _weights(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Weights of four coefficients in the Bernstein coefficients by t, along x and along y, shape (k, 4, 4)."""
        return tuple(  # type: ignore[return-value]
            np.stack([_blossom(*places) for places in _arguments(first, last)], axis=-1)
            for first, last in zip(self.contour.start, self.contour.end, strict=True)
        )


def _arguments(first: Vector, last: Vector) -> list[tuple[Vector, Vector, Vector]]:
    return [(first, first, first), (first, first, last), (first, last, last), (last, last, last)]


def _blossom(one: Vector, two: Vector, three: Vector) -> NDArray[np.float64]:
    """Return the weights of a cubic spline's four coefficients in its blossom on the square, shape (k, 4)."""
    net = np.broadcast_to(TO_BERNSTEIN, (one.size, 4, 4))
    for place in (one, two, three):
        part = place[:, None, None]
        net = (1.0 - part) * net[:, :-1] + part * net[:, 1:]
    return net[:, 0]


def _blocks(row: NDArray[np.intp], column: NDArray[np.intp], width: int) -> NDArray[np.intp]:
    i, j = np.arange(4)[:, None, None], np.arange(4)[None, :, None]
    return np.asarray((row + i) * width + (column + j), dtype=np.intp)
