"""What closed forms on a line share: parts of cells, forces at points, distances."""

from __future__ import annotations

import numpy as np

from ..foundation.checks import Vector
from .known import Distance


def covered(x: Vector, spacing: float, start: float, end: float) -> Vector:
    """Return the length of each node's cell, half a spacing to either side of it, that lies between two abscissae.

    Examples
    --------
    >>> covered(np.array([1.0, 2.0, 3.0]), 1.0, 2.0, 9.0)
    array([0. , 0.5, 1. ])
    """
    low, high = np.maximum(x - spacing / 2, start), np.minimum(x + spacing / 2, end)
    return np.asarray(np.maximum(high - low, 0.0))


def shared(x: Vector, spacing: float, at: float, force: float) -> Vector:
    """Return a force at a point, shared between the nodes beside it as on a lever (force).

    Examples
    --------
    >>> shared(np.array([1.0, 2.0, 3.0]), 1.0, 2.25, 8.0)
    array([0., 6., 2.])
    """
    return np.asarray(force * np.maximum(1 - np.abs(x - at) / spacing, 0.0))


def distance_to_points(*points: float) -> Distance:
    """Return the function of (x, y) whose values are the distances from the nearest of some abscissae."""

    def distance(x: Vector, y: Vector) -> Vector:
        return np.asarray(np.abs(x[:, None] - np.array(points)).min(axis=1))

    return distance


def at_node(touchdown: float, spacing: float) -> bool:
    """Whether a point whose distance from an end is given is a node.

    Examples
    --------
    >>> at_node(0.3, 0.05), at_node(0.3, 0.25)
    (True, False)
    """
    return abs(touchdown / spacing - round(touchdown / spacing)) < 1e-9
