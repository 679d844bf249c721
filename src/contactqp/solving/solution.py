"""Solution: an answer, what it is worth, and the quantities that follow from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..foundation.brackets import Bracket
from ..foundation.checks import Mask, Vector, read_only
from ..foundation.text import at_most
from ..methods.active_set.primal_dual import DIRECT_SIZE
from ..models.base import ContactModel, ForceBalance
from ..problem.contact_qp import ContactQP
from ..proof.certificate import Certificate
from ..proof.certify import sharper
from ..proof.residuals import Residuals
from ..proof.status import Status

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_SHARP_ON_LATTICES = 100_000
"""Nodes up to which a sharp certificate takes some hundredths of a second."""

SLOPE_LIMIT = 0.2
"""Above this slope the hypothesis of small deformations, (c) of the paper, is worth a remark."""


@dataclass(frozen=True, repr=False)
class Solution:
    """The answer of one backend to one problem, judged.

    Attributes
    ----------
    problem : ContactQP
    model : Membrane, Cable, CableNet or None
        None if a bare `ContactQP` was solved.
    backend : str
        Name of the backend that answered.
    note : str
        Why ``"auto"`` chose it, and what the backend has to tell.
    gap : array, shape (n,)
        The backend's ω (length), as it is; nan if it returned nothing. Where there is no support: the frame's mean
        height less the deflection.
    tol : float
        The tolerance asked for, relative to ``problem.gap_scale``.
    status : Status
        The judge's finding.
    residuals : Residuals or None
        Distance from the optimality conditions.
    first_certificate : Certificate or None
        The enclosure of the true gap that the judge saw; None where none is known. See `certificate`.
    first_relative_bound : float
        Its bound over ``problem.gap_scale`` (without a certificate: the natural residual over it).
    termination : str
        The backend's own words for its end.
    iterations : int
        In the backend's ``iteration_unit``.
    setup_seconds, solve_seconds, seconds : float
        Time for set-up, for iterating, and in all with scaling and judging.
    history : mapping of str to array
        Recorded on request, by backends that offer it.
    setting : str
        The level that ``tol`` was asked for by, see `solve`; ``""`` for a number.
    claimed_solved : bool
        Whether the backend itself said that it had solved the problem; ``status`` tells whether it had.
    findings : tuple of str
        What the judge caught the backend at on the way, one sentence each.
    """

    problem: ContactQP
    model: ContactModel | None
    backend: str
    note: str
    gap: Vector
    tol: float
    status: Status
    residuals: Residuals | None
    first_certificate: Certificate | None
    first_relative_bound: float
    termination: str
    iterations: int
    iteration_unit: str
    setup_seconds: float
    solve_seconds: float
    seconds: float
    history: Mapping[str, Vector] = field(default_factory=dict)
    setting: str = ""
    claimed_solved: bool = False
    findings: tuple[str, ...] = ()

    @property
    def finite(self) -> bool:
        """Whether the backend returned a finite vector."""
        return self.residuals is not None

    @cached_property
    def certificate(self) -> Certificate | None:
        """Enclosure of the true gap; None if there is no answer, or nothing is known of such a matrix.

        For up to 4000 unknowns, on a lattice 100,000, it is the sharp one, which is made when it is first asked for.
        Beyond, it is the judge's own; ``certify(solution.problem, solution.gap)`` sharpens it.
        """
        first = self.first_certificate
        affordable = _SHARP_ON_LATTICES if self.problem.stencil is not None else DIRECT_SIZE
        if first is None:
            return None
        return replace(first if self.problem.size > affordable else sharper(first, self.gap), model=self.model)

    @property
    def relative_bound(self) -> float:
        """Certified bound of the gap over ``problem.gap_scale``; without a certificate the natural residual over it."""
        first, certificate = self.first_certificate, self.certificate
        if first is None or certificate is None or not first.gap_bound > certificate.gap_bound:
            return self.first_relative_bound
        return self.first_relative_bound * (certificate.gap_bound / first.gap_bound)

    @property
    def contact_area(self) -> Bracket:
        """Bracket of the area in contact, Δ² for every node (cable: of the length, Δ for every node)."""
        self._physical("contact_area")
        return self._certified("contact_area").contact_area

    @property
    def total_reaction(self) -> Bracket:
        """Bracket of the true total reaction ΣR* (force)."""
        return self._certified("total_reaction").total_reaction

    def _certified(self, attribute: str) -> Certificate:
        if self.certificate is None:
            raise AttributeError(f"{attribute} needs a certificate; this solution has none ({self.status.advice})")
        return self.certificate

    @cached_property
    def reaction(self) -> Vector:
        """R = Gω + q, the support's nodal force (force, upwards), shape (n,)."""
        return read_only(self.problem.stiffness.matvec(self.gap) + self.problem.q)

    @cached_property
    def contact(self) -> Mask:
        """The backend's own contact set: nodes where R_i/G_ii > ω_i, shape (n,)."""
        correction = self.reaction / self.problem.stiffness.diagonal()
        return read_only((correction > self.gap) & self.problem.supported)

    @property
    def deflection(self) -> Vector:
        """W = f - ω (length, positive downwards), shape (n,)."""
        return self._physical("deflection").deflection(self.gap)

    @property
    def contact_pressure(self) -> Vector:
        """ρ = R/Δ² (cable: R/Δ), shape (n,)."""
        return self.reaction / self._physical("contact_pressure").area_of_node("contact_pressure")

    @property
    def max_slope(self) -> float:
        """Largest slope of the deflection along an arm; the theory assumes small ones."""
        return self._physical("max_slope").max_slope(self.gap)

    @property
    def force_balance(self) -> ForceBalance:
        """ΣP = ΣR + the frame's pull (force)."""
        return self._physical("force_balance").force_balance(self.gap)

    def _physical(self, attribute: str) -> ContactModel:
        if self.model is None:
            raise AttributeError(
                f"{attribute} needs a Membrane, a Cable or a CableNet; "
                "this solution is of a bare ContactQP, which knows gap and reaction only"
            )
        return self.model

    def polish(self, *, tol: float | None = None) -> Solution:
        """Return the answer after active sets have gone on from it: exact to rounding once the contact set rests.

        It assembles G, and issues a `ContactWarning` if its own answer is not certified.

        Parameters
        ----------
        tol : float, optional
            Wanted bound in (0, 1), relative as in `solve`; by default the one that was asked for before.

        Returns
        -------
        Solution

        Raises
        ------
        UnsuitableProblemError
            If the matrix is no Z-matrix.
        ValueError
            If ``tol`` is out of range, or there is no finite answer to go on from.

        Examples
        --------
        >>> import contactqp as cq
        >>> rough = cq.solve(cq.gallery.paper_hexagon(), "osqp", tol=1e-2)
        >>> exact = rough.polish(tol=1e-11)
        >>> exact.status.value, exact.certificate.gap_bound < rough.certificate.gap_bound
        ('certified', True)
        """
        from .solve import solve

        problem = self.problem if self.model is None else self.model
        return solve(problem, "active-set", tol=self.tol if tol is None else tol, warm_start=self)

    def to_dataset(self) -> xr.Dataset:
        """Return all fields on the net as an xarray.Dataset with dims y and x (a cable: x), nan outside the frame.

        Variables: gap, deflection, support, reaction, contact_pressure, load, gap_lower, gap_upper, reaction_lower,
        reaction_upper, and contact_state (1 certainly in contact, 0 certainly clear, -1 undecided). Where there is no
        support, gap and its bounds are infinite. A cable net's has the dim node, with the coordinates x, y and point,
        and no contact_pressure.
        """
        from ..io.datasets import solution_dataset

        return solution_dataset(self, self._physical("to_dataset"))

    def plot(self) -> Figure:
        """Draw the contact map and the middle section with support, deflection and reaction.

        The certain states have their own colours: in contact, clear, undecided; a line marks the free boundary.
        A cable has a section only, a cable net its plan and a view in space, and a bare `ContactQP` its gaps and
        reactions, sorted. The figure shows itself in a
        notebook; elsewhere use ``figure.savefig``.
        """
        from ..plotting.answers import plot_solution

        return plot_solution(self)

    def __repr__(self) -> str:
        subject = repr(self.problem if self.model is None else self.model)
        lines = [
            f"Solution by {self.backend}: {self.status.value}, "
            f"{self.iterations} {self.iteration_unit}{'' if self.iterations == 1 else 's'}, {self.seconds:.3g} s",
            f"  problem     {subject}",
        ]
        relative = f"{at_most(self.relative_bound, 1)} of the gap scale; tol {self.tol:g}"
        if self.certificate is not None:
            proof = "weaker bound, no M-matrix" if self.certificate.weaker else "certified"
            lines.append(f"  gap error   <= {at_most(self.certificate.gap_bound)} ({proof}), {relative}")
            certain, clear = (int(np.count_nonzero(m)) for m in (self.certificate.contact, self.certificate.clear))
            undecided = int(np.count_nonzero(self.certificate.undecided))
            lines.append(f"  nodes       {certain} in contact, {clear} clear, {undecided} undecided")
        elif self.residuals is not None:
            residual = f"{self.residuals.natural_residual:.2g} (natural), {relative}"
            lines.append(f"  residual    {residual}; no enclosure is known for this matrix")
        if self.residuals is not None and self.model is not None and self.max_slope > SLOPE_LIMIT:
            lines.append(f"  caution     largest slope {self.max_slope:.2g}: the theory assumes small slopes")
        lines += [f"  finding     {finding}" for finding in self.findings]
        if self.note:
            lines.append(f"  note        {self.note}")
        if not self.status.ok:
            lines.append(f"  {self.backend} said   {self.termination}")
            lines.append(f"  advice      {self.status.advice}")
        return "\n".join(lines)
