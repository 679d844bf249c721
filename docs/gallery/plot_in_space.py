"""
A membrane in space
===================

The hexagon again, with its support below: ``plot3d`` draws a membrane in perspective.
"""

import contactqp as cq

solution = cq.solve(cq.gallery.paper_hexagon(load=0.05))
figure = solution.plot3d()
