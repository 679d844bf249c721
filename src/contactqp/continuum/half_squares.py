"""Half squares: those squares of a plan that a frame halves along a diagonal, and the places of their corners."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask
from ..geometry.numbering import Grid

CORNERS = ((0, 0), (0, 1), (1, 1), (1, 0))
"""Where a corner of a square lies: rows and columns beyond the first, counterclockwise if y goes up."""


class HalfSquares(NamedTuple):
    """Squares that are halved alike: the node A is at the same corner, and B and C next to it lie on the frame.

    The half is the triangle ABC. It consists of the quarter of the square at A, and of two triangles with legs h/2 that
    belong to B and to C, whose right angles are in the middles of AB and AC.

    Attributes
    ----------
    row, column : array of int, shape (n,)
        Places of the squares.
    corner : int
        Which of a square's `CORNERS` is A. B is the one beside it along x, C along y.
    """

    row: NDArray[np.intp]
    column: NDArray[np.intp]
    corner: int

    @property
    def place(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Rows and columns of the squares."""
        return self.row, self.column

    @property
    def corners(self) -> tuple[int, int, int]:
        """Which of a square's corners are A, B and C."""
        down, right = CORNERS[self.corner]
        return self.corner, CORNERS.index((down, 1 - right)), CORNERS.index((1 - down, right))

    @property
    def outwards(self) -> tuple[float, float]:
        """Whether B lies beyond A along x, and C along y, 1, or before it, -1."""
        down, right = CORNERS[self.corner]
        return 1.0 - 2.0 * right, 1.0 - 2.0 * down

    @property
    def step(self) -> tuple[int, int]:
        """How far the diagonal goes along x and y, upwards: it falls if the node is below it on the left, or above."""
        return (-1 if self.outwards[0] == self.outwards[1] else 1), 1

    def of(self, points: Grid) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return what an array of points has at A, B and C."""
        at_a, at_b, at_c = (
            points[self.row + CORNERS[corner][0], self.column + CORNERS[corner][1]] for corner in self.corners
        )
        return at_a, at_b, at_c


def half_squares(halved: Mask, nodes: Mask) -> tuple[HalfSquares, ...]:
    """Return the squares that are halved, together where their nodes are at the same corner."""
    rows, columns = halved.shape
    found = []
    for corner, (down, right) in enumerate(CORNERS):
        row, column = np.nonzero(halved & nodes[down : down + rows, right : right + columns])
        if row.size:
            found.append(HalfSquares(row, column, corner))
    return tuple(found)
