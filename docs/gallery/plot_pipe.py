"""
A pipe that bends
=================

Where a beam comes down it presses on the floor with a concentrated reaction pa/2, a its free length, and its bending
moment vanishes there.
"""

import contactqp as cq

pipe = cq.Beam(10.0, spacing=0.1, bending_stiffness=1.0, load=1.0, support=0.5, ends=("pinned", "clamped"))
figure = cq.solve(pipe).plot()
