"""Measures of an answer that is spread over processes, where arms differ or end on the ground: by passes of numpy."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..methods.multigrid.rows import Rows
from ..problem.bounds import Bounds
from ..problem.contact_problem import ContactProblem
from ..problem.facts import MatrixFacts
from ..problem.posed import Posed
from ..proof.certificate import Certificate
from ..proof.enclosure import Base, Enclosure, Multiples, Proven, enclosure_about, multiples, proven
from ..proof.lattice_measures import ENCLOSED
from ..proof.measures import Measures
from ..proof.residuals import Residuals
from ..proof.vector_measures import residual_terms
from .barriers import PartOfBarrier
from .stencils import PartOfStencil


class _Window(NamedTuple):
    """Some rows and the next one on either side, so that what is computed of the rows is what it is on all of them.

    Attributes
    ----------
    held : slice
        The numbers of its nodes among those that the process holds.
    own : slice
        The numbers of the nodes in the rows themselves among those of the window.
    place : slice
        The same among those that the process holds.
    problem : Posed
    """

    held: slice
    own: slice
    place: slice
    problem: Posed


class MeasuresByRows(Measures):
    """See `Measures`: the same enclosure as `contactqp.proof.vector_measures.VectorMeasures` has for an M-matrix.

    It is taken block by block of rows, so that passes need memory for the nodes of one block. Multiples of the barrier
    are found at the process's own nodes, and the largest of all blocks and processes count: rounded products and sums
    of larger numbers are no smaller, so that what is enclosed is to the bit what one process would enclose that held
    all rows, in one pass.

    Parameters
    ----------
    problem : ContactProblem
        On the rows that the process holds.
    stencil : PartOfStencil
        Its stiffness.
    barrier : PartOfBarrier
    gap : array, shape (n,)
        A finite gap (length).
    part : Rows
        The rows.
    starts : array, shape (rows + 1,)
        The number of the first node in each row, and the number of all nodes.
    """

    def __init__(
        self,
        problem: ContactProblem,
        stencil: PartOfStencil,
        barrier: PartOfBarrier,
        gap: Vector,
        part: Rows,
        starts: NDArray[np.int64],
    ) -> None:
        self.problem, self.gap = problem, gap
        self._stencil, self._barrier, self._part, self._starts = stencil, barrier, part, starts
        bounds = problem.bounds
        kinds = part.everyones([(bounds.standard, bounds.one_sided)])
        self._standard, self._one_sided = (all(each) for each in zip(*kinds, strict=True))
        with np.errstate(over="ignore", invalid="ignore"):
            found, sums = zip(*(self._measured(low, high) for low, high in part.blocks), strict=True)
            numbers = np.array([part for part in found if part is not None])
            extremes = [*numbers[:, :4].max(axis=0), *numbers[:, 4:].min(axis=0), float(not problem.shut)]
            raise_by, lower_by, natural, size, room, reaction, opens = np.array(part.everyones([extremes])).T
            self._multiples = Multiples(
                raise_by.max(keepdims=True), lower_by.max(keepdims=True), np.ones(1, np.bool_), np.ones(1, np.bool_)
            )
            bound = max(self._bound(low, high) for low, high in part.blocks)
        self._gap_bound = max(part.everyones([bound]))
        self._largest_deflection, self._shut = float(size.max()), not opens.any()
        work, objective = part.sums(sums)
        self._residuals = Residuals(
            min_gap=float(room.min()),
            min_reaction=float(reaction.min()),
            complementarity=work,
            natural_residual=float(natural.max()),
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
        size = self.gap.size
        lower, upper = np.zeros(size), np.zeros(size)
        at_lower, at_upper, clear = (np.zeros(size, dtype=np.bool_) for _ in range(3))
        finite = True
        for low, high in self._enclosed:
            window = self._window(low, high)
            if window.place.start == window.place.stop:
                continue
            found = proven(window.problem, self._enclosure(window.held, window.problem.bounds))
            own = found.lower, found.upper, found.at_lower, found.at_upper, found.clear
            for values, some in zip((lower, upper, at_lower, at_upper, clear), own, strict=True):
                values[window.place] = some[window.own]
            finite &= bool(np.isfinite(lower[window.place]).all() and np.isfinite(upper[window.place]).all())
        known = all(self._part.everyones([finite])) and np.isfinite(self._gap_bound)
        bound, known = np.asarray(self._gap_bound), np.asarray(known)
        kind = self._barrier.kind
        return Certificate.of_case(self.problem, Proven(lower, upper, bound, at_lower, at_upper, clear, known, kind))

    @property
    def _enclosed(self) -> Iterator[tuple[int, int]]:
        """The blocks of its own rows, with those beside them that are enclosed as well."""
        first, last = self._part.near(ENCLOSED)
        for low, high in self._part.blocks:
            yield first if low == self._part.first else low, last if high == self._part.last else high

    def _nodes(self, low: int, high: int) -> slice:
        """Return the numbers of the nodes in the rows [low, high) of the arrays."""
        return slice(int(self._starts[low - 1]), int(self._starts[high - 1]))

    def _window(self, low: int, high: int) -> _Window:
        first, last = max(1, low - 1), min(self._part.height - 1, high + 1)
        held, place = self._nodes(first, last), self._nodes(low, high)
        own = slice(place.start - held.start, place.stop - held.start)
        facts = MatrixFacts(self._stencil.on_rows(first - 1, last - 1))
        return _Window(held, own, place, Posed(facts, self.problem.q[held], self._bounds(held)))

    def _bounds(self, at: slice) -> Bounds:
        bounds = Bounds(self.problem.lower[at], self.problem.upper[at])
        # As for all nodes, whatever these are.
        bounds.standard, bounds.one_sided = self._standard, self._one_sided
        return bounds

    def _measured(self, low: int, high: int) -> tuple[tuple[float, ...] | None, tuple[float, float]]:
        """Return multiples, the largest numbers and the least ones of a block, if it has a node, and sums."""
        window = self._window(low, high)
        own, place, problem = window.own, window.place, window.problem
        if place.start == place.stop:
            return None, (0.0, 0.0)
        gap = self.gap[window.held]
        base = Base.of(problem, gap)

        def largest(numbers: Vector, chosen: Mask) -> Vector:
            return np.asarray(numbers[own].max(where=chosen[own], initial=0.0, keepdims=True))

        v, s = self._barrier.v[window.held], self._barrier.s[window.held]
        found = multiples(problem, base, v, s, largest=largest)
        terms = residual_terms(problem, gap, base.reaction)
        energy = 0.5 * gap * (base.reaction + problem.q)
        deflection = np.abs(np.broadcast_to(self.problem.reference, self.gap.shape)[place] - self.gap[place])
        numbers = (
            *(float(each[0]) for each in (found.raise_by, found.lower_by)),
            *(float(each.max()) for each in (terms.natural[own], deflection)),
            *(float(each.min()) for each in (terms.room[own], terms.reaction[own])),
        )
        return numbers, (float(terms.work[own].sum()), float(energy[own].sum()))

    def _enclosure(self, at: slice, bounds: Bounds) -> Enclosure:
        gap = self.gap[at]
        nothing = np.zeros(1)
        base = Base(gap, nothing, nothing, nothing)
        return enclosure_about(gap, bounds, base, self._barrier.v[at], self._multiples, self._barrier.kind)

    def _bound(self, low: int, high: int) -> float:
        """Return the bound of the errors in a block."""
        at = self._nodes(low, high)
        return self._enclosure(at, self._bounds(at)).bound if at.start < at.stop else 0.0
