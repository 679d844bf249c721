"""Stiffnesses as compiled passes look them up: numbers where all are equal, else arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types
from numba.extending import overload


def arm_at(arms: Any, i: int, j: int) -> float:
    """Return one arm's stiffness, for arms that are equal (a number) or not (an array)."""
    return float(arms if np.ndim(arms) == 0 else arms[i, j])


@overload(arm_at, inline="always")
def _compiled_arm(arms, i, j):  # type: ignore[no-untyped-def]
    if isinstance(arms, types.Float):
        return lambda arms, i, j: arms
    return lambda arms, i, j: arms[i, j]


def spring_at(ground: Any, i: int, j: int) -> float:
    """Return the stiffness of a point's arm to the ground: 0 where it is given as a number."""
    return 0.0 if np.ndim(ground) == 0 else float(ground[i, j])


@overload(spring_at, inline="always")
def _compiled_spring(ground, i, j):  # type: ignore[no-untyped-def]
    if isinstance(ground, types.Float):
        return lambda ground, i, j: 0.0
    return lambda ground, i, j: ground[i, j]


def with_spring(total: float, ground: Any, i: int, j: int, length: float) -> float:
    """Return a sum and what a point's spring adds to it at a length; the sum itself where the ground is a number.

    Zero times a length is not always zero, so that compiled code would do as it is told.
    """
    return total if np.ndim(ground) == 0 else total + float(ground[i, j]) * length


@overload(with_spring, inline="always")
def _compiled_sum(total, ground, i, j, length):  # type: ignore[no-untyped-def]
    if isinstance(ground, types.Float):
        return lambda total, ground, i, j, length: total
    return lambda total, ground, i, j, length: total + ground[i, j] * length


def softened(value: float, ground: Any, i: int, j: int, per_diagonal: float) -> float:
    """Return a correction that is as much smaller as a point's spring makes the diagonal larger."""
    return value if np.ndim(ground) == 0 else value / (1.0 + float(ground[i, j]) * per_diagonal)


@overload(softened, inline="always")
def _compiled_softened(value, ground, i, j, per_diagonal):  # type: ignore[no-untyped-def]
    if isinstance(ground, types.Float):
        return lambda value, ground, i, j, per_diagonal: value
    return lambda value, ground, i, j, per_diagonal: value / (1.0 + ground[i, j] * per_diagonal)
