r"""A model's membrane posed as an `ObstacleProblem`, its data known on every cell.

Where the second derivatives of the support f are known to lie in narrow ranges, as those of planes and paraboloids are,
q = p + TΔf is known on every cell. Otherwise depths are counted from a spline F that goes through f nearly, with a_K
≤ f - F ≤ b_K in each cell: u = F - w ≥ F - f is the obstacle problem, see `contactqp.continuum.barriers`, so that a
kink in f costs no more than a cell in which it is not known whether the membrane touches, or by how much a support that
it presses on sticks out. That with the smaller uncertainty is taken.

Of a square that a slanted side halves the data are needed on the half alone; they are bounded on the whole square, for
which a function is asked beyond the frame, and an array goes on as it lies on the half.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..foundation.checks import Mask, repeated
from ..foundation.intervals import Interval
from ..foundation.rounding import UNIT_ROUNDOFF
from ..foundation.surfaces import Ranged
from ..geometry.numbering import Grid
from ..profiles.analytic import Profile
from .cell_fields import CellField
from .cells import Cells, at_corners, extreme_at_corners
from .data import Data
from .ghosts import Continuation
from .halves import away_from_chords, linear_on_halves
from .obstacle import ObstacleProblem
from .pointwise import PointwiseBounds
from .splines import at_points, excess_along_rim, excess_on_cells

_SLACK = 16 * UNIT_ROUNDOFF

_ROOM = 1e-13
"""A support may lie above the frame by this part of the largest height: that is rounding."""


@dataclass(frozen=True, eq=False)
class Posed:
    """A membrane's obstacle problem, and what its bounds say of the membrane.

    Attributes
    ----------
    problem : ObstacleProblem
    surface : array, shape (rows + 2, columns + 2)
        The problem's support at the points, as depths (length).
    surface_error : float
        How far the numbers in ``surface``, and the membrane's support at the points, may be off (length).
    load : pair of arrays, shape (rows + 1, columns + 1)
        Bounds of q = p + TΔf in each cell (force per area).
    """

    problem: ObstacleProblem
    surface: Grid
    surface_error: float
    load: tuple[Grid, Grid]

    @property
    def rest(self) -> tuple[float, float]:
        """Least and largest of the membrane's support less the problem's (length)."""
        inside = self.problem.cells.inside
        least, most = (np.broadcast_to(end, inside.shape)[inside] for end in self.problem.rest)
        return float(least.min()), float(most.max())

    def data_part(self, bounds: PointwiseBounds) -> float:
        """Return how far bounds may be apart because data are known up to a range between the nodes (length)."""
        problem = self.problem
        apart = np.asarray(problem.load_range[1]) - np.asarray(problem.load_range[0])
        apart = np.broadcast_to(apart, problem.cells.inside.shape)
        loads = float(apart.max(where=problem.cells.inside, initial=0.0)) * problem.largest_height
        # What a spline lies beside the support by is paid by shifts alone.
        rest = min(self.rest[1] - self.rest[0], bounds.upper.shift + bounds.lower.shift)
        return loads + (problem.height_range[1] - problem.height_range[0]) + rest


def posed_of(data: Data) -> Posed:
    """Return the obstacle problem of a model's membrane.

    Raises
    ------
    ValueError
        If it is not one over one support, of constant tension, on a frame along lines of the lattice and diagonals of
        its squares.
    """
    _refuse(data)
    cells = Cells(data.model.lattice.mask, data.model.lattice.spacing, data.model.lattice.halved)
    tension = float(data.model.tension)
    laplacian = _laplacian(data)
    sizes = float(np.abs(data.support.values).max(where=cells.corners, initial=0.0))
    doubt = np.inf  # how far a membrane's gap moves by what is not known of the Laplacian
    if laplacian is not None:
        width = float((laplacian.upper - laplacian.lower).max(where=cells.inside, initial=0.0))
        doubt = width * (cells.strip[2] * cells.spacing) ** 2 / 8.0
    if laplacian is not None and doubt <= 1e-12 * sizes:
        return _over_support(data, cells, tension, laplacian)
    over_spline = _over_spline(data, cells, tension, laplacian)
    if laplacian is not None and doubt < over_spline.rest[1] - over_spline.rest[0]:
        return _over_support(data, cells, tension, laplacian)
    return over_spline


def _refuse(data: Data) -> None:
    model = data.model
    unfit = None
    if not data.even_tension:
        unfit = "a tension that varies, or is not the same along x and y"
    elif model.ceiling is not None:
        unfit = "a ceiling"
    elif data.foundation is not None:
        unfit = "an elastic foundation"
    elif not np.isfinite(data.support.values[data.plan.points]).all():
        unfit = "parts without a support"
    if unfit:
        other = "" if data.plan.halved.any() else "; effort='energy' does"
        raise ValueError(
            f"{model!r}: effort='pointwise' encloses a membrane of one tension over one support, not one with {unfit}"
            f"{other}"
        )


def _laplacian(data: Data, *, at: str = "squares") -> Interval | None:
    """Return what holds Δf in each cell, or at each point, of a support as depths; None where it is not known."""
    plan, given = data.plan, data.model.given.get("support")
    shape = plan.squares.shape if at == "squares" else plan.nodes.shape
    if not isinstance(given, Ranged):
        depth = data.model.depth
        flat = data.support.straight and data.support.exact and (repeated(depth) or bool((depth == depth[0]).all()))
        values = data.support.values[plan.points]
        return Interval.of(np.zeros(shape)) if flat and (values == values[0]).all() else None
    bends = given.curvature(*(plan.around_squares if at == "squares" else plan.around_points))
    if bends is None:
        return None
    both = bends.xx + bends.yy
    both = -both if data.model.upwards and not isinstance(given, Profile) else both
    return Interval(np.broadcast_to(both.lower, shape), np.broadcast_to(both.upper, shape))


def _over_support(data: Data, cells: Cells, tension: float, laplacian: Interval) -> Posed:
    """Return the problem with q = p + TΔf."""
    held = _laplacian(data, at="points")
    assert held is not None
    with np.errstate(invalid="ignore"):
        bent = np.where(cells.corners, tension * (held.lower + (held.upper - held.lower) / 2), 0.0)
    load, support = _known(data, cells, "load"), _known(data, cells, "support")
    pressed = np.where(cells.corners, load.values, 0.0)
    corners = [extreme_at_corners(bent, extreme) for extreme in (np.maximum, np.minimum)]
    room = _SLACK * (float(np.abs(bent).max()) + float(np.abs(pressed).max()))
    load_range = (
        tension * laplacian.lower - corners[0] - load.below - room,
        tension * laplacian.upper - corners[1] + load.above + room,
    )
    bounds = _load_bounds(load, cells, tension, laplacian, room)
    sizes = float(np.abs(support.values).max(where=cells.corners, initial=0.0))
    heights, room = _heights(data, cells, np.where(cells.corners, support.values, 0.0), sizes)
    frame, own = _beside_chords(data, cells, "frame_height"), _beside_chords(data, cells, "support")
    height_range = -float((own[0] + frame[1]).max()) - room, float((own[1] + frame[0]).max()) + room
    problem = ObstacleProblem(cells, tension, pressed + bent, heights, load_range, height_range)
    return Posed(problem, support.values, _off_at_points(support, cells), bounds)


def _over_spline(data: Data, cells: Cells, tension: float, laplacian: Interval | None) -> Posed:
    """Return the problem over a spline through the support."""
    load, support = _known(data, cells, "load"), _known(data, cells, "support")
    corners = cells.corners
    values = np.where(corners, support.values, 0.0)
    floor = _spline_through(cells, values)
    # A spline that goes below the frame is raised, by which it is farther from the support.
    frame = np.where(corners, data.frame.values, 0.0)
    frame_below, frame_above = (float(side.max()) for side in _beside_chords(data, cells, "frame_height"))
    missing = frame_above - float(excess_along_rim(cells, floor, frame)[0].min())
    if missing > 0.0:
        floor = floor + missing * (1 + _SLACK)
    least, most = excess_on_cells(cells, floor, values)
    rest = -most - support.below, support.above - least
    off = _SLACK * (np.abs(rest[0]) + np.abs(rest[1]) + np.abs(least) + np.abs(most))
    rest = rest[0] - off, rest[1] + off
    on_floor, error = at_points(floor)
    sizes = float(np.abs(floor).max() + np.abs(frame).max())
    heights, room = _heights(data, cells, on_floor, sizes)
    along = excess_along_rim(cells, floor, on_floor)
    room += 2 * error
    height_range = float(along[0].min()) - frame_above - room, float(along[1].max()) + frame_below + room
    pressed = np.where(corners, load.values, 0.0)
    bend = floor[:-2, 1:-1] + floor[2:, 1:-1] + floor[1:-1, :-2] + floor[1:-1, 2:] - 4.0 * floor[1:-1, 1:-1]
    drive = np.where(corners, pressed + bend * (tension / cells.spacing**2), 0.0)
    problem = ObstacleProblem(
        *(cells, tension, pressed, heights),
        (-np.asarray(load.below), np.asarray(load.above)),
        height_range,
        floor,
        rest,
        drive,
        _kinks(cells, support, floor, values),
    )
    bounds = _load_bounds(load, cells, tension, laplacian, 0.0)
    return Posed(problem, on_floor, error + _off_at_points(support, cells), bounds)


def _kinks(cells: Cells, support: CellField, floor: Grid, values: Grid) -> Grid | None:
    """Return the floor's coefficients less the support's values at nodes of cells with kinks, zero elsewhere."""
    where = at_corners(_kinked(cells, support)) & cells.nodes
    return np.where(where, floor[1:-1, 1:-1] - values, 0.0) if where.any() else None


def _kinked(cells: Cells, support: CellField) -> Mask:
    """Return the cells in which a support has a kink."""
    return np.asarray(cells.inside & (np.isinf(support.bent_below) | np.isinf(support.bent_above)))


def _known(data: Data, cells: Cells, name: str) -> CellField:
    """Return load or support on all of the cells, halved ones among them."""
    field: CellField = getattr(data, name)
    return linear_on_halves(field, cells) if _linear(data, name, field) else field


def _linear(data: Data, name: str, field: CellField) -> bool:
    """Return whether a field is meant as the interpolant of its values at the points."""
    return not (callable(data.model.given.get(name)) and field.exact)


def _off_at_points(support: CellField, cells: Cells) -> float:
    """Return how far the support's values at the points may be off (length)."""
    return float(np.broadcast_to(support.rounding, cells.inside.shape).max(where=cells.inside, initial=0.0))


