"""Measures of an answer that is spread over processes, where arms differ or end on the ground: by passes of numpy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..foundation.checks import Mask, Vector
from ..methods.multigrid.rows import Rows
from ..problem.contact_problem import ContactProblem
from ..proof.certificate import Certificate
from ..proof.enclosure import Base, enclosure_about, multiples, proven
from ..proof.measures import Measures
from ..proof.residuals import Residuals
from ..proof.vector_measures import residual_terms
from .barriers import PartOfBarrier


class MeasuresByRows(Measures):
    """See `Measures`: the same enclosure as `contactqp.proof.vector_measures.VectorMeasures` has for an M-matrix.

    Multiples of the barrier are found at the process's own nodes, and the largest of all processes' counts. So what is
    enclosed is what one process would enclose that held all rows.

    Parameters
    ----------
    problem : ContactProblem
        On the rows that the process holds.
    barrier : PartOfBarrier
    gap : array, shape (n,)
        A finite gap (length).
    part : Rows
        The rows.
    places : list of slice
        The numbers of the nodes in each block of its own rows.
    """

    def __init__(
        self, problem: ContactProblem, barrier: PartOfBarrier, gap: Vector, part: Rows, places: list[slice]
    ) -> None:
        self.problem, self.gap = problem, gap
        self._barrier, self._part = barrier, part
        self._own = slice(places[0].start, places[-1].stop)
        own = self._own
        with np.errstate(over="ignore", invalid="ignore"):
            base = Base.of(problem, gap)
            found = multiples(problem, base, barrier.v, barrier.s, largest=self._largest)
            self._enclosure = enclosure_about(gap, problem.bounds, base, barrier.v, found, barrier.kind)
            terms = residual_terms(problem, gap, base.reaction)
            energy = 0.5 * gap * (base.reaction + problem.q)
            deflection = np.abs(problem.reference - gap)[own].max()
            extremes = terms.room[own].min(), terms.reaction[own].min(), terms.natural[own].max(), deflection
            sums = [(float(terms.work[at].sum()), float(energy[at].sum())) for at in places]
            bound = float(np.maximum(self._enclosure.fall[own].max(), self._enclosure.rise[own].max()))
        numbers = *map(float, extremes), np.inf if np.isnan(bound) else max(0.0, bound), float(not problem.shut)
        room, reaction, natural, largest, bounds, opens = zip(*part.everyones([numbers]), strict=True)
        self._gap_bound, self._largest_deflection, self._shut = float(max(bounds)), float(max(largest)), not any(opens)
        work, objective = part.sums(sums)
        self._residuals = Residuals(
            min_gap=min(room),
            min_reaction=min(reaction),
            complementarity=work,
            natural_residual=max(natural),
            objective=objective,
        )

    @property
    def shut(self) -> bool:
        """See `Measures`."""
        return self._shut

    @property
    def residuals(self) -> Residuals:
        """See `Measures`."""
        return self._residuals

    @property
    def largest_deflection(self) -> float:
        """See `Measures`."""
        return self._largest_deflection

    @property
    def gap_bound(self) -> float:
        """See `Measures`."""
        return self._gap_bound

    def certificate(self) -> Certificate:
        """See `Measures`."""
        found = proven(self.problem, self._enclosure)
        finite = np.isfinite(found.lower[self._own]).all() and np.isfinite(found.upper[self._own]).all()
        known = all(self._part.everyones([bool(finite)])) and np.isfinite(self._gap_bound)
        bound = np.asarray(self._gap_bound)
        return Certificate.of_case(self.problem, replace(found, error_bound=bound, finite=np.asarray(known)))

    def _largest(self, numbers: Vector, chosen: Mask) -> Vector:
        own = self._own
        largest = numbers[own].max(where=chosen[own], initial=0.0)
        return np.array([max(self._part.everyones([float(largest)]))])
