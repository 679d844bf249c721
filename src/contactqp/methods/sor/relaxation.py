"""The relaxation factor, from the decay of the steps.

For a consistently ordered matrix an eigenvalue μ of the Jacobi matrix and one λ of over-relaxation with the factor
β satisfy (λ + β - 1)² = λβ²μ² (Young, *Iterative Solution of Large Linear Systems*, 1971, ch. 5), and
β = 2/(1 + √(1 - μ²)) is the best factor. Once the contact set has settled the projected iteration is the linear one
on the free nodes, so μ is the spectral radius of their part of the matrix. As long as β is below the best factor, the
steps decay with a real λ that shows in their ratio. To raise β whenever the measured λ betrays a larger μ is the
adaptive procedure of Hageman and Young (*Applied Iterative Methods*, 1981, ch. 9). It costs nothing and assumes no
lattice.
"""

from __future__ import annotations

import math

_FIRST = 1.35
_SHORTEST_WINDOW = 2
_STEADY = 0.3
_REAL = 0.48
"""Share of 2 - β by which a decay must lie above β - 1 to be taken for real.

By Young's formula β is then raised no more once 2 - β is below 1/√(1 - 0.48²) = 1.14 times that of the best factor.
A solve whose contact set has yet to settle is served well by less than the best rate in the long run: scanned on the
paper's hexagon and on bowls, the 2 - β of its fewest sweeps to an error of 1e-6 is 1.0 to 1.12 times that of Young's
factor for the final free nodes, and 1.1 to 1.6 times for the paper's stopping rules.
"""
_LEAST_WAIT, _WAIT = 20, 8
"""Sweeps without a step less than all before, at least, and times 2 - β, after which over-relaxation is given up."""
_DAMPING = 0.75
_BOLDEST = 0.4


class AdaptiveRelaxation:
    """Raises the factor from the decay of the steps.

    The decay a sweep is measured over two windows in a row, each about 1/(2 - β) sweeps long, the time in which
    transients of over-relaxation die out. Only if both agree, and lie well above β - 1, the modulus of all eigenvalues
    once β is past the best factor, is the dominant eigenvalue taken for real, so that Young's formula applies. Raising
    is damped, because an overestimate cannot be taken back.

    Parameters
    ----------
    beta : float
        The first factor.

    Attributes
    ----------
    beta : float
        The factor to use for the next sweep.

    Examples
    --------
    Steps that shrink by a tenth a sweep are too slow for β = 1.35, by Young's formula:

    >>> adaptive = AdaptiveRelaxation()
    >>> for sweep in range(8):
    ...     adaptive.observe(0.9**sweep)
    >>> round(adaptive.beta, 2), round(best_factor(0.9, 1.35), 2)
    (1.57, 1.64)
    """

    def __init__(self, beta: float = _FIRST) -> None:
        self.beta = beta
        self._steps: list[float] = []

    def observe(self, step: float, noise: float = 0.0) -> None:
        """Take note of the largest step of the sweep just done with `beta`; below ``noise`` it says nothing."""
        if step <= noise:
            self._steps.clear()
            return
        self._steps.append(step)
        window = max(_SHORTEST_WINDOW, round(1 / (2 - self.beta)))
        if len(self._steps) < 2 * window + 1:
            return
        late = (step / self._steps[-1 - window]) ** (1 / window)
        early = (self._steps[-1 - window] / self._steps[-1 - 2 * window]) ** (1 / window)
        decay = min(late, early)
        if late >= 1 or abs(late - early) > _STEADY * (1 - late):
            return
        if decay <= self.beta - 1 + _REAL * (2 - self.beta):
            return
        raised = self.beta + _DAMPING * (best_factor(decay, self.beta) - self.beta)
        raised = min(raised, 2 - _BOLDEST * (2 - self.beta))
        if raised > self.beta + 0.01 * (2 - self.beta):
            self.beta = raised
            self._steps.clear()


class GuardedRelaxation(AdaptiveRelaxation):
    """The same for an M-matrix that is not symmetric, for which over-relaxation may diverge.

    The eigenvalues of its Jacobi matrix need not be real. Projected Gauss-Seidel, β = 1, converges for every M-matrix
    (Ahn, *Solution of nonsymmetric linear complementarity problems by iterative methods*, J. Optim. Theory Appl. 33,
    1981), so that is what remains where the steps cease to fall.

    Examples
    --------
    >>> guarded = GuardedRelaxation(1.5)
    >>> for sweep in range(30):
    ...     guarded.observe(1.1**sweep)
    >>> guarded.beta
    1.0
    """

    def __init__(self, beta: float = _FIRST) -> None:
        super().__init__(beta)
        self._least, self._waited = math.inf, 0

    def observe(self, step: float, noise: float = 0.0) -> None:
        """See `AdaptiveRelaxation.observe`."""
        if self.beta == 1.0:
            return
        self._waited = 0 if step < self._least else self._waited + 1
        self._least = min(step, self._least)
        if step > noise and self._waited > max(_LEAST_WAIT, _WAIT / (2 - self.beta)):
            self.beta = 1.0
        else:
            super().observe(step, noise)


def young(mu: float) -> float:
    """Return Young's best factor for the spectral radius ``mu`` of the Jacobi matrix.

    Examples
    --------
    >>> young(0.0), young(0.8), young(1.0)
    (1.0, 1.25, 2.0)
    """
    return 2 / (1 + math.sqrt(max(0.0, 1 - mu**2)))


def best_factor(ratio: float, beta: float) -> float:
    """Return Young's best factor, from the decay ratio of the steps under the factor ``beta``.

    Examples
    --------
    Gauss-Seidel (β = 1) that contracts by 0.81 a sweep has μ = 0.9:

    >>> round(best_factor(0.81, 1.0), 4)
    1.3929
    """
    mu_squared = min((ratio + beta - 1) ** 2 / (ratio * beta**2), 1.0)
    return young(math.sqrt(mu_squared))
