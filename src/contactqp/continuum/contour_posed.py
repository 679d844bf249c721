"""A model's membrane within a contour that cuts the squares of its lattice anywhere, posed as a `ContourProblem`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..foundation.checks import Mask
from ..geometry.numbering import Grid
from .background import Background
from .contour_cells import ContourCells
from .contour_heights import depths_along
from .contour_layer import Layer, second_differences
from .contour_problem import ContourProblem
from .contour_rim import ContourRim
from .corner_functions import CornerFunction, corner_functions
from .data import Data
from .ghosts import about
from .obstacle import Range

_NEAR = 1e-6
"""Points that are so near to the contour, in spacings, may lie in the region."""

_ROOM = 1e-13
"""A support may lie above the frame by this part of the largest height: that is rounding."""


@dataclass(frozen=True, eq=False)
class ContourFrame:
    """The frame of a membrane whose contour cuts squares, and what its problem is.

    That the support leaves room for the frame, without which there is no membrane, is asked at the ends of the pieces
    of the contour, and taken for granted between them.

    Attributes
    ----------
    data : Data
    cells : ContourCells
    plainly : bool
        Whether nothing is to be made of what is known of the membrane at corners.

    Raises
    ------
    ValueError
        If the support is found to lie above the frame.
    """

    data: Data
    cells: ContourCells
    plainly: bool = False

    @property
    def plain(self) -> bool:
        """Whether it is posed as it is plainly: of a frame along the lattice, by the lattice's points."""
        return self.plainly or not (self.data.plan.on_lattice or self._functions)

    @property
    def knows_corners(self) -> bool:
        """Whether functions are known of all corners that point inwards."""
        known = {function.corner for function in self._functions}
        return all(corner in known for corner in self.cells.outline.inward_corners)

    def above_support(self, tension: float, load: Grid, load_range: Range) -> ContourProblem:
        """Return the problem whose gaps are counted from the support itself."""
        heights = self._require_room()
        # Where there is a membrane there is room for its frame, however little is known of it.
        lower = np.where((heights.lower <= 0.0).all(axis=0), 0.0, heights.lower)
        heights = ContourRim(heights.contour, lower, np.maximum(heights.upper, 0.0))
        return ContourProblem(
            self.cells,
            tension,
            load,
            self._none,
            load_range,
            rim=heights,
            held=self._held,
            springs=self._springs,
            background=self._background,
        )

    def floor(self, values: Grid) -> Grid:
        """Return the coefficients of a spline that goes through values at the corners of the cells nearly."""
        known = self.cells.corners
        inner = known.copy()
        inner[1:-1, 1:-1] &= known[:-2, 1:-1] & known[2:, 1:-1] & known[1:-1, :-2] & known[1:-1, 2:]
        known = np.pad(inner, 1)
        coefficients = np.pad(np.where(inner, values - np.pad(second_differences(values) / 6.0, 1), 0.0), 1)
        # Beside the coefficients that are known it goes through the values that are, at corners of squares.
        row, column = np.nonzero(self.cells.corners & ~inner)
        layer = Layer(
            known=known,
            reached=about(np.pad(self.cells.corners, 1)),
            focus=np.zeros_like(known),
            away=np.zeros(known.shape),
            asked=np.zeros_like(inner),
            row=row,
            column=column,
            place=np.zeros((2, row.size)),
        )
        layer.fill(coefficients, np.zeros(0), values[row, column])
        return coefficients

    def above_floor(
        self, tension: float, load: Grid, load_range: Range, floor: Grid, rest: Range, drive: Grid, kinks: Grid | None
    ) -> ContourProblem:
        """Return the problem whose gaps are counted from a spline in the place of the support."""
        self._require_room()
        parts = self.cells, tension, load, self._none, load_range, (0.0, 0.0), floor, rest, drive, kinks
        return ContourProblem(
            *parts, rim=-self._frame, held=self._held, springs=self._springs, background=self._background
        )

    @property
    def _none(self) -> Grid:
        return np.zeros(self.cells.nodes.shape)

    @cached_property
    def _frame(self) -> ContourRim:
        return depths_along(self.data, self.cells.contour, "frame_height")

    def _require_room(self) -> ContourRim:
        """Return the support less the frame's height along the contour, refuse one that is seen to be negative."""
        contour = self.cells.contour
        support = depths_along(self.data, contour, "support")
        room = support + -self._frame
        sizes = np.abs(support.lower) + np.abs(self._frame.upper)
        below = room.upper < -_ROOM * np.where(np.isfinite(sizes), sizes, 0.0)
        if below.any():
            end, piece = np.argwhere(below)[0]
            x, y = contour.places((contour.start, (contour.start + contour.end) / 2, contour.end)[end])
            raise ValueError(
                f"{self.data.model!r}: the frame at x={x[piece]:g}, y={y[piece]:g} lies beyond the support, by "
                f"{-room.upper[end, piece]:.3g}: no membrane can be held there; the support must leave room for the "
                "frame"
            )
        return room

    @cached_property
    def _held(self) -> Mask:
        """Which points lie in the region, or next to its contour by rounding."""
        plan = self.data.plan
        found = self.cells.points.copy()
        row, column = np.nonzero(self.cells.corners & ~found)
        near = _NEAR * plan.spacing
        found[row, column] = self.cells.outline.nearly_holds(*plan.lattice.ring_coordinates(row, column), near)
        return found

    @property
    def _springs(self) -> Grid:
        arms = self.data.model.lattice.frame_arms
        found = self._none
        np.add.at(found, (arms.node_row, arms.node_column), float(self.data.model.tension) / arms.length)
        return found

    @property
    def _background(self) -> Background:
        return Background.nothing_of(self.cells.contour, [] if self.plainly else self._functions)

    @cached_property
    def _functions(self) -> list[CornerFunction]:
        return corner_functions(self.cells.outline, self.data.plan.spacing)
