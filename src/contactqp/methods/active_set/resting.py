"""Active sets for a positive semidefinite matrix, whose kernel the nodes in contact must hold."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ...algebra.kernel import Kernel
from ...foundation.checks import Mask, Vector
from ..amg.amg import Amg
from .primal_dual import ActiveSet

if TYPE_CHECKING:
    from scipy.sparse import csr_array


class RestingActiveSet(ActiveSet):
    """The iteration of `ActiveSet`; where no contact holds the kernel, the gap moves along it until some does.

    That lowers the energy, along a straight line, and leaves a matrix of the free nodes that is positive definite.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Symmetric positive semidefinite, with ascending column numbers.
    q, lower, upper, monotone
        See `ActiveSet`.
    amg : callable
        Returns a hierarchy for a positive definite matrix near this one.
    kernel : Kernel
        The matrix's; q leaves no ray of it unbalanced.

    Examples
    --------
    >>> from scipy import sparse
    >>> matrix = sparse.csr_array([[1.0, -1.0], [-1.0, 1.0]])
    >>> given = matrix, np.array([-1.0, 2.0]), np.zeros(2), np.zeros(0), True, lambda: Amg(matrix)
    >>> iteration = RestingActiveSet(*given, kernel=Kernel.of("constant", 2))
    >>> while not iteration.step().finished:
    ...     pass
    >>> iteration.omega
    array([1., 0.])
    """

    def __init__(
        self,
        matrix: csr_array,
        q: Vector,
        lower: Vector,
        upper: Vector,
        monotone: bool,
        amg: Callable[[], Amg],
        kernel: Kernel,
    ) -> None:
        super().__init__(matrix, q, lower, upper, monotone, amg)
        self._kernel = kernel

    def start(self, report: Callable[[str], None] = lambda text: None) -> None:
        """See `ActiveSet.start`."""
        super().start(report)
        self.omega = self._rested(self.omega)

    def _relax(self) -> None:
        super()._relax()
        if not self._kernel.held_by(np.logical_or(*self._held())):
            self.omega = self._rested(self.omega)

    def _take(self, at_lower: Mask, at_upper: Mask) -> int:
        if not self._kernel.held_by(at_lower | at_upper):
            self.omega = self._rested(self.projected(self.omega))
            at_lower, at_upper = self._held()
        return super()._take(at_lower, at_upper)

    def _rested(self, gap: Vector) -> Vector:
        return self._kernel.at_rest(gap, self.q, self._lower, self._upper)
