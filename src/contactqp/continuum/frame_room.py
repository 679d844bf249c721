r"""Room for the frame: whether support and ceiling leave room for it all along its edges, not at its points alone.

Let d = s(f - g) along an edge of the frame, which may be the diagonal of a square that is halved, f a support (s = 1)
or a ceiling (s = -1) and g the frame's height, as depths. Where d ≥ 0 everywhere, the frame's height is that of some
membrane between support and ceiling; where d < 0 anywhere, there is none, and nothing that could be enclosed. On a
segment of length l between two places, d is no less than either of

.. math:: \min f - \max g, \qquad \min(d_1, d_2) - \frac{l²}{8} \max(0, \max d″),

the latter because d less a parabola of the upper end of d″ is concave. Where neither tells, the segment is halved. An
array is its own interpolant, which is no less than at its ends; and where both are the same function there is room.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..foundation.intervals import Interval
from ..foundation.surfaces import Ranged
from ..profiles.analytic import Profile
from .cell_fields import CellField
from .data import Data, bend_along

_Places: TypeAlias = NDArray[np.int64]

_HALVINGS = 6

_ROUNDING = 1e-13
"""A support may lie above the frame by this part of the largest height: that is rounding."""


@dataclass(frozen=True, eq=False)
class _Segments:
    """Parts of edges of the frame in one direction.

    Attributes
    ----------
    step : (int, int)
        How far an edge goes along x and y, in units of the spacing.
    x, y : array, shape (k,)
        Where each begins (length).
    edge : array, shape (k,)
        Which edge each is a part of, and ``first`` and ``last`` the parts of that edge where it begins and ends.
    spacing : float
        Length of an edge along x or y.
    """

    step: tuple[int, int]
    x: Vector
    y: Vector
    edge: _Places
    first: Vector
    last: Vector
    spacing: float

    @property
    def length(self) -> Vector:
        """Length of each along x or y."""
        return self.spacing * (self.last - self.first)

    def ends(self) -> Iterator[tuple[Vector, Vector, Vector]]:
        """Return the places x and y of both ends of each, and the parts of their edges there."""
        yield self.x, self.y, self.first
        yield *self._ahead(self.x, self.y, self.length), self.last

    def _ahead(self, x: Any, y: Any, length: Vector) -> tuple[Vector, Vector]:
        return x + self.step[0] * length, y + self.step[1] * length

    def held(self) -> tuple[Interval, Interval]:
        """Return what holds x and y on each, however its ends are rounded."""
        (x, y, _), (far_x, far_y, _) = self.ends()
        room = 8 * np.spacing(max(float(np.abs(place).max(initial=0.0)) for place in (x, y, far_x, far_y)))
        return tuple(  # type: ignore[return-value]
            Interval.around(one, room).hull(Interval.around(two, room)) for one, two in ((x, far_x), (y, far_y))
        )

    def halves(self, chosen: Mask) -> _Segments:
        """Return both halves of some of them."""
        x, y, edge, first, last = (part[chosen] for part in (self.x, self.y, self.edge, self.first, self.last))
        middle, step = (first + last) / 2, self.length[chosen] / 2
        far_x, far_y = self._ahead(x, y, step)
        return _Segments(
            step=self.step,
            x=np.concatenate([x, far_x]),
            y=np.concatenate([y, far_y]),
            edge=np.concatenate([edge, edge]),
            first=np.concatenate([first, middle]),
            last=np.concatenate([middle, last]),
            spacing=self.spacing,
        )


class _Surface(Protocol):
    """What is known of a support, a ceiling, or the frame's height on segments of the frame, as depths."""

    def at(self, x: Vector, y: Vector, edge: Any, part: Vector) -> Vector:
        """Return depths at places (length)."""

    def held(self, segments: _Segments) -> Interval:
        """Return what holds its depths on segments (length)."""

    def bend(self, segments: _Segments) -> Interval:
        """Return what holds its second derivatives along segments, by the length of these along x or y."""