def _beside_chords(data: Data, cells: Cells, name: str) -> tuple[Grid, Grid]:
    """Return how far support or frame lie below and above chords of the rim in each cell, zero where is none."""
    field = data.support if name == "support" else data.frame
    edges = (data.plan.frame_edges > 0) & cells.whole
    beside = away_from_chords(field, cells, _linear(data, name, field))
    below, above = (
        np.where(edges, side, found) for side, found in zip((field.below, field.above), beside, strict=True)
    )
    return below, above


def _spline_through(cells: Cells, values: Grid) -> Grid:
    """Return the coefficients of a spline that goes through values at the points nearly, beyond the rim as it bends."""
    closure, rows = cells.closure, np.zeros_like(values)
    inner = cells.nodes[1:-1, 1:-1]
    around = values[:-2, 1:-1] + values[2:, 1:-1] + values[1:-1, :-2] + values[1:-1, 2:]
    rows[1:-1, 1:-1] = np.where(inner, around - 4.0 * values[1:-1, 1:-1], 0.0)
    # On the rim the sum of second differences is about that at the nodes next to it.
    known = cells.nodes.copy()
    bend = rows
    while (closure & ~known).any():
        weights = np.pad(known.astype(float), 1)
        sums = np.pad(np.where(known, bend, 0.0), 1)
        count = sum(weights[1 + i : weights.shape[0] - 1 + i, 1 + j : weights.shape[1] - 1 + j] for i, j in _EIGHT)
        total = sum(sums[1 + i : sums.shape[0] - 1 + i, 1 + j : sums.shape[1] - 1 + j] for i, j in _EIGHT)
        new = closure & ~known & (count > 0)
        bend = np.where(new, total / np.maximum(count, 1.0), bend)
        known |= new
    continuation = Continuation(cells)
    wide = continuation(values, bend, "less")
    inner_values = wide[1:-1, 1:-1]
    second = wide[:-2, 1:-1] + wide[2:, 1:-1] + wide[1:-1, :-2] + wide[1:-1, 2:] - 4.0 * inner_values
    return continuation(inner_values - second / 6.0, bend, "less")


