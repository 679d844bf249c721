"""How well a lattice fits a contour: how far the points that stand for the frame lie outside it."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..errors import ContactWarning
from ..foundation.checks import Mask, Vector
from ..foundation.outside import stacklevel_outside
from ..foundation.together import Together, chunks, share_of
from .cuts import fitted
from .lattice import Lattice
from .lattice_by_rows import Held, LatticeByRows, LatticeFacts
from .outline import Outline
from .sides import Moved, Sides

_LOUD = 0.05
"""Growth of a width of the frame above which a lattice is warned of: deflections grow by twice as much."""

_TOLD = 4
"""Sides that a caution names."""

_LOOKED_AT = 100
"""Moved sides whose distance from the next one is looked at: a coast may have thousands."""


@dataclass(frozen=True, eq=False)
class FrameFit:
    """A lattice laid over a frame, each of whose processes looks at some rows alone.

    Attributes
    ----------
    x : array, shape (columns,)
        Abscissae of the columns (length).
    y : array, shape (rows,)
        Ordinates of the rows, ascending (length).
    spacing : float
    bounds : (float, float, float, float)
        Least x and y and largest x and y of the frame (length).
    sides : Sides
        Its straight sides.
    inside : callable
        Whether points lie inside the contour moved inwards by a margin.
    margin : float
        What counts as on the contour (length).
    together : Together
        The processes; what a property tells is the same in all of them.
    """

    x: Vector
    y: Vector
    spacing: float
    bounds: tuple[float, float, float, float]
    sides: Sides
    inside: Callable[[NDArray[np.float64], NDArray[np.float64], float], Mask]
    margin: float
    together: Together

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the lattice."""
        return self.y.size, self.x.size

    @property
    def origin(self) -> tuple[float, float]:
        """Coordinates of the point of the first row and column (length)."""
        return float(self.x[0]), float(self.y[0])

    def nodes(self, first: int, last: int) -> Mask:
        """Return which points of the rows [first, last) lie inside, shape (rows, columns)."""
        found = np.empty((last - first, self.x.size), dtype=np.bool_)
        for begin, end in chunks(first, last, self.x.size):
            x, y = np.broadcast_arrays(self.x, self.y[begin:end, None])
            found[begin - first : end - first] = self.inside(x, y, self.margin)
        return found

    @cached_property
    def _window(self) -> Mask:
        """The nodes on this process's share of the rows, with a ring of frame points about the lattice.

        There is a row more before and behind them.
        """
        rows, columns = self.shape
        first, last = self._share
        window = np.zeros((last - first + 2, columns + 2), dtype=np.bool_)
        low, high = max(0, first - 2), min(rows, last)  # the ring's rows count from one before
        window[low + 2 - first : high + 2 - first, 1:-1] = self.together.agreed(lambda: self.nodes(low, max(low, high)))
        return window

    @property
    def _share(self) -> tuple[int, int]:
        return share_of(self.shape[0] + 2, self.together)

    @cached_property
    def held(self) -> Held:
        """Which rows and columns have nodes."""
        rows, columns = Held.of(self._window[1:-1, 1:-1], self.together)
        return Held(rows[1:-1], columns)

    @cached_property
    def widths(self) -> tuple[float, float]:
        """Width and height of the frame as the lattice has it (length)."""
        columns, rows = (int(np.ptp(np.flatnonzero(held))) + 2 for held in (self.held.columns, self.held.rows))
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
        window = self._window
        own = window[1:-1]
        beside = window[:-2] | window[2:]
        beside[:, :-1] |= own[:, 1:]
        beside[:, 1:] |= own[:, :-1]
        beside &= ~own
        places = self._places(beside)
        low, high = 4 * self.margin, self.spacing
        last = self._first_outside(places, low)
        if last is None:
            return 0.0, np.nan, np.nan
        while high - low > 1e-3 * self.spacing:
            middle = (low + high) / 2
            beyond = self._first_outside(places, middle)
            low, high, last = (low, middle, last) if beyond is None else (middle, high, beyond)
        return high, *last

    @property
    def _slanted(self) -> bool:
        """Whether squares with a node at a corner have another one outside the contour."""
        window = self._window
        corners = window[:-2] | window[1:-1] | window[2:]
        corners[:, 1:] |= corners[:, :-1].copy()
        corners[:, :-1] |= corners[:, 1:].copy()
        corners &= ~window[1:-1]
        return self._first_outside(self._places(corners), 4 * self.margin) is not None

    @property
    def _halved(self) -> Mask | None:
        """Which squares the contour halves along a diagonal, if it cuts no square otherwise; else None."""
        if self.overshoot or not self.sides.on_diagonals(self.spacing, self.origin):
            return None
        # The contour runs along lines and diagonals, so that it cuts no square but along those of its four quarters.
        nodes = np.pad(self._whole, 1)
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

    def _places(self, chosen: Mask) -> tuple[Vector, Vector]:
        """Return x and y of points that are chosen on this process's rows, with the ring (length)."""
        row, column = np.nonzero(chosen)
        x = np.float64(self.origin[0]) + np.float64(self.spacing) * (column - 1)
        y = np.float64(self.origin[1]) + np.float64(self.spacing) * (row + self._share[0] - 1)
        return x, y

    def _first_outside(self, places: tuple[Vector, Vector], distance: float) -> tuple[float, float] | None:
        """Return the first of all processes' places that lies outside the contour moved outwards so far, if any."""
        x, y = places
        out = self.together.agreed(lambda: np.flatnonzero(~self.inside(x, y, -distance)))
        found = self.together.everyones([(float(x[k]), float(y[k])) for k in out[:1]])
        return found[0] if found else None

    def _facts(self, crs: str) -> LatticeFacts:
        """Return how the frame lies to its contour; if it grows by much, the first process warns."""
        caution = self._caution() if self.overshoot else ""
        slanted = self._slanted
        if caution and self.loudest > _LOUD:
            self.together.agreed(lambda: None if self.together.rank else _warn(caution))  # as an error it is everyone's
        return LatticeFacts(self.overshoot, caution, slanted, crs)

    def by_rows(self, crs: str) -> LatticeByRows:
        """Return the lattice, of which no process lays out more rows than it is asked for."""
        return LatticeByRows(self.shape, self.spacing, self.origin, self.nodes, self.held, self._facts(crs))

    def lattice(self, crs: str) -> Lattice:
        """Return the lattice, which is laid out as a whole, in a coordinate reference system."""
        facts = self._facts(crs)
        halved = self._halved if facts.slanted else None
        return Lattice(self._whole, self.spacing, self.origin, **facts._asdict(), halved=halved)

    @property
    def _whole(self) -> Mask:
        return self._window[2:-2, 1:-1]

    def fitted_lattice(self, crs: str, outline: Outline) -> Lattice:
        """Return the lattice whose arms end on the contour."""
        mask, cuts = fitted(self._whole, self.spacing, self.origin, self.inside, self.margin)
        if not mask.any():
            raise ValueError(f"all points of spacing {self.spacing:g} lie next to the contour: choose a smaller one")
        return Lattice(mask, self.spacing, self.origin, crs=crs, cuts=cuts, outline=outline)

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


def _warn(caution: str) -> None:
    warnings.warn(caution, ContactWarning, stacklevel=stacklevel_outside())


def _percent(part: float) -> str:
    """Return a part as a percentage of at least one digit."""
    return f"{part:.0%}" if part >= 0.01 else f"{100 * part:.1g}%"
