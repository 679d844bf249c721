"""Measures of an answer on a large lattice, in one compiled pass."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.checks import Vector, repeated
from ..foundation.loading import load_modules, once
from ..foundation.rounding import UNDERFLOW, UNIT_ROUNDOFF
from ..foundation.threads import Team
from ..geometry.numbering import Grid
from ..methods.multigrid.rows import Rows
from ..problem.barrier import Parabola
from ..problem.contact_problem import ContactProblem
from .certificate import Certificate
from .measures import Measures
from .residuals import Residuals

if TYPE_CHECKING:
    from .lattice_measure_kernels import Passes

_WORTH_COMPILED_PASSES = 10_000
"""Nodes above which passes in memory cost more than loading the compiled ones."""

_GROW = 1 + 16 * UNIT_ROUNDOFF

ENCLOSED = 2
"""So many rows beside its own are enclosed as well, where a problem is a part of a larger one."""


def parabola_of(problem: ContactProblem) -> Parabola | None:
    """Return the problem's barrier if compiled passes apply: a large lattice with arms equal in each direction.

    Nodes beside its frame may be held more firmly.
    """
    if problem.size < _WORTH_COMPILED_PASSES or problem.stiffness.rimmed_lattice is None:
        return None
    barrier = problem.barrier
    return barrier if isinstance(barrier, Parabola) else None


def _kernels(springs: bool) -> Passes:
    load_modules("contactqp.proof.lattice_measure_kernels", kernels="the judge")
    from .lattice_measure_kernels import passes

    once(("judge", springs), lambda: passes(springs), "the judge")
    return passes(springs)


class LatticeMeasures(Measures):
    """See `Measures`; the numbers are kept, not the passes' arrays, but for the grid until it has served twice.

    Parameters
    ----------
    problem : ContactProblem
    barrier : Parabola
        See `parabola_of`.
    gap : array, shape (n,)
        A finite gap (length).
    part : Rows, optional
        The rows of a larger lattice that the problem's are, with those of neighbours; by default they are all.
    threads : int, optional
        By default as many as cores.
    """

    def __init__(
        self,
        problem: ContactProblem,
        barrier: Parabola,
        gap: Vector,
        part: Rows | None = None,
        *,
        threads: int | None = None,
    ) -> None:
        stencil = problem.stiffness.rimmed_lattice
        assert stencil is not None
        self._passes = _kernels(stencil.grounded)
        self.problem, self._barrier, self.gap = problem, barrier, gap
        self._part, self._threads = Rows(problem.layout.rows) if part is None else part, threads
        ground = np.ascontiguousarray(stencil.ground[stencil.numbering.box]) if stencil.grounded else 0.0
        self._arms = float(stencil.horizontal), float(stencil.vertical), ground
        self._bounds = (np.zeros(0), np.zeros(0)) if problem.bounds.standard else _contiguous(problem)
        reference = np.atleast_1d(np.asarray(problem.reference, dtype=np.float64))
        reference = reference[:1].copy() if repeated(reference) else np.ascontiguousarray(reference)
        grid = self._grid()
        self._laid_out: Grid | None = grid
        data = problem.q, reference, int(reference.size > 1)
        found = self._pass(self._passes.measure, self._part.blocks, grid, data)
        raise_by, lower_by, least_gap, least_reaction, work, energy, natural, size = np.array(found).T
        self.raise_by = float(raise_by.max()) * _GROW + UNDERFLOW
        self.lower_by = float(lower_by.max()) * _GROW + UNDERFLOW
        own = grid[self._part.first : self._part.last]
        sizes = max(abs(float(own.max())), abs(float(own.min()))), barrier.largest_v, float(not problem.shut)
        self._largest_gap, self._largest_v, opens = np.max(self._part.everyones([sizes]), axis=0).tolist()
        self._shut = not opens
        self._largest_deflection = float(size.max())
        self._residuals = Residuals(
            min_gap=float(least_gap.min()),
            min_reaction=float(least_reaction.min()),
            complementarity=float(work.sum()),
            natural_residual=float(natural.max()),
            objective=float(energy.sum()),
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
        """Bound of |ω - ω*|: the certificate's, or a little more, for it does not know what is admissible."""
        with np.errstate(over="ignore"):
            step = max(self.raise_by, self.lower_by) * self._largest_v
            return float(_GROW * (step + 8 * UNIT_ROUNDOFF * (step + self._largest_gap)) + 4 * UNDERFLOW)

    def certificate(self) -> Certificate:
        """See `Measures`."""
        problem, size = self.problem, self.problem.size
        lower, upper = np.zeros(size), np.zeros(size)
        contact, clear = np.zeros(size, dtype=np.bool_), np.zeros(size, dtype=np.bool_)
        above = np.zeros(0 if problem.one_sided else size, dtype=np.bool_)
        results = self.raise_by, self.lower_by, lower, upper, contact, above, clear
        grid, self._laid_out = self._laid_out, None
        if grid is None:
            grid = self._grid()
        layout = problem.layout
        with Team(self._threads) as team:
            strips = team.strips(*self._part.near(ENCLOSED), layout.columns)
        found = self._pass(self._passes.enclose, strips, grid, (problem.q,), results)
        bound = max(bound for bound, _ in found)
        if not all(finite for _, finite in found) or not np.isfinite(bound):
            return Certificate.unknown(problem, self._barrier.kind)
        certificate = Certificate(problem, lower, upper, _GROW * bound + UNDERFLOW, contact, clear, self._barrier.kind)
        return certificate if problem.one_sided else replace(certificate, contact_upper=above)

    def _grid(self) -> Grid:
        return self.problem.layout.grid(np.ascontiguousarray(self.gap, dtype=np.float64))

    def _pass(
        self,
        kernel: Any,
        strips: list[tuple[int, int]],
        grid: Grid,
        data: tuple[Any, ...],
        results: tuple[Any, ...] = (),
    ) -> list[Any]:
        """Return what a kernel returns for each strip of the lattice, and for those of the other parts."""
        layout, barrier = self.problem.layout, self._barrier
        place, shape = (layout.runs, layout.row_start), (barrier.rows, barrier.columns, barrier.least_s)
        with Team(self._threads) as team:
            found = team.run(kernel, strips, grid, *data, *self._bounds, *self._arms, *place, *shape, *results)
        return self._part.everyones(found)


def _contiguous(problem: ContactProblem) -> tuple[Vector, Vector]:
    return np.ascontiguousarray(problem.lower), np.ascontiguousarray(problem.upper)
