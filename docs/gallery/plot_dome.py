"""
A disk over a dome
==================

Beside the dome there is no support at all: its height is infinite there. Arms between nodes end where the round frame
cuts them.
"""

import contactqp as cq

dome = cq.profiles.Hemisphere(depth=0.02, radius=0.5)
lattice = cq.Frame.disk(1.0).lattice(spacing=0.04, fitted=True)
solution = cq.solve(cq.Membrane(lattice, tension=1.0, load=0.6, support=dome))
figure = solution.plot(title="Disk over a dome")
