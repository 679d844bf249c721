"""How far a load alone presses the nodes of a lattice at most, from the lattice's size and arms alone."""

from __future__ import annotations

import numpy as np

from ..foundation.checks import Vector, repeated


def reach_on_lattice(shape: tuple[int, int], arms: tuple[float, float], load: Vector) -> float:
    """Return a bound of the deflection below a frame at height zero, without a support (length).

    Of a load p the parabola p x (W - x)/2 over the arms' force, between the sides of the lattice's array, bounds the
    deflection whatever the nodes' mask: its second difference is p everywhere, and it is >= 0 on the frame.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns of the lattice's array.
    arms : (float, float)
        The least stiffness of the arms along rows and along columns (force per length); 0 where there are none.
    load : array, shape (n,)
        Force on each node, positive downwards.

    Examples
    --------
    >>> reach_on_lattice((1, 3), (1.0, 0.0), np.ones(3))
    2.0
    """
    push = max(0.0, float(load[0] if repeated(load) else load.max()))
    rows, columns = shape
    strips = [((count + 1) / 2) ** 2 / (2 * arm) for count, arm in zip((columns, rows), arms, strict=True) if arm > 0]
    return push * min(strips, default=np.inf)
