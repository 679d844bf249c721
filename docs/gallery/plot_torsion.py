"""
Elastic and plastic torsion
===========================

A square bar that is twisted has a stress function u with −Δu = c, whose slope cannot exceed the yield stress. For a
convex cross-section that is the same as u ≤ distance to the edge (Brezis and Sibony 1971): an obstacle problem. Where
the membrane touches the roof, the bar flows.
"""

import numpy as np

import contactqp as cq


def distance_to_edge(x, y):
    return 1 - np.maximum(np.abs(x), np.abs(y))


lattice = cq.Frame.rectangle(2.0, 2.0).lattice(spacing=1 / 64)
bar = cq.Membrane(lattice, tension=1.0, load=5.0, support=distance_to_edge)
solution = cq.solve(bar)
figure = solution.plot(title=f"The bar flows on {solution.contact_area.lower:.2f} of 4")
