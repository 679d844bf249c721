"""
A clamped plate on a floor
==========================

A plate under a uniform load comes down on a floor. It lies flat there, and along the edge of contact it presses with
forces that are larger than the load: bending lets go of the floor with a jump of the shear.
"""

import contactqp as cq

lattice = cq.Frame.rectangle(1.0, 1.0).lattice(spacing=1 / 48)
plate = cq.Plate(lattice, 1.0, load=6000.0, support=1.0, edge="clamped")
figure = cq.solve(plate).plot()
