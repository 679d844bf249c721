"""How well a lattice fits a contour: how far the points that stand for the frame lie outside it."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..errors import ContactWarning
from ..foundation.checks import Mask
from ..foundation.outside import stacklevel_outside
from .cuts import fitted
from .lattice import Lattice
from .sides import Moved, Sides

_LOUD = 0.05
"""Growth of a width of the frame above which a lattice is warned of: deflections grow by twice as much."""

_TOLD = 4
"""Sides that a caution names."""

_LOOKED_AT = 100
"""Moved sides whose distance from the next one is looked at: a coast may have thousands."""


@dataclass(frozen=True, eq=False)
class FrameFit:
    """A lattice laid over a frame.

    Attributes
    ----------
    mask : array of bool, shape (rows, columns)
        The nodes.
    spacing : float
    origin : (float, float)
        Coordinates of ``mask[0, 0]`` (length).
    bounds : (float, float, float, float)
        Least x and y and largest x and y of the frame (length).
    sides : Sides
        Its straight sides.
    inside : callable
        Whether points lie inside the contour moved inwards by a margin.
    margin : float
        What counts as on the contour (length).
    """

    mask: Mask
    spacing: float
    origin: tuple[float, float]
    bounds: tuple[float, float, float, float]
    sides: Sides
    inside: Callable[[NDArray[np.float64], NDArray[np.float64], float], Mask]
    margin: float

    @cached_property
    def widths(self) -> tuple[float, float]:
        """Width and height of the frame as the lattice has it (length)."""
        columns, rows = (int(np.ptp(np.flatnonzero(self.mask.any(axis=axis)))) + 2 for axis in (0, 1))
        return self.spacing * columns, self.spacing * rows

    @property
    def growth(self) -> float:
        """By how much of its width or height the frame grows, whichever is more; 0 if it grows in neither."""
        left, bottom, right, top = self.bounds
        grown = max(self.widths[0] / (right - left), self.widths[1] / (top - bottom)) - 1
        return grown if grown > 1e-9 else 0.0

    @cached_property
    def moved(self) -> list[Moved]:
        """The sides along the axes that do not lie on the lattice, the farthest moved first."""
        return self.sides.moved(self.spacing, self.origin)

    @property
    def loudest(self) -> float:
        """By how much of a width the frame grows: of its own, or of that of an arm of it, whichever is more."""
        return max([self.growth, *(side.distance / self.sides.width(side) for side in self.moved[:_LOOKED_AT])])

    @property
    def overshoot(self) -> float:
        """How far outwards the contour must be moved to take in all points that stand for the frame (length)."""
        return self._farthest[0]

    @cached_property
    def _farthest(self) -> tuple[float, float, float]:
        """How far outside the contour a point that stands for the frame lies at most, and one that does, x and y."""
        padded = np.pad(self.mask, 1)
        beside = np.zeros_like(padded)
        beside[:-1] |= padded[1:]
        beside[1:] |= padded[:-1]
        beside[:, :-1] |= padded[:, 1:]
        beside[:, 1:] |= padded[:, :-1]
        x, y = self._places(beside & ~padded)

        def outside(distance: float) -> NDArray[np.intp]:
            return np.flatnonzero(~self.inside(x, y, -distance))

        low, high = 4 * self.margin, self.spacing
        last = outside(low)
        if not last.size:
            return 0.0, np.nan, np.nan
        while high - low > 1e-3 * self.spacing:
            middle = (low + high) / 2
            beyond = outside(middle)
            low, high, last = (middle, high, beyond) if beyond.size else (low, middle, last)
        return high, float(x[last[0]]), float(y[last[0]])

    @property
    def _slanted(self) -> bool:
        """Whether squares with a node at a corner have another one outside the contour."""
        padded = np.pad(self.mask, 1)
        squares = padded[1:, 1:] | padded[1:, :-1] | padded[:-1, 1:] | padded[:-1, :-1]
        corners = np.zeros_like(padded)
        for rows in (slice(None, -1), slice(1, None)):
            for columns in (slice(None, -1), slice(1, None)):
                corners[rows, columns] |= squares
        x, y = self._places(corners & ~padded)
        return not self.inside(x, y, -4 * self.margin).all()

    @property
    def _halved(self) -> Mask | None:
        """Which squares the contour halves along a diagonal, if it cuts no square otherwise; else None."""
        if self.overshoot or not self.sides.on_diagonals(self.spacing, self.origin):
            return None
        # The contour runs along lines and diagonals, so that it cuts no square but along those of its four quarters.
        nodes = np.pad(self.mask, 1)
        corners = np.stack([nodes[:-1, :-1], nodes[:-1, 1:], nodes[1:, 1:], nodes[1:, :-1]])
        quarters = np.ones_like(corners)
        beside = np.nonzero(~corners.all(axis=0))
        x, y = (
            np.float64(first) + np.float64(self.spacing) * (place - 0.5)
            for first, place in zip(self.origin, beside[::-1], strict=True)
        )
        third = self.spacing / 3
        for quarter, (right, up) in zip(quarters, ((0, -1), (1, 0), (0, 1), (-1, 0)), strict=True):
            quarter[beside] = self.inside(x + right * third, y + up * third, self.margin)
        node, whole, empty = corners.any(axis=0), quarters.all(axis=0), ~quarters.any(axis=0)
        # Corner k lies between the quarters k - 1 and k, counted about the square.
        here = corners & quarters & np.roll(quarters, 1, axis=0)
        halved = (corners.sum(axis=0) == 1) & (quarters.sum(axis=0) == 2) & here.any(axis=0)
        return halved if (halved | (node & whole) | (~node & empty)).all() else None

    def _places(self, padded: Mask) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return x and y of points that are chosen on the array with a ring about it (length)."""
        row, column = np.nonzero(padded)
        x = np.float64(self.origin[0]) + np.float64(self.spacing) * (column - 1)
        y = np.float64(self.origin[1]) + np.float64(self.spacing) * (row - 1)
        return x, y

    def lattice(self, crs: str) -> Lattice:
        """Return the lattice, in a coordinate reference system; a frame that grows is told of, if much by a warning."""
        caution = self._caution() if self.overshoot else ""
        slanted = self._slanted
        if caution and self.loudest > _LOUD:
            warnings.warn(caution, ContactWarning, stacklevel=stacklevel_outside())
        return Lattice(
            *(self.mask, self.spacing, self.origin),
            overshoot=self.overshoot,
            caution=caution,
            crs=crs,
            slanted=slanted,
            halved=self._halved if slanted else None,
        )

    def fitted_lattice(self, crs: str) -> Lattice:
        """Return the lattice whose arms end on the contour."""
        mask, cuts = fitted(self.mask, self.spacing, self.origin, self.inside, self.margin)
        if not mask.any():
            raise ValueError(f"all points of spacing {self.spacing:g} lie next to the contour: choose a smaller one")
        return Lattice(mask, self.spacing, self.origin, crs=crs, cuts=cuts)

    def _caution(self) -> str:
        distance, x, y = self._farthest
        told = f"with spacing {self.spacing:g} the frame lies up to {distance:.2g} outside its contour"
        if self.growth:
            left, bottom, right, top = self.bounds
            told += (
                f": it is {self.widths[0]:.4g} x {self.widths[1]:.4g} instead of {right - left:.4g} x "
                f"{top - bottom:.4g}, up to {_percent(self.growth)} wider"
            )
        if self.moved:
            more = f" and {len(self.moved) - _TOLD} more" if len(self.moved) > _TOLD else ""
            told += f"; sides: {', '.join(map(str, self.moved[:_TOLD]))}{more}"
        else:
            told += f"; most at x = {x:.6g}, y = {y:.6g}"
        return f"{told}; {self._remedy()}"

    def _remedy(self) -> str:
        """Return which spacings fit, in words."""
        fitting = self.sides.fitting(self.spacing)
        if any(abs(each / self.spacing - 1) < 1e-9 for each in fitting):
            return "with another origin it fits: leave the origin out, or put it on a corner of the frame"
        if not fitting:
            return "no spacing fits all sides: a finer one moves them less"
        return f"fitting spacings: {' or '.join(f'{each:.12g}' for each in fitting)}"


def _percent(part: float) -> str:
    """Return a part as a percentage of at least one digit."""
    return f"{part:.0%}" if part >= 0.01 else f"{100 * part:.1g}%"
