"""Cuts: where the contour of a frame cuts the arms between the nodes of a lattice and the points beside them."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from .numbering import Grid

LEAST = 1e-3
"""A node that is nearer to the contour than this part of the spacing, along an arm, belongs to the frame."""

_PROBES = 8
"""Points of an arm that are looked at for the first one outside, so that a narrow piece of frame is not passed over."""

_HALVINGS = 44

Inside = Callable[[NDArray[np.float64], NDArray[np.float64], float], Mask]


class Cuts(NamedTuple):
    """How long the arms are that end on the frame, in spacings.

    Attributes
    ----------
    along_x : array, shape (rows, columns + 1)
        1 where an arm is not cut, less where it is.
    along_y : array, shape (rows + 1, columns)
    """

    along_x: Grid
    along_y: Grid


class FrameArms(NamedTuple):
    """The arms that join a node to the frame, those along x before those along y, each row by row.

    Attributes
    ----------
    node_row, node_column, row, column : array of int, shape (k,)
        Place of the node, and of the lattice's point beside it in the direction of the arm, on the array with a ring.
    length : array, shape (k,)
        In spacings.
    along_x : array of bool, shape (k,)
        Whether the arm lies along x.
    """

    node_row: NDArray[np.intp]
    node_column: NDArray[np.intp]
    row: NDArray[np.intp]
    column: NDArray[np.intp]
    length: Vector
    along_x: Mask

    @property
    def ends(self) -> tuple[Vector, Vector]:
        """Row and column of the point at which the frame holds each arm, with fractions."""
        rows = self.node_row + self.length * (self.row - self.node_row)
        columns = self.node_column + self.length * (self.column - self.node_column)
        return np.asarray(rows), np.asarray(columns)


def frame_arms(mask: Mask, cuts: Cuts | None = None) -> FrameArms:
    """Return the arms of a lattice that end on the frame.

    Examples
    --------
    >>> arms = frame_arms(np.array([[True]]), Cuts(np.array([[1.0, 0.25]]), np.ones((2, 1))))
    >>> [ends.tolist() for ends in arms.ends]
    [[1.0, 1.0, 0.0, 2.0], [0.0, 1.25, 1.0, 1.0]]
    """
    points = np.pad(mask, 1)
    found = []
    for axis, lengths in ((1, None if cuts is None else cuts.along_x), (0, None if cuts is None else cuts.along_y)):
        inner = points[1:-1] if axis == 1 else points[:, 1:-1]
        first, second = (inner[:, :-1], inner[:, 1:]) if axis == 1 else (inner[:-1], inner[1:])
        row, column = np.nonzero(first != second)
        forwards = first[row, column].astype(np.intp)  # the node is the first of the two
        length = np.ones(row.size) if lengths is None else lengths[row, column]
        if axis == 1:
            places = row + 1, column + 1 - forwards, row + 1, column + forwards
        else:
            places = row + 1 - forwards, column + 1, row + forwards, column + 1
        found.append((*places, length, np.full(row.size, axis == 1)))
    return FrameArms(*(np.concatenate(part) for part in zip(*found, strict=True)))


def fitted(mask: Mask, spacing: float, origin: tuple[float, float], inside: Inside, margin: float) -> tuple[Mask, Cuts]:
    """Return the nodes that are left when those next to the contour belong to the frame, and how long arms are.

    Parameters
    ----------
    mask : array of bool, shape (rows, columns)
        The points inside the contour.
    spacing : float
    origin : (float, float)
        Coordinates of ``mask[0, 0]`` (length).
    inside : callable
        Whether points lie inside the contour moved inwards by a margin.
    margin : float
        What counts as on the contour (length).
    """
    arms = frame_arms(mask)
    length = _lengths(arms, spacing, origin, inside, margin / spacing)
    near = length < LEAST
    if near.any():
        left = np.pad(mask, 1)
        left[arms.node_row[near], arms.node_column[near]] = False
        mask = np.ascontiguousarray(left[1:-1, 1:-1])
        arms = frame_arms(mask)
        # A node that has come to the frame holds the arms of its neighbours where it lies.
        length = _lengths(arms, spacing, origin, inside, margin / spacing)
        length[length < LEAST] = LEAST
    rows, columns = mask.shape
    cuts = Cuts(np.ones((rows, columns + 1)), np.ones((rows + 1, columns)))
    for along_x, lengths, shift in ((True, cuts.along_x, (1, 0)), (False, cuts.along_y, (0, 1))):
        own = arms.along_x == along_x
        place = np.minimum(arms.node_row, arms.row)[own] - shift[0], np.minimum(arms.node_column, arms.column)[own]
        lengths[place[0], place[1] - shift[1]] = length[own]
    return mask, cuts


def _lengths(arms: FrameArms, spacing: float, origin: tuple[float, float], inside: Inside, level: float) -> Vector:
    """Return how far each arm goes from its node to the contour, in spacings; 1 where that lies no nearer."""
    x, y = origin[0] + spacing * (arms.node_column - 1.0), origin[1] + spacing * (arms.node_row - 1.0)
    step_x, step_y = spacing * (arms.column - arms.node_column), spacing * (arms.row - arms.node_row)

    def within(part: Vector) -> Mask:
        return np.asarray(inside(np.asarray(x + part * step_x), np.asarray(y + part * step_y), 0.0))

    low, high = np.zeros(x.size), np.ones(x.size)
    reached = np.zeros(x.size, dtype=np.bool_)
    for probe in range(1, _PROBES + 1):
        part = np.full(x.size, probe / _PROBES)
        within_here = within(part)
        out = ~within_here & ~reached
        low[out], high[out] = (probe - 1) / _PROBES, probe / _PROBES
        reached |= out
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        still = within(middle)
        low, high = np.where(still, middle, low), np.where(still, high, middle)
    return np.where(reached & (high < 1 - 2 * level - 1e-12), high, 1.0)
