"""Certificate: a rigorous enclosure of the true solution, from any approximate one."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..algebra.stiffness import growth_bound
from ..foundation.brackets import Bracket, sum_above, sum_below, sum_between
from ..foundation.checks import Mask, Vector, repeated
from ..foundation.rounding import UNDERFLOW, UNIT_ROUNDOFF
from ..foundation.text import at_least, at_most
from ..models.base import ContactModel
from ..problem.contact_problem import ContactProblem
from ..problem.eigenvalue import LeastEigenvalue
from .beyond_m_matrices import COMPARISON, EIGENVALUE
from .enclosure import Enclosure, Proven, middle_and_radius, proven

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_NOWHERE: Mask = np.zeros(0, dtype=np.bool_)
"""Stands for nodes of which none is meant, however many there are."""


@lru_cache(maxsize=16)
def _nowhere(size: int) -> Mask:
    """Return a mask of no node, which takes no memory, but longer to make than it should."""
    return np.broadcast_to(np.False_, (size,))


class ReactionTerms(NamedTuple):
    """Two ways to bound a sum of reactions: of any nodes by the first two, and of all nodes by the others as well.

    Attributes
    ----------
    lower, upper : array, shape (n,)
        Bounds of each node's reaction (force).
    forces, product, reach : array, shape (n,)
        q, the products c_i ω*_i with the column sums c of G as computed, and bounds of the errors of these (force).
    """

    lower: Vector
    upper: Vector
    forces: Vector
    product: Vector
    reach: Vector


@dataclass(frozen=True, eq=False)
class Certificate:
    """Bounds that the exact solution ω* of a problem provably satisfies, node by node.

    Attributes
    ----------
    problem : ContactProblem
        The problem.
    model : Membrane, Cable, CableNet or None
        What it comes from, if that was certified.
    lower, upper : array, shape (n,)
        lower ≤ ω* ≤ upper (length).
    gap_bound : float
        max |ω - ω*| is at most this (length), for the ω that was certified.
    contact : array of bool, shape (n,)
        Nodes where R* ≠ 0 is certain: either bound holds them.
    clear : array of bool, shape (n,)
        Nodes where ω* is certain to lie strictly between its bounds (with the lower bound 0 alone, ω* > 0), and all
        nodes without a bound.
    barrier : str
        What the bounds are multiples of, a vector v > 0 with Gv > 0. On a lattice it is a ``"paraboloid"`` over the
        frame or a ``"strip along x"`` (``"y"``) between two of its sides, for a matrix the answer v of a ``"linear
        solve"`` Gv = 1, and in a sharp certificate that of one over the ``"free set"``: the nodes that the answer does
        not have in contact, v being zero at the others. For a matrix that is no M-matrix it says what is known of it
        instead: its ``"comparison matrix"`` is an M-matrix, or its ``"smallest eigenvalue"`` is bounded from below,
        see `least_eigenvalue`.
    contact_upper : array of bool, shape (n,)
        Nodes where R* < 0 is certain: the upper bound holds them. All False where there is none.
    enclosed : ContactQP or None
        For a semidefinite matrix: the positive definite problem, with springs at nodes in contact, that is proven to
        have the same solution, and by which that is enclosed (see `contactqp.proof.semidefinite`).
    """

    problem: ContactProblem = field(repr=False)
    lower: Vector
    upper: Vector
    gap_bound: float
    contact: Mask
    clear: Mask
    barrier: str
    model: ContactModel | None = field(default=None, repr=False)
    contact_upper: Mask = field(default_factory=lambda: _NOWHERE)
    enclosed: ContactProblem | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        """Without an upper bound no node is in contact with one."""
        if self.contact_upper is _NOWHERE:
            object.__setattr__(self, "contact_upper", _nowhere(self.contact.size))

    @classmethod
    def of(cls, problem: ContactProblem, found: Enclosure) -> Certificate:
        """Return what an enclosure of the solution proves."""
        return cls.of_case(problem, proven(problem, found))

    @classmethod
    def of_case(cls, problem: ContactProblem, found: Proven, case: int | tuple[()] = ()) -> Certificate:
        """Return the certificate of one of the cases that something is proven of; by default there is only one."""
        if not found.finite[case]:
            return cls.unknown(problem, found.barrier)
        vectors: list[Any] = [found.lower[case], found.upper[case], found.contact[case], found.clear[case]]
        if not problem.one_sided:
            vectors.append(found.at_upper[case])
        if found.lower.ndim > 1:  # one that is kept must not hold the numbers of all the others
            vectors = [values.copy() for values in vectors]
        lower, upper, contact, clear, *above = vectors
        bound = float(found.error_bound[case])
        return cls(problem, lower, upper, bound, contact, clear, found.barrier, None, *above)

    @classmethod
    def unknown(cls, problem: ContactProblem, barrier: str) -> Certificate:
        """Return the enclosure that always holds, for numbers whose bounds overflow."""
        nowhere = np.zeros(problem.size, dtype=np.bool_)
        unbounded = ~problem.supported & np.isposinf(problem.upper)
        return cls(problem, np.array(problem.lower), np.array(problem.upper), np.inf, nowhere, unbounded, barrier)

    @property
    def contact_lower(self) -> Mask:
        """Nodes where R* > 0 is certain: the lower bound, the support, holds them."""
        return self.contact & ~self.contact_upper

    @property
    def undecided(self) -> Mask:
        """Nodes that are neither certainly clear nor certainly in contact."""
        return ~(self.contact | self.clear)

    @property
    def weaker(self) -> bool:
        """Whether the bound is one of those known beyond M-matrices, which may exceed the error by far."""
        return self.barrier in (COMPARISON, EIGENVALUE)

    @property
    def least_eigenvalue(self) -> LeastEigenvalue | None:
        """The bound of the smallest eigenvalue that the enclosure rests on, and what proves it; None where none does.

        It is that of DGD with powers of two D which bring the diagonal close to one. What proves it, ``proof``, is
        told by the certificate's repr as well, by the words of `contactqp.problem.eigenvalue.LeastEigenvalue`.
        """
        return (self.enclosed or self.problem).least_eigenvalue if self.barrier == EIGENVALUE else None

    @property
    def contact_nodes(self) -> Bracket:
        """Bracket of the number of nodes in contact, R* ≠ 0: those certainly so, and with them the undecided ones."""
        certain = int(np.count_nonzero(self.contact))
        return Bracket(certain, certain + int(np.count_nonzero(self.undecided)))

    @property
    def contact_area(self) -> Bracket:
        """Bracket of the area in contact (of cables and beams: the length), the sum of what its nodes stand for.

        A node stands for what is nearer to it than to another, of a line for half an arm to either side: m nodes next
        to each other for a length of m Δ. A stretch of `spans` goes from its first node to its last one, which is
        (m - 1) Δ. Where contact ends between two nodes the discrete problem does not tell.
        """
        area = self._physical("contact_area").area_of_node("contact_area")
        if repeated(area):
            nodes = self.contact_nodes
            return Bracket(nodes.lower * float(area[0]), nodes.upper * float(area[0]))
        possible = self.contact | self.undecided
        return sum_between(np.where(self.contact, area, 0.0), np.where(possible, area, 0.0))

    @cached_property
    def reaction(self) -> tuple[Vector, Vector]:
        """Lower and upper bounds of the exact reaction R* = Gω* + q (force), shape (n,) each.

        R* is 0 at nodes that are certainly clear, ≥ 0 where ω* is certainly below its upper bound, and ≤ 0 where it is
        certainly above its lower one.
        """
        problem = self.problem
        with np.errstate(over="ignore", invalid="ignore"):
            middle, radius = middle_and_radius(self.lower, self.upper)
            value, error = problem.stiffness.enclosed_product(middle, problem.q)
            reach = problem.stiffness.modulus_matvec(radius) * (1 + 2 * growth_bound(problem.stiffness)) + error
            lower, upper = np.nextafter(value - reach, -np.inf), np.nextafter(value + reach, np.inf)
        known = np.isfinite(lower) & np.isfinite(upper)
        pushed = np.isposinf(problem.upper) | (self.upper < problem.upper)
        held_back = np.isneginf(problem.lower) | (self.lower > problem.lower)
        lower, upper = np.where(known, lower, -np.inf), np.where(known, upper, np.inf)
        lower, upper = (np.where(pushed, np.maximum(bound, 0.0), bound) for bound in (lower, upper))
        lower, upper = (np.where(held_back, np.minimum(bound, 0.0), bound) for bound in (lower, upper))
        return np.where(self.clear, 0.0, lower), np.where(self.clear, 0.0, upper)

    @cached_property
    def total_reaction(self) -> Bracket:
        """Bracket of the sum of R* over all nodes (force).

        It is the better of two: the sum of the nodes' own brackets, and Σq + cᵀω* with the column sums c of G, which on
        a lattice are zero but beside the frame.
        """
        terms = self.reaction_terms()
        low, high = sum_below(terms.lower), sum_above(terms.upper)
        if np.isfinite(terms.product).all() and np.isfinite(terms.reach).all():
            low = max(low, sum_below([*terms.forces, *terms.product, *-terms.reach]))
            high = min(high, sum_above([*terms.forces, *terms.product, *terms.reach]))
        return Bracket(max(0.0, low) if self.problem.one_sided else low, high)

    def reaction_terms(self) -> ReactionTerms:
        """Return what the bracket of the total reaction is summed of."""
        problem = self.problem
        with np.errstate(over="ignore", invalid="ignore"):
            columns, slack = problem.stiffness.transposed.enclosed_product(np.ones(problem.size))
            middle, radius = middle_and_radius(self.lower, self.upper)
            product = columns * middle
            reach = np.abs(columns) * radius + slack * (np.abs(middle) + radius)
            reach = (reach + 4 * UNIT_ROUNDOFF * np.abs(product) + UNDERFLOW) * (1 + 16 * UNIT_ROUNDOFF)
        return ReactionTerms(*self.reaction, problem.q, product, reach)

    def intersects(self, other: Certificate) -> bool:
        """Whether one and the same solution can satisfy both enclosures, so that two answers are compatible."""
        return bool((np.maximum(self.lower, other.lower) <= np.minimum(self.upper, other.upper)).all())

    def _repr_html_(self) -> str:
        from ..plotting.cards import certificate_card

        return certificate_card(self, self.model)

    def plot(self) -> Figure:
        """Draw the contact map of what is certain: nodes in contact, clear and undecided, each in their own colour.

        Of a cable it is the bounds of the gap, and of a cable net the plan.

        Raises
        ------
        AttributeError
            If a bare `ContactQP` was certified, which knows no places; certify the model.
        """
        from ..plotting.answers import plot_certificate

        return plot_certificate(self, self._physical("plot"))

    def _physical(self, attribute: str) -> ContactModel:
        if self.model is None:
            raise AttributeError(
                f"{attribute} needs a model, as Membrane, Cable or Beam; "
                "this certificate is of a bare ContactQP, certify the model"
            )
        return self.model

    def __repr__(self) -> str:
        kind, least = self.barrier, self.least_eigenvalue
        if least is not None:
            kind += f" >= {at_least(least.bound, 3)} by {least.proof}"
        if self.weaker:
            kind += ", weaker than for an M-matrix"
        return (
            f"Certificate(|gap error| <= {at_most(self.gap_bound, 3)}; {np.count_nonzero(self.contact)} in contact, "
            f"{np.count_nonzero(self.clear)} clear, {np.count_nonzero(self.undecided)} undecided; {kind})"
        )
