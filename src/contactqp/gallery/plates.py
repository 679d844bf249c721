"""Plates whose exact answers are known."""

from __future__ import annotations

import numpy as np

from ..foundation.checks import Vector, integer_at_least
from ..geometry.frame import Frame
from ..models.plate import Plate
from .catalogue import entry
from .known import Known

_WAVES = 401
"""Half-waves along a side of the last terms that are summed: what is left out is less than 1e-12 of the deflection."""


def plate_under_load(nodes: int, tension: float = 0.0) -> tuple[Plate, Vector]:
    """Return a simply supported square plate under a uniform load, free of contact, and its exact deflection.

    D = p = L = 1 on the square (0, L)². Navier's series, over odd m and n,

        w = Σ 16p/(π²mn) sin(mπx) sin(nπy) / (Dκ² + Tκ),   κ = π²(m² + n²)

    (Timoshenko and Woinowsky-Krieger, *Theory of Plates and Shells*, 2nd ed. 1959, art. 28; with tension art. 91). In
    the middle it is 0.00406 pL⁴/D without tension (their table 8).

    Parameters
    ----------
    nodes : int
        Nodes along a side.
    tension : float
        TL²/D, >= 0.

    Examples
    --------
    >>> plate, exact = plate_under_load(3)
    >>> exact.reshape(3, 3)[1].round(6)
    array([0.002938, 0.004062, 0.002938])
    """
    nodes = integer_at_least(nodes, 1, "nodes")
    lattice = Frame.rectangle(1.0, 1.0, (0.5, 0.5)).lattice(1.0 / (nodes + 1))
    plate = Plate(lattice, 1.0, tension=tension, load=1.0, support=np.inf, edge="simply supported")
    wave = np.pi * np.arange(1, _WAVES + 1, 2)
    kappa = wave[:, None] ** 2 + wave**2
    amplitude = 16.0 / (wave[:, None] * wave * (kappa**2 + tension * kappa))
    x, y = np.sin(np.outer(lattice.x, wave)), np.sin(np.outer(lattice.y, wave))
    return plate, lattice.gather(y @ amplitude @ x.T)


@entry("plate-under-load", n=15)
def _plate_entry(name: str, nodes: int) -> Known:
    """Return a simply supported square plate under a uniform load, free of contact: D = p = L = 1."""
    return _entry(name, nodes, 0.0)


@entry("plate-with-tension", n=15)
def _stretched_entry(name: str, nodes: int) -> Known:
    """Return a stretched square plate under a uniform load, free of contact: D = p = L = 1, T = 20."""
    return _entry(name, nodes, 20.0)


def _entry(name: str, nodes: int, tension: float) -> Known:
    plate, deflection = plate_under_load(nodes, tension)
    source = (
        "Navier's series: Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed. 1959, arts. 28, 91"
    )
    return Known(
        name,
        plate,
        source,
        plate.lattice.spacing,
        deflection=deflection,
        reaction=np.zeros(deflection.size),
        contact_area=0.0,
    )
