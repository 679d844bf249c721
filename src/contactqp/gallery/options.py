"""Options with early exercise: problems whose matrix is not symmetric."""

from __future__ import annotations

import numpy as np

from ..foundation.checks import Vector
from ..foundation.loading import load_modules
from ..problem.contact_lcp import ContactLCP
from .catalogue import entry
from .intervals import covered, distance_to_points
from .known import Known


@entry("american-put", n=99)
def _put_entry(name: str, nodes: int) -> Known:
    """Return a perpetual American put by central differences over the logarithm of the price: r = 0.06, σ = 0.2, K = 1.

    In x = ln S: σ²V″/2 + (r - σ²/2)V′ - rV ≤ 0, V ≥ 1 - S, one of both an equality. With γ = 2r/σ² it is exercised at
    S* = γ/(1 + γ), above which V = (1 - S*)(S/S*)^{-γ}; below, ρ = r. Here -1 < x < 2, and rows are multiplied by the
    spacing.
    """
    load_modules("scipy.sparse")
    from scipy import sparse

    rate, volatility = 0.06, 0.2
    gamma = 2 * rate / volatility**2
    exercise = gamma / (1 + gamma)
    start, end = -1.0, 2.0
    spacing = (end - start) / (nodes + 1)
    diffusion, drift = volatility**2 / 2 / spacing**2, (rate - volatility**2 / 2) / (2 * spacing)
    up, down = diffusion + drift, diffusion - drift
    if down <= 0:
        raise ValueError(f"n must be >= 3 for {name!r}, whose matrix is no M-matrix otherwise, got {nodes}")
    x: Vector = start + spacing * np.arange(1.0, nodes + 1)
    diagonals = [spacing * value for value in (-down, up + down + rate, -up)]
    q = np.zeros(nodes)
    q[0] -= spacing * down * (1 - np.exp(start))
    q[-1] -= spacing * up * (1 - exercise) * np.exp(-gamma * (end - np.log(exercise)))
    matrix = sparse.diags_array(diagonals, offsets=[-1, 0, 1], shape=(nodes, nodes))
    payoff = 1 - np.exp(x)
    above = (1 - exercise) * np.exp(-gamma * (np.maximum(x, np.log(exercise)) - np.log(exercise)))
    return Known(
        name,
        ContactLCP(matrix, q, lower=payoff),
        "Merton, Theory of rational option pricing, Bell J. Econ. 4 (1973), sect. 8",
        spacing,
        deflection=np.where(x < np.log(exercise), payoff, above),
        reaction=rate * covered(x, spacing, start, float(np.log(exercise))),
        contact_area=float(np.log(exercise)) - start,
        distance=distance_to_points(float(np.log(exercise))),
        places=x,
    )
