"""Checks of arguments, shared by every public entry: name, value and remedy in the message."""

from __future__ import annotations

import math
import operator
from difflib import get_close_matches
from os import PathLike
from typing import TYPE_CHECKING, Any, SupportsIndex, cast

import numpy as np
from numpy.typing import NDArray

from .text import shortened

if TYPE_CHECKING:
    from collections.abc import Iterable

Vector = NDArray[np.float64]
Mask = NDArray[np.bool_]


def finite_number(value: object, name: str) -> float:
    """Return ``value`` as a float; it must be a real, finite scalar."""
    refused = (bool, np.bool_, str, bytes, complex, np.complexfloating)
    if hasattr(value, "magnitude") and hasattr(value, "units"):
        raise TypeError(f"{name} has a unit, {value!r}, which would be lost: hand over its magnitude")
    if isinstance(value, refused) or np.ndim(cast("Any", value)):
        raise TypeError(f"{name} must be a real number, got {value!r}")
    try:
        number = float(cast("Any", value))
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be a real number, got {value!r}") from None
    except OverflowError:
        raise ValueError(f"{name} must be finite, got a number beyond double precision") from None
    if not math.isfinite(number):
        raise ValueError(f"{name} must be finite, got {number}")
    return number


def positive_number(value: object, name: str) -> float:
    """Return ``value`` as a float > 0."""
    number = finite_number(value, name)
    if number <= 0:
        raise ValueError(f"{name} must be > 0, got {number:g}")
    return number


def open_interval(value: object, low: float, high: float, name: str) -> float:
    """Return ``value`` as a float strictly between ``low`` and ``high``."""
    number = finite_number(value, name)
    if not low < number < high:
        raise ValueError(f"{name} must lie strictly between {low:g} and {high:g}, got {number:g}")
    return number


def boolean(value: object, name: str) -> bool:
    """Return ``value`` as a bool; numbers and words are refused."""
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} must be True or False, got {value!r}")
    return bool(value)


def integer_at_least(value: object, low: int, name: str) -> int:
    """Return ``value`` as an int >= ``low``; floats with a whole value are refused as well."""
    if isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} must be an integer, got {value!r}")
    try:
        number = operator.index(cast("SupportsIndex", value))
    except TypeError:
        raise TypeError(f"{name} must be an integer, got {value!r}") from None
    if number < low:
        raise ValueError(f"{name} must be >= {low}, got {number}")
    return number


def integers_at_least(value: object, low: int, name: str) -> list[int]:
    """Return integers >= ``low``, given as a sequence of them or as one.

    Examples
    --------
    >>> integers_at_least((31, 63), 1, "sizes"), integers_at_least(31, 1, "sizes")
    ([31, 63], [31])
    >>> integers_at_least("31,63", 1, "sizes")
    Traceback (most recent call last):
    ...
    TypeError: sizes must be an integer or a sequence of integers, as [31, 63], got '31,63'
    """
    if hasattr(value, "__index__") and not np.ndim(cast("Any", value)):
        return [integer_at_least(value, low, name)]
    try:
        several = [] if isinstance(value, (str, bytes)) else list(cast("Iterable[object]", value))
    except TypeError:
        several = []
    if not several and not (hasattr(value, "__len__") and len(value) == 0):
        raise TypeError(f"{name} must be an integer or a sequence of integers, as [31, 63], got {value!r}")
    return [integer_at_least(one, low, name) for one in several]


def names_in(value: object, name: str) -> list[str]:
    """Return names, given as a sequence of them.

    Examples
    --------
    >>> names_in(("low", "mid"), "levels")
    ['low', 'mid']
    >>> names_in("mid", "levels")
    Traceback (most recent call last):
    ...
    TypeError: levels must be a sequence of names, got 'mid' alone; write ['mid']
    """
    if isinstance(value, str):
        raise TypeError(f"{name} must be a sequence of names, got {value!r} alone; write [{value!r}]")
    try:
        return list(cast("Iterable[str]", value))
    except TypeError:
        raise TypeError(f"{name} must be a sequence of names, got {value!r}") from None


