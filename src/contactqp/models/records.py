"""What pictures, datasets and spans read of an answer and of a certificate, wherever those come from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from ..foundation.checks import Mask, Vector
    from ..problem.contact_qp import ContactQP
    from .base import ContactModel


class Enclosed(Protocol):
    """Bounds that the exact gap provably satisfies, node by node: what a view reads of a `Certificate`.

    Attributes
    ----------
    lower, upper : array, shape (n,)
        lower ≤ ω* ≤ upper (length).
    gap_bound : float
        Bound of max|ω - ω*| (length).
    contact, clear, undecided : array of bool, shape (n,)
        What is certain of each node.
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
    def contact(self) -> Mask: ...  # noqa: D102
    @property
    def clear(self) -> Mask: ...  # noqa: D102
    @property
    def undecided(self) -> Mask: ...  # noqa: D102
    @property
    def barrier(self) -> str: ...  # noqa: D102
    @property
    def reaction(self) -> tuple[Vector, Vector]: ...  # noqa: D102


class Answered(Protocol):
    """An answer and what it is worth: what a view reads of a `Solution`.

    Attributes
    ----------
    problem : ContactQP
    model : ContactModel or None
        None if a bare `ContactQP` was solved.
    backend, status, termination : str
        Who answered, what the judge found, and what the backend said at its end.
    tol, relative_bound : float
        The tolerance asked for and the bound reached, relative to the gap scale.
    gap, deflection, reaction, contact_pressure : array, shape (n,)
    contact : array of bool, shape (n,)
        The backend's own contact set.
    certificate : Enclosed or None
    finite : bool
        Whether the backend returned a finite vector.
    iterations : int
    seconds : float
    """

    @property
    def problem(self) -> ContactQP: ...  # noqa: D102
    @property
    def model(self) -> ContactModel | None: ...  # noqa: D102
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
    def gap(self) -> Vector: ...  # noqa: D102
    @property
    def deflection(self) -> Vector: ...  # noqa: D102
    @property
    def reaction(self) -> Vector: ...  # noqa: D102
    @property
    def contact_pressure(self) -> Vector: ...  # noqa: D102
    @property
    def contact(self) -> Mask: ...  # noqa: D102
    @property
    def certificate(self) -> Enclosed | None: ...  # noqa: D102
    @property
    def finite(self) -> bool: ...  # noqa: D102
    @property
    def iterations(self) -> int: ...  # noqa: D102
    @property
    def seconds(self) -> float: ...  # noqa: D102
