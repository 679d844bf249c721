r"""Sensitivity: derivatives of gap, deflection and reaction by what a contact problem is made of.

At a solution with the free nodes F and the nodes C that a bound b holds, all of them strictly (gaps away from the
bounds on F, reactions other than zero on C), a small change of the data leaves the sets as they are, and

.. math:: G_{FF}\dot ω_F = -(\dot q_F + G_{FC}\dot b_C),\quad \dot ω_C = \dot b_C,\quad \dot R = G\dot ω + \dot q,

where q̇ is the derivative of the reaction at a gap that stays. Forwards a direction takes one linear solve; backwards
(by the adjoint equations) the derivatives of a number by all data take one. For an M-matrix or a positive definite G
the solution is directionally differentiable even where nodes are *biactive*, with gap and reaction both zero; the
derivative then solves a contact problem of its own, whose gaps are bounded by ḃ there (Mignot, *Contrôle dans les
inéquations variationelles elliptiques*, J. Functional Analysis 22, 1976; for complementarity problems: Facchinei and
Pang, *Finite-Dimensional Variational Inequalities and Complementarity Problems*, 2003, section 5.4).

An enclosure proves sides of the stored problem, whose numbers are rounded themselves: of a membrane that hangs unloaded
from its frame and touches a support it says that some nodes are clear, by the last digit of their heights. What is so
close to both is biactive, whatever rounding made of it. So a node is on a side only if that is proven, and if its
distance from the bound, or its reaction, is not small against the problem's scales either.
"""

from __future__ import annotations

import warnings
from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..backends import get_backend
from ..errors import ContactWarning
from ..foundation.cards import card
from ..foundation.checks import Mask, Vector, finite_number, one_of, vector
from ..foundation.outside import stacklevel_outside
from ..foundation.text import counted
from ..proof.status import Status
from .parameters import Change, OfModel, OfProblem, Parameters
from .request import Request

if TYPE_CHECKING:
    from ..backends.base import Backend
    from ..methods.free_system import FreeSystem
    from ..models.base import ContactModel
    from ..problem.contact_problem import ContactProblem
    from ..proof.certificate import Certificate
    from ..proof.judge import Verdict

_PRECISE_DERIVATIVE = 1e-9
"""Wanted bound of a derivative that is one-sided, relative to its own scale."""

_SURE = 1e-8
"""Error over the error scale up to which an answer is taken as it is."""

_TOUCHING = 1e-11
"""Distance from a bound over the gap scale, and reaction over the mean force, up to which they count as none."""

_ROUNDED = 64 * float(np.finfo(np.float64).eps)
"""What rounded heights may make of none, over their own sizes: of a distance, and of a reaction over the diagonal."""


class Solved(Protocol):
    """What is asked of a solution, see `contactqp.solving.solution.Solution`."""

    @property
    def subject(self) -> ContactModel | ContactProblem: ...  # noqa: D102
    @property
    def model(self) -> ContactModel | None: ...  # noqa: D102
    @property
    def problem(self) -> ContactProblem: ...  # noqa: D102
    @property
    def gap(self) -> Vector: ...  # noqa: D102
    @property
    def finite(self) -> bool: ...  # noqa: D102
    @property
    def tol(self) -> float: ...  # noqa: D102
    @property
    def status(self) -> Status: ...  # noqa: D102
    @property
    def iterations(self) -> int: ...  # noqa: D102
    @property
    def relative_bound(self) -> float: ...  # noqa: D102
    @property
    def verdict(self) -> Verdict: ...  # noqa: D102
    @property
    def certificate(self) -> Certificate | None: ...  # noqa: D102

    def by(  # noqa: D102
        self,
        backend: Backend,
        subject: ContactModel | ContactProblem,
        request: Request,
        *,
        warm_start: Vector | None = None,
    ) -> Self: ...
    def with_gap(self, gap: Vector, request: Request, note: str) -> Self: ...  # noqa: D102


@dataclass(frozen=True, eq=False)
class Derivative:
    """The derivative of a solution in a direction; one-sided where nodes are biactive.

    Attributes
    ----------
    gap : array, shape (n,)
        Of ω (length per unit of the direction).
    reaction : array, shape (n,)
        Of R (force per unit of the direction).
    deflection : array, shape (n,), or None
        Of the model's deflection, positive as its heights; None for a bare problem.
    """

    gap: Vector
    reaction: Vector
    deflection: Vector | None

    @property
    def total_reaction(self) -> float:
        """Of the sum of all reactions (force per unit of the direction)."""
        return float(self.reaction.sum())

    def __repr__(self) -> str:
        largest = float(np.abs(self.gap).max())
        return f"Derivative({self.gap.size} nodes, gap up to {largest:.3g}, total reaction {self.total_reaction:.3g})"


