"""Data that tell their places themselves: tables and arrays with labels, told apart without loading what makes them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Vector, real_array
from ..foundation.loading import load_modules

_X = ("x", "X", "easting", "eastings")
_Y = ("y", "Y", "northing", "northings")
"""Names of axes; degrees are no lengths, so that those of longitude and latitude are not among them."""

APART = 1e-6
"""Places nearer than this part of the spacing are the same."""


def is_dataarray(value: Any) -> bool:
    """Whether ``value`` is an xarray.DataArray, found out without importing xarray."""
    return hasattr(value, "dims") and hasattr(value, "coords")


def is_table(value: Any) -> bool:
    """Whether ``value`` is a pandas.DataFrame."""
    return hasattr(value, "columns") and hasattr(value, "index") and hasattr(value, "to_numpy")


def is_series(value: Any) -> bool:
    """Whether ``value`` is a pandas.Series."""
    return hasattr(value, "index") and hasattr(value, "to_numpy") and hasattr(value, "name") and not is_table(value)


def is_labelled(value: Any) -> bool:
    """Whether ``value`` may tell its places."""
    return is_dataarray(value) or is_table(value) or is_series(value)


def with_places(value: Any, name: str) -> Any:
    """Return labelled data as a DataArray along y and x, or along node, as a table with x and y, or as an array.

    Parameters
    ----------
    value : object
        A DataArray: further dimensions of one entry are left out, and axes may also be told by other names, or by the
        attributes ``axis`` and ``standard_name`` of CF. A pandas.DataFrame with numbers for labels, which are then y
        and x; or with columns x and y and one of values. A pandas.Series whose labels are the nodes' numbers, or pairs
        (y, x) or (x, y) by the names of the index. Everything else is returned as it is.
    name : str
        The argument's name, for messages.

    Examples
    --------
    >>> import pandas as pd
    >>> with_places(pd.DataFrame([[1.0, 2.0], [3.0, 4.0]], index=[0.5, 0.0], columns=[0.0, 0.5]), "load").dims
    ('y', 'x')
    >>> with_places(pd.Series([3.0, 1.0, 2.0], index=[2, 0, 1]), "load")
    array([1., 2., 3.])
    """
    if is_dataarray(value):
        return _along_axes(value)
    if is_table(value):
        return _of_table(value, name)
    if is_series(value):
        return _of_series(value, name)
    return value


def _along_axes(field: Any) -> Any:
    if not field.dims:
        return field
    names = {}
    for dim in field.dims:
        told = dict(field.coords[dim].attrs) if dim in field.coords else {}
        for axis, known in (("x", _X), ("y", _Y)):
            standard = told.get("standard_name") == f"projection_{axis}_coordinate"
            if dim in known or standard or str(told.get("axis", "")).lower() == axis:
                names[dim] = axis
    others = [dim for dim in field.dims if dim not in names and dim != "node" and field.sizes[dim] == 1]
    if others and len(field.dims) > len(others):
        field = field.isel(dict.fromkeys(others, 0), drop=True)
    wanted = {dim: axis for dim, axis in names.items() if dim != axis}
    return field.rename(wanted) if wanted and len(set(names.values())) == len(names) else field


def _of_table(table: Any, name: str) -> Any:
    columns = [str(column) for column in table.columns]
    x, y = (next((each for each in columns if each in known), None) for known in (_X, _Y))
    if x is not None and y is not None:
        values = [column for column in columns if column not in (x, y)]
        chosen = name if name in values else values[0] if len(values) == 1 else None
        if chosen is None:
            found = ", ".join(values) or "none"
            raise ValueError(f"{name} is a table with x and y, and must have one more column, or one {name!r}: {found}")
        return Places(*(real_array(table[each].to_numpy(), f"{name}[{each!r}]") for each in (x, y, chosen)))
    if all(_is_told(labels) for labels in (table.index, table.columns)):
        load_modules("xarray")
        import xarray as xr

        coordinates = {"y": np.asarray(table.index, dtype=float), "x": np.asarray(table.columns, dtype=float)}
        return xr.DataArray(table.to_numpy(), coordinates, ("y", "x"), attrs=dict(table.attrs))
    return table.to_numpy()


def _of_series(series: Any, name: str) -> Any:
    index = series.index
    levels = [str(level) for level in getattr(index, "names", [])]
    if len(levels) == 2:
        return _of_table(series.rename(name).reset_index(), name)
    values = series.to_numpy()
    labels = np.asarray(index)
    if labels.dtype.kind in "iu" and np.array_equal(np.sort(labels), np.arange(labels.size)):
        return values[np.argsort(labels)]
    return values


def _is_told(labels: Any) -> bool:
    """Whether labels are numbers that somebody gave, and not counted from 0."""
    array = np.asarray(labels)
    return array.dtype.kind in "iuf" and not np.array_equal(array, np.arange(array.size))


def grid_of(field: Any, spacing: float, name: str) -> tuple[NDArray[Any], tuple[float, float] | None]:
    """Return a DataArray's values with y ascending, and where the first lies; None where it has no coordinates.

    Raises
    ------
    ValueError
        If it does not lie along y and x, or not on a lattice of such a spacing.
    """
    if set(field.dims) != {"y", "x"}:
        raise ValueError(f"{name} must have the dims ('y', 'x'), got {field.dims}")
    field = field.transpose("y", "x")
    if not {"x", "y"} <= set(field.coords):
        return field.to_numpy(), None
    field = field.sortby(["x", "y"])
    first = []
    for axis in ("x", "y"):
        places = np.asarray(field[axis], dtype=np.float64)
        expected = places[0] + spacing * np.arange(places.size)
        if np.abs(places - expected).max() > APART * abs(spacing):
            raise ValueError(
                f"{name} must lie on a lattice of spacing {spacing:g}, but its {axis} goes from {places[0]:g} to "
                f"{places[-1]:g} in {places.size} places"
            )
        first.append(float(places[0]))
    return field.to_numpy(), (first[0], first[1])


class Places(NamedTuple):
    """Values at points, one row of a table each.

    Attributes
    ----------
    x, y, values : array, shape (m,)
    """

    x: Vector
    y: Vector
    values: Vector
