r"""A model's membrane posed as an `ObstacleProblem`, its data known on every cell.

Where the second derivatives of the support f are known to lie in narrow ranges, as those of planes and paraboloids are,
q = p + TΔf is known on every cell. Otherwise f is replaced by a spline F that goes through it nearly, with
a ≤ f - F ≤ b. Deflections depend on their support monotonically, and no more than it changes: with w_F that over F,

.. math:: w_F + \min(a, 0) ≤ w_f ≤ w_F + \max(b, 0).

(For f ≤ F + b, and w_F + max(b, 0) is no less than the frame and has at least the load's curvature where it does not
rest on F + b; likewise from below with the roles changed.) That with the smaller uncertainty is taken.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..foundation.checks import repeated
from ..foundation.intervals import Interval
from ..foundation.rounding import UNIT_ROUNDOFF
from ..foundation.surfaces import Ranged
from ..geometry.numbering import Grid
from ..profiles.analytic import Profile
from .cells import Cells, extreme_at_corners
from .data import Data
from .ghosts import Continuation
from .obstacle import ObstacleProblem
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
        How far the numbers in ``surface`` may be from it (length).
    rest : (float, float)
        Least and largest of the membrane's support less the problem's (length).
    load : pair of arrays, shape (rows + 1, columns + 1)
        Bounds of q = p + TΔf in each cell (force per area).
    """

    problem: ObstacleProblem
    surface: Grid
    surface_error: float
    rest: tuple[float, float]
    load: tuple[Grid, Grid]

    @property
    def data_part(self) -> float:
        """How far bounds may be apart because data are known up to a range between the nodes (length)."""
        problem = self.problem
        apart = np.asarray(problem.load_range[1]) - np.asarray(problem.load_range[0])
        apart = np.broadcast_to(apart, problem.cells.inside.shape)
        loads = float(apart.max(where=problem.cells.inside, initial=0.0)) * problem.largest_height
        return loads + (problem.height_range[1] - problem.height_range[0]) + (self.rest[1] - self.rest[0])

    @property
    def gap_moves(self) -> tuple[float, float]:
        """What is added to a lower and to an upper bound of the problem's gap for one of the membrane's (length)."""
        least, most = self.rest
        return least - max(most, 0.0), most - min(least, 0.0)

    @property
    def deflection_moves(self) -> tuple[float, float]:
        """What is added to a lower and to an upper bound of the deflection over the problem's support (length)."""
        least, most = self.rest
        return min(least, 0.0), max(most, 0.0)


