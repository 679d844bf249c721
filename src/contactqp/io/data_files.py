"""Data files that a case names: arrays, tables and images, told apart by their suffix."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import CaseFileError
from ..foundation.loading import load_modules
from ..geometry.lattice import Lattice


def existing_file(case_path: Path, key: str, name: str) -> Path:
    """Return the path of a file that a case names relative to its own folder."""
    file = case_path.parent / name
    if not file.is_file():
        raise CaseFileError(f"{case_path}: {key} = {name!r}: there is no file {file}")
    return file


def read_array(case_path: Path, key: str, name: str, entry: str | None) -> NDArray[np.float64]:
    """Return the two-dimensional array of numbers in a data file that a case names relative to its own folder."""
    file = existing_file(case_path, key, name)
    where = f"{case_path}: {key} = {name!r}"
    suffix = file.suffix.lower()
    reader = READERS.get(_OTHER_SUFFIXES.get(suffix, suffix))
    if reader is None:
        raise CaseFileError(f"{where}: unknown kind {suffix!r}; known: {' '.join(READERS)}")
    try:
        values = reader(file, entry)
    except CaseFileError as error:
        raise CaseFileError(f"{where}: {error}") from None
    except (ValueError, OSError) as error:
        raise CaseFileError(f"{where}: cannot read it: {error}") from None
    array = np.atleast_2d(np.asarray(values))
    if array.ndim != 2 or array.dtype.kind not in "biuf":
        raise CaseFileError(
            f"{where}: expected a two-dimensional array of numbers, got {array.dtype} of shape {array.shape}"
        )
    return array.astype(np.float64)


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


def _grey_levels(file: Path, entry: str | None) -> NDArray[Any]:
    load_modules("matplotlib.image")
    from matplotlib import image

    pixels = np.asarray(image.imread(file))
    if pixels.dtype.kind in "ui":
        pixels = pixels / np.iinfo(pixels.dtype).max
    if pixels.ndim == 3:
        pixels = pixels[..., :3].mean(axis=2) if pixels.shape[2] >= 3 else pixels[..., 0]
    return np.asarray(pixels[::-1], dtype=np.float64)


READERS: dict[str, Callable[[Path, str | None], NDArray[Any]]] = {
    ".npy": _array,
    ".npz": _array_of_archive,
    ".csv": _table,
    ".png": _grey_levels,
    ".jpg": _grey_levels,
    ".tif": _grey_levels,
    ".bmp": _grey_levels,
}
"""What reads a file's array, by its suffix; where a file holds several, it takes the name of one."""

_OTHER_SUFFIXES = {".jpeg": ".jpg", ".tiff": ".tif"}


def resampled(grid: NDArray[np.float64], lattice: Lattice) -> NDArray[np.float64]:
    """Interpolate bilinearly: the file's corners fall on the corners of the lattice's array."""
    load_modules("scipy.interpolate")
    from scipy.interpolate import RegularGridInterpolator

    axes = [np.linspace(0, 1, n) if n > 1 else np.array([0.0, 1.0]) for n in grid.shape]
    padded = np.repeat(grid, 2, axis=0) if grid.shape[0] == 1 else grid
    padded = np.repeat(padded, 2, axis=1) if grid.shape[1] == 1 else padded
    targets = [np.linspace(0, 1, n) if n > 1 else np.array([0.5]) for n in lattice.shape]
    points = np.stack(np.meshgrid(*targets, indexing="ij"), axis=-1)
    return np.asarray(RegularGridInterpolator(axes, padded)(points))
