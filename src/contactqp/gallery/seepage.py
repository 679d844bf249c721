"""Water that seeps through a dam."""

from __future__ import annotations

from types import MappingProxyType

from ..geometry.frame import Frame
from ..models.membrane import Membrane
from .bent import DamHead
from .catalogue import entry
from .known import Known, Quoted

WIDTH, ABOVE, BELOW = 16.0, 24.0, 4.0
"""Width of the dam, and heights of the water on either side of it."""

SEEPAGE_TOP = 12.7059138062
"""Where the free surface meets the lower face, by Polubarinova-Kochina's integrals, which the tests evaluate."""


@entry("dam", n=31)
def _dam_entry(name: str, nodes: int) -> Known:
    """Return Brandt and Cryer's dam: water at heights 24 and 4 on either side of a wall of 16; n nodes across, odd.

    Baiocchi's w, the integral of the pressure head from a point upwards, satisfies Δw = 1 where it is positive, that is
    below the free surface, and w ≥ 0: a membrane of T = p = 1 over the plane, in elevations. On the upper face
    w = (24 - y)²/2, on the lower one ((4 - y)⁺)²/2, linear between both at the foot, 0 at the top. How much seeps
    through is (24² - 4²)/(2·16), whatever the free surface is; where that meets the lower face is known by elliptic
    integrals.
    """
    if nodes % 2 == 0:
        raise ValueError(f"n must be odd for {name!r}, whose height is one and a half times its width, got {nodes}")
    spacing = WIDTH / (nodes + 1)
    lattice = Frame.rectangle(WIDTH, ABOVE, center=(WIDTH / 2, ABOVE / 2)).lattice(spacing)

    top = Quoted(
        SEEPAGE_TOP,
        1e-10,
        "Polubarinova-Kochina, Theory of Ground Water Movement, 1962; Crank, Free and Moving "
        "Boundary Problems, 1984, sect. 7.4",
    )
    return Known(
        name,
        Membrane(lattice, tension=1.0, load=1.0, support=0.0, frame_height=DamHead(WIDTH, ABOVE, BELOW), upwards=True),
        "Brandt and Cryer, Multigrid algorithms for the solution of linear complementarity problems arising from free "
        "boundary problems, SIAM J. Sci. Stat. Comput. 4 (1983)",
        spacing,
        numbers=MappingProxyType({"height at which the free surface meets the lower face": top}),
    )