def real_array(value: object, name: str, *, copied: bool = True) -> NDArray[np.float64]:
    """Return ``value`` as a float array, a new one unless told otherwise; complex and non-numeric data are refused."""
    if hasattr(value, "magnitude") and hasattr(value, "units"):
        raise TypeError(f"{name} has a unit, {shortened(repr(value))}, which would be lost: hand over its magnitude")
    if np.ma.is_masked(value):
        raise ValueError(f"{name} has masked entries; fill them first")
    try:
        array = np.asarray(value)
    except ValueError:
        raise ValueError(f"{name} must hold numbers in rows of one length, got {_told(value)}") from None
    if array.dtype.kind == "c":
        raise TypeError(f"{name} must be real, got complex values (dtype {array.dtype})")
    if isinstance(value, (str, PathLike)):
        raise TypeError(
            f"{name} must hold real numbers, got {_told(value)}; if that is a file, contactqp.read_field reads numbers "
            "and fields from it, and contactqp.read_surface a map of heights"
        )
    if hasattr(value, "toarray") and hasattr(value, "shape"):
        dense = f"{name}.toarray(){_straightened(value.shape)}"
        raise TypeError(f"{name} must be a dense array, got a sparse one of shape {value.shape}; hand over {dense}")
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{name} must hold real numbers, got {_told(value)} (dtype {array.dtype})")
    return np.array(array, dtype=np.float64) if copied else np.asarray(array, dtype=np.float64)


def _told(value: object) -> str:
    return f"an array of shape {value.shape}" if isinstance(value, np.ndarray) else shortened(repr(value))


def vector(value: object, size: int, name: str, *, copied: bool = True) -> Vector:
    """Return ``value`` as a float vector of exactly ``size`` finite entries, a new one unless told otherwise."""
    array = real_array(value, name, copied=copied)
    if array.shape != (size,):
        raise ValueError(f"{name} must have shape ({size},), got {told_shape(array, size, name)}")
    refuse_non_finite(array, name)
    return array


def told_shape(array: NDArray[Any], size: int, name: str) -> str:
    """Return an array's shape that should be ``(size,)``, and what to do where it is a row or a column of that length.

    Examples
    --------
    >>> told_shape(np.zeros((3, 1)), 3, "q"), told_shape(np.zeros(4), 3, "q")
    ('(3, 1); hand over q.ravel()', '(4,)')
    """
    straightened = _straightened(array.shape) if array.size == size else ""
    return f"{array.shape}; hand over {name}{straightened}" if straightened else str(array.shape)


def _straightened(shape: tuple[int, ...]) -> str:
    """Return what makes a vector of a row or a column, nothing for other shapes."""
    return ".ravel()" if len(shape) == 2 and 1 in shape else ""


def positive_vector(value: object, size: int, name: str) -> Vector:
    """Return ``value`` as a new float vector of exactly ``size`` entries > 0."""
    array = vector(value, size, name)
    if not array.min() > 0:
        worst = int(np.argmin(array))
        raise ValueError(f"{name} must be > 0 everywhere, but entry {worst} is {array[worst]:g}")
    return array


def refuse_non_finite(array: NDArray[np.float64], name: str, *, what: str = "entry") -> None:
    """Raise a ValueError that shows the first entry of ``array`` that is nan or infinite."""
    finite = np.isfinite(array)
    if not finite.all():
        bad = np.flatnonzero(~finite)
        others = f" ({bad.size} such entries)" if bad.size > 1 else ""
        raise ValueError(f"{name} must be finite, but {what} {bad[0]} is {array.flat[bad[0]]}{others}")


def one_of(value: object, known: Iterable[str], name: str) -> str:
    """Return ``value`` if it is one of the ``known`` words."""
    known = list(known)
    if not isinstance(value, str) or value not in known:
        raise ValueError(f"{name} must be one of {', '.join(map(repr, known))}, got {value!r}{nearest(value, known)}")
    return value


_LONGEST_WORD = 100


def nearest(word: object, known: Iterable[str]) -> str:
    """Return ``'; did you mean ...?'`` for the known word closest to ``word``, or nothing."""
    text = str(word).lower()
    # Comparing takes a time that grows with the length, and nothing that long is a slip.
    close = get_close_matches(text, list(known), n=1, cutoff=0.5) if len(text) <= _LONGEST_WORD else []
    return f"; did you mean {close[0]!r}?" if close else ""


def unchanging(value: object) -> bool:
    """Whether ``value`` is an array of floats that holds its own numbers and has been marked as `read_only`."""
    return type(value) is np.ndarray and value.dtype == np.float64 and not value.flags.writeable and value.base is None


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """Mark ``array`` as not writeable and return it."""
    array.setflags(write=False)
    return array


def repeated(vector: Vector) -> bool:
    """Whether a vector is one number repeated in memory (see `numpy.broadcast_to`), which costs nothing to keep."""
    return vector.strides == (0,)


def times(vector: Vector, factor: float | Vector) -> Vector:
    """Return ``vector * factor``, one number repeated where both are."""
    one = np.asarray(factor)
    if repeated(vector) and (one.ndim == 0 or repeated(one)):
        return np.broadcast_to(vector[0] * one.flat[0], vector.shape)
    return read_only(vector * factor)
