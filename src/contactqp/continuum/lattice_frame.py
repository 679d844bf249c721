"""A model's frame along lines of its lattice and diagonals of its squares, and the `ObstacleProblem` within it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..foundation.checks import Mask
from ..foundation.rounding import UNIT_ROUNDOFF
from ..geometry.numbering import Grid
from .cell_fields import CellField
from .cells import Cells
from .data import Data
from .ghosts import Continuation
from .halves import away_from_chords, linear_on_halves
from .obstacle import ObstacleProblem, Range
from .splines import at_points, excess_along_rim

_SLACK = 16 * UNIT_ROUNDOFF

_ROOM = 1e-13
"""A support may lie above the frame by this part of the largest height: that is rounding."""


@dataclass(frozen=True, eq=False)
class LatticeFrame:
    """The frame of a membrane along lines and diagonals of its lattice, and what its problem is.

    Attributes
    ----------
    data : Data
    cells : Cells
    """

    data: Data
    cells: Cells

    plain: ClassVar[bool] = True
    """It is posed in no other way."""

    def above_support(self, tension: float, load: Grid, load_range: Range) -> ObstacleProblem:
        """Return the problem whose gaps are counted from the support itself.

        Parameters
        ----------
        tension, load, load_range
            See `ObstacleProblem`.

        Raises
        ------
        ValueError
            If the support is not known to leave room for the frame.
        """
        data, cells = self.data, self.cells
        support = known_on_cells(data, cells, "support").values
        sizes = float(np.abs(support).max(where=cells.corners, initial=0.0))
        heights, room = _heights(data, cells, np.where(cells.corners, support, 0.0), sizes)
        frame, own = _beside_chords(data, cells, "frame_height"), _beside_chords(data, cells, "support")
        height_range = -float((own[0] + frame[1]).max()) - room, float((own[1] + frame[0]).max()) + room
        return ObstacleProblem(cells, tension, load, heights, load_range, height_range)

    def floor(self, values: Grid) -> Grid:
        """Return the coefficients of a spline through values at the points nearly, that is not below the frame.

        Where it would be it is raised, by which it is farther from the support.
        """
        cells = self.cells
        floor = _spline_through(cells, values)
        frame = np.where(cells.corners, self.data.frame.values, 0.0)
        above = float(_beside_chords(self.data, cells, "frame_height")[1].max())
        missing = above - float(excess_along_rim(cells, floor, frame)[0].min())
        return floor + missing * (1 + _SLACK) if missing > 0.0 else floor

    def above_floor(
        self, tension: float, load: Grid, load_range: Range, floor: Grid, rest: Range, drive: Grid, kinks: Grid | None
    ) -> ObstacleProblem:
        """Return the problem whose gaps are counted from a spline in the place of the support.

        Parameters
        ----------
        tension, load, load_range, floor, rest, drive, kinks
            See `ObstacleProblem`.

        Raises
        ------
        ValueError
            If the support is not known to leave room for the frame.
        """
        data, cells = self.data, self.cells
        on_floor, error = at_points(floor)
        frame = np.where(cells.corners, data.frame.values, 0.0)
        below, above = (float(side.max()) for side in _beside_chords(data, cells, "frame_height"))
        sizes = float(np.abs(floor).max() + np.abs(frame).max())
        heights, room = _heights(data, cells, on_floor, sizes)
        along = excess_along_rim(cells, floor, on_floor)
        room += 2 * error
        height_range = float(along[0].min()) - above - room, float(along[1].max()) + below + room
        return ObstacleProblem(cells, tension, load, heights, load_range, height_range, floor, rest, drive, kinks)


def kinked(cells: Cells, support: CellField) -> Mask:
    """Return the cells in which a support has a kink."""
    return np.asarray(cells.inside & (np.isinf(support.bent_below) | np.isinf(support.bent_above)))


def known_on_cells(data: Data, cells: Cells, name: str) -> CellField:
    """Return load or support on all of the cells, halved ones among them."""
    field: CellField = getattr(data, name)
    return linear_on_halves(field, cells) if _linear(data, name, field) else field


def _linear(data: Data, name: str, field: CellField) -> bool:
    """Return whether a field is meant as the interpolant of its values at the points."""
    return not (callable(data.model.given.get(name)) and field.exact)


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
    bent = kinked(cells, data.support)
    for edges in cells.slanted:
        cell = edges.row, edges.column - (edges.step[1] < 0)
        posed, own = (np.minimum(*(one[place] for place in edges.ends)) for one in heights)
        if (np.where(bent[cell], posed, own) - below[cell] < -room).any():
            raise ValueError(
                f"{data.model!r}: the support is not known to leave room for the frame along its slanted sides, "
                "between points of the lattice: take a finer lattice, or move them apart"
            )
