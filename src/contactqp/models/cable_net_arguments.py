"""Checks of a cable net's arguments."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..foundation.checks import Mask, Vector, positive_number, real_array, refuse_non_finite

Numbers: TypeAlias = NDArray[np.int64]


def checked_positions(value: ArrayLike) -> Vector:
    """Return plan coordinates as a new array of shape (points, 2), finite."""
    positions = real_array(value, "positions")
    if positions.ndim != 2 or positions.shape[1] != 2:
        raise ValueError(f"positions must have shape (points, 2), got {positions.shape}")
    bad = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if bad.size:
        x, y = positions[bad[0]]
        raise ValueError(f"positions must be finite, but point {bad[0]} is ({x:g}, {y:g})")
    return positions


def checked_segments(value: ArrayLike, points: int) -> Numbers:
    """Return pairs of point numbers as a new array of shape (segments, 2), none of them a loop or given twice."""
    segments = np.array(value)
    if segments.ndim != 2 or segments.shape[1] != 2:
        raise ValueError(f"segments must have shape (segments, 2), got {segments.shape}")
    if not len(segments):
        raise ValueError("segments must hold one or more, got shape (0, 2)")
    if segments.dtype.kind not in "iu":
        raise TypeError(f"segments must hold point numbers, integers, got dtype {segments.dtype}")
    outside = np.flatnonzero(((segments < 0) | (segments >= points)).any(axis=1))
    if outside.size:
        raise ValueError(f"{name_segment(segments, outside[0])}: there are {points} points, numbered 0 to {points - 1}")
    segments = segments.astype(np.int64)
    loops = np.flatnonzero(segments[:, 0] == segments[:, 1])
    if loops.size:
        raise ValueError(f"{name_segment(segments, loops[0])} joins a point to itself; leave it out")
    _, first, which = np.unique(np.sort(segments, axis=1), axis=0, return_index=True, return_inverse=True)
    again = np.flatnonzero(first[which.ravel()] != np.arange(len(segments)))
    if again.size:
        raise ValueError(
            f"{name_segment(segments, again[0])} repeats segments[{first[which.ravel()[again[0]]]}]; "
            "give one of them, with their tensions added"
        )
    return segments


def name_segment(segments: Numbers, k: int) -> str:
    """Name a segment by its number and ends, for messages."""
    return f"segments[{k}] = ({segments[k, 0]}, {segments[k, 1]})"


def each_positive(value: Any, size: int, name: str) -> Vector:
    """Return a number, repeated, or an array as a vector of numbers > 0."""
    if np.ndim(value) == 0:
        return np.full(size, positive_number(value, name))
    values = real_array(value, name)
    if values.shape != (size,):
        raise ValueError(f"{name} must be a number or have shape ({size},), got {values.shape}")
    refuse_non_finite(values, name)
    if values.min() <= 0:
        k = int(np.argmin(values))
        raise ValueError(f"{name} must be > 0, but {name}[{k}] is {values[k]:g}")
    return values


def refuse_overflow(force_density: Vector) -> None:
    """Raise a ValueError unless all force densities are finite and > 0."""
    if not (np.isfinite(force_density).all() and force_density.min() > 0):
        raise ValueError(
            "tension over length is too large or too small for double precision: it goes from "
            f"{force_density.min():g} to {force_density.max():g}; take other units"
        )


def fixed_mask(value: ArrayLike, points: int) -> Mask:
    """Return which points are fixed, from their numbers or a mask; there must be fixed and free ones."""
    given = np.asarray(value)
    if given.ndim != 1:
        raise ValueError(f"fixed must have one dimension, got shape {given.shape}")
    if not given.size:
        raise ValueError("fixed must name one point or more")
    if given.dtype == np.bool_:
        if given.shape != (points,):
            raise ValueError(f"fixed as a mask must have shape ({points},), got {given.shape}")
        mask = np.array(given)
    elif given.dtype.kind in "iu":
        outside = given[(given < 0) | (given >= points)]
        if outside.size:
            raise ValueError(
                f"fixed names point {outside[0]}, but there are {points} points, numbered 0 to {points - 1}"
            )
        mask = np.zeros(points, dtype=np.bool_)
        mask[given] = True
    else:
        raise TypeError(f"fixed must hold point numbers or be a mask, got dtype {given.dtype}")
    if not mask.any():
        raise ValueError("fixed must name one point or more")
    if mask.all():
        raise ValueError(f"all {points} points are fixed: leave one free")
    return mask
