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
