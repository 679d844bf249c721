"""Variables of dataset files, told apart by their suffix and chosen by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import CaseFileError
from ..foundation.checks import nearest
from ..geometry.labelled import with_places
from ..profiles.gridded import in_plan
from .netcdf import opened_netcdf
from .zarr_stores import opened_zarr

if TYPE_CHECKING:
    import xarray as xr

DATASETS: dict[str, Callable[[Path], AbstractContextManager[xr.Dataset]]] = {
    ".nc": opened_netcdf,
    ".zarr": opened_zarr,
}
"""What opens a dataset, by the suffix of its file or folder."""


def variable_in_plan(path: Path, key: str | None) -> Any:
    """Return a variable of a file as a DataArray; its only one along y and x, where none is named.

    Raises
    ------
    CaseFileError
        If the file cannot be read, or does not tell which variable is meant.
    """
    with _opened(path) as data:
        return _chosen(data, key).load()


class GridInFile(NamedTuple):
    """A variable of a file along y and x, of which rows are read when they are asked for.

    Attributes
    ----------
    x, y : array
        Coordinates of the columns and the rows, in the order of the file.
    rows : callable
        Returns the values of the rows [first, last), shape (rows, columns).
    """

    x: NDArray[Any]
    y: NDArray[Any]
    rows: Callable[[int, int], NDArray[Any]]


def grid_in_file(path: Path, key: str | None) -> GridInFile:
    """Return what `variable_in_plan` does, but leave the values in the file.

    Raises
    ------
    CaseFileError
        See there; of damaged parts when they are read.
    ValueError
        If the variable does not lie along y and x, with coordinates.
    """

    def rows(first: int, last: int) -> NDArray[Any]:
        with _opened(path) as data:
            return np.asarray(in_plan(_chosen(data, key).isel(y=slice(first, last))))

    with _opened(path) as data:
        grid = in_plan(_chosen(data, key))
        return GridInFile(grid["x"].to_numpy(), grid["y"].to_numpy(), rows)


@contextmanager
def _opened(path: Path) -> Iterator[xr.Dataset]:
    try:
        with DATASETS[path.suffix.lower()](path) as data:
            yield data
    except OSError as error:
        raise CaseFileError(str(error)) from None


def _chosen(data: xr.Dataset, key: str | None) -> Any:
    named = {str(name): with_places(data[name], str(name)) for name in data.data_vars}
    names = [name for name, field in named.items() if {"x", "y"} <= set(map(str, field.dims))]
    if key is None and len(names) != 1:
        raise CaseFileError(f"choose one of its variables by key: {', '.join(names) or 'none lies along y and x'}")
    if key is not None and key not in data:
        raise CaseFileError(f"no variable {key!r} in it; it has {', '.join(names)}{nearest(key, names)}")
    return named[names[0]] if key is None else with_places(data[key], key)
