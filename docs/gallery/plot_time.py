"""
Let go above a floor
====================

A damped membrane sinks onto its support. Each step is a contact problem, certified given the state before.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactqp as cq

cable = cq.Cable(span=10.0, spacing=0.1, tension=1.0, load=1.0, support=4.0)
history = cq.march(cable, times=np.linspace(0.0, 20.0, 41), damping=1.0)
figure, axes = plt.subplots(figsize=(7, 3.2), layout="constrained")
for step in (2, 4, 8, 12, 20, 40):
    axes.plot(cable.node_x, history.deflections[step], label=f"t = {step / 2:g}")
axes.set(xlabel="x", ylabel="deflection, positive downwards")
axes.invert_yaxis()
axes.legend(frameon=False, ncols=2, fontsize="small")
