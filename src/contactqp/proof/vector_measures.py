"""Measures of an answer by passes of numpy over vectors: for any matrix, and for lattices that are not large."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..foundation.checks import Vector
from ..problem.contact_qp import ContactQP
from .beyond_m_matrices import weaker_enclosure
from .certificate import Certificate
from .enclosure import Base, Enclosure, enclosure_about, multiples
from .measures import Measures
from .residuals import Residuals


class VectorMeasures(Measures):
    """See `Measures`.

    Parameters
    ----------
    problem : ContactQP
    gap : array, shape (n,)
        A finite gap (length).
    """

    def __init__(self, problem: ContactQP, gap: Vector) -> None:
        self.problem, self._gap = problem, gap

    @cached_property
    def residuals(self) -> Residuals:
        """See `Measures`."""
        problem, gap = self.problem, self._gap
        with np.errstate(over="ignore", invalid="ignore"):
            product = problem.stiffness.matvec(gap)
            reaction = product + problem.q
            natural = problem.bounds.natural_map(gap, reaction / problem.stiffness.diagonal())
            room = float((gap - problem.lower).min())
            least, distance = float(reaction.min()), gap - problem.bounds.floor
            if not problem.one_sided:
                capped = np.isfinite(problem.upper)
                room = min(room, float((problem.upper - gap).min()))
                least = float(reaction.min(where=~capped, initial=np.inf))
                least = min(least, float((-reaction).min(where=capped & ~problem.supported, initial=np.inf)))
                distance = np.where((reaction < 0) & capped, gap - problem.upper, distance)
            return Residuals(
                min_gap=room,
                min_reaction=least,
                complementarity=_inner(distance, reaction),
                natural_residual=float(np.abs(natural).max()),
                objective=_inner(gap, 0.5 * product + problem.q),
            )

    @cached_property
    def largest_deflection(self) -> float:
        """See `Measures`."""
        with np.errstate(over="ignore", invalid="ignore"):
            return float(np.abs(self.problem.reference - self._gap).max())

    @property
    def gap_bound(self) -> float:
        """See `Measures`."""
        return np.inf if self._enclosure is None else self._enclosure.bound

    @property
    def estimated_error(self) -> float:
        """See `Measures`; the estimate is the natural residual over an estimated smallest eigenvalue.

        That is of the matrix with a diagonal of ones, in whose terms the natural residual is a force out of balance.
        """
        if self._enclosure is not None:
            return self._enclosure.bound
        return self.residuals.natural_residual / self.problem.estimated_least_eigenvalue

    def certificate(self) -> Certificate | None:
        """See `Measures`."""
        return None if self._enclosure is None else Certificate.of(self.problem, self._enclosure)

    @cached_property
    def _enclosure(self) -> Enclosure | None:
        """The enclosure by the barrier of an M-matrix, or a weaker one, or None."""
        problem, barrier = self.problem, self.problem.barrier
        with np.errstate(over="ignore", invalid="ignore"):
            if barrier is None:
                return weaker_enclosure(problem, self._gap)
            base = Base.of(problem, self._gap)
            found = multiples(problem, base, barrier.v, barrier.s)
            return enclosure_about(self._gap, problem.bounds, base, barrier.v, found, barrier.kind)


def _inner(first: Vector, second: Vector) -> float:
    """Return the inner product by pairwise summation, without BLAS, whose threads stall on a busy machine."""
    return float((first * second).sum())
