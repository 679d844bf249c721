"""
When to exercise an option
==========================

An American put is a contact problem in each step of time, with a matrix that is not symmetric. Contact is where it is
exercised; its edge is the price below which that is best.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy import sparse

import contactqp as cq

points, steps, strike, rate, volatility = 401, 100, 40.0, 0.06, 0.2
log, dt = np.linspace(-1.6, 1.6, points), 1 / steps
h, drift = log[1] - log[0], rate - volatility**2 / 2
up, down = volatility**2 / 2 / h**2 + drift / h, volatility**2 / 2 / h**2
entries = [-dt * down, 1 + dt * (up + down + rate), -dt * up]
payoff = np.maximum(strike - strike * np.exp(log), 0.0)
step = cq.ContactLCP(sparse.diags_array(entries, offsets=[-1, 0, 1], shape=(points, points)), -payoff, lower=payoff)
solver, value, edge = cq.Solver(step, tol=1e-9), payoff, []
for _ in range(steps):
    solution = solver.solve(q=-value)
    value = solution.gap
    exercised = solution.contact & (payoff > 0)
    edge.append(strike * np.exp(log[exercised].max()))
figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.2), layout="constrained")
left.plot(strike * np.exp(log), payoff, color="0.5", label="exercised at once")
left.plot(strike * np.exp(log), value, label="value")
left.set(xlim=(20, 60), ylim=(0, 20), xlabel="price", ylabel="value of the put")
left.legend(frameon=False)
right.plot(dt * np.arange(1, steps + 1), edge)
right.set(xlabel="years to expiry", ylabel="exercise at or below this price")
