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
from ..geometry.lattice import Lattice
from ..profiles.sample_files import check_separators
from .headers import read_npy, refuse_large_picture


def existing_file(case_path: Path, key: str, name: str) -> Path:
    """Return the path of a file that a case names relative to its own folder."""
    file = case_path.parent / name
    try:
        known = file.is_file()
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
        Which array of a .npz file; None for its only one.
    delimiter, decimal : str
        What separates the columns of a .csv file, and what begins the decimals of its numbers.
    """

    key: str | None = None
    delimiter: str = ","
    decimal: str = "."


def read_array(case_path: Path, key: str, name: str, how: Reading) -> NDArray[np.float64]:
    """Return the two-dimensional array of numbers in a data file that a case names relative to its own folder."""
    file = existing_file(case_path, key, name)
    try:
        return read_numbers(file, how)
    except CaseFileError as error:
        raise CaseFileError(f"{case_path}: {key} = {shortened(name)!r}: {error}") from None


def read_numbers(file: Path, how: Reading) -> NDArray[np.float64]:
    """Return the two-dimensional array of numbers in a data file; one row where the file holds one dimension.

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
            values = np.asarray(reader(file, how))
    except CaseFileError:
        raise
    except Exception as error:  # what a decoder raises of a damaged file may be anything
        raise CaseFileError(f"cannot read it: {shortened(error, 200) or type(error).__name__}") from None
    array = np.atleast_2d(values)
    if array.ndim != 2 or array.dtype.kind not in "biuf":
        raise CaseFileError(f"expected a two-dimensional array of numbers, got {array.dtype} of shape {array.shape}")
    if not array.size:
        raise CaseFileError(f"it holds no numbers: its shape is {array.shape}")
    return array.astype(np.float64)


def _array(file: Path, how: Reading) -> NDArray[Any]:
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


def _table(file: Path, how: Reading) -> NDArray[Any]:
    check_separators(how.delimiter, how.decimal)
    with file.open(encoding="utf-8-sig") as lines:
        plain = lines if how.decimal == "." else (line.replace(how.decimal, ".") for line in lines)
        return np.loadtxt(plain, delimiter=how.delimiter, ndmin=2)


def _grey_levels(file: Path, how: Reading) -> NDArray[Any]:
    refuse_large_picture(file)
    from matplotlib import image

    pixels = np.asarray(image.imread(file))
    if pixels.dtype.kind in "ui":
        pixels = pixels / np.iinfo(pixels.dtype).max
    if pixels.ndim == 3:
        pixels = pixels[..., :3].mean(axis=2) if pixels.shape[2] >= 3 else pixels[..., 0]
    return np.asarray(pixels[::-1], dtype=np.float64)


READERS: dict[str, Callable[[Path, Reading], NDArray[Any]]] = {
    ".npy": _array,
    ".npz": _array_of_archive,
    ".csv": _table,
    ".png": _grey_levels,
    ".jpg": _grey_levels,
    ".tif": _grey_levels,
    ".bmp": _grey_levels,
}
"""What reads a file's array, by its suffix."""

_OTHER_SUFFIXES = {".jpeg": ".jpg", ".tiff": ".tif"}


def resampled(grid: NDArray[np.float64], lattice: Lattice) -> NDArray[np.float64]:
    """Interpolate bilinearly: the file's corners fall on the corners of the lattice's array."""
    from scipy.interpolate import RegularGridInterpolator

    axes = [np.linspace(0, 1, n) if n > 1 else np.array([0.0, 1.0]) for n in grid.shape]
    padded = np.repeat(grid, 2, axis=0) if grid.shape[0] == 1 else grid
    padded = np.repeat(padded, 2, axis=1) if grid.shape[1] == 1 else padded
    targets = [np.linspace(0, 1, n) if n > 1 else np.array([0.5]) for n in lattice.shape]
    points = np.stack(np.meshgrid(*targets, indexing="ij"), axis=-1)
    return np.asarray(RegularGridInterpolator(axes, padded)(points))