class Sensitivity:
    """Derivatives of a solution by load, support and whatever else it depends on.

    Made by `Solution.sensitivity`. Parameters of a model: ``load``, ``support``, ``ceiling`` and ``foundation`` (if it
    has them), each with a value for each node, in the units and the sense in which the model takes them; ``tension``,
    where it is one number, and ``arms_x`` and ``arms_y``, the tension of each arm along x and along y, see
    `contactqp.Membrane.arm_tensions` (of a cable net ``tension``, that of each segment);
    ``bending_stiffness``, where it is one number, and of a beam ``point_stiffness``, that of each node and end, see
    `contactqp.Beam.point_stiffness`; ``frame_height``, by which the
    whole frame is moved, and ``frame_heights``, that of each of its points, see `contactqp.Membrane.heights_of_frame`
    (of a cable net ``fixed_height``). Of a bare problem: ``q``, ``lower``, ``upper``.

    Attributes
    ----------
    solution : Solution
        The answer whose contact set counts: the one that was given, or, where that was not good enough, the one that
        active sets have made of it.
    biactive : array of int
        Nodes that are not proven to be in contact or clear, or whose distance from the bound and reaction are both no
        more than ``tolerance``: there derivatives are one-sided.

    Examples
    --------
    >>> import contactqp as cq
    >>> cable = cq.Cable(span=10.0, spacing=0.1, tension=2.0, load=1.0, support=3.0)
    >>> sensitivity = cq.solve(cable, tol=1e-9).sensitivity()
    >>> round(sensitivity.forward(load=1.0).total_reaction, 6)
    6.5
    >>> gradient = sensitivity.adjoint(reaction=1.0)  # of the total reaction, by everything
    >>> sorted(gradient)
    ['arms_x', 'frame_height', 'frame_heights', 'load', 'support', 'tension']
    >>> round(gradient["tension"], 6), gradient["frame_heights"][1, [0, -1]].round(6)
    (-1.714286, array([0.571429, 0.571429]))
    """

    def __init__(self, solution: Solved, tolerance: float = _TOUCHING) -> None:
        if not 0 <= finite_number(tolerance, "tolerance") < 1:
            raise ValueError(f"tolerance must be in [0, 1), got {tolerance:g}")
        self.solution = _exact(solution)
        certificate = _decided(self.solution) or self.solution.certificate
        if certificate is None:
            raise ValueError(
                f"a sensitivity needs a contact set that is known, but nothing is proven of {self.solution!r}; "
                "solve to a smaller tol, or by a backend that certifies the problem"
            )
        self._problem = problem = self.solution.problem
        close, weak = self._thresholds(tolerance)
        strict = np.abs(problem.reaction(self.solution.gap)) > weak
        self._at_lower, self._at_upper = certificate.contact_lower & strict, certificate.contact_upper & strict
        with np.errstate(invalid="ignore"):  # where there is neither a bound nor an enclosure
            near_lower = certificate.lower - problem.lower <= close
            near_upper = problem.upper - certificate.upper <= close
        self._open_below, self._open_above = near_lower & ~self._held, near_upper & ~self._held
        self._open: Mask = self._open_below | self._open_above
        self._shut: Mask = problem.upper - problem.lower <= close
        self.biactive: NDArray[np.intp] = np.flatnonzero(self._open)
        self._known: FreeSystem | None = None

    def _thresholds(self, tolerance: float) -> tuple[Vector | float, Vector | float]:
        """Return the distance (length) and the reaction (force) up to which a node touches a bound without a force."""
        if not tolerance:
            return 0.0, 0.0
        problem, model = self._problem, self.solution.model
        forces, heights = [problem.q], np.abs(problem.reference)
        if model is not None:
            forces, heights = [problem.q, model.nodal_load], np.abs(model.reference)
        force = max(float(np.abs(each).mean()) for each in forces)
        rounded = _ROUNDED * (problem.gap_scale + heights + np.abs(self.solution.gap))
        return tolerance * problem.gap_scale + rounded, tolerance * force + problem.stiffness.diagonal() * rounded

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(self._parameters.known)

    def forward(self, **directions: Any) -> Derivative:
        """Return the derivative in a direction: of one parameter, or of several that change together.

        Parameters
        ----------
        **directions : number, array, shape (n,), or whatever the model takes for such a parameter
            By how much each parameter changes.

        Raises
        ------
        TypeError, ValueError
            If there is no such parameter, or a direction has the wrong kind or shape, or moves the two bounds of a node
            through each other that leave it no gap.

        Examples
        --------
        >>> import contactqp as cq
        >>> problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
        >>> cq.solve(problem).sensitivity().forward(q=[-1.0, 0.0]).gap
        array([0.5, 0. ])
        """
        change = self._parameters.change(directions)
        self._refuse_crossing(change)
        gap, held = self._moved(change) if self.biactive.size else (self._moved_freely(change), self._held)
        reaction = self._problem.stiffness.matvec(gap) + change.reaction
        model = self.solution.model
        return Derivative(
            gap=gap,
            reaction=np.where(held, reaction, 0.0),
            deflection=None if model is None else (change.reference - gap) * (-1.0 if model.upwards else 1.0),
        )

    def adjoint(
        self,
        *,
        gap: ArrayLike | None = None,
        deflection: ArrayLike | None = None,
        reaction: ArrayLike | None = None,
        by: Collection[str] | None = None,
        biactive: Literal["refuse", "held"] = "refuse",
    ) -> dict[str, Any]:
        """Return the derivatives of a number by the parameters: J = Σ weight times gap, deflection and reaction.

        A total reaction is ``reaction=1.0``; the deflection of a node is ``deflection=`` with a one there. The weights
        of a nonlinear J are its own derivatives by gap, deflection and reaction.

        Parameters
        ----------
        gap, deflection, reaction : float or array, shape (n,), optional
            Weights, one at least. A bare problem has no deflection.
        by : collection of str, optional
            Names of the parameters; by default all of them.
        biactive : {"refuse", "held"}
            What becomes of biactive nodes: an error, as there is no gradient, or they count as held, which is one of
            the one-sided derivatives, for methods that need no more.

        Returns
        -------
        dict
            Array of the parameter's shape, or a number, by the name of the parameter.

        Raises
        ------
        ValueError
            If nodes are biactive and to be refused: there is no gradient then, and only `forward` tells the one-sided
            derivatives.
        TypeError
            If no weight is given, one has the wrong kind, or a parameter is unknown.
        """
        weights = {"gap": gap, "deflection": deflection, "reaction": reaction}
        if all(weight is None for weight in weights.values()):
            raise TypeError(
                "give the weights of the number to be differentiated, gap=, deflection= or reaction=: reaction=1.0 is "
                "the total reaction, and gap=w the sum of w times the gap"
            )
        names = self.parameters if by is None else [by] if isinstance(by, str) else by
        for name in names:
            self._parameters.named(name)
        if one_of(biactive, ("refuse", "held"), "biactive") == "refuse" and self.biactive.size:
            count, first = counted(self.biactive.size, "node"), self._name(int(self.biactive[0]))
            raise ValueError(
                f"there is no gradient: {count} (first {first}) may have neither gap nor reaction, so that derivatives "
                "differ to either side; take forward() for directions"
            )
        size, model = self._problem.size, self.solution.model
        by_gap, by_deflection, by_reaction = (
            np.zeros(size) if w is None else vector(np.full(size, w) if np.ndim(w) == 0 else w, size, name)
            for name, w in weights.items()
        )
        if model is None and by_deflection.any():
            raise TypeError("a bare problem has no deflection; give weights for gap and reaction")
        by_reference = by_deflection * (-1.0 if model is not None and model.upwards else 1.0)
        at_lower = self._at_lower | (self._open_below & ~self._open_above)
        at_upper = self._at_upper | self._open_above
        held, stiffness = at_lower | at_upper, self._problem.stiffness.transposed
        # Reactions of free nodes vanish, whatever changes.
        by_reaction = np.where(held, by_reaction, 0.0)
        weight = by_gap - by_reference + stiffness.matvec(by_reaction)
        adjoint = self._equations(held).solve(weight, transposed=True)
        by_bound = weight - stiffness.matvec(adjoint)
        return self._parameters.gradient(
            Change(
                reaction=by_reaction - adjoint,
                lower=np.where(at_lower, by_bound, 0.0),
                upper=np.where(at_upper, by_bound, 0.0),
                reference=by_reference,
            ),
            names,
        )

    @cached_property
    def _held(self) -> Mask:
        return np.asarray(self._at_lower | self._at_upper)

    @cached_property
    def _parameters(self) -> Parameters:
        model, problem = self.solution.model, self._problem
        if model is None:
            return OfProblem(problem)
        free = ~(self._held | self._open)
        return OfModel(model, self.solution.gap, np.where(free, 0.0, problem.reaction(self.solution.gap)))

    def _moved_freely(self, change: Change) -> Vector:
        """Return the derivative of the gap by one linear solve."""
        gap = np.where(self._at_upper, change.upper, np.where(self._at_lower, change.lower, 0.0))
        force = change.reaction + self._problem.stiffness.matvec(gap)
        return gap - self._equations(self._held).solve(force)

    def _moved(self, change: Change) -> tuple[Vector, Mask]:
        """Return the derivative of the gap by its own contact problem, and which nodes are held in that.

        Biactive nodes may leave their bounds, but not pass them.
        """
        problem = self._problem
        lower = np.where(self._at_upper, change.upper, -np.inf)
        upper = np.where(self._at_lower, change.lower, np.inf)
        lower = np.where(self._at_lower | self._open_below, change.lower, lower)
        upper = np.where(self._at_upper | self._open_above, change.upper, upper)
        own = problem.with_data(change.reaction, lower, upper)
        found = self.solution.by(get_backend("active-set"), own, Request.of(_PRECISE_DERIVATIVE, None, None, {}))
        if found.status is not Status.CERTIFIED:
            warnings.warn(
                f"the derivative's own contact problem is {found.status}, with {found.iterations} steps: take it with "
                "caution",
                ContactWarning,
                stacklevel=stacklevel_outside(),
            )
        correction = own.reaction(found.gap) / own.stiffness.diagonal()
        at_lower, at_upper = own.bounds.contact(found.gap, correction)
        gap = np.where(at_lower, lower, np.where(at_upper, upper, own.project(found.gap)))
        return gap, at_lower | at_upper

    def _refuse_crossing(self, change: Change) -> None:
        crossing = np.flatnonzero(self._shut & (change.lower > change.upper))
        if crossing.size:
            raise ValueError(
                f"there is no derivative: at {self._name(int(crossing[0]))} the bounds leave no gap, and the direction "
                "moves them through each other"
            )

    def _equations(self, held: Mask) -> FreeSystem:
        """Return the equations of the nodes that are not held, whose factors or hierarchy are kept."""
        if self._known is None or not np.array_equal(self._known.free, ~held):
            self._known = self._problem.facts.free_system(~held)
        return self._known

    def _name(self, node: int) -> str:
        model = self.solution.model
        return f"unknown {node}" if model is None else model.describe(node)

    def __repr__(self) -> str:
        held = int(np.count_nonzero(self._held))
        count = f", {counted(self.biactive.size, 'biactive node')}" if self.biactive.size else ""
        return f"Sensitivity({held} of {self._problem.size} nodes held{count}; by {', '.join(self.parameters)})"

    def _repr_html_(self) -> str:
        facts = {
            "held": f"{int(np.count_nonzero(self._held))} of {self._problem.size} nodes",
            "biactive": f"{self.biactive.size}" if self.biactive.size else "",
            "by": ", ".join(self.parameters),
        }
        return card("Sensitivity", facts)


