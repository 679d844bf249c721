"""Pictures and TIFF files as arrays of numbers: grey levels of the one, values as they are stored of the other."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import CaseFileError
from ..foundation.checks import Vector
from ..geometry.fields import Rows
from .headers import opened_picture

if TYPE_CHECKING:
    from PIL.Image import Image


class Raster(NamedTuple):
    """The numbers of a data file, in the order of its rows.

    Attributes
    ----------
    values : array, shape (rows, columns)
        As they are stored; of a picture grey levels from 0 (black) to 1 (white).
    rows : {"up", "down"}
        Which way y goes from row to row where nothing else tells it: up, but down in pictures.
    no_data : float or None
        The value that stands for none, if the file names one.
    places : pair of arrays, shape (columns,) and (rows,), or None
        x of the columns and y of the rows (length), if the file holds a geo-transform.
    """

    values: NDArray[Any]
    rows: Rows = "up"
    no_data: float | None = None
    places: tuple[Vector, Vector] | None = None


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


def read_tiff(file: Path) -> Raster:
    """Return the numbers of a TIFF file of one band as they are stored, its no-data value and its geo-transform."""
    with _opened(file) as picture:
        tags: Any = picture.tag_v2  # type: ignore[attr-defined]
        _refuse_other_pages(picture)
        bands = int(tags.get(_SAMPLES, 1))
        if bands != 1:
            raise CaseFileError(f"a TIFF file of {bands} bands; extract the one that holds the values")
        kind = int(tags.get(_BITS, (1,))[0]), int(tags.get(_FORMAT, (_UNSIGNED,))[0])
        if kind not in _KINDS or int(tags.get(_PHOTOMETRIC, _BLACK_IS_ZERO)) != _BLACK_IS_ZERO:
            raise CaseFileError(_OTHER_KIND)
        values = np.asarray(picture).astype(_KINDS[kind])
        no_data = _no_data(tags)
        return Raster(values, "down", no_data, _places(tags, values.shape))


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
        raise CaseFileError(f"it is no picture, or a damaged one{other}") from None


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
