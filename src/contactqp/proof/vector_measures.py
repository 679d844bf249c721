"""Measures of an answer by passes of numpy over vectors: for any matrix, and for lattices that are not large."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..foundation.checks import Vector
from ..problem.contact_problem import ContactProblem
from ..problem.posed import Posed
from .beyond_m_matrices import weaker_enclosure
from .certificate import Certificate
from .enclosure import Base, Enclosure, Proven, enclosure_about, multiples, proven
from .measures import Measures
from .residuals import Residuals


class ResidualTerms(NamedTuple):
    """What residuals are found of, node by node.

    Attributes
    ----------
    room : array, shape (..., n)
        Distance from the nearer bound (length).
    reaction : array, shape (..., n)
        What must not be negative (force): R, -R where there is an upper bound alone, infinite where there are both.
    work : array, shape (..., n)
        R times the distance from the bound that it belongs to (force times length).
    natural : array, shape (..., n)
        Modulus of the natural residual (length).
    """

    room: Vector
    reaction: Vector
    work: Vector
    natural: Vector


def residual_terms(problem: Posed, gap: Vector, reaction: Vector) -> ResidualTerms:
    """Return what the residuals of a gap with such a reaction are found of."""
    natural = np.abs(problem.bounds.natural_map(gap, reaction / problem.stiffness.diagonal()))
    room, distance = gap - problem.lower, gap - problem.bounds.floor
    if problem.one_sided:
        return ResidualTerms(room, reaction, distance * reaction, natural)
    capped = np.isfinite(problem.upper)
    room = np.minimum(room, problem.upper - gap)
    least = np.where(capped, np.where(problem.supported, np.inf, -reaction), reaction)
    distance = np.where((reaction < 0) & capped, gap - problem.upper, distance)
    return ResidualTerms(room, least, distance * reaction, natural)


class Passes:
    """Passes over one answer, or over the answers to many cases, one a row; each is made when it is first asked for.

    Parameters
    ----------
    problem : Posed
    gap : array, shape of the problem's forces
        Finite gaps (length).
    """

    def __init__(self, problem: Posed, gap: Vector) -> None:
        self._problem, self._gap = problem, gap

    @cached_property
    def residuals(self) -> tuple[Vector, Vector, Vector, Vector, Vector]:
        """What `Residuals` consists of, in its order, shapes (...)."""
        problem, gap = self._problem, self._gap
        with np.errstate(over="ignore", invalid="ignore"):
            product = problem.stiffness.matvec(gap)
            terms = residual_terms(problem, gap, product + problem.q)
            return (
                terms.room.min(axis=-1),
                terms.reaction.min(axis=-1),
                terms.work.sum(axis=-1),  # not by BLAS, whose threads stall on a busy machine
                terms.natural.max(axis=-1),
                problem.energy(gap, product),
            )

    @cached_property
    def enclosure(self) -> Enclosure | None:
        """The enclosure by the barrier of an M-matrix, or a weaker one of one answer, or None."""
        problem, barrier = self._problem, self._problem.barrier
        with np.errstate(over="ignore", invalid="ignore"):
            if barrier is None:
                return weaker_enclosure(problem, self._gap)
            base = Base.of(problem, self._gap)
            found = multiples(problem, base, barrier.v, barrier.s)
            return enclosure_about(self._gap, problem.bounds, base, barrier.v, found, barrier.kind)

    @cached_property
    def proven(self) -> Proven | None:
        """What the enclosure proves."""
        return None if self.enclosure is None else proven(self._problem, self.enclosure)


class VectorMeasures(Measures):
    """See `Measures`.

    Parameters
    ----------
    problem : ContactProblem
    gap : array, shape (n,)
        A finite gap (length).
    passes : Passes, optional
        Those over many cases of which this is one; by default passes over this gap alone are made.
    case : int, optional
        Its row among them.
    """

    def __init__(
        self, problem: ContactProblem, gap: Vector, passes: Passes | None = None, case: int | tuple[()] = ()
    ) -> None:
        self.problem, self._gap = problem, gap
        self._passes, self._case = Passes(problem, gap) if passes is None else passes, case

    @cached_property
    def residuals(self) -> Residuals:
        """See `Measures`."""
        return Residuals(*(float(found[self._case]) for found in self._passes.residuals))

    @cached_property
    def largest_deflection(self) -> float:
        """See `Measures`."""
        with np.errstate(over="ignore", invalid="ignore"):
            return float(np.abs(self.problem.reference - self._gap).max())

    @property
    def gap_bound(self) -> float:
        """See `Measures`."""
        enclosure = self._passes.enclosure
        return np.inf if enclosure is None else float(enclosure.error_bound[self._case])

    @property
    def estimated_error(self) -> float:
        """See `Measures`; the estimate is the natural residual over an estimated smallest eigenvalue.

        That is of the matrix with a diagonal of ones, in whose terms the natural residual is a force out of balance.
        """
        if self._passes.enclosure is not None:
            return self.gap_bound
        return self.residuals.natural_residual / self.problem.estimated_least_eigenvalue

    def certificate(self) -> Certificate | None:
        """See `Measures`."""
        found = self._passes.proven
        return None if found is None else Certificate.of_case(self.problem, found, self._case)
