"""Signs of a foundation between the points of a lattice: a function that is seen to be negative there is refused.

What is proven of energies takes k ≥ 0 for granted, as a model does, which sees k at its nodes only. Cells in which a
function is not known to be positive are cut into four, a few times, and its value in the middle of each is looked at.
"""

from __future__ import annotations

import numpy as np

from ..foundation.checks import Mask, Vector
from ..foundation.intervals import Interval
from ..foundation.surfaces import Ranged

_CUTS = 4


def require_not_negative(function: Ranged, around: tuple[Interval, Interval], cells: Mask) -> None:
    """Refuse a foundation that is negative between the points of a lattice.

    Parameters
    ----------
    function : Ranged
        Of (x, y).
    around : pair of Interval
        What holds x and y in each cell (length).
    cells : array of bool
        Which cells belong to the membrane.

    Raises
    ------
    ValueError
        If it is found negative at a place.

    Examples
    --------
    >>> from contactqp import Smooth
    >>> cell = Interval.between([0.0], [1.0]), Interval.between([0.0], [0.0])
    >>> require_not_negative(Smooth(lambda x, y: x**2, second_derivative=2.0), cell, np.array([True]))
    >>> require_not_negative(Smooth(lambda x, y: x * (x - 1), second_derivative=2.0), cell, np.array([True]))
    Traceback (most recent call last):
    ...
    ValueError: foundation is -0.25 at x=0.5, y=0, between the points of the lattice, and must be >= 0 everywhere
    """
    x, y = (
        Interval(*(np.broadcast_to(end, cells.shape)[cells] for end in (side.lower, side.upper))) for side in around
    )
    for _ in range(_CUTS):
        whole = function.range(x, y)
        if whole is None:
            return
        open_cells = ~(whole.lower >= 0)
        x, y = (Interval(side.lower[open_cells], side.upper[open_cells]) for side in (x, y))
        if not x.lower.size:
            return
        middle = _middle(x), _middle(y)
        there = function.range(Interval.of(middle[0]), Interval.of(middle[1]))
        if there is not None and (there.upper < 0).any():
            worst = int(np.argmin(there.upper))
            raise ValueError(
                f"foundation is {there.upper[worst]:.3g} at x={middle[0][worst]:g}, y={middle[1][worst]:g}, between "
                "the points of the lattice, and must be >= 0 everywhere"
            )
        halves = [
            (Interval(side.lower, inner), Interval(inner, side.upper))
            for side, inner in zip((x, y), middle, strict=True)
        ]
        pairs = [(one, two) for one in halves[0] for two in halves[1]]
        x, y = (
            Interval(*(np.concatenate([getattr(pair[k], end) for pair in pairs]) for end in ("lower", "upper")))
            for k in (0, 1)
        )


def _middle(side: Interval) -> Vector:
    return np.asarray(side.lower + (side.upper - side.lower) / 2)
