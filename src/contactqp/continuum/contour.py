r"""Contour: a frame that cuts the squares of a lattice anywhere, in pieces of which each lies in one square.

Lengths are in spacings here, and counted from the first point of the lattice's array with its ring. A segment from P to
Q is cut where it crosses lines of the lattice, at parts of its way that are rounded as the places of P and Q are. So
the contour lies within ``reach`` of the pieces that are kept: a few units in the last place of the largest coordinate,
and the sagitta of the arcs that chords stand for. Where a side runs along a line of the lattice, to rounding, it is
taken to lie on it, and the square on its left, where the region is, is the one that it belongs to.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..foundation.rounding import UNIT_ROUNDOFF
from ..geometry.lattice import Lattice
from ..geometry.outline import Outline

_Places = NDArray[np.intp]

_ROUNDINGS = 64
"""More roundings, of a coordinate each, than there are on the way from corners of the outline to ends of pieces."""

_ON_LINE = 4
"""A piece that is nearer to the edge of a square than so many of these roundings does not cut it."""


@dataclass(frozen=True, eq=False)
class Contour:
    """The contour of a frame on a lattice.

    Attributes
    ----------
    row, column : array of int, shape (k,)
        The square that each piece lies in.
    start, end : array, shape (2, k)
        Where it begins and ends, along x and along y from the first corner of the square, 0 to 1 to rounding.
    reach : float
        How far the contour lies from the pieces at most (spacings).
    inside : array of bool, shape (rows + 1, columns + 1)
        The squares that the region has a part of: those that the contour cuts, and those within it.
    cut : array of bool, shape (rows + 1, columns + 1)
        The squares that the contour cuts.
    segment : array of int, shape (k,)
        Which segment of the outline each is a piece of.
    first : (float, float)
        x and y of the first point (length).
    spacing : float
        Length.
    """

    row: _Places
    column: _Places
    start: NDArray[np.float64]
    end: NDArray[np.float64]
    reach: float
    inside: Mask
    cut: Mask
    segment: _Places
    first: tuple[float, float]
    spacing: float

    @classmethod
    def of(cls, lattice: Lattice, outline: Outline) -> Contour:
        """Return an outline on a lattice."""
        spacing, (x, y) = lattice.spacing, lattice.origin
        shape = lattice.shape[0] + 1, lattice.shape[1] + 1
        ends = [((corners - (x, y)) / spacing + 1.0).T for corners in outline.segments]
        largest = max(float(np.abs(corners).max()) for corners in outline.segments) + max(abs(x), abs(y))
        rounding = UNIT_ROUNDOFF * (largest / spacing + max(shape))
        start, end, segment = _cut_at_lines(*ends)
        column, row = _squares(start, end, _ON_LINE * rounding, shape)
        corner = np.stack([column, row])
        start, end = start - corner, end - corner
        reach = _ROUNDINGS * rounding + outline.sagitta / spacing
        distances = _ON_LINE * rounding, reach if outline.sagitta else 0.0
        cut = _cut_squares((start, end), (column, row), distances, shape)
        middles = lattice.ring_coordinates(np.arange(shape[0]) + 0.5, np.arange(shape[1]) + 0.5)
        inside = outline.holds(*np.broadcast_arrays(middles[0], middles[1][:, None])) | cut
        return cls(row, column, start, end, reach, inside, cut, segment, (x - spacing, y - spacing), spacing)

    @property
    def size(self) -> int:
        """Number of pieces."""
        return self.row.size

    @cached_property
    def length(self) -> Vector:
        """Length of each piece, with what it reaches beyond, rounded up (length)."""
        step = self.end - self.start
        return np.asarray((np.hypot(*step) + 2 * self.reach) * (self.spacing * (1 + 8 * UNIT_ROUNDOFF)))

    def places(self, end: NDArray[np.float64]) -> tuple[Vector, Vector]:
        """Return x and y of one of the ends of all pieces (length)."""
        return (
            self.first[0] + self.spacing * (self.column + end[0]),
            self.first[1] + self.spacing * (self.row + end[1]),
        )


def _cut_at_lines(
    start: NDArray[np.float64], end: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], _Places]:
    """Return the pieces of segments between lines of the lattice, shape (2, k), and of which they are."""
    segments = np.arange(start.shape[1])
    number, part = [segments, segments], [np.zeros(segments.size), np.ones(segments.size)]
    for low, high, begin, way in zip(np.minimum(start, end), np.maximum(start, end), start, end - start, strict=True):
        first = np.ceil(low)
        count = np.maximum(np.floor(high) - first + 1, 0).astype(np.int64)
        of = np.repeat(segments, count)
        line = first[of] + (np.arange(of.size) - np.repeat(np.cumsum(count) - count, count))
        with np.errstate(divide="ignore", invalid="ignore"):
            at = (line - begin[of]) / way[of]
        number.append(of[np.isfinite(at)])
        part.append(np.clip(at[np.isfinite(at)], 0.0, 1.0))
    of, at = np.concatenate(number), np.concatenate(part)
    order = np.lexsort((at, of))
    of, at = of[order], at[order]
    whole = (of[1:] == of[:-1]) & (at[1:] > at[:-1])
    of, before, after = of[:-1][whole], at[:-1][whole], at[1:][whole]
    step = (end - start)[:, of]
    return start[:, of] + before * step, np.where(after == 1.0, end[:, of], start[:, of] + after * step), of


def _squares(
    start: NDArray[np.float64], end: NDArray[np.float64], rounding: float, shape: tuple[int, int]
) -> tuple[_Places, _Places]:
    """Return column and row of the square that each piece lies in, or that lies to its left if it is on a line."""
    step = end - start
    left = np.stack([-step[1], step[0]]) / np.maximum(np.hypot(*step), np.finfo(float).tiny)
    column, row = np.floor((start + end) / 2 + rounding * left).astype(np.intp)
    return np.clip(column, 0, shape[1] - 1), np.clip(row, 0, shape[0] - 1)


def _cut_squares(
    pieces: tuple[NDArray[np.float64], NDArray[np.float64]],
    squares: tuple[_Places, _Places],
    distances: tuple[float, float],
    shape: tuple[int, int],
) -> Mask:
    """Return the squares that pieces cut by more than rounding, or that arcs may which rise above them by a part.

    The distances are both of these, in spacings.
    """
    (start, end), (rounding, rise) = pieces, distances
    place = np.stack(squares)
    least, most = np.minimum(start, end), np.maximum(start, end)
    crosses = ((most > rounding) & (least < 1 - rounding)).all(axis=0)
    cut = np.zeros(shape, dtype=np.bool_)
    cut[tuple(place[::-1, crosses])] = True
    if rise:
        # Chords of a circle, of which there are a multiple of four, reach as far along x and y as it does.
        low, high = (least + place).min(axis=1), (most + place).max(axis=1)
        for shift in np.ndindex(3, 3):
            step = np.array(shift)[:, None] - 1
            near = np.where(step < 0, least - rise < 0, np.where(step > 0, most + rise > 1, True)).all(axis=0)
            beside = (place + step)[:, near]
            within = ((beside + 1 - rounding > low[:, None]) & (beside + rounding < high[:, None])).all(axis=0)
            cut[tuple(beside[::-1, within])] = True
    return cut
