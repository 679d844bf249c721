"""
Between floor and ceiling
=========================

A fabric that is pulled harder along x than along y is pressed down on its left and lifted on its right. It lies on
the floor there, and at the ceiling here.
"""

import numpy as np

import contactqp as cq

fabric = cq.Membrane(
    cq.Frame.rectangle(4.0, 2.0).lattice(spacing=0.05),
    tension=(lambda x, y: 2 + 0.25 * x, 1.0),
    load=lambda x, y: np.where(x < 0, 1.0, -1.0),
    support=0.1,
    ceiling=-0.05,
)
figure = cq.solve(fabric).plot()
