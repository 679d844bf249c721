"""
What a lower support would change
=================================

The derivative of the total reaction by the height of the support at each node: one linear solve, for all nodes at
once. It vanishes where the membrane is free.
"""

import matplotlib.pyplot as plt

import contactqp as cq

membrane = cq.gallery.paper_hexagon()
by_support = cq.solve(membrane, tol=1e-9).sensitivity().adjoint(reaction=1.0)["support"]
figure, axes = plt.subplots(figsize=(6, 3.8), layout="constrained")
drawn = axes.scatter(membrane.node_x, membrane.node_y, c=by_support, s=9, cmap="viridis")
figure.colorbar(drawn, label="reaction lost by depth gained")
axes.set(xlabel="x", ylabel="y", aspect="equal")
