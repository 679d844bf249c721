"""Barriers of stiffnesses that are divided among processes, each of which knows them at its nodes."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import TypeAlias

import numpy as np

from ..algebra.stencil import Stencil
from ..foundation.checks import Vector
from ..foundation.threads import Team
from ..geometry.numbering import Layout
from ..methods.multigrid.arms import Arms
from ..methods.multigrid.contact import ContactMultigrid
from ..methods.multigrid.linear import cycle_until
from ..methods.multigrid.strips import Strip
from ..methods.multigrid.weighted_hierarchy import load_kernels
from ..problem.barrier import Barrier, Parabola, image_below

_TOLERANCES = 1e-3, 1e-6, 1e-9
"""Forces out of balance, relative to those that are applied, at which a solution is looked at whether it is one."""


class PartOfParabola(Parabola):
    """A parabola on a process's rows."""

    def __init__(self, whole: Parabola, part: Strip, layout: Layout) -> None:
        rows = np.ascontiguousarray(whole.rows[part.offset : part.offset + part.height])
        super().__init__(rows, whole.columns, whole.least_s, whole.kind, layout)
        self._part, self._own_layout = part, layout

    @cached_property
    def largest_v(self) -> float:
        """Largest v of all processes' nodes."""
        part, layout = self._part, self._own_layout
        runs = layout.runs[layout.row_start[part.first] : layout.row_start[part.last]]
        nearest = np.clip(int(self.columns.argmax()), runs[:, 1], runs[:, 2] - 1)
        own = self.rows[runs[:, 0]] + self.columns[nearest]
        return max(part.everyones([float(own.max(initial=0.0))]))


class PartOfBarrier(Barrier):
    """A barrier of any kind on a process's rows.

    Parameters
    ----------
    v, s : array, shape (n,)
        Of all nodes that the process holds.
    kind : str
    least_s, largest_v : float
        Of all processes' nodes.
    """

    def __init__(self, v: Vector, s: Vector, kind: str, least_s: float, largest_v: float) -> None:
        super().__init__(v, s, kind)
        self.least_s, self.largest_v = least_s, largest_v

    @property
    def reach(self) -> float:
        """See `Barrier`."""
        return self.largest_v / self.least_s


BarrierOfRows: TypeAlias = PartOfParabola | PartOfBarrier


def found_barrier(stencil: Stencil, arms: Arms, own: slice, parabolas: Iterable[Parabola], team: Team) -> PartOfBarrier:
    """Return a barrier of arms that differ, or that end on the ground: a parabola that proves to be one, or G⁻¹1.

    As `contactqp.problem.barrier.find_barrier` finds one. Whatever v is, s is a bound of Gv, computed node by node.

    Parameters
    ----------
    stencil : Stencil
        The stiffness of the process's nodes.
    arms : Arms
        The same, as the multigrid has it, with all nodes free.
    own : slice
        The numbers of the nodes in the process's own rows.
    parabolas : iterable of Parabola
        Of which the one of the least reach is taken that proves to be a barrier.
    team : Team

    Raises
    ------
    ValueError
        If none is found, in every process.
    """
    checked = (_checked(stencil, arms, own, parabola.v, parabola.kind) for parabola in parabolas)
    candidates = [candidate for candidate in checked if candidate is not None]
    if candidates:
        return min(candidates, key=lambda candidate: candidate.reach)
    load_kernels(arms)
    layout, part = arms.layout, arms.part
    solver = ContactMultigrid(arms, layout.grid(np.full(stencil.size, -1.0)), team)
    for tolerance in _TOLERANCES:
        cycle_until(solver, tolerance)
        found = solver.omega.copy()
        part.share(found)
        candidate = _checked(stencil, arms, own, layout.vector(found), "linear solve")
        if candidate is not None:
            return candidate
    raise ValueError(
        "the tension varies too much from node to node for a certificate by several processes: no vector was found "
        "that proves the stiffness to be an M-matrix; start one process"
    )


def _checked(stencil: Stencil, arms: Arms, own: slice, v: Vector, kind: str) -> PartOfBarrier | None:
    """Return the barrier if v > 0 and G v > 0 hold beyond rounding at all processes' nodes."""
    layout, part = arms.layout, arms.part
    good = bool(np.isfinite(v).all()) and float(v[own].min()) > 0
    s = image_below(stencil, v) if good else np.zeros_like(v)
    found = part.everyones([(float(s[own].min()), float(v[own].max()))])
    least_s, largest_v = min(least for least, _ in found), max(largest for _, largest in found)
    if not least_s > 0:
        return None
    grid = layout.grid(s)
    part.share(grid)  # the rows at the ends of what is held lack a neighbour
    return PartOfBarrier(v, layout.vector(grid), kind, least_s, largest_v)
