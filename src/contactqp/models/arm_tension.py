"""ArmTension: how the pull of arms on the nodes depends on the tension of each arm."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Vector, real_array

Arms = NDArray[np.float64]


@dataclass(frozen=True)
class ArmTension:
    """The tension of some arms as a parameter: their pull is linear in it, at depths that stay.

    Attributes
    ----------
    shape : tuple of int
        Of an array with an entry for each arm.
    pull : callable
        Returns the force with which arms of given tensions pull each node upwards at given depths, shape (n,), the
        frame being as it is: ``pull(depths, tensions)``.
    share : callable
        The transposed map: returns for each arm what a weighted sum of these forces grows by with its tension:
        ``share(depths, weights)``.
    """

    shape: tuple[int, ...]
    pull: Callable[[Vector, Arms], Vector]
    share: Callable[[Vector, Vector], Arms]

    def tensions(self, value: Any, name: str) -> Arms:
        """Return an entry for each arm, given so or as one number for all.

        Raises
        ------
        TypeError, ValueError
            If it has the wrong kind or shape, or is not finite.
        """
        given = real_array(value, name)
        if given.shape not in ((), self.shape):
            raise ValueError(f"{name} must be a number or have shape {self.shape}, got {given.shape}")
        if not np.isfinite(given).all():
            raise ValueError(f"{name} must be finite")
        return np.broadcast_to(given, self.shape)
