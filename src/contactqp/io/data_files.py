"""Data files that a case names: arrays, tables and images, told apart by their suffix."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

from ..errors import CaseFileError
from ..foundation.checks import nearest
from ..foundation.text import shortened
from ..profiles.sample_files import check_separators, read_points
from .headers import mapped_npy, read_npy
from .rasters import Raster, raster_of_points, read_picture, read_tiff


def existing_file(case_path: Path, key: str, name: str) -> Path:
    """Return the path of a file that a case names relative to its own folder."""
    file = case_path.parent / name
    try:
        known = file.exists() if file.suffix.lower() == ".zarr" else file.is_file()
    except (OSError, ValueError):  # a name that no file can have
        known = False
    if not known:
        raise CaseFileError(f"{case_path}: {key} = {shortened(name)!r}: there is no file {shortened(file, 200)}")
    return file


@dataclass(frozen=True)
class Reading:
    """How a data file is to be read, where its suffix leaves that open.

    Attributes
    ----------
    key : str or None
        Which array of a .npz file, column of a table with x and y, or band of a .tif file; None for the only one.
    delimiter, decimal : str
        What separates the columns of a .csv file, and what begins the decimals of its numbers.
    by_rows : bool
        Whether no more is to be read than the rows that are asked for later, where the kind of file allows it: .npy,
        and .tif if rasterio is installed.
    """

    key: str | None = None
    delimiter: str = ","
    decimal: str = "."
    by_rows: bool = False


def read_raster(case_path: Path, key: str, name: str, how: Reading) -> Raster:
    """Return the numbers of a data file that a case names relative to its own folder."""
    file = existing_file(case_path, key, name)
    try:
        return read_numbers(file, how)
    except CaseFileError as error:
        raise CaseFileError(f"{case_path}: {key} = {shortened(name)!r}: {error}") from None


def read_numbers(file: Path, how: Reading) -> Raster:
    """Return the numbers of a data file, in two dimensions; one row where the file holds one dimension.

    Raises
    ------
    CaseFileError
        If its suffix is unknown, or it cannot be read, or holds anything else.
    """
    suffix = file.suffix.lower()
    reader = READERS.get(_OTHER_SUFFIXES.get(suffix, suffix))
    if reader is None:
        raise CaseFileError(f"unknown kind {suffix!r}; known: {' '.join(READERS)}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # decoders warn of a damaged file before they refuse it
            found = reader(file, how)
    except CaseFileError:
        raise
    except Exception as error:  # what a decoder raises of a damaged file may be anything
        raise CaseFileError(f"cannot read it: {shortened(error, 200) or type(error).__name__}") from None
    raster = found if isinstance(found, Raster) else Raster(found)
    array = np.atleast_2d(raster.values) if isinstance(raster.values, np.ndarray) else raster.values
    if len(array.shape) != 2 or array.dtype.kind not in "biuf":
        raise CaseFileError(f"expected a two-dimensional array of numbers, got {array.dtype} of shape {array.shape}")
    if 0 in array.shape:
        raise CaseFileError(f"it holds no numbers: its shape is {array.shape}")
    return raster._replace(values=array)


def _array(file: Path, how: Reading) -> NDArray[Any]:
    if how.by_rows:
        return mapped_npy(file)
    with file.open("rb") as stream:
        return read_npy(stream, file.stat().st_size)


def _array_of_archive(file: Path, how: Reading) -> NDArray[Any]:
    with ZipFile(file) as archive:
        entries = {entry.filename.removesuffix(".npy"): entry for entry in archive.infolist()}
        names = shortened(", ".join(entries), 200)
        if how.key is None and len(entries) != 1:
            raise CaseFileError(f"choose one of its arrays by key: {names}")
        if how.key is not None and how.key not in entries:
            raise CaseFileError(f"no array {how.key!r} in it; it has {names}{nearest(how.key, entries)}")
        entry = entries[how.key] if how.key is not None else next(iter(entries.values()))
        with archive.open(entry) as stream:
            return read_npy(stream, entry.file_size)


def _table(file: Path, how: Reading) -> NDArray[Any] | Raster:
    if _names_places(file, how.delimiter):
        return _points(file, how)
    check_separators(how.delimiter, how.decimal)
    with file.open(encoding="utf-8-sig") as lines:
        plain = lines if how.decimal == "." else (line.replace(how.decimal, ".") for line in lines)
        return np.loadtxt(plain, delimiter=how.delimiter, ndmin=2)


def _points(file: Path, how: Reading) -> Raster:
    """Return the values of a file with x, y and a value in each line, whose places are those of a grid."""
    given = {"delimiter": how.delimiter, "decimal": how.decimal}
    try:
        found = read_points(file, depth=how.key, **given, called="key", unchecked=True)
    except ValueError as error:
        raise CaseFileError(str(error).removeprefix(str(file)).lstrip(":, ")) from None
    return raster_of_points(*found.values.T)


def _names_places(file: Path, delimiter: str) -> bool:
    """Whether the first line of a .csv file names columns x and y."""
    with file.open(encoding="utf-8-sig", errors="replace") as lines:
        return {"x", "y"} <= {name.strip().lower() for name in lines.readline(100_000).split(delimiter)}


def _picture(file: Path, how: Reading) -> Raster:
    return read_picture(file)


def _tiff(file: Path, how: Reading) -> Raster:
    return read_tiff(file, how.key, by_rows=how.by_rows)


READERS: dict[str, Callable[[Path, Reading], NDArray[Any] | Raster]] = {
    ".npy": _array,
    ".npz": _array_of_archive,
    ".csv": _table,
    ".xyz": _points,
    ".png": _picture,
    ".jpg": _picture,
    ".tif": _tiff,
    ".bmp": _picture,
}
"""What reads a file's numbers, by its suffix in small letters.

Each takes the path and how the case wants it read, and returns a plain array of one or two dimensions, whose rows go
up (the first is that of the smallest y), or a `Raster`, which tells rows, missing values and places itself. It may
raise what it likes of a damaged file: the message names file and key.
"""

_OTHER_SUFFIXES = {".jpeg": ".jpg", ".tiff": ".tif"}
