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
    """

    def __init__(self, problem: ContactProblem, barrier: Parabola, gap: Vector) -> None:
        stencil = problem.stiffness.rimmed_lattice
        assert stencil is not None
        self._passes = _kernels(stencil.grounded)
        self.problem, self._barrier, self._gap = problem, barrier, gap
        ground = np.ascontiguousarray(stencil.ground[stencil.numbering.box]) if stencil.grounded else 0.0
        self._arms = float(stencil.horizontal), float(stencil.vertical), ground
        self._bounds = (np.zeros(0), np.zeros(0)) if problem.bounds.standard else _contiguous(problem)
        reference = np.atleast_1d(np.asarray(problem.reference, dtype=np.float64))
        reference = reference[:1].copy() if repeated(reference) else np.ascontiguousarray(reference)
        grid = self._grid()
        self._laid_out: Grid | None = grid
        found = self._pass(self._passes.measure, grid, (problem.q, reference, int(reference.size > 1)))
        raise_by, lower_by, least_gap, least_reaction, work, energy, natural, size = np.array(found).T
        self.raise_by = float(raise_by.max()) * _GROW + UNDERFLOW
        self.lower_by = float(lower_by.max()) * _GROW + UNDERFLOW
        self._largest_gap = max(abs(float(grid.max())), abs(float(grid.min())))
        self._largest_deflection = float(size.max())
        self._residuals = Residuals(
            min_gap=float(least_gap.min()),
            min_reaction=float(least_reaction.min()),
            complementarity=float(work.sum()),
            natural_residual=float(natural.max()),
            objective=float(energy.sum()),
        )

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
            step = max(self.raise_by, self.lower_by) * self._barrier.largest_v
            return _GROW * (step + 8 * UNIT_ROUNDOFF * (step + self._largest_gap)) + 4 * UNDERFLOW

    def certificate(self) -> Certificate:
        """See `Measures`."""
        problem, size = self.problem, self.problem.size
        lower, upper = np.empty(size), np.empty(size)
        contact, clear = np.empty(size, dtype=np.bool_), np.empty(size, dtype=np.bool_)
        above = np.zeros(0 if problem.one_sided else size, dtype=np.bool_)
        results = self.raise_by, self.lower_by, lower, upper, contact, above, clear
        grid, self._laid_out = self._laid_out, None
        if grid is None:
            grid = self._grid()
        found = self._pass(self._passes.enclose, grid, (problem.q,), results)
        bound = max(bound for bound, _ in found)
        if not all(finite for _, finite in found) or not np.isfinite(bound):
            return Certificate.unknown(problem, self._barrier.kind)
        certificate = Certificate(problem, lower, upper, _GROW * bound + UNDERFLOW, contact, clear, self._barrier.kind)
        return certificate if problem.one_sided else replace(certificate, contact_upper=above)

    def _grid(self) -> Grid:
        return self.problem.layout.grid(np.ascontiguousarray(self._gap, dtype=np.float64))

    def _pass(self, kernel: Any, grid: Grid, data: tuple[Any, ...], results: tuple[Any, ...] = ()) -> list[Any]:
        """Return what a kernel returns for each strip of the lattice."""
        layout, barrier = self.problem.layout, self._barrier
        place, shape = (layout.runs, layout.row_start), (barrier.rows, barrier.columns, barrier.least_s)
        with Team() as team:
            strips = team.strips(1, layout.rows + 1, layout.columns)
            return team.run(kernel, strips, grid, *data, *self._bounds, *self._arms, *place, *shape, *results)


def _contiguous(problem: ContactProblem) -> tuple[Vector, Vector]:
    return np.ascontiguousarray(problem.lower), np.ascontiguousarray(problem.upper)
