"""Sampled: a depth profile known at abscissae, such as a surveyed sea-bed, from arrays or a CSV file."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..foundation.checks import Vector, one_of, read_only, real_array, refuse_non_finite, vector
from ..foundation.intervals import Interval
from ..foundation.loading import load_modules
from ..foundation.surfaces import Curvature
from .analytic import Profile
from .choices import DUPLICATES, KEEP_ONE, OUTSIDE, REACH, Decimal, Duplicates, Outside, one_of_each
from .sample_files import Column, read_samples

_ROUNDING = 1e-13
"""What interpolation may round by, over the largest depth."""

Interpolation = Literal["linear", "pchip"]


class Sampled(Profile):
    """A profile through samples along x, the same for all y.

    A model asks for the ordinates at its nodes only: ground that rises between two of them is not felt, so the nodes
    should lie at least as close as the samples.

    Parameters
    ----------
    x : array, shape (m,)
        Abscissae of the samples, increasing, length.
    depth : array, shape (m,)
        Heights there, positive downwards, length.
    interpolation : {"linear", "pchip"}
        Straight between the samples, or the monotone cubic of Fritsch and Carlson (SIAM J. Numer. Anal. 17, 1980),
        which is smooth and has no summit and no hollow that the samples do not have.
    outside : {"error", "hold", "none"}
        Before the first and beyond the last sample: refuse, continue with the nearest sample's depth, or no support.
    upwards : bool
        Whether the heights given are elevations, positive upwards; the profile itself returns depths all the same.

    Raises
    ------
    TypeError, ValueError
        If there are fewer than two samples, x does not increase, or an entry is not finite or not a number.

    Attributes
    ----------
    x, depth : array, shape (m,)
        The samples, read-only; heights are positive downwards, whatever they were given as.

    Examples
    --------
    >>> bed = Sampled([0.0, 100.0, 300.0], [80.0, 82.0, 81.0])
    >>> bed
    Sampled(3 samples, x from 0 to 300, linear)
    >>> bed([50.0, 200.0])
    array([81. , 81.5])
    >>> Sampled([0.0, 100.0, 300.0], [-80.0, -82.0, -81.0], upwards=True)([50.0, 200.0])
    array([81. , 81.5])
    """

    def __init__(
        self,
        x: ArrayLike,
        depth: ArrayLike,
        *,
        interpolation: Interpolation = "linear",
        outside: Outside = "error",
        upwards: bool = False,
    ) -> None:
        abscissae = real_array(x, "x")
        if abscissae.ndim != 1:
            raise ValueError(f"x must have one dimension, got shape {abscissae.shape}")
        refuse_non_finite(abscissae, "x")
        ordinates = vector(depth, abscissae.size, "depth")
        _refuse_too_few(abscissae.size)
        k = _first_disorder(abscissae)
        if k:
            raise ValueError(
                f"x must increase, but x[{k}] = {abscissae[k]:g} follows x[{k - 1}] = {abscissae[k - 1]:g}; {_SORT}"
            )
        self.x: Vector = read_only(abscissae)
        self.depth: Vector = read_only(-ordinates if upwards else ordinates)
        self.interpolation = one_of(interpolation, ("linear", "pchip"), "interpolation")
        self.outside = one_of(outside, OUTSIDE, "outside")

    @classmethod
    def from_csv(
        cls,
        path: str | Path,
        x: Column = "x",
        depth: Column = "depth",
        *,
        delimiter: str = ",",
        decimal: Decimal = ".",
        duplicates: Duplicates = "error",
        interpolation: Interpolation = "linear",
        outside: Outside = "error",
        upwards: bool = False,
    ) -> Sampled:
        r"""Read the samples from two columns of a CSV file.

        Empty lines and lines that begin with # are passed over. The first row left is the header if a column is chosen
        by name, or if neither of its two cells is a number.

        Parameters
        ----------
        path : path
            A text file in UTF-8.
        x, depth : str or int
            The columns, by name or by position, which counts from 0.
        delimiter : str
            What separates the columns.
        decimal : {".", ","}
            What begins the decimals of a number; with a comma, choose another delimiter, as ``";"``.
        duplicates : {"error", "mean", "first", "last", "shallowest", "deepest"}
            Of several samples at one x, in lines that follow each other: refuse, or keep one.
        interpolation, outside, upwards
            See the class.

        Raises
        ------
        OSError
            If the file cannot be read.
        ValueError
            If a column is missing, a cell is not a finite number, or the samples are not a profile; the message names
            the file, the line and the value.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> file = pathlib.Path(tempfile.mkdtemp()) / "bed.csv"
        >>> _ = file.write_text("x,depth\n0,80\n100,82\n")
        >>> Sampled.from_csv(file)
        Sampled(2 samples, x from 0 to 100, linear)
        >>> _ = file.write_text("km;z\n0;80,5\n0;80,7\n1;82\n")
        >>> Sampled.from_csv(file, "km", "z", delimiter=";", decimal=",", duplicates="mean").depth
        array([80.6, 82. ])
        """
        found = read_samples(Path(path), {"x": x, "depth": depth}, delimiter=delimiter, decimal=decimal)
        one_of(duplicates, DUPLICATES, "duplicates")
        abscissae = found.values[:, 0]
        k = _first_disorder(abscissae, strictly=duplicates == "error")
        if k:
            where, here, before = f"{path}, line {found.line_of(k)}", abscissae[k], abscissae[k - 1]
            remedy = _SORT
            if here == before:
                remedy = f"two samples at one place: {KEEP_ONE}"
            raise ValueError(f"{where}: {found.names[0]} must increase, but {here:g} follows {before:g}; {remedy}")
        ordinates = found.values[:, 1]
        places, depths = _one_for_each(abscissae, -ordinates if upwards else ordinates, duplicates)
        try:
            _refuse_too_few(places.size)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None
        return cls(places, depths, interpolation=interpolation, outside=outside)

    def __call__(self, x: ArrayLike, y: ArrayLike = 0.0) -> NDArray[np.float64]:
        """Return the depths f at the points (x, y)."""
        points = np.broadcast_arrays(np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64))[0]
        first, last = self.x[0], self.x[-1]
        reach = REACH * (last - first)
        beyond = (points < first - reach) | (points > last + reach)
        if self.outside == "error" and beyond.any():
            raise ValueError(
                f"x = {points[beyond][0]:g} lies outside the samples, which go from {first:g} to {last:g}; pass "
                "outside='hold' to continue them, or outside='none' for no support there"
            )
        held = np.clip(points, first, last)
        if self.interpolation == "linear":
            depth = np.interp(held, self.x, self.depth)
        else:
            load_modules("scipy.interpolate")
            from scipy.interpolate import PchipInterpolator

            depth = PchipInterpolator(self.x, self.depth)(held)
        return np.asarray(np.where(beyond, np.inf, depth) if self.outside == "none" else depth)

    def range(self, x: Interval, y: Interval) -> Interval:
        """See `Profile.range`: depths are greatest and least at the ends or at samples, however they are joined."""
        low, high, beyond = self._clipped(x)
        ends = np.stack([np.asarray(Sampled.__call__(self, end)) for end in (low, high)])
        first, last = np.searchsorted(self.x, low, "left"), np.searchsorted(self.x, high, "right")
        room = _ROUNDING * float(np.abs(self.depth).max())
        least = np.minimum(ends.min(axis=0), _extreme(self.depth, first, last, np.minimum, np.inf)) - room
        most = np.maximum(ends.max(axis=0), _extreme(self.depth, first, last, np.maximum, -np.inf)) + room
        shape = np.broadcast_shapes(x.lower.shape, y.lower.shape)
        most = np.where(beyond, np.inf, most) if self.outside == "none" else most
        return Interval(np.broadcast_to(least, shape), np.broadcast_to(most, shape))

    def curvature(self, x: Interval, y: Interval) -> Curvature | None:
        """See `Profile.curvature`: kinks at samples that are joined by straight lines; of a cubic it is not known."""
        if self.interpolation != "linear":
            return None
        low, high, beyond = self._clipped(x)
        slopes = np.diff(self.depth) / np.diff(self.x)
        # Beyond the samples the profile goes on level, where it goes on.
        turns = np.diff(np.concatenate([[0.0], slopes, [0.0]])) if self.outside == "hold" else np.zeros(self.x.size)
        if self.outside != "hold":
            turns[1:-1] = np.diff(slopes)
        first, last = np.searchsorted(self.x, low, "left"), np.searchsorted(self.x, high, "right")
        upwards, downwards = (np.concatenate([[0], np.cumsum(kinks)]) for kinks in (turns > 0, turns < 0))
        bent = [counts[last] > counts[first] for counts in (upwards, downwards)]
        unknown = beyond & (self.outside == "none")
        shape = np.broadcast_shapes(x.lower.shape, y.lower.shape)
        upper = np.where(bent[0] | unknown, np.inf, 0.0)
        lower = np.where(bent[1], -np.inf, 0.0)
        none = Interval.of(np.zeros(shape))
        return Curvature(Interval(np.broadcast_to(lower, shape), np.broadcast_to(upper, shape)), none, none)

    def _clipped(self, x: Interval) -> tuple[Vector, Vector, NDArray[np.bool_]]:
        """Return the ends of intervals within the samples, and which go beyond these by more than rounding."""
        room = REACH * (self.x[-1] - self.x[0])
        beyond = (x.lower < self.x[0] - room) | (x.upper > self.x[-1] + room)
        return np.clip(x.lower, self.x[0], self.x[-1]), np.clip(x.upper, self.x[0], self.x[-1]), np.asarray(beyond)

    def __repr__(self) -> str:
        outside = "" if self.outside == "error" else f", outside={self.outside!r}"
        return f"Sampled({self.x.size} samples, x from {self.x[0]:g} to {self.x[-1]:g}, {self.interpolation}{outside})"


_SORT = "sort the samples and keep one for each x"


def _refuse_too_few(count: int) -> None:
    if count < 2:
        raise ValueError(f"a profile needs two samples or more, got {count}")


def _first_disorder(x: Vector, *, strictly: bool = True) -> int:
    """Return the first place whose abscissa is no larger than the one before it (or is smaller), 0 if there is none."""
    steps = np.diff(x)
    bad = np.flatnonzero(steps <= 0 if strictly else steps < 0)
    return int(bad[0]) + 1 if bad.size else 0


def _one_for_each(x: Vector, depth: Vector, kept: str) -> tuple[Vector, Vector]:
    """Return one sample for each abscissa of a sequence that does not decrease."""
    starts = np.flatnonzero(np.concatenate([[True], np.diff(x) > 0])[: x.size])
    if starts.size == x.size:
        return x, depth
    return x[starts], one_of_each(depth, starts, kept)


def _extreme(values: Vector, first: Any, last: Any, take: Any, none: float) -> Vector:
    """Return the least or the greatest of ``values[first:last]`` for many pairs of places, ``none`` of no value.

    Of two runs whose length is a power of two, and which together cover the places, the extremes are kept.
    """
    count = np.maximum(last - first, 0)
    found = np.full(np.shape(count), none)
    run, length = values, 1
    while length <= values.size:
        chosen = (count >= length) & (count < 2 * length)
        if chosen.any():
            found[chosen] = take(run[first[chosen]], run[last[chosen] - length])
        if 2 * length > values.size:
            break
        run = take(run[:-length], run[length:])
        length *= 2
    return found
