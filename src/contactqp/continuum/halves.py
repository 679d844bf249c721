r"""Fields on squares that slanted sides halve: what they are on the half, and along the diagonal.

A corner of such a square lies beyond the frame. A function is asked there as well. An array tells nothing of it, and is
meant as linear on the half: with A the corner at the node, B and C those on the frame, the fourth value is taken as B +
C - A, by which the bilinear interpolant is linear. Where a point is the fourth corner of several squares their mean is
taken, and where it belongs to the membrane its own value; the interpolant is then off by no more than a quarter of the
difference, for on the half the weight of the fourth corner, xy with x + y ≤ 1, is at most 1/4.

On the diagonal, at the part t of the way, the bilinear interpolant is the chord's height and t(1 - t)(A - B - C + D).

**Without D.** With x and y counted from the node along the legs, in units of them, the bilinear interpolant is the
linear one of A, B and C, and (A - B - C + D)xy, where xy is between 0 and 1/4 on the half, and 1/16 in the mean over
the quarter of the square at the node. By so much margins are changed that are to tell how far a field lies from the
linear interpolant, see `about_halves`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..foundation.rounding import UNIT_ROUNDOFF
from ..geometry.numbering import Grid
from ..plotting.of_squares import Halves
from .cell_fields import CellField
from .cells import Cells, Places
from .plan import Plan

_ROUNDING = 16 * UNIT_ROUNDOFF


def linear_on_halves(field: CellField, cells: Cells) -> CellField:
    """Return a field that is meant as the interpolant of its values, with its values beyond the frame.

    Parameters
    ----------
    field : CellField
    cells : Cells
    """
    if not cells.cut.any():
        return field
    row, column = np.nonzero(cells.cut)
    (own, first, last), beyond = _corners(cells)
    wanted = field.values[first] + field.values[last] - field.values[own]
    shape = cells.nodes.shape
    place = np.ravel_multi_index(beyond, shape)
    count = np.bincount(place, minlength=cells.nodes.size).reshape(shape)
    total = np.bincount(place, wanted, cells.nodes.size).reshape(shape)
    values = np.where((count > 0) & ~cells.points, total / np.maximum(count, 1), field.values)
    three = np.stack([field.values[place] for place in (own, first, last)])
    off = np.abs(values[beyond] - wanted) / 4.0 + _ROUNDING * np.abs(three).sum(axis=0)
    changed: dict[str, Any] = {}
    for name, on_half in (
        ("below", off),
        ("above", off),
        ("range_lower", three.min(axis=0)),
        ("range_upper", three.max(axis=0)),
    ):
        kept = np.array(np.broadcast_to(getattr(field, name), cells.inside.shape))
        kept[row, column] = on_half
        changed[name] = kept
    return replace(field, values=values, **changed)


def about_halves(field: CellField, plan: Plan, *, linear: bool) -> CellField:
    """Return a field that is told on halves by the linear interpolant, its values beyond the frame left aside.

    Parameters
    ----------
    field : CellField
    plan : Plan
    linear : bool
        Whether it is meant as that interpolant.
    """
    if not plan.halves:
        return field
    names = [f"{part}{side}" for part in ("", "mean_", "bent_") for side in ("below", "above")]
    names += ["range_lower", "range_upper", "rounding"]
    kept: dict[str, Any] = {name: np.array(np.broadcast_to(getattr(field, name), plan.squares.shape)) for name in names}
    for halves in plan.halves:
        place, three = halves.place, np.stack(halves.of(field.values))
        if linear:
            with np.errstate(invalid="ignore"):
                least, most = three.min(axis=0), three.max(axis=0)
            # Where a corner has no support, the half has none.
            kept["range_lower"][place] = np.where(np.isposinf(most), most, least)
            kept["range_upper"][place] = np.where(np.isneginf(least), least, most)
            continue
        far = plan.at_corner(field.values, halves.corner - 2)[place]
        with np.errstate(invalid="ignore"):
            twist = (three[0] + far) - (three[1] + three[2])
            off = _ROUNDING * (np.abs(three).sum(axis=0) + np.abs(far))
        for side, sign in (("below", -1.0), ("above", 1.0)):
            most = np.maximum(sign * twist, 0.0) / 4
            for name, change in ((side, most), (f"bent_{side}", most), (f"mean_{side}", sign * twist / 16)):
                moved = kept[name][place] + change + off
                kept[name][place] = np.where(np.isnan(moved), np.inf, moved)
        kept["rounding"][place] += off
    return replace(field, values=np.where(plan.points, field.values, 0.0), **kept)


def away_from_chords(field: CellField, cells: Cells, linear: bool) -> tuple[Grid, Grid]:
    """Return how far a field lies below and above the chords along diagonals at most (length); zero elsewhere.

    Parameters
    ----------
    field : CellField
    cells : Cells
    linear : bool
        Whether it is meant as the interpolant of its values, of which it is the chord.
    """
    below, above = np.zeros(cells.inside.shape), np.zeros(cells.inside.shape)
    if linear or not cells.cut.any():
        return below, above
    (own, first, last), beyond = _corners(cells)
    four = [field.values[place] for place in (own, beyond, first, last)]
    twist = (four[0] + four[1]) - (four[2] + four[3])
    off = _ROUNDING * np.abs(four).sum(axis=0)
    for found, kept, sign in ((below, field.below, -1.0), (above, field.above, 1.0)):
        kept = np.broadcast_to(kept, found.shape)[cells.cut]
        found[cells.cut] = (kept + np.maximum(sign * twist, 0.0) / 4.0 + off) * (1 + _ROUNDING)
    return below, above


def halves_of(cells: Cells, places: tuple[Grid, Grid]) -> Halves:
    """Return the halves that belong to the region, each from its node on.

    Parameters
    ----------
    cells : Cells
    places : pair of arrays
        x and y of all points, shapes (1, columns + 2) and (rows + 2, 1), length.
    """
    x, y = places
    three, _ = _corners(cells)
    corners = [np.column_stack([x[0, column], y[row, 0]]) for row, column in three]
    return Halves(cells.cut, np.stack(corners, axis=1))


def _corners(cells: Cells) -> tuple[tuple[Places, Places, Places], Places]:
    """Return the points of the halved cells: node and both ends of the diagonal, and the one beyond."""
    row, column = np.nonzero(cells.cut)
    nodes = cells.nodes
    down = (nodes[row + 1, column] | nodes[row + 1, column + 1]).astype(np.intp)
    right = (nodes[row, column + 1] | nodes[row + 1, column + 1]).astype(np.intp)
    far_down, far_right = 1 - down, 1 - right
    points = [
        (row + i, column + j) for i, j in ((down, right), (far_down, right), (down, far_right), (far_down, far_right))
    ]
    return (points[0], points[1], points[2]), points[3]
