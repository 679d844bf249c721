"""
A cable on springs
==================

Springs of stiffness k pull a cable back to height zero. The stiffer they are, the less of it lies on the floor;
beyond k = p/f it does not touch at all.
"""

import matplotlib.pyplot as plt

import contactqp as cq

figure, axes = plt.subplots(figsize=(7, 3.2), layout="constrained")
for stiffness in (0.0, 0.5, 1.0, 2.0, 4.0):
    cable = cq.Cable(span=10.0, spacing=0.05, tension=1.0, load=1.0, support=0.8, foundation=stiffness)
    solution = cq.solve(cable)
    axes.plot(cable.node_x, solution.deflection, label=f"k = {stiffness:g}, {solution.contact.sum()} nodes in contact")
axes.axhline(0.8, color="0.5", lw=3, zorder=0)
axes.set(xlabel="x", ylabel="deflection, positive downwards")
axes.invert_yaxis()
axes.legend(frameon=False, fontsize="small")
