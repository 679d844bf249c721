"""The relaxation factor, from the spectral radius of the free nodes and from the decay of the steps.

For a consistently ordered matrix an eigenvalue μ of the Jacobi matrix and one λ of over-relaxation with the factor
β satisfy (λ + β - 1)² = λβ²μ² (Young, *Iterative Solution of Large Linear Systems*, 1971, ch. 5), and
β = 2/(1 + √(1 - μ²)) is the best factor. Once the contact set has settled the projected iteration is the linear one
on the free nodes, so μ is the spectral radius of their part of the matrix. There are two ways to learn it.

* `FreeSetRelaxation` computes it, now and then, for the present free nodes, on nets of equal arms; their five-point
  matrices are consistently ordered whatever part of them is free, and in both orders of the sweeps.
* `AdaptiveRelaxation` observes it. As long as β is below the best factor, the steps decay with a real λ that shows in
  their ratio; raising β whenever the measured λ betrays a larger μ is the adaptive procedure of Hageman and Young
  (*Applied Iterative Methods*, 1981, ch. 9). It costs nothing and assumes no net, but it sees only what has become
  visible, and takes the growth of the contact set for decay.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .spectral import jacobi_radius

if TYPE_CHECKING:
    from .sweepers import FreeNodes

_FIRST = 1.35
_SHORTEST_WINDOW = 3
_STEADY = 0.3
_REAL = 0.3
_DAMPING = 0.8
_BOLDEST = 0.4

_FIRST_ON_NET = 1.37
_SWEEPS_BEFORE_FIRST_ESTIMATE = 8
_SWEEPS_BETWEEN_ESTIMATES = 2.5
"""Factor between the sweeps done at two estimates, so that all of them together cost little more than the last."""
_CHANGE_WORTH_AN_ESTIMATE = 0.2
_LOOKS = 10
"""The free nodes are counted again after a tenth of the sweeps done."""
_MOST_BEYOND_ESTIMATE = 0.82
"""Least 2 - β, relative to that of the estimate. Ritz values are lower bounds of μ, so that the factor they give is too
low by some tenth of 2 - β; beyond this the free set must have grown, or the observation is mistaken."""


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
    (1.58, 1.64)
    """

    def __init__(self, beta: float = _FIRST) -> None:
        self.restart(beta)

    def restart(self, beta: float) -> None:
        """Go on with another factor, and forget the steps."""
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


class FreeSetRelaxation:
    """Takes the factor from the Jacobi matrix of the free nodes of a net as they settle.

    After some sweeps the free nodes are known well enough for a first estimate of their μ (see `spectral`). It is made
    again where it has lost its ground: when the number of free nodes has changed by a fifth, or when the steps decay as
    if μ were larger. Between estimates the factor follows the decay of the steps, as in `AdaptiveRelaxation`, but
    only a little way beyond what the last estimate says: steps that contact or rounding holds up look like slow decay,
    and would drive it too high.

    Estimates err to the low side, and so they should. Young's factor minimises the spectral radius, that is the error
    after many sweeps; without contact it is also the best for few. With contact the best factor of a whole solve is
    lower: scanned on the paper's hexagon and on bowls, its 2 - β is that of Young's for the final free set times 1.0
    to 1.12 for an error of 1e-6, and times 1.1 to 1.6 for the paper's rules, whose sweeps are up to three times fewer.
    Nodes that leave contact excite modes of every μ, which all decay with β - 1 and not faster if β is too high for
    them, and a residual shows those more than the slowest mode, which it scales by 1 - μ. As the estimate for given
    free nodes makes 2 - β too large by 1.04 to 1.12 times, and the fewer free nodes of early sweeps add to that, no
    other allowance is made.

    Attributes
    ----------
    beta : float
        The factor to use for the next sweep.

    Examples
    --------
    A square of 31 x 31 free nodes has μ = cos(π/32), so the best factor is 1.82:

    >>> import numpy as np
    >>> from contactqp.sor.sweepers import FreeNodes
    >>> relaxation = FreeSetRelaxation()
    >>> for sweep in range(8):
    ...     relaxation.observe(0.9**sweep)
    >>> relaxation.due(960)
    True
    >>> work = relaxation.estimate(FreeNodes(np.ones((31, 31), dtype=bool), 0.25, 0.25))
    >>> round(relaxation.beta, 2)
    1.81
    """

    def __init__(self) -> None:
        self._observer = AdaptiveRelaxation(_FIRST_ON_NET)
        self._highest = 2.0
        self._sweeps = 0
        self._next = float(_SWEEPS_BEFORE_FIRST_ESTIMATE)
        self._next_look = 0
        self._free_then = 0
        self._estimated = False
        self._at_limit = self._noisy = False

    @property
    def beta(self) -> float:
        """The factor to use for the next sweep."""
        return self._observer.beta

    def observe(self, step: float, noise: float = 0.0) -> None:
        """Take note of the largest step of the sweep just done with `beta`; below ``noise`` it says nothing."""
        self._sweeps += 1
        self._noisy = step <= noise
        self._observer.observe(step, noise)
        if self._observer.beta > self._highest:
            self._at_limit = True
            self._observer.beta = self._highest

    @property
    def patient(self) -> bool:
        """Whether no estimate is due yet, whatever the number of free nodes, which takes a pass to learn."""
        waits = self._sweeps < self._next_look and not self._at_limit
        return self._noisy or waits or self._sweeps < self._next

    def due(self, free_nodes: int) -> bool:
        """Whether it is time for an estimate, when so many nodes are free."""
        if self.patient or free_nodes == 0:
            return False
        if not self._estimated:
            return True
        self._next_look = self._sweeps + max(1, self._sweeps // _LOOKS)
        change = abs(free_nodes - self._free_then)
        if change == 0:
            # The same nodes would give the same estimate.
            self._at_limit = False
        return self._at_limit or change > _CHANGE_WORTH_AN_ESTIMATE * self._free_then

    def estimate(self, free: FreeNodes) -> float:
        """Take the factor from the free nodes; return the work in nodes, each once through the matrix."""
        radius = jacobi_radius(free.mask, free.across, free.along)
        self._observer.restart(young(radius.mu))
        self._highest = 2 - _MOST_BEYOND_ESTIMATE * (2 - self._observer.beta)
        self._free_then = int(np.count_nonzero(free.mask))
        self._next = self._sweeps * _SWEEPS_BETWEEN_ESTIMATES
        self._estimated, self._at_limit = True, False
        return radius.products


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
