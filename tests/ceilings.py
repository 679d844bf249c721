"""Models with an upper bound of the gap, of every kind."""

import numpy as np

import contactqp as cq

HEADROOM = 0.3


def _load(x, y):
    """Down on the left, up on the right, and none in the middle."""
    return np.where(np.abs(x) < 1.1, 0.0, np.where(x < 0, 1.0, -1.0))


def models_under_ceilings():
    """Return a membrane, a cable and a net with nodes on either bound, and free ones; all have 0.1 to the support."""
    lattice = cq.Frame.rectangle(8.0, 3.0).lattice(0.5)
    surfaces = {"support": 0.1, "ceiling": 0.1 - HEADROOM}
    membrane = cq.Membrane(lattice, 1.0, load=_load, **surfaces)
    cable = cq.Cable(8.0, spacing=0.5, tension=1.0, load=_load, start=-4.0, **surfaces)
    net = cq.CableNet.orthogonal(lattice, 0.5, load=lambda x, y: 0.25 * _load(x, y), **surfaces)
    return [membrane, cable, net]
