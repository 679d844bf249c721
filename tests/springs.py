"""A kind of model that the package does not know: nodes anywhere in plan, each hung on a spring of its own."""

import numpy as np
from scipy import sparse

from contactqp.models.base import ContactModel


class Springs(ContactModel):
    """Nodes at given places, each pulled to height zero by a spring: w = min(f, P/k), R = P - k w."""

    def __init__(self, places, stiffness, load, support, node_area=None):
        self.places = np.array(places, dtype=float)
        self.stiffness = np.array(stiffness, dtype=float)
        self.load, self.support = np.array(load, dtype=float), np.array(support, dtype=float)
        self.node_area = None if node_area is None else np.array(node_area, dtype=float)

    @property
    def exact(self):
        """The deflection."""
        return np.minimum(self.support, self.load / self.stiffness)

    @property
    def nodal_load(self):
        return self.load

    @property
    def node_x(self):
        return self.places[:, 0]

    @property
    def node_y(self):
        return self.places[:, 1]

    def describe(self, node):
        return f"spring {node}"

    def max_slope(self, gap):
        return 0.0

    def free_boundary(self, contact):
        return np.zeros((0, 2))

    def assemble_stiffness(self):
        return sparse.csr_array(sparse.diags_array(self.stiffness))

    def pull(self, depths):
        return self.stiffness * depths


def springs(count=40, seed=0, **changes):
    """Return springs at random places, of which about half touch a support."""
    rng = np.random.default_rng(seed)
    made = {
        "places": rng.uniform(0, [4, 3], (count, 2)),
        "stiffness": rng.uniform(1, 2, count),
        "load": rng.uniform(0.5, 1.5, count),
        "support": rng.uniform(0.2, 1.0, count),
        "node_area": rng.uniform(0.1, 0.3, count),
    }
    return Springs(**(made | changes))
