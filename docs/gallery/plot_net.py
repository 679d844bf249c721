"""
A cable net over a dome
=======================

Any graph of tensioned segments: here an orthogonal net, whose nodes come down on a paraboloid.
"""

import contactqp as cq

lattice = cq.Frame.rectangle(2.0, 2.0).lattice(spacing=0.125)
dome = cq.profiles.Paraboloid(depth=0.05, radius=2.0)
net = cq.CableNet.orthogonal(lattice, 1.0, load=0.05, support=dome)
figure = cq.solve(net).plot()