@dataclass(frozen=True, eq=False)
class _Chords:
    """A surface that is straight along each edge: its depths at both ends of the edges."""

    ends: tuple[Vector, Vector]

    def at(self, x: Vector, y: Vector, edge: Any, part: Vector) -> Vector:
        one, two = (end[edge] for end in self.ends)
        return np.asarray(np.where(part == 0, one, np.where(part == 1, two, one + part * (two - one))))

    def held(self, segments: _Segments) -> Interval:
        one, two = (self.at(*place[:2], segments.edge, place[2]) for place in segments.ends())
        return Interval.between(np.minimum(one, two), np.maximum(one, two))

    def bend(self, segments: _Segments) -> Interval:
        return Interval.of(np.zeros(segments.x.size))


@dataclass(frozen=True, eq=False)
class _Function:
    """A function that tells what it does on rectangles, and the sign by which its values are depths."""

    function: Any
    sign: float

    def at(self, x: Vector, y: Vector, edge: Any, part: Vector) -> Vector:
        return np.broadcast_to(self.sign * np.asarray(self.function(x, y), dtype=np.float64), x.shape)

    def held(self, segments: _Segments) -> Interval:
        held: Interval | None = self.function.range(*segments.held())
        return Interval.of(self.sign) * held if held is not None else _anything(segments)

    def bend(self, segments: _Segments) -> Interval:
        bends = self.function.curvature(*segments.held())
        if bends is None:
            return _anything(segments)
        return Interval.of(self.sign) * bend_along(self.function, bends, segments.step)


def _anything(segments: _Segments) -> Interval:
    return Interval.between(np.full(segments.x.size, -np.inf), np.full(segments.x.size, np.inf))


def require_room(data: Data) -> None:
    """Refuse a frame for which support or ceiling leave no room, or are not known to, between two of its points.

    Along diagonals it may not be known, for that is told of whole halves of squares, see `room_along_diagonals`.

    Parameters
    ----------
    data : Data

    Raises
    ------
    ValueError
    """
    if not data.plan.on_lattice:
        return  # it is asked along the contour itself
    for surface, sign in data.surfaces:
        for step, _, open_parts in _not_known(data, surface, sign):
            if open_parts.x.size and 0 in step:
                x, y, name = open_parts.x[0], open_parts.y[0], _name(sign)
                raise ValueError(
                    f"the {name} is not known to leave room for the frame near x={x:g}, y={y:g}, between points of the "
                    "lattice: declare smaller constants of the two, or move them apart"
                )


def room_along_diagonals(data: Data, surface: CellField, sign: float) -> Mask:
    """Return in which squares that are halved support or ceiling are known to leave room for the frame.

    Parameters
    ----------
    data : Data
    surface : CellField
    sign : float
        One of the `Data.surfaces`.

    Raises
    ------
    ValueError
        If they leave none.
    """
    known = data.plan.halved.copy()
    for (right, up), (first, _), open_parts in _not_known(data, surface, sign):
        if right and up:
            row, column = first[open_parts.edge].T
            known[row, column - (right < 0)] = False
    return known


def _name(sign: float) -> str:
    return "support" if sign > 0 else "ceiling"


def _not_known(
    data: Data, surface: CellField, sign: float
) -> Iterator[tuple[tuple[int, int], tuple[_Places, _Places], _Segments]]:
    """Yield edges of the frame by their direction, and the parts of them where a surface may lie beyond the frame."""
    name, field = _name(sign), surface if sign > 0 else -surface
    given = data.model.given.get(name), data.model.given.get("frame_height", 0.0)
    if given[0] is given[1]:
        return
    everywhere, frame = data.plan.points, data.plan.frame
    sizes = [np.abs(field.values[everywhere]), np.abs(data.frame.values[frame])]
    slip = _ROUNDING * max(float(size[np.isfinite(size)].max(initial=0.0)) for size in sizes)
    slip += 2 * sum(_rounding_at_frame(data, each) for each in (field, data.frame))
    for step, edges in _edges(data):
        segments = _segments(data, step, edges)
        pair = [_surface(data, *each, edges) for each in zip(given, (field, data.frame), strict=True)]
        if any(isinstance(each, _Function) for each in pair):
            yield step, edges, _left_along(segments, pair[0], pair[1], sign, slip)


