"""Heights along a contour that cuts the squares of a lattice anywhere: of a frame, and of a support above it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..foundation.intervals import Interval
from ..foundation.rounding import UNIT_ROUNDOFF
from ..foundation.surfaces import Ranged
from ..geometry.fields import is_function
from ..geometry.numbering import Grid
from ..profiles.analytic import Profile
from .contour import Contour
from .contour_rim import ContourRim
from .data import Data

_SLACK = 16 * UNIT_ROUNDOFF


def depths_along(data: Data, contour: Contour, name: str) -> ContourRim:
    r"""Return what is known of the frame's height, or of the support, along a contour, as depths.

    A function g on a piece of the contour that goes on straight, with t from 0 to 1, lies beside the chord of its
    values at the ends by no more than an eighth of what d²g/dt² may be. Beside the piece, to which the contour is near,
    the same is true for the piece moved there: values and second derivatives are those on boxes so much larger. An
    array is meant as its bilinear interpolant, and a function of which nothing but values is known is taken for that of
    these; along the contour both are taken for their chords.

    Parameters
    ----------
    data : Data
    contour : Contour
    name : {"frame_height", "support"}
    """
    given = data.model.given.get(name, 0.0)
    sign = -1.0 if data.model.upwards and not isinstance(given, Profile) else 1.0
    ends = [contour.places(end) for end in (contour.start, contour.end)]
    field = data.support if name == "support" else data.frame
    if not (is_function(given) and field.exact and isinstance(given, Ranged)):
        values = _interpolated(field.values, contour)
        return ContourRim.between_chords(contour, values, values)
    reach = contour.reach * contour.spacing
    reach += 8 * float(np.spacing(max(float(np.abs(place).max()) for end in ends for place in end)))
    boxes = [tuple(Interval.around(place, reach) for place in end) for end in ends]
    held = [given.range(*box) or _ANYTHING for box in boxes]
    lower, upper = (np.stack([np.broadcast_to(getattr(each, end), contour.size) for each in held]) for end in _ENDS)
    whole = boxes[0][0].hull(boxes[1][0]), boxes[0][1].hull(boxes[1][1])
    below, above = _beside_chords(given, whole, contour)
    lower, upper = lower - below, upper + above
    around = given.range(*whole)
    if around is not None:
        # A chord may be replaced by a constant that is nearer at both of its ends, not at one of them.
        lower = np.where((lower <= around.lower).all(axis=0), around.lower, lower)
        upper = np.where((upper >= around.upper).all(axis=0), around.upper, upper)
    found = ContourRim.between_chords(contour, lower, upper)
    return found if sign > 0 else -found


_ENDS = "lower", "upper"

_ANYTHING = Interval.between(-np.inf, np.inf)


def _interpolated(values: Grid, contour: Contour) -> NDArray[np.float64]:
    """Return the bilinear interpolant of values at the points at both ends of the pieces, shape (2, k)."""
    row, column = contour.row, contour.column
    own = [values[row + i, column + j] for i, j in ((0, 0), (0, 1), (1, 0), (1, 1))]
    found = []
    for x, y in (contour.start, contour.end):
        low, high = own[0] + x * (own[1] - own[0]), own[2] + x * (own[3] - own[2])
        found.append(low + y * (high - low))
    return np.stack(found)


def _beside_chords(
    given: Ranged, box: tuple[Interval, Interval], contour: Contour
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return how far a function lies below and above the chords on the pieces of a contour at most (length)."""
    bends = given.curvature(*box)
    if bends is None:
        return np.full(contour.size, np.inf), np.full(contour.size, np.inf)
    # The ends of a piece may be off by what the contour lies beside it, too.
    room = 4 * contour.reach
    x, y = (Interval.around(step * contour.spacing, room * contour.spacing) for step in contour.end - contour.start)
    along = bends.xx * x.square() + 2.0 * (bends.xy * (x * y)) + bends.yy * y.square()
    return tuple(np.maximum(part, 0.0) / 8.0 * (1 + _SLACK) for part in (along.upper, -along.lower))  # type: ignore[return-value]
