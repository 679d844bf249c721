"""Surfaces from data files that tell where their values lie, such as surveys of a sea-bed."""

from __future__ import annotations

from pathlib import Path
from typing import TypeAlias

import numpy as np

from ..errors import CaseFileError
from ..foundation.checks import Vector, finite_number, one_of
from ..profiles.choices import DUPLICATES, Duplicates, Outside
from ..profiles.gridded import Gridded
from ..profiles.sample_files import Column, first_cells, read_points
from ..profiles.scattered import INTERPOLATIONS, Interpolation, Scattered
from .data_files import Reading, read_numbers
from .on_nodes import upright
from .variables import DATASETS, variable_in_plan

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
            return gridded(*_grid(path, key, no_data))
        points = _points(path, (x, y, key), delimiter, decimal, no_data)
        grid = _filled(*points) if interpolation == "linear" else None
        if grid is not None:
            return gridded(*grid)
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


def _grid(path: Path, key: Column | None, no_data: float | None) -> _Values:
    """Return x of the columns, y of the rows, and values of a file that holds a grid, nan where there is none."""
    name, suffix = None if key is None else str(key), path.suffix.lower()
    if suffix in DATASETS:
        field = Gridded.of(variable_in_plan(path, name), outside="none")
        return field.x, field.y, np.where(field.depth == no_data, np.nan, field.depth)
    raster = upright(read_numbers(path, Reading(name)), None, no_data, transform=True)
    if raster.places is None:
        raise CaseFileError(
            "it does not tell where its values lie; say profiles.Gridded(x, y, values) with x of the columns and y of "
            "the rows"
        )
    return *raster.places, raster.values


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
