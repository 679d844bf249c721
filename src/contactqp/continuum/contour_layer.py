r"""Coefficients next to a contour that cuts the squares of a lattice anywhere: those of least squares.

Any numbers there make a spline, and what is proven of it does not depend on where they come from. Near the contour and
beyond it they are chosen so that, as nearly as they can,

* h²Δs at points of the lattice is what is wanted there, where with c for the coefficients

.. math:: h² Δs = \tfrac16 \sum_{j} (1, 4, 1)_j (δ_x^2 c)_{\cdot j} + \tfrac16 \sum_{i} (1, 4, 1)_i (δ_y^2 c)_{i \cdot},

* s is what is wanted on the contour, halfway on each of its pieces, and
* third differences along rows and columns are small.

The first counts most: what is missed of the Laplacian makes a bound worse by d²/8h² times as much as what is missed of
the height.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..foundation.loading import load_modules
from ..geometry.numbering import Grid

_OF_LAPLACIAN, _OF_HEIGHT, _OF_ROUGHNESS = 10.0, 1.0, 0.1
"""What an equation of each kind is multiplied by."""

_DOUBTFUL, _FAR = 2.0, 12.0
"""Nearer to a corner, in spacings, a lattice's answer tells little of it, and from there on all the more."""

_LAPLACIAN = np.array([[2, 2, 2], [2, -16, 2], [2, 2, 2]]) / 6.0
_ROUGHNESS = np.array([-1.0, 3.0, -3.0, 1.0])


Rows: TypeAlias = tuple[NDArray[np.intp], NDArray[np.float64]]
"""Equations: places of coefficients, counted flat, and their weights, both of shape (equations, coefficients)."""


