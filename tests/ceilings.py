"""Models with an upper bound of the gap, which no model of the package has by itself."""

from functools import cached_property

import numpy as np

import contactqp as cq

HEADROOM = 0.3


class _UnderCeiling:
    """The gap is at most `HEADROOM`."""

    @cached_property
    def problem(self):
        below = super().problem
        return cq.ContactQP(below.G, below.q, upper=HEADROOM, gap_scale=0.1)


class MembraneUnderCeiling(_UnderCeiling, cq.Membrane):
    pass


class CableUnderCeiling(_UnderCeiling, cq.Cable):
    pass


class NetUnderCeiling(_UnderCeiling, cq.CableNet):
    pass


def _load(x, y):
    """Down on the left, up on the right, and none in the middle."""
    return np.where(np.abs(x) < 1.1, 0.0, np.where(x < 0, 1.0, -1.0))


def models_under_ceilings():
    """Return a membrane, a cable and a net with nodes on either bound, and free ones; all have 0.1 to the support."""
    lattice = cq.Frame.rectangle(8.0, 3.0).lattice(0.5)
    membrane = MembraneUnderCeiling(lattice, 1.0, load=_load, support=0.1)
    cable = CableUnderCeiling(8.0, spacing=0.5, tension=1.0, load=_load, support=0.1, start=-4.0)
    net = NetUnderCeiling.orthogonal(lattice, 0.5, load=lambda x, y: 0.25 * _load(x, y), support=0.1)
    return [membrane, cable, net]
