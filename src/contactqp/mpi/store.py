"""One Zarr store that many processes write, each its own chunks."""

from __future__ import annotations

import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.loading import needed
from ..io.fields import Field
from ..io.zarr_stores import INSTALL
from .membrane import MembraneByRows
from .ranks import Ranks

_CHUNK = 64
"""Rows of a chunk, if every process has so many."""


def write_store(
    path: Path,
    ranks: Ranks,
    membrane: MembraneByRows,
    rows: tuple[int, int],
    fields: Mapping[str, Field],
    facts: Mapping[str, Any],
) -> Path:
    """Write fields into a folder, replacing one of that name as a whole; all processes must call it.

    A chunk is written by the process that has its first row: what it lacks of the last one its neighbour sends.

    Parameters
    ----------
    path : Path
    ranks : Ranks
    membrane : MembraneByRows
        It tells the places of rows and columns.
    rows : (int, int)
        The rows [first, last) of this process.
    fields : mapping of str to Field
        Values on these rows, shape (rows, columns).
    facts : mapping of str to value
        Attributes of the store.

    Raises
    ------
    ImportError, OSError
        If zarr is not installed, or the store cannot be written; in every process.
    """
    needed("zarr", "writing .zarr", INSTALL)
    unfinished = path.with_name(f".{path.name}.unfinished")
    first, last = rows
    chunk = min(_CHUNK, *ranks.everyones([last - first]))
    ranks.agreed(lambda: None if ranks.rank else _create(unfinished, membrane, fields, facts, chunk))
    begin, end = (min(-(-row // chunk) * chunk, membrane.shape[0]) for row in rows)
    whole = {name: _up_to_chunk(ranks, field.values, begin - first, end - last) for name, field in fields.items()}
    ranks.agreed(lambda: _fill(unfinished, whole, begin, end))
    ranks.agreed(lambda: None if ranks.rank else _replace(unfinished, path))
    return path


def facts_of_store(path: Path) -> dict[str, Any]:
    """Return a store's attributes; none where there is no such store, or one that cannot be read."""
    try:
        group = needed("zarr", "reading .zarr", INSTALL).open_group(path, mode="r")
        return dict(group.attrs)
    except (OSError, ValueError, KeyError):
        return {}


def opened(path: Path) -> Any:
    """Return a store to read from.

    Raises
    ------
    ImportError
        If zarr is not installed.
    OSError
        If there is none, or it cannot be read.
    """
    zarr = needed("zarr", "reading .zarr", INSTALL)
    try:
        return zarr.open_group(path, mode="r")
    except Exception as error:  # whatever it says of what is no store
        raise OSError(f"{path} is no Zarr store, or a damaged one: {error}") from None


def _create(
    folder: Path, membrane: MembraneByRows, fields: Mapping[str, Field], facts: Mapping[str, Any], chunk: int
) -> None:
    zarr = needed("zarr", "writing .zarr", INSTALL)
    shutil.rmtree(folder, ignore_errors=True)
    group = zarr.open_group(folder, mode="w", zarr_format=3, attributes=dict(facts))
    for name, places in (("y", membrane.y(0, membrane.shape[0])), ("x", membrane.x)):
        axis = group.create_array(
            name, shape=places.shape, dtype="float64", dimension_names=(name,), attributes={"units": "length"}
        )
        axis[:] = places
    for name, field in fields.items():
        group.create_array(
            name,
            shape=membrane.shape,
            chunks=(chunk, membrane.shape[1]),
            dtype="float64",
            fill_value=np.nan,
            dimension_names=("y", "x"),
            attributes={"units": field.unit, "long_name": field.meaning},
        )


def _up_to_chunk(ranks: Ranks, values: NDArray[Any], lent: int, lacking: int) -> NDArray[Any]:
    """Return the rows that a process writes: without those it lends the process before, with those it lacks."""
    borrowed = np.empty((lacking, *values.shape[1:]), dtype=values.dtype)
    given = [(ranks.rank - 1, values[:lent])] if ranks.rank > 0 else []
    wanted = [(ranks.rank + 1, borrowed)] if ranks.rank < ranks.size - 1 else []
    ranks.exchange(given, wanted)
    return np.concatenate([values[lent:], borrowed])


def _fill(folder: Path, whole: Mapping[str, NDArray[Any]], begin: int, end: int) -> None:
    group = needed("zarr", "writing .zarr", INSTALL).open_group(folder, mode="r+")
    for name, values in whole.items():
        group[name][begin:end] = values


def _replace(folder: Path, path: Path) -> None:
    if path.exists():
        shutil.rmtree(path)
    os.replace(folder, path)
