"""
A cable comes down on a floor
=============================

A cable under a load p comes down on a floor f below its ends after a = √(2Tf/p): 30 here.
"""

import contactqp as cq

cable = cq.Cable(span=100.0, spacing=1.0, tension=1000.0, load=2.0, support=0.9)
figure = cq.solve(cable).plot()
