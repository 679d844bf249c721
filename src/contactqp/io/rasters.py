"""Pictures and TIFF files as arrays of numbers: grey levels of the one, values as they are stored of the other."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..errors import CaseFileError
from ..foundation.checks import Vector, nearest
from ..foundation.limits import BYTES_OF_A_PIXEL, refuse_too_many
from ..foundation.loading import loaded
from ..geometry.fields import Rows
from .headers import opened_picture

if TYPE_CHECKING:
    from PIL.Image import Image


class Stored(Protocol):
    """Numbers of a file, read by ``stored[first:last]`` if they are not in memory."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Rows and columns."""

    @property
    def dtype(self) -> np.dtype[Any]:
        """The kind of the numbers."""

    def __getitem__(self, rows: slice, /) -> NDArray[Any]:
        """Return some rows."""


class Raster(NamedTuple):
    """The numbers of a data file, in the order of its rows.

    Attributes
    ----------
    values : array, shape (rows, columns), or Stored
        As they are stored; of a picture grey levels from 0 (black) to 1 (white).
    rows : {"up", "down"}
        Which way y goes from row to row where nothing else tells it: up, but down in pictures.
    no_data : float or None
        The value that stands for none, if the file names one.
    places : pair of arrays, shape (columns,) and (rows,), or None
        x of the columns and y of the rows (length), if the file holds a geo-transform.
    crs : str
        The coordinate reference system of these, as ``"EPSG:25832"``; ``""`` if the file tells none.
    """

    values: NDArray[Any] | Stored
    rows: Rows = "up"
    no_data: float | None = None
    places: tuple[Vector, Vector] | None = None
    crs: str = ""


def raster_of_points(x: Vector, y: Vector, values: Vector) -> Raster:
    """Return the values at points that are those of a grid of equal steps, nan where there is none.

    Raises
    ------
    CaseFileError
        If they are not, or two lie at one place.
    """
    grids = []
    for name, places in (("x", x), ("y", y)):
        along = np.unique(places)
        steps = np.diff(along)
        if along.size > 1 and (not np.isfinite(along).all() or np.ptp(steps) > 1e-6 * steps.min()):
            raise CaseFileError(
                f"its points lie on no grid of equal steps along {name}: interpolate them onto one, or onto the nodes"
            )
        grids.append(along)
    column, row = np.searchsorted(grids[0], x), np.searchsorted(grids[1], y)
    places, counts = np.unique(row * grids[0].size + column, return_counts=True)
    if (counts > 1).any():
        k = np.flatnonzero(row * grids[0].size + column == places[counts.argmax()])[0]
        raise CaseFileError(f"it has {counts.max()} values at x = {x[k]:g}, y = {y[k]:g}; leave one")
    refuse_too_many(grids[0].size * grids[1].size, "places", BYTES_OF_A_PIXEL, "thin the data out")
    grid = np.full((grids[1].size, grids[0].size), np.nan)
    grid[row, column] = values
    return Raster(grid, "up", None, (grids[0], grids[1]))


def read_picture(file: Path) -> Raster:
    """Return the grey levels of a picture of 8 bits a channel; colours count by the mean of red, green and blue."""
    with _opened(file) as picture:
        if picture.format == "PNG" and _png_depth(file) > 8:
            raise CaseFileError(
                "a picture of 16 bits: grey levels have 8; save numbers as .tif or .npy, which are taken as they are"
            )
        if picture.mode in ("1", "L", "LA"):
            levels = np.asarray(picture.convert("L"), dtype=np.float64)
        else:
            levels = np.asarray(picture.convert("RGB"), dtype=np.float64).mean(axis=2)
    return Raster(levels / 255, "down")


def _png_depth(file: Path) -> int:
    """Return the bits a channel, which Pillow reduces to 8 without a word where a pixel has several channels."""
    with file.open("rb") as stream:
        return stream.read(25)[24]


_BITS, _PHOTOMETRIC, _SAMPLES, _FORMAT, _SUBFILE = 258, 262, 277, 339, 254
_BLACK_IS_ZERO, _SMALLER_COPY = 1, 1
_PIXEL_SCALE, _TIE_POINT, _TRANSFORMATION, _GEO_KEYS, _NO_DATA = 33550, 33922, 34264, 34735, 42113
_RASTER_TYPE, _PIXEL_IS_POINT = 1025, 2
_UNSIGNED, _SIGNED, _FLOAT = 1, 2, 3

_KINDS = {
    (8, _UNSIGNED): "u1",
    (16, _UNSIGNED): "u2",
    (16, _SIGNED): "i2",
    (32, _SIGNED): "i4",
    (32, _FLOAT): "f4",
}
"""The numbers that Pillow hands on as they are stored, by bits and sample format."""


