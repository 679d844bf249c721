"""What data files say of their size before any of it is read."""

from __future__ import annotations

import math
import re
import warnings
from io import BytesIO
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import CaseFileError
from ..foundation.limits import BYTES_OF_A_NUMBER, BYTES_OF_A_PIXEL, memory, refuse_too_many

if TYPE_CHECKING:
    from PIL.Image import Image

_HEADERS: dict[tuple[int, int], Any] = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}
"""What reads the header of a .npy file by the version of its format; later versions hold no plain numbers."""


_LONGEST_HEADER = 70_000
"""Bytes: more than numpy takes."""


def read_npy(stream: IO[bytes], size: int) -> NDArray[Any]:
    """Return the array of numbers in a .npy file, if the file is as long as its header says.

    Parameters
    ----------
    stream : file
        At the beginning.
    size : int
        Bytes that the file holds.

    Raises
    ------
    CaseFileError
        If the header is none of an array of numbers, or more entries are claimed than are taken, or than there are.

    Examples
    --------
    >>> import io
    >>> file = io.BytesIO()
    >>> np.save(file, np.zeros((2, 3)))
    >>> _ = file.seek(0)
    >>> read_npy(file, len(file.getvalue())).shape
    (2, 3)
    """
    _shape_of_npy(stream, size, whole=True)
    stream.seek(0)
    return np.asarray(np.lib.format.read_array(stream, allow_pickle=False))


def mapped_npy(file: Path) -> NDArray[Any]:
    """Return the array of numbers in a .npy file, of which no more is read than is asked for.

    Raises
    ------
    CaseFileError
        As `read_npy`, but however many entries there are.
    """
    with file.open("rb") as stream:
        shape = _shape_of_npy(stream, file.stat().st_size, whole=False)
    return np.asarray(np.load(file, mmap_mode="r" if math.prod(shape) else None, allow_pickle=False))


def _shape_of_npy(stream: IO[bytes], size: int, *, whole: bool) -> tuple[int, ...]:
    """Return the shape that the header tells, if it is that of an array of numbers, all of which are there."""
    head = BytesIO(stream.read(_LONGEST_HEADER))  # a header may claim to be longer than memory
    read_header = _HEADERS.get(np.lib.format.read_magic(head))
    if read_header is None:
        raise CaseFileError("expected an array of numbers; its format is one of records")
    shape, _, dtype = read_header(head)
    if dtype.kind not in "biuf":
        raise CaseFileError(f"expected an array of numbers, got {dtype} of shape {shape}")
    if not all(isinstance(length, int) and length >= 0 for length in shape):
        raise CaseFileError(f"its header claims the shape {shape}")
    count = math.prod(shape)
    if whole:
        refuse_too_many(count, "entries", BYTES_OF_A_NUMBER, "thin the data out")
    claimed = head.tell() + count * dtype.itemsize
    if claimed > size:
        raise CaseFileError(
            f"it is cut off: its header claims shape {shape} of {dtype}, that is {memory(claimed)}, "
            f"it has {memory(size)}"
        )
    return tuple(shape)


_PICTURES = ("BMP", "JPEG", "PNG", "TIFF")

_MOST_PIXELS_A_BYTE = 8 * 1032
"""Of a PNG file: its compression makes one byte of 1032 at most, and a pixel is a bit or more."""


def opened_picture(file: Path) -> Image:
    """Return a picture of which only the header is read; the caller closes it.

    Raises
    ------
    CaseFileError
        If it is cut off: its header claims more pixels than its file can hold.
    ValueError
        If it has more pixels than are taken.
    UnidentifiedImageError
        If it is no picture of the known kinds.
    """
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # its limit is not ours
            picture = Image.open(file, formats=_PICTURES)
    except Image.DecompressionBombError as error:
        told = re.search(r"(\d+) pixels", str(error))
        _refuse(int(told[1]) if told else 0)
        raise CaseFileError(str(error)) from None
    pixels = math.prod(picture.size)
    try:
        _refuse(pixels)
        if picture.format == "PNG" and pixels > _MOST_PIXELS_A_BYTE * file.stat().st_size:
            held = memory(file.stat().st_size)
            raise CaseFileError(f"it is cut off: its header claims {pixels:,} pixels, it has {held}")
    except (ValueError, CaseFileError):
        picture.close()
        raise
    return picture


def _refuse(pixels: int) -> None:
    refuse_too_many(pixels, "pixels", BYTES_OF_A_PIXEL, "scale the picture down")
