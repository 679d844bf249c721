"""Variables of dataset files, told apart by their suffix and chosen by name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..errors import CaseFileError
from ..foundation.checks import nearest
from ..geometry.labelled import with_places
from .netcdf import read_netcdf
from .zarr_stores import read_zarr

DATASETS: dict[str, Callable[[Path], Any]] = {".nc": read_netcdf, ".zarr": read_zarr}
"""What reads a dataset, by the suffix of its file or folder."""


def variable_in_plan(path: Path, key: str | None) -> Any:
    """Return a variable of a file as a DataArray; its only one along y and x, where none is named.

    Raises
    ------
    CaseFileError
        If the file cannot be read, or does not tell which variable is meant.
    """
    try:
        data = DATASETS[path.suffix.lower()](path)
    except OSError as error:
        raise CaseFileError(str(error)) from None
    named = {str(name): with_places(data[name], str(name)) for name in data.data_vars}
    names = [name for name, field in named.items() if {"x", "y"} <= set(map(str, field.dims))]
    if key is None and len(names) != 1:
        raise CaseFileError(f"choose one of its variables by key: {', '.join(names) or 'none lies along y and x'}")
    if key is not None and key not in data:
        raise CaseFileError(f"no variable {key!r} in it; it has {', '.join(names)}{nearest(key, names)}")
    return named[names[0]] if key is None else with_places(data[key], key)
