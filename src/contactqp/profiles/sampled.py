"""Sampled: a depth profile known at abscissae, such as a surveyed sea-bed, from arrays or a CSV file."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..foundation.checks import Vector, nearest, one_of, read_only, real_array, refuse_non_finite, vector
from ..foundation.loading import load_modules

Interpolation = Literal["linear", "pchip"]
Outside = Literal["error", "hold", "none"]

_REACH = 1e-9
"""Points outside the samples by less than this part of their extent are taken for rounding."""


class Sampled:
    """A profile through samples along x, the same for all y.

    A model asks for the ordinates at its nodes only: ground that rises between two of them is not felt, so the nodes
    should lie at least as close as the samples.

    Parameters
    ----------
    x : array, shape (m,)
        Abscissae of the samples, increasing, length.
    depth : array, shape (m,)
        Ordinates there, positive downwards, length.
    interpolation : {"linear", "pchip"}
        Straight between the samples, or the monotone cubic of Fritsch and Carlson (SIAM J. Numer. Anal. 17, 1980),
        which is smooth and has no summit and no hollow that the samples do not have.
    outside : {"error", "hold", "none"}
        Before the first and beyond the last sample: refuse, continue with the nearest sample's depth, or no support.

    Raises
    ------
    TypeError, ValueError
        If there are fewer than two samples, x does not increase, or an entry is not finite or not a number.

    Attributes
    ----------
    x, depth : array, shape (m,)
        The samples, read-only.

    Examples
    --------
    >>> bed = Sampled([0.0, 100.0, 300.0], [80.0, 82.0, 81.0])
    >>> bed
    Sampled(3 samples, x from 0 to 300, linear)
    >>> bed([50.0, 200.0])
    array([81. , 81.5])
    """

    def __init__(
        self,
        x: ArrayLike,
        depth: ArrayLike,
        *,
        interpolation: Interpolation = "linear",
        outside: Outside = "error",
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
        self.depth: Vector = read_only(ordinates)
        self.interpolation = one_of(interpolation, ("linear", "pchip"), "interpolation")
        self.outside = one_of(outside, ("error", "hold", "none"), "outside")

    @classmethod
    def from_csv(
        cls,
        path: str | Path,
        x: str | int = "x",
        depth: str | int = "depth",
        *,
        delimiter: str = ",",
        interpolation: Interpolation = "linear",
        outside: Outside = "error",
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
        interpolation, outside : str
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
        """
        if x == depth:
            raise ValueError(f"x and depth must be different columns, got {x!r} for both")
        rows = _rows(Path(path), delimiter)
        first = rows[0][1]
        places = [_place(first, column, path) for column in (x, depth)]
        named = isinstance(x, str) or isinstance(depth, str)
        if named or not any(place < len(first) and _is_number(first[place]) for place in places):
            del rows[0]
        samples = np.empty((len(rows), 2))
        for k, (line, cells) in enumerate(rows):
            where = f"{path}, line {line}"
            samples[k] = [_cell(cells, place, name, where) for place, name in zip(places, ("x", "depth"), strict=True)]
        try:
            _refuse_too_few(len(rows))
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None
        k = _first_disorder(samples[:, 0])
        if k:
            raise ValueError(
                f"{path}, line {rows[k][0]}: x must increase, but {samples[k, 0]:g} follows {samples[k - 1, 0]:g}; "
                f"{_SORT}"
            )
        return cls(samples[:, 0], samples[:, 1], interpolation=interpolation, outside=outside)

    def __call__(self, x: ArrayLike, y: ArrayLike = 0.0) -> NDArray[np.float64]:
        """Return the ordinates f at the points (x, y)."""
        points = np.broadcast_arrays(np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64))[0]
        first, last = self.x[0], self.x[-1]
        reach = _REACH * (last - first)
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

    def __repr__(self) -> str:
        outside = "" if self.outside == "error" else f", outside={self.outside!r}"
        return f"Sampled({self.x.size} samples, x from {self.x[0]:g} to {self.x[-1]:g}, {self.interpolation}{outside})"


_SORT = "sort the samples and keep one for each x"


def _refuse_too_few(count: int) -> None:
    if count < 2:
        raise ValueError(f"a profile needs two samples or more, got {count}")


def _first_disorder(x: Vector) -> int:
    """Return the first place whose abscissa is no larger than the one before it, 0 if there is none."""
    bad = np.flatnonzero(np.diff(x) <= 0)
    return int(bad[0]) + 1 if bad.size else 0


def _rows(path: Path, delimiter: str) -> list[tuple[int, list[str]]]:
    """Return the rows that hold something, each with the number of its line."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        reader = csv.reader(file, delimiter=delimiter, skipinitialspace=True)
        try:
            rows = [(reader.line_num, [cell.strip() for cell in cells]) for cells in reader]
        except (UnicodeDecodeError, csv.Error) as error:
            raise ValueError(f"{path}: not a table in UTF-8: {error}") from None
    rows = [(line, cells) for line, cells in rows if any(cells) and not cells[0].startswith("#")]
    if not rows:
        raise ValueError(f"{path}: it has no rows")
    return rows


def _place(header: list[str], column: str | int, path: str | Path) -> int:
    if not isinstance(column, str):
        return column
    if column not in header:
        raise ValueError(f"{path}: no column {column!r}; it has {', '.join(header)}{nearest(column, header)}")
    if header.count(column) > 1:
        raise ValueError(f"{path}: {header.count(column)} columns are called {column!r}; choose one by position")
    return header.index(column)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _cell(cells: list[str], place: int, name: str, where: str) -> float:
    if not 0 <= place < len(cells):
        columns = f"{len(cells)} column{'' if len(cells) == 1 else 's'}"
        raise ValueError(f"{where}: no column {place}, it has {columns}, counted from 0")
    if not _is_number(cells[place]):
        raise ValueError(f"{where}: {name} is {cells[place]!r}, which is no number")
    value = float(cells[place])
    if not np.isfinite(value):
        raise ValueError(f"{where}: {name} must be finite, got {value}")
    return value
