"""LatticeBounds: what judge and certificate want to know of an answer on a large lattice, in one compiled pass."""

from __future__ import annotations

from functools import cache, cached_property
from typing import Any

import numpy as np

from ..foundation.checks import Mask, Vector, repeated
from ..foundation.progress import compiling
from ..foundation.rounding import UNDERFLOW, UNIT_ROUNDOFF
from ..foundation.threads import Team
from ..problem.barrier import Parabola
from ..problem.contact_qp import ContactQP

_WORTH_COMPILED_PASSES = 10_000
"""Nodes above which passes in memory cost more than loading the compiled ones."""

_GROW = 1 + 16 * UNIT_ROUNDOFF


def parabola_of(problem: ContactQP) -> Parabola | None:
    """Return the problem's barrier if compiled passes apply: a large lattice with arms equal in each direction."""
    if problem.size < _WORTH_COMPILED_PASSES or problem.stencil is None:
        return None
    barrier = problem.barrier
    return barrier if isinstance(barrier, Parabola) and problem.stencil.uniform else None


@cache
def _kernels() -> tuple[Any, Any]:
    with compiling("the judge"):
        from .lattice_measure_kernels import enclose, measure
    return measure, enclose


class LatticeBounds:
    """Measures of one answer, shared by the certificate and the residuals.

    Parameters
    ----------
    problem : ContactQP
    barrier : Parabola
        See `parabola_of`.
    gap : array, shape (n,)
        Finite.
    """

    def __init__(self, problem: ContactQP, barrier: Parabola, gap: Vector) -> None:
        measure, _ = _kernels()
        assert problem.stencil is not None
        self.problem, self.barrier = problem, barrier
        self._layout = problem.layout
        self._grid = self._layout.grid(np.ascontiguousarray(gap, dtype=np.float64))
        self._arms = float(problem.stencil.horizontal), float(problem.stencil.vertical)
        self._place = self._layout.runs, self._layout.row_start
        self._shape = barrier.rows, barrier.columns, barrier.least_s
        reference = np.atleast_1d(np.asarray(problem.reference, dtype=np.float64))
        reference = reference[:1].copy() if repeated(reference) else np.ascontiguousarray(reference)
        found = self._pass(measure, (problem.q, reference, int(reference.size > 1)))
        columns = np.array(found).T
        raise_by, lower_by, least_gap, least_reaction, work, energy, natural, size = columns
        self.raise_by = float(raise_by.max()) * _GROW + UNDERFLOW
        self.lower_by = float(lower_by.max()) * _GROW + UNDERFLOW
        self.least_gap, self.least_reaction = float(least_gap.min()), float(least_reaction.min())
        self.complementarity, self.objective = float(work.sum()), float(energy.sum())
        self.natural_residual = float(natural.max())
        self.largest_deflection = float(size.max())

    def _pass(self, kernel: Any, data: tuple[Any, ...], results: tuple[Any, ...] = ()) -> list[Any]:
        """Return what a kernel returns for each strip of the lattice."""
        with Team() as team:
            strips = team.strips(1, self._layout.rows + 1, self._layout.columns)
            return team.run(kernel, strips, self._grid, *data, *self._arms, *self._place, *self._shape, *results)

    @cached_property
    def gap_bound(self) -> float:
        """Bound of |ω - ω*|: the enclosure's, or a little more (it does not know that ω* >= 0)."""
        with np.errstate(over="ignore"):
            step = max(self.raise_by, self.lower_by) * self.barrier.largest_v
            largest = max(abs(float(self._grid.max())), abs(float(self._grid.min())))
            return _GROW * (step + 8 * UNIT_ROUNDOFF * (step + largest)) + 4 * UNDERFLOW

    def enclosure(self) -> tuple[Vector, Vector, Mask, Mask, float] | None:
        """Return lower, upper, contact, clear and the bound of |ω - ω*|; None where numbers overflow."""
        _, enclose = _kernels()
        size = self.problem.size
        lower, upper = np.empty(size), np.empty(size)
        contact, clear = np.empty(size, dtype=np.bool_), np.empty(size, dtype=np.bool_)
        results = self.raise_by, self.lower_by, lower, upper, contact, clear
        found = self._pass(enclose, (self.problem.q,), results)
        bound = max(bound for bound, _ in found)
        if not all(finite for _, finite in found) or not np.isfinite(bound):
            return None
        return lower, upper, contact, clear, _GROW * bound + UNDERFLOW