def _rounding_at_frame(data: Data, field: CellField) -> float:
    """Return how far values of a field may be rounded at the frame: those of a roof that begins there, beyond it."""
    beside = field.rounding[(data.plan.frame_edges > 0) | data.plan.halved]
    return float(beside[np.isfinite(beside)].max(initial=0.0))


def _edges(data: Data) -> Iterator[tuple[tuple[int, int], tuple[_Places, _Places]]]:
    """Yield how far the frame's edges go along x and y, and the places of both ends of them, as rows of points."""
    plan = data.plan
    frame, inside = plan.frame, np.pad(plan.whole, 1)
    level = frame[:, :-1] & frame[:, 1:] & (inside[:-1, 1:-1] | inside[1:, 1:-1])
    upright = frame[:-1] & frame[1:] & (inside[1:-1, :-1] | inside[1:-1, 1:])
    for where, (right, up) in ((upright, (0, 1)), (level, (1, 0))):
        first = np.argwhere(where)
        yield (right, up), (first, first + np.array([up, right]))
    for halves in plan.halves:
        right, up = halves.step
        first = np.column_stack([halves.row, halves.column + (right < 0)])
        yield (right, up), (first, first + np.array([up, right]))


def _segments(data: Data, step: tuple[int, int], edges: tuple[_Places, _Places]) -> _Segments:
    x, y = data.plan.lattice.ring_coordinates(edges[0][:, 0], edges[0][:, 1])
    count = len(edges[0])
    return _Segments(step, x, y, np.arange(count), np.zeros(count), np.ones(count), data.plan.spacing)


def _surface(data: Data, given: Any, field: CellField, edges: tuple[_Places, _Places]) -> _Surface:
    """Return a surface as what was given tells it; of what tells points alone, the interpolant is meant."""
    if isinstance(given, Ranged) and field.exact:
        return _Function(given, -1.0 if data.model.upwards and not isinstance(given, Profile) else 1.0)
    one, two = (field.values[end[:, 0], end[:, 1]] for end in edges)
    return _Chords((one, two))


def _left_along(segments: _Segments, surface: _Surface, frame: _Surface, sign: float, slip: float) -> _Segments:
    """Return parts of segments on which a surface may lie beyond the frame however often they are halved.

    Raises
    ------
    ValueError
        If it does.
    """
    for _ in range(_HALVINGS):
        if not segments.x.size:
            break
        with np.errstate(invalid="ignore", over="ignore"):
            found = [
                sign * (surface.at(x, y, segments.edge, part) - frame.at(x, y, segments.edge, part))
                for x, y, part in segments.ends()
            ]
            bend = sign * (surface.bend(segments) - frame.bend(segments))
            bent = np.minimum(*found) - segments.length**2 / 8 * (1 + 1e-12) * np.maximum(bend.upper, 0.0)
            ranged = (sign * (surface.held(segments) - frame.held(segments))).lower
        for d, (x, y, _) in zip(found, segments.ends(), strict=True):
            if (d < -slip).any():
                worst, name = int(np.argmin(d)), _name(sign)
                raise ValueError(
                    f"the frame at x={x[worst]:g}, y={y[worst]:g} lies beyond the {name}, by {-d[worst]:.3g}: no "
                    f"membrane can be held there; the {name} must leave room for the frame, between points of the "
                    "lattice, too"
                )
        segments = segments.halves(~(np.fmax(bent, ranged) >= -slip))
    return segments
