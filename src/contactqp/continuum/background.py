"""Background: a sum of harmonic functions about corners, which is added to a spline.

A barrier s + b, with b harmonic in the region, has the Laplacian of s alone, see `contactqp.continuum.contour_problem`;
b counts where values do, in squares and along the contour, where it is enclosed: see
`contactqp.continuum.corner_on_lattice`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Vector
from ..foundation.rounding import UNDERFLOW, gamma
from ..geometry.numbering import Grid
from .contour import Contour
from .contour_rim import ContourRim
from .corner_functions import CornerFunction
from .corner_on_lattice import CornerOnLattice

_ERROR = gamma(64)


@dataclass(frozen=True, eq=False)
class Background:
    """A sum of functions about corners of a contour, b.

    Attributes
    ----------
    contour : Contour
    parts : tuple of CornerOnLattice
    factors : array
        One for each (length).
    """

    contour: Contour
    parts: tuple[CornerOnLattice, ...]
    factors: Vector

    @classmethod
    def nothing_of(cls, contour: Contour, functions: Iterable[CornerFunction]) -> Background:
        """Return the sum of some functions with all factors zero."""
        parts = tuple(CornerOnLattice(contour, function) for function in functions)
        return cls(contour, parts, np.zeros(len(parts)))

    def with_factors(self, factors: Vector) -> Background:
        """Return another sum of the same functions."""
        return replace(self, factors=factors)

    @property
    def functions(self) -> list[CornerFunction]:
        """The functions."""
        return [part.function for part in self.parts]

    @cached_property
    def coefficients(self) -> Grid:
        """Coefficients of the spline Qb that follows b, shape (rows + 4, columns + 4), length."""
        rows, columns = self.contour.inside.shape
        return self._sum(np.zeros((rows + 3, columns + 3)), self.factors, [part.spline for part in self.parts])

    @property
    def at_points(self) -> Grid:
        """B at the points, shape (rows + 2, columns + 2), length."""
        return self.coefficients[1:-1, 1:-1]

    @cached_property
    def points_error(self) -> Grid:
        """How far that may be off (length)."""
        rows, columns = self.contour.inside.shape
        parts = [part.points_error for part in self.parts]
        return self._error(np.zeros((rows + 1, columns + 1)), parts)

    @cached_property
    def beside(self) -> Grid:
        """How far b may lie from Qb in each square, infinite in hidden ones, shape (rows + 1, columns + 1), length."""
        parts = [np.where(part.hidden, np.inf, part.beside) for part in self.parts]
        return self._error(np.zeros(self.contour.inside.shape), parts)

    @cached_property
    def hidden(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Rows and columns of the squares in which Qb does not follow b."""
        row, column = np.nonzero(np.isinf(self.beside) & self.contour.inside)
        return row, column

    def ranges_in_hidden(self, coefficients: Grid) -> tuple[Vector, Vector]:
        """Return what a spline with b added lies between in each of the `hidden` squares (length).

        The spline lies between the least and the largest of sixteen coefficients, with those of Qb for the functions
        that it follows there; of others, all that counts is how large they are at most.
        """
        row, column = self.hidden
        places = [(row + i, column + j) for i in range(4) for j in range(4)]
        block = np.stack([coefficients[place] for place in places])
        room = np.zeros(row.size)
        for part, factor in zip(self.parts, self.factors, strict=True):
            own = np.stack([part.spline[place] for place in places])
            block = block + np.where(part.hidden[row, column], 0.0, factor * own)
            room += abs(factor) * part.beside[row, column]
        room = room * (1 + _ERROR) + _ERROR * np.abs(block).max(axis=0) + UNDERFLOW
        return block.min(axis=0) - room, block.max(axis=0) + room

    @cached_property
    def along(self) -> ContourRim:
        """What b is known to lie between along the contour."""
        middle, off = np.zeros((3, self.contour.size)), np.zeros(self.contour.size)
        for part, factor in zip(self.parts, self.factors, strict=True):
            parabola, beside = part.along
            middle = middle + factor * parabola
            off = off + abs(factor) * (beside + _ERROR * np.abs(parabola).max(axis=0))
        off = off * (1 + _ERROR) + UNDERFLOW
        return ContourRim(self.contour, middle - off, middle + off)

    @staticmethod
    def _sum(start: Grid, factors: Vector, parts: list[Grid]) -> Grid:
        for factor, part in zip(factors, parts, strict=True):
            if factor:
                start = start + factor * part
        return start

    def _error(self, start: Grid, parts: list[Grid]) -> Grid:
        return self._sum(start, np.abs(self.factors), parts) * (1 + _ERROR) + UNDERFLOW
