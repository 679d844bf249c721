r"""Kinks of a support: what lies beside its interpolant in a cell that a kink crosses, part by part.

Where second derivatives tell nothing, the range of f on the cell does: but on parts of the cell it tells more, for f
and its bilinear interpolant If then vary less. On each of k² parts,

.. math:: \min f - \max If ≤ f - If ≤ \max f - \min If,

where If lies between the least and the largest of its values at the corners of the part.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..foundation.checks import Mask
from ..foundation.intervals import Interval
from ..foundation.rounding import UNIT_ROUNDOFF
from ..foundation.surfaces import Ranged
from .cell_fields import CellField
from .plan import CORNERS, Plan

_PARTS = 16

_ROUNDING = 32 * UNIT_ROUNDOFF


def cells_with_kinks(plan: Plan, field: CellField) -> Mask:
    """Return the squares in which a field is a function that may have a kink, shape (rows + 1, columns + 1)."""
    bent = np.isinf(field.bent_below) | np.isinf(field.bent_above)
    return np.asarray(plan.squares & np.broadcast_to(bent, plan.squares.shape))


def told_by_parts(plan: Plan, field: CellField, function: Ranged, sign: float) -> CellField:
    """Return a field of a function, with what it has beside its interpolant in cells with kinks told by parts.

    Parameters
    ----------
    plan : Plan
    field : CellField
    function : Ranged
    sign : float
        What values of the function are multiplied by.
    """
    row, column = np.nonzero(cells_with_kinks(plan, field))
    if not row.size:
        return field
    along_x, along_y = plan.around_squares
    steps = np.arange(_PARTS + 1) / _PARTS
    x = _parts(along_x.lower[0, column], along_x.upper[0, column], steps)
    y = _parts(along_y.lower[row, 0], along_y.upper[row, 0], steps)
    told = function.range(*(Interval(p.lower[place], p.upper[place]) for p, place in ((x, _ALONG), (y, _ACROSS))))
    if told is None:
        return field
    shape = row.size, _PARTS, _PARTS
    lower, upper = (np.broadcast_to(sign * end, shape) for end in (told.lower, told.upper))
    lower, upper = np.minimum(lower, upper), np.maximum(lower, upper)
    four = [field.values[row + down, column + right] for down, right in CORNERS]
    right, up = steps[None, None, :], steps[None, :, None]
    first, second, third, fourth = (value[:, None, None] for value in four)
    inner = (1 - up) * ((1 - right) * first + right * second) + up * (right * third + (1 - right) * fourth)
    corners = np.stack([inner[:, :-1, :-1], inner[:, 1:, :-1], inner[:, :-1, 1:], inner[:, 1:, 1:]])
    most, least = corners.max(axis=0), corners.min(axis=0)
    off = np.broadcast_to(field.rounding, plan.squares.shape)[row, column]
    off = off + _ROUNDING * (np.abs(four).sum(axis=0) + np.maximum(np.abs(lower), np.abs(upper)).max(axis=(1, 2)))
    found: dict[str, Any] = {}
    for name, away in (("below", most - lower), ("above", upper - least)):
        kept = np.array(np.broadcast_to(getattr(field, name), plan.squares.shape))
        kept[row, column] = np.fmin(kept[row, column], np.maximum(away.max(axis=(1, 2)), 0.0) + off)
        found[name] = kept
    return replace(field, **found)


_ALONG = np.s_[:, None, :]
_ACROSS = np.s_[:, :, None]


def _parts(lower: np.ndarray, upper: np.ndarray, steps: np.ndarray) -> Interval:
    """Return what holds each part of some stretches, however their ends are rounded, shape (k, parts)."""
    ends = lower[:, None] + (upper - lower)[:, None] * steps
    room = 32 * np.spacing(np.maximum(np.abs(lower), np.abs(upper)))[:, None]
    return Interval(ends[:, :-1] - room, ends[:, 1:] + room)
