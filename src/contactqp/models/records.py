"""What pictures, datasets and spans read of an answer and of a certificate, wherever those come from."""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ..foundation.checks import Mask, Vector
    from ..problem.contact_problem import ContactProblem
    from .base import ContactModel


class Posed(Protocol):
    """A problem, and the model that it comes from, if it comes from one."""

    @property
    def problem(self) -> ContactProblem: ...  # noqa: D102
    @property
    def model(self) -> ContactModel | None: ...  # noqa: D102


def subject_of(posed: Posed) -> ContactModel | ContactProblem:
    """Return the model of a solution or a comparison, and of a bare problem the problem: views go by its class."""
    return posed.problem if posed.model is None else posed.model


class Held(Protocol):
    """Nodes by the bound that holds them, shape (n,) each: the support, the upper bound, either."""

    @property
    def contact_lower(self) -> Mask: ...  # noqa: D102
    @property
    def contact_upper(self) -> Mask: ...  # noqa: D102
    @property
    def contact(self) -> Mask: ...  # noqa: D102


class Enclosed(Held, Protocol):
    """Bounds that the exact gap provably satisfies, node by node: what a view reads of a `Certificate`.

    Attributes
    ----------
    lower, upper : array, shape (n,)
        lower ≤ ω* ≤ upper (length).
    gap_bound : float
        Bound of max|ω - ω*| (length).
    contact_lower, contact_upper, contact, clear, undecided : array of bool, shape (n,)
        What is certain of each node: held by the support, by the upper bound, by either, by neither; or nothing.
    barrier : str
        What the bounds are multiples of.
    reaction : pair of arrays, shape (n,) each
        Lower and upper bounds of the exact reaction (force).
    """

    @property
    def lower(self) -> Vector: ...  # noqa: D102
    @property
    def upper(self) -> Vector: ...  # noqa: D102
    @property
    def gap_bound(self) -> float: ...  # noqa: D102
    @property
    def clear(self) -> Mask: ...  # noqa: D102
    @property
    def undecided(self) -> Mask: ...  # noqa: D102
    @property
    def barrier(self) -> str: ...  # noqa: D102
    @property
    def reaction(self) -> tuple[Vector, Vector]: ...  # noqa: D102


class NodeState(IntEnum):
    """What is known of a node, by the numbers that files hold."""

    UNDECIDED = -1
    CLEAR = 0
    CONTACT = 1
    CONTACT_UPPER = 2


def states_of(certificate: Enclosed) -> NDArray[np.int64]:
    """Return what a certificate proves of each node, as numbers of `NodeState`, shape (n,)."""
    states = np.full(certificate.contact.shape, NodeState.UNDECIDED.value)
    states[certificate.clear] = NodeState.CLEAR
    states[certificate.contact_lower] = NodeState.CONTACT
    states[certificate.contact_upper] = NodeState.CONTACT_UPPER
    return states


class Answered(Posed, Held, Protocol):
    """An answer and what it is worth: what a view reads of a `Solution`.

    Attributes
    ----------
    problem : ContactProblem
    model : ContactModel or None
        None if a bare `ContactQP` was solved.
    backend, status, termination : str
        Who answered, what the judge found, and what the backend said at its end.
    tol, relative_bound, relative_residual : float
        The tolerance asked for, the bound reached (infinite if none is known) and the natural residual, relative to the
        error scale, see `Verdict.scale`.
    gap, deflection, reaction, contact_pressure : array, shape (n,)
    contact_lower, contact_upper, contact : array of bool, shape (n,)
        The backend's own contact sets: with the support, with the upper bound, with either.
    certificate : Enclosed or None
    cautions : tuple of str
        Why a certified answer may still not be what was meant.
    finite : bool
        Whether the backend returned a finite vector.
    iterations : int
    seconds : float
    """

    @property
    def backend(self) -> str: ...  # noqa: D102
    @property
    def status(self) -> str: ...  # noqa: D102
    @property
    def termination(self) -> str: ...  # noqa: D102
    @property
    def tol(self) -> float: ...  # noqa: D102
    @property
    def relative_bound(self) -> float: ...  # noqa: D102
    @property
    def relative_residual(self) -> float: ...  # noqa: D102
    @property
    def gap(self) -> Vector: ...  # noqa: D102
    @property
    def deflection(self) -> Vector: ...  # noqa: D102
    @property
    def reaction(self) -> Vector: ...  # noqa: D102
    @property
    def contact_pressure(self) -> Vector: ...  # noqa: D102
    @property
    def certificate(self) -> Enclosed | None: ...  # noqa: D102
    @property
    def cautions(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def finite(self) -> bool: ...  # noqa: D102
    @property
    def iterations(self) -> int: ...  # noqa: D102
    @property
    def seconds(self) -> float: ...  # noqa: D102


def held_reaction(solution: Answered) -> Vector:
    """Return the reaction where a node may be held, exactly 0 where it is certainly clear (force), shape (n,).

    At free nodes the answer's own reaction is what rounding, or its error, has left out of balance, of either sign.
    """
    if solution.certificate is None:
        return solution.reaction
    return np.where(solution.certificate.clear, 0.0, solution.reaction)


class Settling(Protocol):
    """Load factors at which nodes settle: what a picture reads of a `Touchdown`.

    Attributes
    ----------
    clear, contact, load : array, shape (n,)
        Between which factors each node settles, infinite where they are not known, and the middle of the two, nan
        there.
    loads : array
        The factors that were solved for, ascending.
    width : float
        Largest distance of the known ones.
    """

    @property
    def model(self) -> ContactModel: ...  # noqa: D102
    @property
    def clear(self) -> Vector: ...  # noqa: D102
    @property
    def contact(self) -> Vector: ...  # noqa: D102
    @property
    def load(self) -> Vector: ...  # noqa: D102
    @property
    def loads(self) -> Vector: ...  # noqa: D102
    @property
    def width(self) -> float: ...  # noqa: D102
