"""The paper's example solved again: everything its table and figures are made of."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from ..comparison.compare import compare
from ..comparison.comparison import Comparison
from ..foundation.checks import Mask, Vector, read_only
from ..foundation.progress import Progress
from ..gallery.membranes import PAPER_LOADS, paper_hexagon
from ..models.membrane import Membrane
from ..paths.load_path import LoadPath
from ..paths.trace import trace
from ..solving.solution import Solution
from ..solving.solve import solve
from .facts import TABLE_1, PaperRow
from .scan import Scan, scan
from .theory import jacobi_radius, optimal_factor

LONG_RUN_TOLERANCE = 1e-12
"""ε (in Δ) at which the best factor is that of the long run, as theory's is."""

LONG_RUN_FACTORS: Vector = read_only(np.round(np.arange(1.30, 1.90, 0.01), 2))


@dataclass(frozen=True, eq=False)
class TableRow:
    """A load of Table 1, the paper's numbers beside ours.

    Attributes
    ----------
    paper : PaperRow
    step, residual : Scan
        Sweeps with the two stopping rules, ε = 0.001.
    long_run : Scan
        With the step rule and ε = 10⁻¹², by factors 0.01 apart.
    radius, optimal : float
        Jacobi's spectral radius μ on the final free set, and theory's best factor.
    """

    paper: PaperRow
    step: Scan
    residual: Scan
    long_run: Scan
    radius: float
    optimal: float


@dataclass(frozen=True, eq=False)
class Reproduction:
    """The example at the loads of Table 1. Made by `reproduce`.

    Attributes
    ----------
    path : LoadPath
        The ten loads by active sets, each from the one before.
    unloaded : Solution
        At P′ = 0.
    comparisons : tuple of Comparison
        All backends at each load.
    rows : tuple of TableRow
    """

    path: LoadPath
    unloaded: Solution
    comparisons: tuple[Comparison, ...]
    rows: tuple[TableRow, ...]

    @property
    def membrane(self) -> Membrane:
        """The model of the path, which has a lattice."""
        assert isinstance(self.path.model, Membrane)
        return self.path.model

    @property
    def contact_maps(self) -> list[tuple[float, Mask]]:
        """P′ and the nodes in contact, shape (n,), unloaded and at each load of the path.

        A node that a certificate proves clear is not in contact, whatever its answer says: unloaded, gap and reaction
        of the summit are zero but for rounding.
        """
        loads = [0.0, *map(float, self.path.values)]
        return [
            (load, solution.contact if solution.certificate is None else solution.contact & ~solution.certificate.clear)
            for load, solution in zip(loads, (self.unloaded, *self.path.solutions), strict=True)
        ]

    @property
    def decided(self) -> bool:
        """Whether certificates decide every node at every load: in contact, or clear."""
        certificates = [solution.certificate for solution in self.path.solutions]
        return all(certificate is not None and not certificate.undecided.any() for certificate in certificates)

    @property
    def nested(self) -> bool:
        """Whether certificates prove that every contact set contains that of the load before."""
        if not self.decided or self.path.findings:
            return False
        return all(
            bool(after.contact[before.contact].all())
            for before, after in pairwise(solution.certificate for solution in self.path.solutions)
            if before is not None and after is not None
        )

    @cached_property
    def backends(self) -> tuple[str, ...]:
        """The backends that were compared."""
        return tuple(row.backend for row in self.comparisons[0].rows)

    @cached_property
    def identical(self) -> bool:
        """Whether all backends are certified, agree, and have the contact sets of the path, at every load."""
        return all(
            comparison.agree
            and all(np.array_equal(found.contact, solution.contact) for found in comparison.solutions.values())
            for comparison, solution in zip(self.comparisons, self.path.solutions, strict=True)
        )

    @property
    def ok(self) -> bool:
        """Whether all that was to be verified is: certified answers, nested contact sets, agreement."""
        return all(solution.status.ok for solution in self.path.solutions) and self.nested and self.identical


def reproduce(loads: Iterable[float] = PAPER_LOADS) -> Reproduction:
    """Solve the paper's hexagon over the surrogate surface, and scan its relaxation factors.

    Parameters
    ----------
    loads : sequence of float
        P′, of Table 1; by default all ten.

    Raises
    ------
    ValueError
        If a load is not in Table 1, or there is none.

    Examples
    --------
    >>> found = reproduce(loads=[0.09, 0.10])
    >>> found.ok, [row.step.least for row in found.rows], [row.paper.sweeps for row in found.rows]
    (True, [18, 17], [18, 17])
    """
    chosen = sorted(set(loads))
    known = {row.load: row for row in TABLE_1}
    if not chosen or not set(chosen) <= set(known):
        raise ValueError(f"loads must be some of Table 1's, {', '.join(f'{load:.2f}' for load in known)}, got {chosen}")
    path = trace(paper_hexagon(1.0), loads=chosen, backend="active-set")
    comparisons: list[Comparison] = []
    rows: list[TableRow] = []
    with Progress("the paper's example") as progress:
        for load, solution in zip(chosen, path.solutions, strict=True):
            progress.update(f"P' = {load:.2f}, {len(rows) + 1} of {len(chosen)}")
            model = paper_hexagon(load)
            comparisons.append(compare(model))
            radius = jacobi_radius(model, ~solution.contact)
            rows.append(
                TableRow(
                    paper=known[load],
                    step=scan(model, "step"),
                    residual=scan(model, "residual"),
                    long_run=scan(model, "step", stopping_length=LONG_RUN_TOLERANCE, factors=LONG_RUN_FACTORS),
                    radius=radius,
                    optimal=optimal_factor(radius),
                )
            )
    return Reproduction(path, solve(paper_hexagon(0.0), "active-set"), tuple(comparisons), tuple(rows))
