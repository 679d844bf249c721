"""How far a load alone presses the nodes of a lattice at most, from the lattice's size and arms alone."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..foundation.checks import Vector, repeated


def reach_on_lattice(shape: tuple[int, int], arms: tuple[Any, Any], load: Vector) -> float:
    """Return a bound of the deflection below a frame at height zero, without a support (length).

    Of a load p the parabola p x (W - x)/2 over the arms' force, between the sides of the lattice's array, bounds the
    deflection whatever the nodes' mask: its second difference is p everywhere, and it is >= 0 on the frame. Where arms
    vary, no node sinks farther than under the whole load on it alone, held by its own row or column alone: to take arms
    away makes it softer (Rayleigh), and so does it to carry the load there, for the influence of a load is largest
    where it acts. A node of a row is held to both sides by arms in series, of which it is no softer than in the middle,
    a quarter of their softness together.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns of the lattice's array.
    arms : (float or array, float or array)
        Stiffness of the arms along rows, shape (rows, columns + 1), and along columns, shape (rows + 1, columns)
        (force per length), or the number that all have; 0 where there are none.
    load : array, shape (n,)
        Force on each node, positive downwards.

    Examples
    --------
    >>> reach_on_lattice((1, 3), (1.0, 0.0), np.ones(3))
    2.0
    >>> reach_on_lattice((1, 3), (np.array([[1.0, 1.0, 2.0, 2.0]]), 0.0), np.ones(3))
    2.25
    """
    push = max(0.0, float(load[0] if repeated(load) else load.max()))
    if np.ndim(arms[0]) == np.ndim(arms[1]) == 0:
        strips = [
            ((count + 1) / 2) ** 2 / (2 * float(arm))
            for count, arm in zip(shape[::-1], arms, strict=True)
            if float(arm) > 0
        ]
        return push * min(strips, default=np.inf)
    rows, columns = shape
    places = (rows, columns + 1), (rows + 1, columns)
    with np.errstate(divide="ignore", over="ignore"):
        softness = min(
            float((1 / np.broadcast_to(arm, place)).sum(axis=1 - axis).max())
            for axis, (arm, place) in enumerate(zip(arms, places, strict=True))
        )
        whole = push * load.size if repeated(load) else float(np.maximum(load, 0.0).sum())
        return whole * softness / 4 if whole else 0.0