_EIGHT = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]


def _load_bounds(
    load: CellField, cells: Cells, tension: float, laplacian: Interval | None, room: float
) -> tuple[Grid, Grid]:
    """Return bounds of p + TΔf in each cell."""
    shape = cells.inside.shape
    lower, upper = np.broadcast_to(load.range_lower, shape), np.broadcast_to(load.range_upper, shape)
    if laplacian is None:
        return np.full(shape, -np.inf), np.full(shape, np.inf)
    sizes = room + _SLACK * (np.abs(lower) + np.abs(upper))
    return lower + tension * laplacian.lower - sizes, upper + tension * laplacian.upper + sizes


def _heights(data: Data, cells: Cells, surface: Grid, sizes: float) -> tuple[Grid, float]:
    """Return γ = f - g at the points of the rim, zero elsewhere, and how far it may be off by rounding."""
    rim = cells.closure & ~cells.nodes
    frame = np.where(rim, data.frame.values, 0.0)
    heights, room = np.where(rim, surface - frame, 0.0), _ROOM * (sizes + float(np.abs(frame).max()))
    # A spline in the place of the support may have been raised to the frame; whether there is room the support tells.
    own = np.where(rim, data.support.values - frame, 0.0)
    if min(heights.min(), own.min()) < -room:
        raise ValueError(f"{data.model!r}: the support lies above the frame, which leaves no room for a membrane")
    _require_room(data, cells, (heights, own), room)
    return np.maximum(heights, 0.0), room


def _require_room(data: Data, cells: Cells, heights: tuple[Grid, Grid], room: float) -> None:
    """Refuse a support that is not known to leave room for the frame all along its slanted sides.

    The heights at the points are those of the problem's support above the frame, and of the membrane's own, which
    decides but where it has a kink.
    """
    if data.model.given.get("support") is data.model.given.get("frame_height", 0.0):
        return
    below = _beside_chords(data, cells, "support")[0] + _beside_chords(data, cells, "frame_height")[1]
    bent = _kinked(cells, data.support)
    for edges in cells.slanted:
        cell = edges.row, edges.column - (edges.step[1] < 0)
        posed, own = (np.minimum(*(one[place] for place in edges.ends)) for one in heights)
        if (np.where(bent[cell], posed, own) - below[cell] < -room).any():
            raise ValueError(
                f"{data.model!r}: the support is not known to leave room for the frame along its slanted sides, "
                "between points of the lattice: take a finer lattice, or move them apart"
            )
