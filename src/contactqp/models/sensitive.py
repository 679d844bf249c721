"""What an answer is differentiated by arm for arm and point for point: tensions, stiffnesses, heights of the frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Vector, real_array

Values = NDArray[np.float64]


def one_each(value: Any, shape: tuple[int, ...], name: str) -> Values:
    """Return an entry for each arm or point, given so or as one number for all.

    Raises
    ------
    TypeError, ValueError
        If it has the wrong kind or shape, or is not finite.

    Examples
    --------
    >>> one_each(2.0, (3,), "tension")
    array([2., 2., 2.])
    """
    given = real_array(value, name)
    if given.shape not in ((), shape):
        raise ValueError(f"{name} must be a number or have shape {shape}, got {given.shape}")
    if not np.isfinite(given).all():
        raise ValueError(f"{name} must be finite")
    return np.broadcast_to(given, shape)


@dataclass(frozen=True)
class Resistance:
    """What holds the nodes, as the tension of some arms: their pull is linear in it, at depths that stay.

    Attributes
    ----------
    shape : tuple of int
        Of an array with an entry for each arm, or for each point that bends; () where it is one number.
    pull : callable
        Returns the force with which given tensions (stiffnesses) pull each node upwards at given depths, shape (n,),
        the frame being as it is: ``pull(depths, tensions)``.
    share : callable
        The transposed map: returns for each entry what a weighted sum of these forces grows by with it:
        ``share(depths, weights)``.
    """

    shape: tuple[int, ...]
    pull: Callable[[Vector, Values], Vector]
    share: Callable[[Vector, Vector], Values]


@dataclass(frozen=True)
class FrameHeights:
    """The heights of the points that hold the arms' ends: forces on the nodes are linear in them.

    Attributes
    ----------
    name : str
        What they are called.
    weights : array
        Of each point in the frame's mean height; zero at points that hold nothing, whose heights do not matter.
    force : callable
        Returns the force with which the arms push each node down when the points go down by given lengths, shape (n,).
    share : callable
        The transposed map: returns for each point what a weighted sum of these forces grows by.
    """

    name: str
    weights: Values
    force: Callable[[Values], Vector]
    share: Callable[[Vector], Values]
