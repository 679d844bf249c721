"""AnswerByRows: what a process knows of an answer that is spread over many, and what all of them know together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._version import __version__
from ..foundation.brackets import Bracket, sum_above, sum_below
from ..foundation.checks import Vector
from ..foundation.text import at_most, counted
from ..io.fields import Field
from ..models.base import ForceBalance
from ..models.records import states_of
from ..models.suspicions import steep
from ..problem.barrier import Barrier
from ..proof.certificate import Certificate
from ..proof.energy import Nodes, admissible_state, bracket_at, inner_between
from ..proof.residuals import Residuals
from ..proof.status import DISCRETE, Status
from .membrane import MembraneByRows
from .posed import MeasuresOfRows, PosedByRows
from .store import write_store


class _NodesByRows(Nodes):
    """All processes' nodes; vectors have those that this one holds."""

    def __init__(self, posed: PosedByRows) -> None:
        super().__init__(posed.problem)
        self._posed = posed

    @property
    def barrier(self) -> Barrier:
        """See `Nodes`."""
        return self._posed.barrier

    def product(self, x: Vector) -> tuple[Vector, Vector]:
        """See `Nodes`; in plain double precision."""
        return self.problem.stiffness.enclosed_product(x, self.problem.q)

    def any(self, *vectors: Vector) -> bool:
        """See `Nodes`."""
        return any(self._posed.part.everyones([any(bool(each[self._posed.own].any()) for each in vectors)]))

    def largest(self, values: Vector) -> float:
        """See `Nodes`."""
        return max(self._posed.part.everyones([float(values[self._posed.own].max())]))

    def inner_between(self, x: Vector, y: Vector, error: Vector) -> Bracket:
        """See `Nodes`: brackets of blocks of rows, added outwards."""
        posed = self._posed
        places = [posed.nodes_of(*block) for block in posed.part.blocks]
        lower, upper = zip(
            *posed.part.everyones([inner_between(x[at], y[at], error[at]) for at in places]), strict=True
        )
        low, high = (sum_below(lower) if any(lower) else 0.0), (sum_above(upper) if any(upper) else 0.0)
        return Bracket(low, high)


