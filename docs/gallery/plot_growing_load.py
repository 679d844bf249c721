"""
A growing load
==============

The exact path of a cable that settles node by node: how many nodes lie on the floor under which load.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactqp as cq

cable = cq.Cable(span=20.0, spacing=0.5, tension=1.0, load=1.0, support=2.0)
found = cq.events(cable, stop=3.0)
figure, axes = plt.subplots(figsize=(6, 3.2), layout="constrained")
axes.step(found.load, np.arange(1, found.load.size + 1), where="post")
axes.set(xlabel="load factor", ylabel="nodes on the floor", title=f"{found.load.size} events")