@dataclass(frozen=True, eq=False)
class Layer:
    """The coefficients next to a contour.

    Attributes
    ----------
    known, reached : array of bool, shape (rows + 4, columns + 4)
        Where coefficients are given, and where there are any.
    focus : array of bool, shape (rows + 4, columns + 4)
        Where coefficients are given, and yet are to be smooth.
    away : array, shape (rows + 4, columns + 4)
        How far places are from the nearest corner that functions belong to (spacings).
    asked : array of bool, shape (rows + 2, columns + 2)
        Points at which it is known what Laplacian is wanted.
    row, column : array of int, shape (k,)
        The square that each of some places on the contour lies in.
    place : array, shape (2, k)
        Where in it they are, along x and along y.
    """

    known: Mask
    reached: Mask
    focus: Mask
    away: Grid
    asked: Mask
    row: NDArray[np.intp]
    column: NDArray[np.intp]
    place: NDArray[np.float64]

    @cached_property
    def _unknown(self) -> NDArray[np.intp]:
        return np.flatnonzero(self.reached & ~self.known)

    @cached_property
    def points(self) -> NDArray[np.intp]:
        """Points at which the Laplacian is asked for, counted flat on the array of points."""
        complete = _all_about(self.reached)[1:-1, 1:-1]
        open_places = ~_all_about(self.known | ~self.reached)[1:-1, 1:-1]
        return np.flatnonzero(complete & open_places & self.asked)

    @cached_property
    def _equations(self) -> tuple[Any, Any, Any]:
        """The matrix of all equations by given coefficients, that by unknown ones, and the factors of its square."""
        load_modules("scipy.sparse.linalg")
        from scipy.sparse import csr_array
        from scipy.sparse.linalg import splu

        parts = [self._of_laplacian(), self._of_heights(), self._of_roughness()]
        count = sum(len(places) for places, _ in parts)
        number = np.repeat(np.arange(count), np.concatenate([np.full(len(p), p.shape[1]) for p, _ in parts]))
        place = np.concatenate([places.ravel() for places, _ in parts])
        weight = np.concatenate([weights.ravel() for _, weights in parts])
        whole = csr_array((weight, (number, place)), shape=(count, self.known.size))
        own = whole[:, self._unknown]
        square = (own.T @ own).tocsc()
        square.setdiag(square.diagonal() + 1e-12)
        return whole, own, splu(square)

    @cached_property
    def _trust(self) -> Vector:
        """Weights of the equations for what is far from corners, next to which the lattice's answer is off."""
        parts = [self._of_laplacian(), self._of_heights(), self._of_roughness()]
        far = np.concatenate([self.away.reshape(-1)[places].min(axis=1) for places, _ in parts])
        return np.where(far < _DOUBTFUL, 0.0, np.minimum(far, _FAR))

    def _of_laplacian(self) -> Rows:
        width = self.known.shape[1]
        row, column = np.divmod(self.points, width - 2)
        i, j = np.divmod(np.arange(9), 3)
        places = (row[:, None] + i) * width + column[:, None] + j
        return places, np.broadcast_to(_OF_LAPLACIAN * _LAPLACIAN.ravel(), places.shape)

    def _of_heights(self) -> Rows:
        width = self.known.shape[1]
        i, j = np.divmod(np.arange(16), 4)
        places = (self.row[:, None] + i) * width + self.column[:, None] + j
        along_x, along_y = (_basis(place) for place in self.place)
        return places, _OF_HEIGHT * along_y[:, i] * along_x[:, j]

    def _of_roughness(self) -> Rows:
        flat, unknown = self.reached.ravel(), (self.reached & (~self.known | self.focus)).ravel()
        found = []
        for step in (1, self.known.shape[1]):
            first = np.arange(flat.size - 3 * step)
            whole = np.logical_and.reduce([flat[first + k * step] for k in range(4)])
            some = np.logical_or.reduce([unknown[first + k * step] for k in range(4)])
            found.append(first[whole & some][:, None] + step * np.arange(4))
        places = np.concatenate(found)
        return places, np.broadcast_to(_OF_ROUGHNESS * _ROUGHNESS, places.shape)

    def fill(self, coefficients: Grid, laplacian: Vector, heights: Vector) -> None:
        """Write the unknown coefficients.

        Parameters
        ----------
        coefficients : array, shape (rows + 4, columns + 4)
        laplacian : array
            h²Δs that is wanted at `points`; empty if none is.
        heights : array, shape (k,)
            s that is wanted on the contour.
        """
        _, own, factors = self._equations
        flat = coefficients.reshape(-1)
        flat[self._unknown] = factors.solve(own.T @ self._left(coefficients, laplacian, heights))

    def _left(self, coefficients: Grid, laplacian: Vector, heights: Vector) -> Vector:
        """Return what is missed of all equations if the unknown coefficients are zero."""
        flat = np.where(self.known, coefficients, 0.0).reshape(-1)
        left = -(self._equations[0] @ flat)
        left[: laplacian.size] += _OF_LAPLACIAN * laplacian
        left[laplacian.size : laplacian.size + heights.size] += _OF_HEIGHT * heights
        return np.asarray(left)

    def shares(
        self, functions: list[tuple[Grid, Vector]], coefficients: Grid, laplacian: Vector, heights: Vector
    ) -> Vector:
        """Return how much of some functions to take away from a spline, so that the rest fits best.

        Parameters
        ----------
        functions : list of (array, array)
            Their coefficients, and what they are on the contour.
        coefficients, laplacian, heights
            See `fill`.
        """
        if not functions:
            return np.zeros(0)
        _, own, factors = self._equations
        none = np.zeros(laplacian.size)
        columns = np.stack([self._left(one, none, on_contour) for one, on_contour in functions], axis=1)
        left = self._left(coefficients, laplacian, heights)
        # What the unknown coefficients can take up is no reason for a function.
        columns, left = (part - own @ factors.solve(np.asarray(own.T @ part)) for part in (columns, left))
        columns, left = columns * self._trust[:, None], left * self._trust
        sizes = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
        found, *_ = np.linalg.lstsq(columns / sizes, left, rcond=1e-10)
        return np.asarray(found / sizes)


def second_differences(values: Grid) -> Grid:
    """Return the sum of the second differences along rows and columns at inner points, shape (rows, columns)."""
    around = (values[:-2, 1:-1] + values[2:, 1:-1]) + (values[1:-1, :-2] + values[1:-1, 2:])
    return np.asarray(around - 4.0 * values[1:-1, 1:-1])


def _all_about(points: Mask) -> Mask:
    """Return the points that are, with the eight about each, among some."""
    found = np.zeros_like(points)
    rows = points[:-2] & points[1:-1] & points[2:]
    found[1:-1, 1:-1] = rows[:, :-2] & rows[:, 1:-1] & rows[:, 2:]
    return found


def _basis(part: Vector) -> NDArray[np.float64]:
    """Return the weights of four coefficients in a cubic spline's value at parts of the way between two points."""
    back = 1.0 - part
    middle = [(4.0 - 6.0 * t * t + 3.0 * t**3) for t in (part, back)]
    return np.column_stack([back**3, *middle, part**3]) / 6.0