def read_tiff(file: Path, band: str | None = None, *, by_rows: bool = False) -> Raster:
    """Return the numbers of a TIFF file as they are stored, its no-data value, its geo-transform and its system.

    Files of several bands, and of numbers that Pillow does not know, are read by rasterio, if it is installed.

    Parameters
    ----------
    file : Path
    band : str or None
        The name or the number, from 1 on, of the band; None for the only one.
    by_rows : bool
        Whether to leave the numbers in the file until their rows are asked for, which rasterio reads.
    """
    try:
        if band is None:
            return _by_pillow(file, by_rows=by_rows)
        refusal = CaseFileError(f"band {band!r} of a TIFF file is read by rasterio: pip install 'contactqp[geo]'")
    except CaseFileError as error:
        if _OTHER_KIND not in str(error) and "bands" not in str(error):
            raise
        refusal = error
    try:
        rasterio = loaded("rasterio")
    except ImportError:
        raise refusal from None
    try:
        return _by_rasterio(rasterio, file, band, by_rows=by_rows)
    except rasterio.errors.RasterioError:
        raise refusal from None


_STORED = ("uint8", "int8", "uint16", "int16", "uint32", "int32", "float32", "float64")


class RowsOfTiff:
    """The numbers of a band of a TIFF file, which stay there until their rows are asked for.

    Parameters
    ----------
    file : Path
    band : int
        From 1 on.
    shape : (int, int)
    dtype : numpy.dtype
    """

    def __init__(self, file: Path, band: int, shape: tuple[int, ...], dtype: np.dtype[Any]) -> None:
        self.shape, self.dtype = shape, dtype
        self._file, self._band = file, band

    def __getitem__(self, rows: slice) -> NDArray[Any]:
        """Return some rows."""
        first, last, _ = rows.indices(self.shape[0])
        if first >= last:
            return np.empty((0, self.shape[1]), dtype=self.dtype)
        with _opened_by_rasterio(loaded("rasterio"), self._file) as data:
            return np.asarray(data.read(self._band, window=((first, last), (0, self.shape[1]))))


@contextmanager
def _opened_by_rasterio(rasterio: Any, file: Path) -> Iterator[Any]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rasterio.errors.NotGeoreferencedWarning)
        with rasterio.open(file, driver="GTiff") as data:
            yield data


def _by_rasterio(rasterio: Any, file: Path, band: str | None, *, by_rows: bool) -> Raster:
    with _opened_by_rasterio(rasterio, file) as data:
        if not by_rows:
            refuse_too_many(data.width * data.height, "pixels", BYTES_OF_A_PIXEL, "scale the picture down")
        names = [name or str(number) for number, name in enumerate(data.descriptions, 1)]
        if band is None and data.count != 1:
            raise CaseFileError(f"a TIFF file of {data.count} bands; choose one by key: {', '.join(names)}")
        known = [*names, *map(str, range(1, data.count + 1))]
        if band is not None and band not in known:
            raise CaseFileError(f"no band {band!r} in it; it has {', '.join(names)}{nearest(band, names)}")
        number = 1 if band is None else names.index(band) + 1 if band in names else int(band)
        palette = data.colorinterp[number - 1] == rasterio.enums.ColorInterp.palette
        if palette or data.tags(ns="IMAGE_STRUCTURE").get("MINISWHITE") or data.dtypes[number - 1] not in _STORED:
            raise CaseFileError(_OTHER_KIND)
        if data.subdatasets:
            raise CaseFileError("a TIFF file of several pages; extract the one that holds the values")
        move, kind = data.transform, np.dtype(data.dtypes[number - 1])
        values = RowsOfTiff(file, number, data.shape, kind) if by_rows else data.read(number)
        if move.b or move.d:
            raise CaseFileError("its geo-transform turns or shears the rows; bring it to rows along x first")
        places = None
        if not move.is_identity:
            x = move.c + move.a * (np.arange(data.width) + 0.5)
            places = x, move.f + move.e * (np.arange(data.height) + 0.5)
        crs = data.crs.to_string() if data.crs else ""
        return Raster(values, "down", data.nodata, places, crs)


