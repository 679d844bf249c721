"""A problem of the gallery with an enclosure of its exact solution, or the reason why there is none sharp enough."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..foundation.checks import Vector
from ..foundation.rounding import UNDERFLOW, UNIT_ROUNDOFF
from ..gallery.catalogue import load
from ..models.base import ContactModel
from ..problem.contact_qp import ContactQP
from ..proof.certify import certify
from ..solving.solve import solve

WIDTH = 1e-12
"""What ω is enclosed to at every node, relative to `Proved.scale`, or else it does not count as proved."""

_TOL = 1e-9


@dataclass(frozen=True, eq=False)
class Proved:
    """A problem, given by its numbers in double precision, and bounds of its exact solution.

    Attributes
    ----------
    family : str
        Its name in the gallery.
    n : int
        Nodes along a side.
    source : str
    problem : ContactQP
        Made of the matrix as it is written: what is proved is the solution of these very numbers.
    lower, upper : array, shape (n²,)
        lower ≤ ω* ≤ upper (length).
    contact, clear : int
        Nodes that are certainly in contact, and certainly not.
    barrier : str
        What the proof's bounds are multiples of, see `contactqp.Certificate`.
    """

    family: str
    n: int
    source: str
    problem: ContactQP
    lower: Vector
    upper: Vector
    contact: int
    clear: int
    barrier: str

    @property
    def scale(self) -> float:
        """What the largest |ω*| is at least (length); the problem's gap scale where that is less than its 1e-9.

        Then ω* is rounding of the problem's data, which has no scale of its own.
        """
        largest = float(max(self.lower.max(), -self.upper.min()))
        return largest if largest > _NOTHING * self.problem.gap_scale else self.problem.gap_scale

    @property
    def width(self) -> float:
        """What upper - lower is at most, at any node (length), rounded upwards."""
        exact = self.upper - self.lower
        return float(exact.max() * (1 + 4 * UNIT_ROUNDOFF) + UNDERFLOW)

    @property
    def relative_width(self) -> float:
        """The width over the scale."""
        return self.width / self.scale

    @property
    def holds(self) -> bool:
        """Whether the enclosure is as narrow as a proved answer's: 1e-12 of the scale."""
        return self.width * (1 + 4 * UNIT_ROUNDOFF) <= WIDTH * self.scale


_NOTHING = 1e-9


def prove(family: str, n: int) -> Proved:
    """Solve a problem of the gallery, and enclose its exact solution.

    What is enclosed is the solution of the problem that consists of G as rows of doubles, q and the bounds, which may
    differ in the last place from what the model means by them.

    Parameters
    ----------
    family : str
        A name of `contactqp.gallery.names`, of a model.
    n : int
        Nodes along a side.

    Raises
    ------
    ValueError
        If the name is unknown, or the entry is no model or does not have that many nodes.

    Examples
    --------
    >>> found = prove("ball", 15)
    >>> found.holds, found.problem
    (True, ContactQP(225 unknowns, 1065 nonzeros, M-matrix))
    """
    known = load(family, n)
    if not isinstance(known.model, ContactModel):
        raise ValueError(f"family must be a model with a symmetric matrix, but {family!r} is {known.model!r}")
    meant = known.model.problem
    problem = ContactQP(meant.G, meant.q, meant.lower, meant.upper, gap_scale=meant.gap_scale)
    answer = solve(known.model, tol=_TOL, on_failure="ignore").gap
    certificate = certify(problem, answer)
    lower, upper = certificate.lower, certificate.upper
    counts = int(np.count_nonzero(certificate.contact)), int(np.count_nonzero(certificate.clear))
    return Proved(family, n, known.source, problem, lower, upper, *counts, certificate.barrier)