def _exact(solution: Solved) -> Solved:
    """Return an answer whose contact set is proven where that can be, and whose error is next to nothing."""
    if not solution.finite or (_decided(solution) is not None and _precise(solution)):
        return solution
    request = Request.of(min(solution.tol, _SURE), None, None, {})
    settled = _settled(solution, request)
    if settled is not None:
        return settled
    start = solution.problem.project(solution.gap)
    finished = solution.by(get_backend("active-set"), solution.subject, request, warm_start=start)
    return finished if finished.certificate is not None else solution


def _decided(solution: Solved) -> Certificate | None:
    """Return the judge's own certificate where it decides all nodes, so that no sharper one is asked for."""
    certificate = solution.verdict.certificate
    return None if certificate is None or certificate.undecided.any() else certificate


def _precise(solution: Solved) -> bool:
    return solution.verdict.relative_bound <= _SURE or solution.relative_bound <= _SURE


def _settled(solution: Solved, request: Request) -> Solved | None:
    """Return the solution of the free nodes' equations, the nodes of the answer's own contact set held.

    None where that has another contact set, or is not proven to be precise. It is what active sets would end with, and
    its factors or hierarchy are those of the derivatives.
    """
    problem, diagonal = solution.problem, solution.problem.stiffness.diagonal()
    at_lower, at_upper = problem.bounds.contact(solution.gap, problem.reaction(solution.gap) / diagonal)
    gap = np.where(at_lower, problem.lower, np.where(at_upper, problem.upper, solution.gap))
    try:
        gap -= problem.facts.free_system(~(at_lower | at_upper)).solve(problem.reaction(gap))
    except ValueError:
        return None
    same = problem.bounds.contact(gap, problem.reaction(gap) / diagonal)
    if not all(map(np.array_equal, same, (at_lower, at_upper))):
        return None
    found = solution.with_gap(problem.project(gap), request, "the equations of its free nodes solved")
    return found if _precise(found) else None
