"""
How sharp a bound is
====================

The true error of an answer that is stopped early, and what is proven of it: by some sweeps over the lattice (fast),
and sharpened.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactqp as cq

model = cq.gallery.paper_hexagon()
truth = cq.solve(model, "active-set", tol=1e-12).gap
figure, axes = plt.subplots(figsize=(6, 3.4), layout="constrained")
sweeps = [5, 10, 20, 40, 80]
errors, fast, sharp = [], [], []
for limit in sweeps:
    rough = cq.solve(model, "psor", max_iter=limit, tol=1e-12, on_failure="ignore").gap
    errors.append(np.abs(rough - truth).max())
    fast.append(cq.certify(model, rough, effort="fast").gap_bound)
    sharp.append(cq.certify(model, rough, effort="sharp").gap_bound)
axes.loglog(sweeps, fast, "o-", label="fast bound")
axes.loglog(sweeps, sharp, "s-", label="sharp bound")
axes.loglog(sweeps, errors, "k.--", label="true error")
axes.set_xticks(sweeps, sweeps)
axes.minorticks_off()
axes.set(xlabel="sweeps of PSOR", ylabel="error of the gap")
axes.legend(frameon=False)
