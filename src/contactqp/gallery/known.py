"""Known: a problem with what is known of its answer, in one shape for all entries of the gallery."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector, vector
from ..models.base import ContactModel
from ..problem.contact_problem import ContactProblem

if TYPE_CHECKING:
    from ..models.records import Answered

Distance = Callable[[Vector, Vector], Vector]
"""Distances of points (x, y) from a free boundary (length)."""


@dataclass(frozen=True)
class Quoted:
    """A number as it was published.

    Attributes
    ----------
    value : float
    error : float
        How far a number may lie from it that agrees: somewhat more than half a unit of the last digit that was printed,
        or more where the source's solver was less accurate than that.
    source : str
        Author, year, place.
    """

    value: float
    error: float
    source: str

    def holds(self, value: float) -> bool:
        """Whether a number agrees with the published one in the digits that were printed.

        Examples
        --------
        >>> Quoted(-0.4057, 5e-5, "CUTEst").holds(-0.405702)
        True
        """
        return abs(value - self.value) <= self.error


@dataclass(frozen=True, eq=False)
class Known:
    """A problem of the gallery, and what is known of its answer.

    Attributes
    ----------
    name : str
        As `contactqp.gallery.load` takes it.
    model : ContactModel or ContactProblem
        What `contactqp.solve` takes.
    source : str
        Author, year, and place of the formula or of the numbers.
    spacing : float
        Distance of neighbouring nodes (length); of a mesh the longest side, as a rule.
    deflection : array, shape (n,), or None
        Exact continuous deflection at the nodes, positive as the model's heights; of a bare problem the gap. None where
        no formula is known.
    reaction : array, shape (n,), or None
        Exact continuous reaction at each node, of all that it stands for (force). It jumps at the free boundary, so
        that a discrete one is close to it in the sum of moduli, not node by node.
    exact : bool
        Whether the discrete answer is the continuous one at the nodes, to rounding. Where contact ends between two
        nodes no discrete answer tells.
    contact_area : float or None
        Of the continuum (area; of cables and beams a length).
    distance : function of (x, y), or None
        Distances from the exact free boundary, at points between a node in contact and one that is not (length).
    energy : Quoted or None
        Published optimum: potential energy of the discrete answer (force times length), see `energy_of`.
    numbers : mapping of str to Quoted
        What else was published, by what it is.
    places : array, shape (n,), or None
        Abscissae of the nodes of a bare problem, which knows none.

    Examples
    --------
    >>> import contactqp as cq
    >>> known = cq.gallery.load("cable-on-floor", n=19)
    >>> known
    Known('cable-on-floor', Cable(19 nodes, spacing=0.05, tension=1, load=1, support=0.045), exact to rounding)
    >>> bool(abs(cq.solve(known.model, tol=1e-12).deflection - known.deflection).max() < 1e-14)
    True
    """

    name: str
    model: ContactModel | ContactProblem
    source: str
    spacing: float
    deflection: Vector | None = None
    reaction: Vector | None = None
    exact: bool = False
    contact_area: float | None = None
    distance: Distance | None = None
    energy: Quoted | None = None
    numbers: Mapping[str, Quoted] = field(default_factory=lambda: MappingProxyType({}))
    places: Vector | None = None

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return self.model.problem.size if isinstance(self.model, ContactModel) else self.model.size

    @property
    def node_area(self) -> Vector:
        """What each node stands for, shape (n,): an area, of cables and beams a length."""
        if isinstance(self.model, ContactModel) and self.model.node_area is not None:
            return self.model.node_area
        return np.full(self.size, self.spacing)

    def found(self, solution: Answered) -> Vector:
        """Return what is to be compared with `deflection`: an answer's deflection, of a bare problem its gap."""
        return solution.deflection if isinstance(self.model, ContactModel) else solution.gap

    def free_boundary(self, contact: Mask) -> NDArray[np.float64]:
        """Return the middles between a node in contact and a neighbour that is not, shape (k, 2), length.

        Parameters
        ----------
        contact : array of bool, shape (n,)
        """
        if isinstance(self.model, ContactModel):
            return self.model.free_boundary(contact)
        assert self.places is not None
        at = np.flatnonzero(contact[1:] != contact[:-1])
        middles = (self.places[at] + self.places[at + 1]) / 2
        return np.column_stack([middles, np.zeros(at.size)])

    def energy_of(self, deflection: Vector) -> float:
        """Return ½wᵀGw - Pᵀw (force times length), of a model whose frame is at height zero.

        Parameters
        ----------
        deflection : array, shape (n,)
            Positive as the model's heights (length).

        Raises
        ------
        TypeError
            Of a bare problem, whose forces are not known apart from its support.
        """
        if not isinstance(self.model, ContactModel):
            raise TypeError(f"{self.name!r} is a bare problem, of which only the energy of the gap is known")
        depths = vector(deflection, self.size, "deflection")
        depths = -depths if self.model.upwards else depths
        return float(depths @ self.model.pull(depths) / 2 - self.model.nodal_load @ depths)

    def __repr__(self) -> str:
        told = [repr(self.name), repr(self.model)]
        if self.deflection is not None:
            told.append("exact to rounding" if self.exact else "closed form")
        if self.energy is not None:
            told.append(f"optimum {self.energy.value:.10g}")
        return f"Known({', '.join(told)})"
