"""
The load at which each node settles
===================================

A load path, and for each node a bracket of the load at which it comes down, from certified answers on both sides.
"""

import contactqp as cq

path = cq.trace(cq.gallery.paper_hexagon(load=1.0), loads=cq.gallery.PAPER_LOADS)
figure = path.touchdown(width=0.002).plot()