def _by_pillow(file: Path, *, by_rows: bool) -> Raster:
    by_rows = by_rows and _has_rasterio()
    with _opened_of_any_size(file) if by_rows else _opened(file) as picture:
        tags: Any = picture.tag_v2  # type: ignore[attr-defined]
        _refuse_other_pages(picture)
        bands = int(tags.get(_SAMPLES, 1))
        if bands != 1:
            raise CaseFileError(f"a TIFF file of {bands} bands; extract the one that holds the values")
        kind = int(tags.get(_BITS, (1,))[0]), int(tags.get(_FORMAT, (_UNSIGNED,))[0])
        if kind not in _KINDS or int(tags.get(_PHOTOMETRIC, _BLACK_IS_ZERO)) != _BLACK_IS_ZERO:
            raise CaseFileError(_OTHER_KIND)
        shape, dtype = picture.size[::-1], np.dtype(_KINDS[kind])
        values = RowsOfTiff(file, 1, shape, dtype) if by_rows else np.asarray(picture).astype(dtype)
        return Raster(values, "down", _no_data(tags), _places(tags, shape), _crs(tags))


def _has_rasterio() -> bool:
    try:
        loaded("rasterio")
    except ImportError:
        return False
    return True


_OTHER_KIND = (
    "a kind of TIFF file whose values cannot be had as they are stored; known are integers of 8, 16 and 32 bits "
    "and float32, black at 0 and without a palette: convert it to float32, or save the numbers as .npy"
)


def _opened(file: Path) -> Image:
    from PIL import UnidentifiedImageError

    try:
        return opened_picture(file)
    except UnidentifiedImageError:
        other = f", or {_OTHER_KIND}" if file.suffix.lower().startswith(".tif") else ""
        raise CaseFileError(f"{_NO_PICTURE}{other}") from None


def _opened_of_any_size(file: Path) -> Image:
    """Return a TIFF file of which nothing but the header is to be read."""
    from PIL.TiffImagePlugin import TiffImageFile

    try:
        return TiffImageFile(file)
    except SyntaxError:
        raise CaseFileError(f"{_NO_PICTURE}, or {_OTHER_KIND}") from None


_NO_PICTURE = "it is no picture, or a damaged one"


def _refuse_other_pages(picture: Image) -> None:
    """Raise unless what follows the first page are smaller copies of it."""
    for page in range(1, getattr(picture, "n_frames", 1)):
        picture.seek(page)
        if int(picture.tag_v2.get(_SUBFILE, 0)) != _SMALLER_COPY:  # type: ignore[attr-defined]
            raise CaseFileError("a TIFF file of several pages; extract the one that holds the values")
    picture.seek(0)


def _no_data(tags: Any) -> float | None:
    text = str(tags.get(_NO_DATA, "")).strip(" \0")
    if not text:
        return None
    try:
        return float(text)
    except ValueError:
        raise CaseFileError(f"its no-data value is {text!r}, which is no number") from None


_PROJECTED, _USER_DEFINED = 3072, 32767


def _crs(tags: Any) -> str:
    """Return the EPSG code of the file's projected system, ``""`` where none is told."""
    keys = tags.get(_GEO_KEYS, ())
    codes = [keys[k + 3] for k in range(4, len(keys) - 3, 4) if keys[k] == _PROJECTED]
    return f"EPSG:{codes[0]}" if codes and codes[0] not in (0, _USER_DEFINED) else ""


def _places(tags: Any, shape: tuple[int, ...]) -> tuple[Vector, Vector] | None:
    """Return x of the columns' and y of the rows' middles by the file's geo-transform; None if it has none."""
    if _TRANSFORMATION in tags:
        matrix = np.array(tags[_TRANSFORMATION], dtype=np.float64)
        if matrix.size != 16 or matrix[1] or matrix[4]:
            raise CaseFileError("its geo-transform turns or shears the rows; bring it to rows along x first")
        (step_x, origin_x), (step_y, origin_y) = matrix[[0, 3]], matrix[[5, 7]]
    elif _PIXEL_SCALE in tags and _TIE_POINT in tags:
        scale, tie = (np.array(tags[key], dtype=np.float64) for key in (_PIXEL_SCALE, _TIE_POINT))
        if tie.size != 6:
            raise CaseFileError(f"its geo-transform has {tie.size // 6} tie points; bring it to one first")
        step_x, step_y = scale[0], -scale[1]
        origin_x, origin_y = tie[3] - tie[0] * step_x, tie[4] - tie[1] * step_y
    else:
        return None
    steps = float(step_x), float(step_y)
    if not (math.isfinite(steps[0]) and math.isfinite(steps[1]) and steps[0] > 0 and steps[1] != 0):
        raise CaseFileError(f"its geo-transform has steps of {steps[0]:g} along x and {steps[1]:g} along y")
    keys = tags.get(_GEO_KEYS, ())
    types = [keys[k + 3] for k in range(4, len(keys) - 3, 4) if keys[k] == _RASTER_TYPE]
    middle = 0.0 if types == [_PIXEL_IS_POINT] else 0.5
    return (
        origin_x + steps[0] * (np.arange(shape[1]) + middle),
        origin_y + steps[1] * (np.arange(shape[0]) + middle),
    )
