"""Data files that a case names: arrays, tables and images, told apart by their suffix."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import CaseFileError
from .rasters import Raster, read_picture, read_tiff


def existing_file(case_path: Path, key: str, name: str) -> Path:
    """Return the path of a file that a case names relative to its own folder."""
    file = case_path.parent / name
    if not file.is_file():
        raise CaseFileError(f"{case_path}: {key} = {name!r}: there is no file {file}")
    return file


def read_raster(case_path: Path, key: str, name: str, entry: str | None) -> Raster:
    """Return the two-dimensional array of numbers in a data file that a case names relative to its own folder."""
    file = existing_file(case_path, key, name)
    where = f"{case_path}: {key} = {name!r}"
    suffix = file.suffix.lower()
    reader = READERS.get(_OTHER_SUFFIXES.get(suffix, suffix))
    if reader is None:
        raise CaseFileError(f"{where}: unknown kind {suffix!r}; known: {' '.join(READERS)}")
    try:
        found = reader(file, entry)
    except CaseFileError as error:
        raise CaseFileError(f"{where}: {error}") from None
    except (ValueError, OSError) as error:
        raise CaseFileError(f"{where}: cannot read it: {error}") from None
    raster = found if isinstance(found, Raster) else Raster(np.asarray(found))
    array = np.atleast_2d(raster.values)
    if array.ndim != 2 or array.dtype.kind not in "biuf":
        raise CaseFileError(
            f"{where}: expected a two-dimensional array of numbers, got {array.dtype} of shape {array.shape}"
        )
    return raster._replace(values=array)


def _array(file: Path, entry: str | None) -> NDArray[Any]:
    return np.asarray(np.load(file))


def _array_of_archive(file: Path, entry: str | None) -> NDArray[Any]:
    with np.load(file) as archive:
        names = list(archive)
        if entry is None and len(names) != 1:
            raise CaseFileError(f"choose one of its arrays by key: {', '.join(names)}")
        if entry is not None and entry not in names:
            raise CaseFileError(f"no array {entry!r} in it; it has {', '.join(names)}")
        return np.asarray(archive[entry or names[0]])


def _table(file: Path, entry: str | None) -> NDArray[Any]:
    return np.loadtxt(file, delimiter=",", ndmin=2)


def _picture(file: Path, entry: str | None) -> Raster:
    return read_picture(file)


def _tiff(file: Path, entry: str | None) -> Raster:
    return read_tiff(file)


READERS: dict[str, Callable[[Path, str | None], NDArray[Any] | Raster]] = {
    ".npy": _array,
    ".npz": _array_of_archive,
    ".csv": _table,
    ".png": _picture,
    ".jpg": _picture,
    ".tif": _tiff,
    ".bmp": _picture,
}
"""What reads a file's array, by its suffix: a plain one, whose rows go up, or a `Raster`.

Where a file holds several, it takes the name of one.
"""

_OTHER_SUFFIXES = {".jpeg": ".jpg", ".tiff": ".tif"}