def posed_of(data: Data) -> Posed:
    """Return the obstacle problem of a model's membrane.

    Raises
    ------
    ValueError
        If it is not one over one support, of constant tension, on a frame along lines of the lattice.
    """
    _refuse(data)
    cells = Cells(data.model.lattice.mask, data.model.lattice.spacing)
    tension = float(data.model.tension)
    laplacian = _laplacian(data)
    sizes = float(np.abs(data.support.values).max(where=cells.closure, initial=0.0))
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
    if not model.tension_of_arms.constant or isinstance(model.tension, tuple):
        unfit = "a tension that varies, or is not the same along x and y"
    elif model.ceiling is not None:
        unfit = "a ceiling"
    elif data.foundation is not None:
        unfit = "an elastic foundation"
    elif not np.isfinite(data.support.values[data.plan.points]).all():
        unfit = "parts without a support"
    if unfit:
        raise ValueError(
            f"{model!r}: effort='pointwise' encloses a membrane of one tension over one support, not one with {unfit}; "
            "effort='energy' does"
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
        bent = np.where(cells.closure, tension * (held.lower + (held.upper - held.lower) / 2), 0.0)
    pressed = np.where(cells.closure, data.load.values, 0.0)
    corners = [extreme_at_corners(bent, extreme) for extreme in (np.maximum, np.minimum)]
    room = _SLACK * (float(np.abs(bent).max()) + float(np.abs(pressed).max()))
    load_range = (
        tension * laplacian.lower - corners[0] - data.load.below - room,
        tension * laplacian.upper - corners[1] + data.load.above + room,
    )
    load = pressed + bent
    bounds = _load_bounds(data, tension, laplacian, room)
    support, frame = data.support, data.frame
    edges = data.plan.frame_edges > 0
    sizes = float(np.abs(support.values).max(where=cells.closure, initial=0.0))
    heights, room = _heights(data, np.where(cells.closure, support.values, 0.0), sizes)
    height_range = (
        -float((support.below + frame.above).max(where=edges, initial=0.0)) - room,
        float((support.above + frame.below).max(where=edges, initial=0.0)) + room,
    )
    problem = ObstacleProblem(cells, tension, load, heights, load_range, height_range)
    error = float(np.broadcast_to(support.rounding, cells.inside.shape).max(where=cells.inside, initial=0.0))
    return Posed(problem, support.values, error, (0.0, 0.0), bounds)


def _over_spline(data: Data, cells: Cells, tension: float, laplacian: Interval | None) -> Posed:
    """Return the problem over a spline through the support."""
    support, closure = data.support, cells.closure
    values = np.where(closure, support.values, 0.0)
    floor = _spline_through(cells, values)
    least, most = excess_on_cells(cells, floor, values)
    rest = float((-most - support.below)[cells.inside].min()), float((support.above - least)[cells.inside].max())
    on_floor, error = at_points(floor)
    # A spline that goes below the frame is raised, by which it is farther from the support.
    frame, edges = np.where(closure, data.frame.values, 0.0), data.plan.frame_edges > 0
    frame_above = float(np.asarray(data.frame.above).max(where=edges, initial=0.0))
    frame_below = float(np.asarray(data.frame.below).max(where=edges, initial=0.0))
    missing = frame_above - float(excess_along_rim(cells, floor, frame)[0].min())
    if missing > 0.0:
        floor = floor + missing * (1 + _SLACK)
        on_floor, error = at_points(floor)
        off = _SLACK * float(np.abs(floor).max())
        rest = rest[0] - missing * (1 + 2 * _SLACK) - off, rest[1] - missing + off
    sizes = float(np.abs(floor).max() + np.abs(frame).max())
    heights, room = _heights(data, on_floor, sizes)
    along = excess_along_rim(cells, floor, on_floor)
    room += 2 * error
    height_range = float(along[0].min()) - frame_above - room, float(along[1].max()) + frame_below + room
    pressed = np.where(closure, data.load.values, 0.0)
    bend = floor[:-2, 1:-1] + floor[2:, 1:-1] + floor[1:-1, :-2] + floor[1:-1, 2:] - 4.0 * floor[1:-1, 1:-1]
    drive = np.where(closure, pressed + bend * (tension / cells.spacing**2), 0.0)
    problem = ObstacleProblem(
        *(cells, tension, pressed, heights),
        (-np.asarray(data.load.below), np.asarray(data.load.above)),
        height_range,
        floor,
        drive,
    )
    bounds = _load_bounds(data, tension, laplacian, 0.0)
    return Posed(problem, on_floor, error, rest, bounds)


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


def _load_bounds(data: Data, tension: float, laplacian: Interval | None, room: float) -> tuple[Grid, Grid]:
    """Return bounds of p + TΔf in each cell."""
    inside = data.plan.squares
    lower = np.broadcast_to(data.load.range_lower, inside.shape)
    upper = np.broadcast_to(data.load.range_upper, inside.shape)
    if laplacian is None:
        return np.full(inside.shape, -np.inf), np.full(inside.shape, np.inf)
    sizes = room + _SLACK * (np.abs(lower) + np.abs(upper))
    return lower + tension * laplacian.lower - sizes, upper + tension * laplacian.upper + sizes


def _heights(data: Data, surface: Grid, sizes: float) -> tuple[Grid, float]:
    """Return γ = f - g at the points of the rim, zero elsewhere, and how far it may be off by rounding."""
    rim = data.plan.frame
    frame = np.where(rim, data.frame.values, 0.0)
    heights, room = np.where(rim, surface - frame, 0.0), _ROOM * (sizes + float(np.abs(frame).max()))
    if heights.min() < -room:
        raise ValueError(f"{data.model!r}: the support lies above the frame, which leaves no room for a membrane")
    return np.maximum(heights, 0.0), room
