"""The ways in which a mesh membrane's tension and its fixed points may be given."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..foundation.checks import Mask, Vector, positive_number, read_only
from ..geometry.fields import evaluated, is_function
from ..geometry.triangles import TriangleMesh
from .cable_net_arguments import each_positive, fixed_mask

FixedLike: TypeAlias = ArrayLike | Callable[[NDArray[np.float64], NDArray[np.float64]], ArrayLike] | None
"""None for the boundary; names of groups; numbers or a mask of points; or a function of (x, y) that says yes or no."""


def fixed_points(mesh: TriangleMesh, fixed: Any) -> Mask:
    """Return which points are fixed, shape (points,); there must be fixed ones and others.

    Raises
    ------
    TypeError, ValueError
        If the argument has the wrong kind or shape, or all points are fixed, or none.
    """
    points = len(mesh.points)
    if fixed is None:
        return fixed_mask(np.unique(mesh.edges[mesh.boundary]), points)
    if isinstance(fixed, str):
        fixed = (fixed,)
    if isinstance(fixed, (list, tuple)) and fixed and all(isinstance(name, str) for name in fixed):
        return fixed_mask(mesh.points_of(fixed), points)
    if is_function(fixed):
        return fixed_mask(_told(mesh, fixed), points)
    return fixed_mask(fixed, points)


def _told(mesh: TriangleMesh, says: Any) -> Mask:
    x, y = mesh.points.T
    try:
        told = np.asarray(says(x, y))
    except (TypeError, ValueError):  # a function of numbers, as of ``x > 0 and y > 0``
        told = np.array([says(float(a), float(b)) for a, b in mesh.points])
    if told.dtype != np.bool_:
        raise TypeError(f"fixed(x, y) must return True or False for each point, got dtype {told.dtype}")
    if told.shape not in ((), x.shape):
        raise ValueError(f"fixed(x, y) must return True or False for each of {x.size} points, got {told.shape}")
    told = np.broadcast_to(told, x.shape)
    if not told.any():
        raise ValueError("fixed(x, y) is True at no point of the mesh; name one point or more")
    return told


def tension_of_triangles(mesh: TriangleMesh, tension: Any) -> float | Vector:
    """Return a tension as a number > 0, or as one for each triangle, shape (triangles,), read-only.

    Raises
    ------
    TypeError, ValueError
        If it has the wrong kind or shape, or is not > 0 everywhere.
    """
    if is_function(tension):
        x, y = mesh.middles.T
        tension = np.broadcast_to(evaluated(tension, x, y, "tension"), len(mesh.triangles))
    if np.ndim(tension) == 0:
        return positive_number(tension, "tension")
    return read_only(each_positive(tension, len(mesh.triangles), "tension"))