@dataclass(frozen=True, eq=False, repr=False)
class AnswerByRows:
    """The answer of `solve`: arrays of the process's own rows, and numbers that are the same in every process.

    Attributes
    ----------
    posed : PosedByRows
    tol : float
    status : Status
        ``certified`` if the error is proven to be within ``tol``.
    termination : str
        Why the iteration ended.
    measures : LatticeMeasures or MeasuresByRows
    certificate : Certificate
        Of the process's rows, and two rows of each neighbour; its ``gap_bound`` is that of the whole answer.
    iterations : int
        Cycles on the finest lattice.
    setup_seconds, seconds : float
        Time until the iteration began, and in all.
    cycle_seconds : float
        Time of a cycle on the finest lattice, in the mean.
    messages, sent : float
        Messages, and bytes in them, that this process has sent in each cycle on the finest lattice, in the mean.
    """

    posed: PosedByRows
    tol: float
    status: Status
    termination: str
    measures: MeasuresOfRows
    certificate: Certificate
    iterations: int
    setup_seconds: float
    seconds: float
    cycle_seconds: float
    messages: float
    sent: float

    @property
    def membrane(self) -> MembraneByRows:
        """The model."""
        return self.posed.membrane

    @property
    def rows(self) -> tuple[int, int]:
        """The rows [first, last) of the lattice that are this process's: together they are all of them."""
        posed = self.posed
        (first, last), ranks = posed.part.own, posed.ranks
        return (
            0 if ranks.rank == 0 else posed.top + first - 1,
            self.membrane.shape[0] if ranks.rank == ranks.size - 1 else posed.top + last - 1,
        )

    def on_rows(self, values: NDArray[Any], fill: float = np.nan) -> NDArray[Any]:
        """Lay values of the nodes that the process holds out on its own rows, shape (rows, columns).

        Parameters
        ----------
        values : array, shape (n,)
        fill : float
            Value of the other points.
        """
        posed, (first, last) = self.posed, self.rows
        layout, part = posed.lattice.layout, posed.part
        found = np.full((last - first, self.membrane.shape[1]), fill, dtype=np.result_type(values, type(fill)))
        own = layout.mask[part.first - 1 : part.last - 1]
        begin = posed.top + part.own[0] - 1 - first
        found[begin : begin + len(own), posed.columns][own] = values[posed.own]
        return found

    @property
    def gap(self) -> NDArray[np.float64]:
        """ω (length) on the own rows, nan at points that are no nodes; see `contactqp.Solution.gap`."""
        return self.on_rows(self.measures.gap)

    @property
    def deflection(self) -> NDArray[np.float64]:
        """Deflection (length) on the own rows, positive as the membrane's heights."""
        return self.on_rows((-1.0 if self.membrane.upwards else 1.0) * self._below)

    @property
    def reaction(self) -> NDArray[np.float64]:
        """R = Gω + q (force) on the own rows."""
        return self.on_rows(self._reaction)

    @property
    def contact_state(self) -> NDArray[np.float64]:
        """What is proven of each node of the own rows: 1 in contact, 2 with the ceiling, 0 clear, -1 undecided."""
        return self.on_rows(states_of(self.certificate).astype(np.float64))

    @property
    def gap_bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Proven bounds of the exact gap (length) on the own rows."""
        return self.on_rows(self.certificate.lower), self.on_rows(self.certificate.upper)

    @property
    def gap_bound(self) -> float:
        """Proven bound of the gap's largest error at any node (length)."""
        return self.certificate.gap_bound

    @property
    def scale(self) -> float:
        """The error scale (length), see `contactqp.proof.measures.Measures.scale`."""
        return self.measures.scale

    @property
    def relative_bound(self) -> float:
        """`gap_bound` over `scale`."""
        return self.gap_bound / self.scale

    @property
    def residuals(self) -> Residuals:
        """How far the answer is from the optimality conditions."""
        return self.measures.residuals

    @cached_property
    def node_counts(self) -> tuple[int, int, int]:
        """How many nodes are certainly in contact, certainly clear, and undecided."""
        own, certificate = self.posed.own, self.certificate
        masks = certificate.contact, certificate.clear, certificate.undecided
        counts = tuple(int(np.count_nonzero(mask[own])) for mask in masks)
        contact, clear, undecided = (sum(part) for part in zip(*self.posed.part.everyones([counts]), strict=True))
        return contact, clear, undecided

    @property
    def contact_area(self) -> Bracket:
        """Bracket of the area in contact."""
        contact, _, undecided = self.node_counts
        area = self.membrane.node_area
        return Bracket(contact * area, (contact + undecided) * area)

    @cached_property
    def total_reaction(self) -> Bracket:
        """Bracket of the sum of R* over all nodes (force), see `contactqp.Certificate.total_reaction`."""
        posed, terms = self.posed, self.certificate.reaction_terms()
        found = []
        for block in posed.part.blocks:
            at = posed.nodes_of(*block)
            forces, product, reach = terms.forces[at], terms.product[at], terms.reach[at]
            every = np.isfinite(product).all() and np.isfinite(reach).all()
            found.append(
                (
                    sum_below(terms.lower[at]),
                    sum_above(terms.upper[at]),
                    sum_below(np.concatenate([forces, product, -reach])) if every else -np.inf,
                    sum_above(np.concatenate([forces, product, reach])) if every else np.inf,
                    float(self.certificate.problem.one_sided),
                )
            )
        low, high, low_all, high_all, one_sided = map(list, zip(*posed.part.everyones(found), strict=True))
        least = max(sum_below(low), sum_below(low_all))
        return Bracket(
            max(0.0, least) if all(one_sided) else least,
            min(sum_above(high), sum_above(high_all)),
        )

    @cached_property
    def energy_bracket(self) -> Bracket:
        """Bracket of the potential energy at the exact solution (force times length), see `contactqp.energy_bracket`.

        The lower end comes without a linear solve, from the reaction of the answer.
        """
        problem = self.posed.problem
        return bracket_at(_NodesByRows(self.posed), *admissible_state(problem, self.measures.gap))

    @cached_property
    def force_balance(self) -> ForceBalance:
        """ΣP = ΣR + the frame's pull (force), with what a ceiling adds."""
        posed, problem = self.posed, self.posed.problem
        reaction = self._reaction
        _, at_ceiling = problem.bounds.contact(self.measures.gap, reaction / problem.stiffness.diagonal())
        pushed = posed.total(np.where(at_ceiling, -reaction, 0.0))
        foundation = posed.total(posed.springs * self._below) if self.membrane.has("foundation") else 0.0
        return ForceBalance(
            load=posed.total(posed.load),
            reaction=posed.total(reaction) + pushed,
            frame=posed.total(self._pull) - foundation,
            ceiling=pushed,
            foundation=foundation,
        )

    @cached_property
    def max_slope(self) -> float:
        """Largest slope of the deflection along an arm (no unit); the theory assumes small ones."""
        posed = self.posed
        numbering, rows = posed.stencil.numbering, slice(posed.part.first - 1, posed.part.last + 1)
        heights = posed.heights(self._below)[rows]
        nodes = numbering.to_grid(np.ones(self._below.size, dtype=np.bool_), ring=1, fill=False)[rows]
        steepest = 0.0
        for own, there in ((heights, nodes), (heights[1:-1].T, nodes[1:-1].T)):
            rise, arms = np.abs(np.diff(own, axis=0)), there[:-1] | there[1:]
            steepest = max(steepest, float(rise.max(where=arms, initial=0.0)))
        return max(posed.part.everyones([steepest])) / self.membrane.spacing

    @cached_property
    def _below(self) -> Vector:
        return self.posed.reference - self.measures.gap

    @cached_property
    def _reaction(self) -> Vector:
        problem = self.posed.problem
        return problem.stiffness.enclosed_product(self.measures.gap)[0] + problem.q

    @cached_property
    def _pull(self) -> Vector:
        """Force with which the arms pull each node upwards (force); of outer rows that others own it is not right."""
        return self.posed.stencil.pull(self.posed.heights(self._below))

    def to_zarr(self, path: str | Path, facts: Mapping[str, Any] | None = None) -> Path:
        """Write all fields into one Zarr store; every process writes its rows. All must call it.

        Parameters
        ----------
        path : str or Path
            A folder that all processes reach; one of that name is replaced as a whole.
        facts : mapping of str to number or str, optional
            Further attributes of the store.

        Raises
        ------
        ImportError
            If zarr is not installed.
        OSError
            If it cannot be written, in every process.
        """
        told = {
            "status": self.status.value,
            "tol": self.tol,
            "gap_error_bound": self.gap_bound,
            "error_scale": self.scale,
            "contactqp_version": __version__,
        }
        return write_store(
            Path(path), self.posed.ranks, self.membrane, self.rows, self.fields, {**told, **(facts or {})}
        )

    @property
    def fields(self) -> dict[str, Field]:
        """What `to_zarr` writes: quantities on the own rows, with units and meanings."""
        lower, upper = self.gap_bounds
        sense = "positive upwards" if self.membrane.upwards else "positive downwards"
        states = "1 certainly in contact with the support, 2 with the upper bound, 0 certainly clear, -1 undecided"
        return {
            "gap": Field(self.gap, "length", "clearance over the support"),
            "deflection": Field(self.deflection, "length", f"deflection, {sense}"),
            "reaction": Field(self.reaction, "force", "nodal reaction, upwards"),
            "gap_lower": Field(lower, "length", "certified lower bound of the gap"),
            "gap_upper": Field(upper, "length", "certified upper bound of the gap"),
            "contact_state": Field(self.contact_state, "1", states),
        }

    def summary(self) -> str:
        """Return what there is to tell, in lines; all processes must call it, and one may print it."""
        contact, clear, undecided = self.node_counts
        balance, ranks = self.force_balance, self.posed.ranks
        area, reaction, energy = self.contact_area, self.total_reaction, self.energy_bracket
        lines = [
            f"AnswerByRows: {self.status.value}, multigrid of {counted(ranks.size, 'process', 'processes')}, "
            f"{counted(self.iterations, 'cycle')}, "
            f"{self.seconds:.2f} s",
            f"  problem     {self.membrane!r}",
            f"  gap error   <= {at_most(self.gap_bound)} (certified), {at_most(self.relative_bound, 1)} of the error "
            f"scale; tol {self.tol:g}",
            f"  against     {DISCRETE}",
            f"  nodes       {contact} in contact, {clear} clear, {undecided} undecided: proven of the exact solution",
            f"  reaction    {reaction.lower:.6g} to {reaction.upper:.6g} in all",
            f"  contact     {area.lower:.6g} to {area.upper:.6g} in area",
            f"  energy      {energy.lower:.10g} to {energy.upper:.10g}",
            f"  balance     load {balance.load:.6g} = support {balance.reaction:.6g} + frame {balance.frame:.6g}"
            + (f" - ceiling {balance.ceiling:.6g}" if balance.ceiling else "")
            + f", but for {abs(balance.imbalance):.1g}",
        ]
        if not self.status.ok:
            lines.append(f"  ended       {self.termination}")
        lines += [f"  caution     {told}" for told in steep(self.max_slope)]
        return "\n".join(lines)

    def __repr__(self) -> str:
        first, last = self.rows
        rows = f"rows {first} to {last} of {self.membrane.shape[0]}"
        return f"AnswerByRows({self.status.value}, |gap error| <= {at_most(self.gap_bound, 3)}, {rows})"
