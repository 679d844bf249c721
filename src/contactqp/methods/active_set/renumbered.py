"""Active sets on a matrix whose unknowns are kept in an order of their own."""

from __future__ import annotations

from collections.abc import Callable

from ...algebra.kernel import Kernel
from ...foundation.checks import Vector
from ..amg.ordered import Ordered
from .primal_dual import ActiveSet, Step
from .resting import RestingActiveSet


class Renumbered:
    """The iteration of `ActiveSet`, for vectors in the order that the matrix was given in.

    Parameters
    ----------
    ordered : Ordered
        The matrix.
    q : array, shape (n,)
    lower, upper : array, shape (n,)
        Bounds as for `ActiveSet`.
    monotone : bool
        See `ActiveSet`.
    kernel : Kernel, optional
        Of a matrix that is semidefinite, see `RestingActiveSet`.
    """

    def __init__(
        self,
        ordered: Ordered,
        q: Vector,
        lower: Vector,
        upper: Vector,
        monotone: bool,
        kernel: Kernel | None = None,
    ) -> None:
        self._ordered = ordered
        forces, above, below = self._inwards(q, lower, upper)
        given = ordered.matrix, forces, above, below, monotone, lambda: ordered.amg
        if kernel is None:
            self._iteration = ActiveSet(*given)
        else:
            self._iteration = RestingActiveSet(*given, kernel.taken(ordered.inwards))

    def restart(self, q: Vector, lower: Vector, upper: Vector) -> None:
        """Go back to ω = 0 with other forces and other values of the bounds."""
        self._iteration.restart(*self._inwards(q, lower, upper))

    def start(self, report: Callable[[str], None] = lambda text: None) -> None:
        """Start from the solution of coarser problems."""
        self._iteration.start(report)

    def start_from(self, gap: Vector) -> None:
        """Start from a gap, shape (n,)."""
        self._iteration.start_from(self._ordered.inwards(gap))

    def step(self) -> Step:
        """Do a step, see `ActiveSet.step`."""
        return self._iteration.step()

    def feasible(self) -> Vector:
        """Return ω between its bounds, shape (n,)."""
        return self._ordered.outwards(self._iteration.feasible())

    def _inwards(self, *vectors: Vector) -> list[Vector]:
        return [self._ordered.inwards(vector) for vector in vectors]
