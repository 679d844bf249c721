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
from .lattice import Lattice

_LOUD = 0.05
"""Growth of the frame's width or height above which a lattice is warned of: deflections grow by twice as much."""

_TOLD = 0.005
"""Growth above which every answer carries a caution."""

_PARTS = 10_000
"""Largest number of spacings along a side among those that are tried."""


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
    inside : callable
        Whether points lie inside the contour moved inwards by a margin.
    margin : float
        What counts as on the contour (length).
    """

    mask: Mask
    spacing: float
    origin: tuple[float, float]
    bounds: tuple[float, float, float, float]
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
    def overshoot(self) -> float:
        """How far outwards the contour must be moved to take in all points that stand for the frame (length)."""
        padded = np.pad(self.mask, 1)
        beside = np.zeros_like(padded)
        beside[:-1] |= padded[1:]
        beside[1:] |= padded[:-1]
        beside[:, :-1] |= padded[:, 1:]
        beside[:, 1:] |= padded[:, :-1]
        row, column = np.nonzero(beside & ~padded)
        x = np.float64(self.origin[0]) + np.float64(self.spacing) * (column - 1)
        y = np.float64(self.origin[1]) + np.float64(self.spacing) * (row - 1)

        def reached(distance: float) -> bool:
            return bool(self.inside(x, y, -distance).all())

        low, high = 4 * self.margin, self.spacing
        if reached(low):
            return 0.0
        while high - low > 1e-3 * self.spacing:
            middle = (low + high) / 2
            low, high = (low, middle) if reached(middle) else (middle, high)
        return high

    def lattice(self, fitting: list[float]) -> Lattice:
        """Return the lattice, and warn if the frame is a good deal wider with it than it is.

        Parameters
        ----------
        fitting : list of float
            Spacings that fit, as a remedy.
        """
        caution = self._caution(fitting) if self.growth > _TOLD else ""
        if self.growth > _LOUD:
            warnings.warn(caution, ContactWarning, stacklevel=stacklevel_outside())
        return Lattice(self.mask, self.spacing, self.origin, overshoot=self.overshoot, caution=caution)

    def _caution(self, fitting: list[float]) -> str:
        left, bottom, right, top = self.bounds
        told = [f"{each:.12g}" for each in fitting]
        remedy = f"fitting spacings: {' or '.join(told)}" if told else "no spacing fits both: take a finer one"
        if any(abs(each / self.spacing - 1) < 1e-9 for each in fitting):
            remedy = "with another origin it fits: leave the origin out, or put it on a corner of the frame"
        return (
            f"with spacing {self.spacing:g} the frame is {self.widths[0]:.4g} x {self.widths[1]:.4g} instead of "
            f"{right - left:.4g} x {top - bottom:.4g}, up to {self.growth:.0%} wider; {remedy}"
        )


def nearest_fitting(width: float, height: float, spacing: float) -> list[float]:
    """Return the spacings next to a given one, below and above it, that divide both sides of a rectangle.

    Examples
    --------
    >>> nearest_fitting(3.0, 2.0, 0.3), nearest_fitting(2.0, 3**0.5, 0.3)
    ([0.25, 0.3333333333333333], [])
    """
    parts = np.arange(2, _PARTS)
    candidates = min(width, height) / parts
    ratios = max(width, height) / candidates
    fits = candidates[np.abs(ratios - np.round(ratios)) <= 1e-9 * ratios]
    return [*fits[fits <= spacing][:1].tolist(), *fits[fits > spacing][-1:].tolist()]
