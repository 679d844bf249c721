"""Surfaces from data files that tell where their values lie, such as surveys of a sea-bed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..errors import CaseFileError
from ..foundation.checks import Vector, finite_number, one_of, real_array
from ..profiles.choices import DUPLICATES, Duplicates, Outside
from ..profiles.gridded import Gridded
from ..profiles.sample_files import Column, first_cells, read_points
from ..profiles.scattered import INTERPOLATIONS, Interpolation, Scattered
from .data_files import Reading, read_numbers
from .on_nodes import upright
from .variables import DATASETS, grid_in_file

_Values: TypeAlias = tuple[Vector, Vector, Vector]
_Columns: TypeAlias = tuple[Column | None, Column | None, Column | None]

_POINTS = (".xyz", ".csv", ".txt")


def read_surface(
    path: str | Path,
    *,
    key: Column | None = None,
    x: Column | None = None,
    y: Column | None = None,
    factor: float = 1.0,
    offset: float = 0.0,
    upwards: bool = False,
    no_data: float | None = None,
    interpolation: Interpolation = "linear",
    outside: Outside = "error",
    duplicates: Duplicates = "error",
    delimiter: str | None = None,
    decimal: str = ".",
) -> Gridded | Scattered:
    r"""Return the surface through the values of a file, ``offset + factor * value``, where the file puts them.

    Parameters
    ----------
    path : str or Path
        ``.tif``: a GeoTIFF, as its geo-transform puts it; ``.nc`` and ``.zarr``: a variable along y and x with
        coordinates; ``.xyz``, ``.csv`` and ``.txt``: x, y and a value in each line.
    key : str or int, optional
        Which band, variable or column holds the values, where there are several; a column by its name, or by its
        position, which counts from 0.
    x, y : str or int, optional
        Which columns of a text file hold the places; by default those called x and y, without a header the first two.
    factor, offset : float
    upwards : bool
        Whether the file's values, with factor and offset, are elevations, positive upwards; the profile returns depths
        all the same.
    no_data : float, optional
        A value that stands for none, beside nan and the one that a ``.tif`` file names.
    interpolation : {"linear", "nearest", "cubic"}
        See `profiles.Scattered`; a grid is interpolated linearly.
    outside : {"error", "hold", "none"}
        Beyond what the file covers: refuse, continue with the value at the edge, or no support; see `profiles.Gridded`
        and `profiles.Scattered`.
    duplicates : {"error", "mean", "first", "last", "shallowest", "deepest"}
        Of several values at one place of a text file: refuse, or keep one.
    delimiter, decimal : str
        What separates the columns of a text file, by default what its first row has, and what begins the decimals of
        its numbers.

    Returns
    -------
    profiles.Gridded or profiles.Scattered
        The first where the values fill a grid, and those of ``.tif``, ``.nc`` and ``.zarr`` in any case; points without
        a value are holes of a grid, and left out of scattered points.

    Raises
    ------
    CaseFileError
        If the file cannot be read, or does not tell places; the message names it.

    Examples
    --------
    >>> import tempfile
    >>> file = Path(tempfile.mkdtemp()) / "bed.xyz"
    >>> _ = file.write_text("0 0 -80\n4 0 -82\n0 2 -81\n4 2 -83\n")
    >>> read_surface(file, upwards=True)
    Gridded(2 x 2, x from 0 to 4, y from 0 to 2)
    >>> _ = file.write_text("# soundings\n0;0;80,5\n4;0;82\n1;2;81\n")
    >>> read_surface(file, decimal=",")
    Scattered(3 soundings, x from 0 to 4, y from 0 to 2, linear)
    """
    told = {name: value for name, value in locals().items() if name != "path"}
    return surface_of_file(path, **told, by_rows=False)


def surface_of_file(
    path: str | Path,
    *,
    key: Column | None,
    x: Column | None,
    y: Column | None,
    factor: float,
    offset: float,
    upwards: bool,
    no_data: float | None,
    interpolation: Interpolation,
    outside: Outside,
    duplicates: Duplicates,
    delimiter: str | None,
    decimal: str,
    by_rows: bool,
) -> Gridded | Scattered:
    """Return what `read_surface` does; by rows, a grid whose values stay in the file until they are needed."""
    path = Path(path)

    def gridded(columns: Vector, rows: Vector, values: Vector) -> Gridded:
        return Gridded(columns, rows, offset + factor * values, outside=outside, upwards=upwards)

    try:
        factor, offset = finite_number(factor, "factor"), finite_number(offset, "offset")
        one_of(interpolation, INTERPOLATIONS, "interpolation")
        one_of(duplicates, DUPLICATES, "duplicates")
        if not path.exists():
            raise CaseFileError("there is no such file")
        if path.suffix.lower() not in _POINTS:
            if interpolation != "linear":
                raise CaseFileError(f"interpolation = {interpolation!r} is for points of text files; a grid is linear")
            grid = _grid(path, key, no_data, by_rows=by_rows)
            if by_rows:
                return GriddedInFile(grid, factor, offset, outside=outside, upwards=upwards)
            return gridded(grid.x, grid.y, grid.rows(0, grid.y.size))
        points = _points(path, (x, y, key), delimiter, decimal, no_data)
        filled = _filled(*points) if interpolation == "linear" else None
        if filled is not None:
            return gridded(*filled)
        places_x, places_y, values = (each[~np.isnan(points[2])] for each in points)
        return Scattered(
            *(places_x, places_y, offset + factor * values),
            interpolation=interpolation,
            outside=outside,
            duplicates=duplicates,
            upwards=upwards,
        )
    except (ValueError, TypeError, OSError) as error:
        raise CaseFileError(f"{path}: {str(error).removeprefix(str(path)).lstrip(':, ')}") from None


_RowsOfFile: TypeAlias = Callable[[int, int], NDArray[np.float64]]
"""Returns the values of the rows [first, last), shape (rows, columns)."""


class _GridOfFile(NamedTuple):
    """A grid of values in a file, nan where there is none.

    Attributes
    ----------
    x, y : array
        Ascending abscissae of the columns and ordinates of the rows (length).
    rows : _RowsOfFile
    """

    x: Vector
    y: Vector
    rows: _RowsOfFile


class GriddedInFile(Gridded):
    """A surface through the values of a file, ``offset + factor * value``, of which those are read that are needed.

    Parameters
    ----------
    grid : _GridOfFile
    factor, offset : float
    outside, upwards
        See `Gridded`.
    """

    def __init__(self, grid: _GridOfFile, factor: float, offset: float, *, outside: Outside, upwards: bool) -> None:
        self._lie_at(grid.x, grid.y, outside)
        self._grid, self._factor, self._offset, self._sense = grid, factor, offset, -1.0 if upwards else 1.0
        self._first, self._kept = 0, np.empty((0, grid.x.size))

    def heights(self, rows: slice, columns: slice) -> NDArray[np.float64]:
        """See `Gridded`; a row at a time is asked for, again and again, so that some beyond them are read and kept."""
        first, last = rows.start, rows.stop
        if not self._first <= first <= last <= self._first + len(self._kept):
            end = min(self.y.size, max(last, first + _KEPT // self.x.size))
            self._first = first
            self._kept = self._sense * (self._offset + self._factor * self._grid.rows(first, end))
        return self._kept[first - self._first : last - self._first, columns]


_KEPT = 1 << 20
"""Values of a file that are kept."""


def _grid(path: Path, key: Column | None, no_data: float | None, *, by_rows: bool) -> _GridOfFile:
    """Return the grid that a file holds."""
    name, suffix = None if key is None else str(key), path.suffix.lower()
    if suffix in DATASETS:
        variable = grid_in_file(path, name)

        def rows_of_variable(first: int, last: int) -> NDArray[np.float64]:
            values = real_array(variable.rows(first, last), "values")
            return np.where(values == no_data, np.nan, values)

        return _ascending(real_array(variable.x, "x"), real_array(variable.y, "y"), rows_of_variable)
    numbers = upright(read_numbers(path, Reading(name, by_rows=by_rows)), None, no_data, transform=True)
    if numbers.places is None:
        raise CaseFileError(
            "it does not tell where its values lie; say profiles.Gridded(x, y, values) with x of the columns and y of "
            "the rows"
        )
    return _ascending(*numbers.places, numbers.rows)


def _ascending(x: Vector, y: Vector, rows: _RowsOfFile) -> _GridOfFile:
    """Return a grid, whose columns and rows may go either way."""
    turned, down, count = x[0] > x[-1], y[0] > y[-1], y.size

    def upright_rows(first: int, last: int) -> NDArray[np.float64]:
        values = rows(count - last, count - first)[::-1] if down else rows(first, last)
        return values[:, ::-1] if turned else values

    return _GridOfFile(x[::-1] if turned else x, y[::-1] if down else y, upright_rows)


def _points(path: Path, columns: _Columns, delimiter: str | None, decimal: str, no_data: float | None) -> _Values:
    """Return x, y and value of each point of a text file, nan where there is no value."""
    if columns == (None, None, None) and path.suffix.lower() != ".xyz":
        first = first_cells(path, delimiter, decimal)
        if len(first) > 3 and None not in first:
            raise CaseFileError(
                f"it has {len(first)} columns and no header: choose those of places and values by x, y and key; of an "
                "array of values say profiles.Gridded(x, y, values)"
            )
    found = read_points(path, *columns, delimiter=delimiter, decimal=decimal, called="key", unchecked=True)
    x, y, values = found.values.T
    return x, y, np.where(values == no_data, np.nan, values)


def _filled(x: Vector, y: Vector, values: Vector) -> _Values | None:
    """Return points as a grid, if there is one at each crossing of its columns and rows."""
    (columns, column), (rows, row) = (np.unique(places, return_inverse=True) for places in (x, y))
    if min(columns.size, rows.size) < 2 or columns.size * rows.size != x.size:
        return None
    at = row * columns.size + column
    if (np.bincount(at, minlength=x.size) != 1).any():
        return None
    grid = np.empty(x.size)
    grid[at] = values
    return columns, rows, grid.reshape(rows.size, columns.size)
