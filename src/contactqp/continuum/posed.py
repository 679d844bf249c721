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

from ..foundation.checks import repeated
from ..foundation.intervals import Interval
from ..foundation.rounding import UNIT_ROUNDOFF
from ..foundation.surfaces import Ranged
from ..geometry.numbering import Grid
from ..profiles.analytic import Profile
from .cell_fields import CellField
from .cells import Cells, at_corners, extreme_at_corners
from .contour import Contour
from .contour_cells import ContourCells, outline_of
from .contour_posed import ContourFrame
from .data import Data
from .lattice_frame import LatticeFrame, kinked, known_on_cells
from .obstacle import ObstacleProblem
from .plan import ContourPlan
from .pointwise import PointwiseBounds
from .splines import at_points, excess_on_cells

_SLACK = 16 * UNIT_ROUNDOFF


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
    plain : bool
        Whether it is posed as it is plainly.
    """

    problem: ObstacleProblem
    surface: Grid
    surface_error: float
    load: tuple[Grid, Grid]
    plain: bool

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


def posed_of(data: Data, *, plainly: bool = False) -> Posed:
    """Return the obstacle problem of a model's membrane.

    Parameters
    ----------
    data : Data
    plainly : bool
        Whether nothing is to be made of what is known of the membrane at corners.

    Raises
    ------
    ValueError
        If it is not one over one support, of constant tension, on a frame along lines of the lattice and diagonals of
        its squares.
    """
    data = data.of_whole_squares
    _refuse(data)
    frame = _frame_of(data, plainly=plainly)
    cells = frame.cells
    tension = float(data.model.tension)
    laplacian = _laplacian(data)
    sizes = float(np.abs(data.support.values).max(where=cells.corners, initial=0.0))
    doubt = np.inf  # how far a membrane's gap moves by what is not known of the Laplacian
    if laplacian is not None:
        width = float((laplacian.upper - laplacian.lower).max(where=cells.inside, initial=0.0))
        doubt = width * (cells.strip[2] * cells.spacing) ** 2 / 8.0
    if laplacian is not None and doubt <= 1e-12 * sizes:
        return _over_support(data, frame, tension, laplacian)
    over_spline = _over_spline(data, frame, tension, laplacian)
    if laplacian is not None and doubt < over_spline.rest[1] - over_spline.rest[0]:
        return _over_support(data, frame, tension, laplacian)
    return over_spline


def _frame_of(data: Data, *, plainly: bool) -> LatticeFrame | ContourFrame:
    """Return the frame: of rectangles along the lattice, by its points; of others, by the pieces of its contour."""
    lattice, plan = data.model.lattice, data.plan
    if lattice.outline is not None and isinstance(plan, ContourPlan):
        return ContourFrame(data, ContourCells.of(lattice, lattice.outline, plan.contour), plainly=plainly)
    cells = Cells(lattice.mask, lattice.spacing, lattice.halved)
    if plainly or cells.rectangular:
        return LatticeFrame(data, cells)
    outline = outline_of(cells, lattice)
    contour = Contour.of(lattice, outline)
    frame = ContourFrame(data, ContourCells.of(lattice, outline, contour, lattice.halved))
    return frame if frame.knows_corners else LatticeFrame(data, cells)


def _refuse(data: Data) -> None:
    model = data.model
    unfit = None
    if not data.even_tension:
        unfit = "a tension that varies, or is not the same along x and y"
    elif model.ceiling is not None:
        unfit = "a ceiling"
    elif data.foundation is not None:
        unfit = "an elastic foundation"
    elif not np.isfinite(data.support.values[data.plan.asked]).all():
        unfit = "parts without a support"
    if unfit:
        other = "; effort='energy' does" if data.plan.on_lattice else ""
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


def _over_support(data: Data, frame: LatticeFrame | ContourFrame, tension: float, laplacian: Interval) -> Posed:
    """Return the problem with q = p + TΔf."""
    cells = frame.cells
    held = _laplacian(data, at="points")
    assert held is not None
    with np.errstate(invalid="ignore"):
        bent = np.where(cells.corners, tension * (held.lower + (held.upper - held.lower) / 2), 0.0)
    load, support = known_on_cells(data, cells, "load"), known_on_cells(data, cells, "support")
    pressed = np.where(cells.corners, load.values, 0.0)
    corners = [extreme_at_corners(bent, extreme) for extreme in (np.maximum, np.minimum)]
    room = _SLACK * (float(np.abs(bent).max()) + float(np.abs(pressed).max()))
    load_range = (
        tension * laplacian.lower - corners[0] - load.below - room,
        tension * laplacian.upper - corners[1] + load.above + room,
    )
    bounds = _load_bounds(load, cells, tension, laplacian, room)
    problem = frame.above_support(tension, pressed + bent, load_range)
    return Posed(problem, support.values, _off_at_points(support, cells), bounds, frame.plain)


def _over_spline(data: Data, frame: LatticeFrame | ContourFrame, tension: float, laplacian: Interval | None) -> Posed:
    """Return the problem over a spline through the support."""
    cells = frame.cells
    load, support = known_on_cells(data, cells, "load"), known_on_cells(data, cells, "support")
    corners = cells.corners
    values = np.where(corners, support.values, 0.0)
    floor = frame.floor(values)
    least, most = excess_on_cells(cells, floor, values)
    rest = -most - support.below, support.above - least
    off = _SLACK * (np.abs(rest[0]) + np.abs(rest[1]) + np.abs(least) + np.abs(most))
    rest = rest[0] - off, rest[1] + off
    on_floor, error = at_points(floor)
    pressed = np.where(corners, load.values, 0.0)
    bend = floor[:-2, 1:-1] + floor[2:, 1:-1] + floor[1:-1, :-2] + floor[1:-1, 2:] - 4.0 * floor[1:-1, 1:-1]
    drive = np.where(corners, pressed + bend * (tension / cells.spacing**2), 0.0)
    load_range = -np.asarray(load.below), np.asarray(load.above)
    kinks = _kinks(cells, support, floor, values)
    problem = frame.above_floor(tension, pressed, load_range, floor, rest, drive, kinks)
    bounds = _load_bounds(load, cells, tension, laplacian, 0.0)
    return Posed(problem, on_floor, error + _off_at_points(support, cells), bounds, frame.plain)


def _kinks(cells: Cells, support: CellField, floor: Grid, values: Grid) -> Grid | None:
    """Return the floor's coefficients less the support's values at nodes of cells with kinks, zero elsewhere."""
    where = at_corners(kinked(cells, support)) & cells.nodes
    return np.where(where, floor[1:-1, 1:-1] - values, 0.0) if where.any() else None


def _off_at_points(support: CellField, cells: Cells) -> float:
    """Return how far the support's values at the points may be off (length)."""
    return float(np.broadcast_to(support.rounding, cells.inside.shape).max(where=cells.inside, initial=0.0))


def _load_bounds(
    load: CellField, cells: Cells, tension: float, laplacian: Interval | None, room: float
) -> tuple[Grid, Grid]:
    """Return bounds of p + TΔf in each cell."""
    shape = cells.inside.shape
    lower, upper = np.broadcast_to(load.range_lower, shape), np.broadcast_to(load.range_upper, shape)
    if laplacian is None:
        return np.full(shape, -np.inf), np.full(shape, np.inf)
    sizes = room + _SLACK * (np.abs(lower) + np.abs(upper))
    with np.errstate(over="ignore"):  # beyond the frame a support may have no bends at all
        bent = tension * laplacian.lower, tension * laplacian.upper
    return lower + bent[0] - sizes, upper + bent[1] + sizes
