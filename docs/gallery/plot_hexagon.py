"""
The paper's hexagon
===================

A hexagonal membrane of 1857 nodes is pressed on a hill and a floor. The picture shows where it certainly touches, and
the middle section with deflection, gap and reaction. The surface is a surrogate consistent with Table 1 of the paper
that the example is from, not a reproduction.
"""

import contactqp as cq

frame = cq.Frame.polygon([(32, 0), (8, 24), (-8, 24), (-32, 0), (-8, -24), (8, -24)])
membrane = cq.Membrane(frame.lattice(spacing=1.0), tension=1.0, load=0.03, support=cq.profiles.HillAndFloor())
solution = cq.solve(membrane)
figure = solution.plot()
