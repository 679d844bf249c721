"""
A contact set as long as can be
===============================

An unloaded membrane hangs over a spiral ridge. Its contact set winds through the whole square, which is hard for
methods that move the contact set by a layer of nodes a step.
"""

import contactqp as cq

solution = cq.solve(cq.gallery.spiral(127), "multigrid")
figure = solution.plot(title=f"{solution.iterations} cycles of multigrid")
