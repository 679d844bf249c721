"""Widening: more contact nodes are released than a step asks for, where the contact set creeps.

A free boundary that has to recede shows it at the nodes beside it alone, so that each step releases a layer of them or
two. Bending stiffens this: under a heavy beam or plate hundreds of layers may have to go. So while as many nodes change
sides as in the step before, layers of contact nodes behind those released are freed with them, twice as many each time
that nearly all of them stay free, and a quarter where they do not. Nodes that are freed wrongly are found at once,
because the equations carry them beyond their bound; and what the step gains is still decided by the energy.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...foundation.checks import Mask, Vector

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_AS_MANY = 0.9, 1.5
"""Parts of the last step's exchanges between which a contact set counts as creeping."""

_PATIENCE = 2
"""Steps in a row that creep before layers are added."""

_NEARLY_ALL = 0.9


class Widening:
    """How many layers of contact nodes are released with those that a step releases.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Its entries tell which unknowns are neighbours.
    """

    def __init__(self, matrix: csr_array) -> None:
        self._indptr, self._indices = matrix.indptr, matrix.indices
        self.restart()
        self._added: NDArray[np.intp] = np.zeros(0, dtype=np.intp)

    def restart(self) -> None:
        """Forget the steps so far."""
        self.layers = self._creeps = 0
        self._exchanged = 0.0

    def widened(self, held: tuple[Mask, Mask], before: tuple[Mask, Mask]) -> tuple[Mask, Mask]:
        """Return the nodes at their lower and at their upper bound, without the layers that are released with others.

        Parameters
        ----------
        held, before : (array of bool, array of bool), shapes (n,)
            Nodes at their lower and at their upper bound, as the step has found them and as they were before it.
        """
        self._added = self._added[:0]
        if not self.layers:
            return held
        for at_bound, was in zip(held, before, strict=True):
            released = np.flatnonzero(was & ~(held[0] | held[1]))
            if released.size:
                behind = self._behind(released, at_bound)
                self._added = np.concatenate([self._added, behind])
        free = np.zeros(held[0].size, dtype=np.bool_)
        free[self._added] = True
        return held[0] & ~free, held[1] & ~free

    def learn(self, exchanged: int, omega: Vector, lower: Vector, upper: Vector) -> None:
        """See what has become of the nodes that were added, after a step in which so many changed sides."""
        if self._added.size:
            stay = omega[self._added] > lower[self._added]
            if upper.size:
                stay &= omega[self._added] < upper[self._added]
            self.layers = 2 * self.layers if stay.mean() > _NEARLY_ALL else self.layers // 4
        elif not self.layers:
            least, most = (part * self._exchanged for part in _AS_MANY)
            self._creeps = self._creeps + 1 if 0 < exchanged <= most and exchanged >= least else 0
            self.layers = int(self._creeps >= _PATIENCE)
        self._exchanged = exchanged

    def _behind(self, released: NDArray[np.intp], at_bound: Mask) -> NDArray[np.intp]:
        """Return the nodes at a bound that are so many layers, or fewer, away from those released."""
        unseen, front, found = at_bound.copy(), released, [released[:0]]
        for _ in range(self.layers):
            counts = self._indptr[front + 1] - self._indptr[front]
            first = np.repeat(self._indptr[front] - (np.cumsum(counts) - counts), counts)
            neighbours = self._indices[first + np.arange(first.size)]
            front = np.unique(neighbours[unseen[neighbours]])
            if not front.size:
                break
            unseen[front] = False
            found.append(front)
        return np.concatenate(found)
