"""The relaxation factor, estimated while the iteration runs.

For a consistently ordered matrix an eigenvalue μ of the Jacobi matrix and one λ of over-relaxation with the factor
β satisfy (λ + β - 1)² = λβ²μ² (Young, *Iterative Solution of Large Linear Systems*, 1971, ch. 5), and
β = 2/(1 + √(1 - μ²)) is the best factor. As long as β is below it, the steps decay with a real λ that shows in
their ratio. Raising β whenever the measured λ betrays a larger μ is the adaptive procedure of Hageman and Young
(*Applied Iterative Methods*, 1981, ch. 9). Once the contact set has settled the projected iteration is the linear one
on the free nodes.
"""

from __future__ import annotations

import math

_FIRST = 1.4
_SETTLED = 0.05
_LARGEST = 1.999


class AdaptiveRelaxation:
    """Raises the factor from the ratio of successive steps.

    Attributes
    ----------
    beta : float
        The factor to use for the next sweeps.

    Examples
    --------
    >>> adaptive = AdaptiveRelaxation()
    >>> adaptive.beta
    1.4
    """

    def __init__(self) -> None:
        self.beta = _FIRST
        self._ratios: list[float] = []
        self._last = math.inf

    def observe(self, step: float) -> None:
        """Take note of the largest step of the sweep just done with `beta`."""
        if math.isfinite(self._last) and self._last > 0:
            self._ratios.append(step / self._last)
        self._last = step
        if len(self._ratios) < 3 or self.beta >= _LARGEST:
            return
        first, second, ratio = self._ratios[-3:]
        settled = max(abs(ratio - second), abs(second - first)) < _SETTLED * (1 - min(ratio, 1.0)) + 1e-12
        if settled and self.beta - 1 < ratio < 1:
            better = best_factor(ratio, self.beta)
            if better > self.beta + 0.25 * (2 - self.beta) * _SETTLED:
                self.beta = min(better, _LARGEST)
                self._ratios.clear()
                self._last = math.inf


def best_factor(ratio: float, beta: float) -> float:
    """Return Young's best factor, from the decay ratio of the steps under the factor ``beta``.

    Examples
    --------
    Gauss-Seidel (β = 1) that contracts by 0.81 a sweep has μ = 0.9:

    >>> round(best_factor(0.81, 1.0), 4)
    1.3929
    """
    mu_squared = min((ratio + beta - 1) ** 2 / (ratio * beta**2), 1.0)
    return 2 / (1 + math.sqrt(1 - mu_squared))
