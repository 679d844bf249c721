"""
A rough surface that repeats itself
===================================

Nothing but contact holds a periodic string that is pressed on a rough line: its matrix is semidefinite. The load
decides on how many summits it lies.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactqp as cq

n = 128
x = np.arange(n) / n
ring = 2 * np.eye(n) - np.roll(np.eye(n), 1, axis=0) - np.roll(np.eye(n), -1, axis=0)
rough = 0.1 * np.cos(2 * np.pi * x) + 0.05 * np.cos(6 * np.pi * x + 1)
figure, axes = plt.subplots(figsize=(7, 3.2), layout="constrained")
axes.fill_between(x, rough, rough.min() - 0.02, color="0.85")
for pressed in (5e-5, 2e-4, 6e-4):
    solution = cq.solve(cq.ContactQP(ring, np.full(n, pressed), lower=rough, kernel="constant"))
    axes.plot(x, solution.gap, label=f"{solution.contact.sum()} nodes in contact")
axes.set(xlabel="x", ylabel="height")
axes.legend(frameon=False, fontsize="small")
