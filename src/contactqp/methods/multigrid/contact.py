"""Truncated nonsmooth Newton multigrid for min ½ωᵀGω + qᵀω between bounds, on a lattice.

Gräser and Kornhuber, *Multigrid methods for obstacle problems*, J. Comput. Math. 27 (2009): projected
Gauss-Seidel finds the contact nodes; one linear multigrid cycle for the other nodes, which are unconstrained for the
moment, takes away the smooth error; the correction is projected, and shortened by a line search where it
could raise the energy. Every step lowers the energy, and the sweeps alone would converge, so the method does; where
arms differ, one step may be excepted (see `_BOLD`), and each ends in the plane of the last two steps.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...foundation.threads import Team
from ...geometry.numbering import Grid
from ...geometry.runs import FREE, KIND
from .arms import Arms
from .hierarchy import VISITED
from .lattice_kernels import exchange_kernels, lattice_kernels, start_from_coarse
from .rows import HALO
from .weighted_hierarchy import hierarchy_of

_SWEEPS = 3
_MOST_SWEEPS = 24
_AT_ONCE = 6
"""Half-sweeps in one pass through memory."""

_LEAST_STRIP = 2 * _AT_ONCE
"""What is left out near one border of a strip must not depend on what is left out near the other."""

_DEPENDENT = 1e-10
"""Two directions are taken for one where the square of the sine between them is smaller."""

_BOLD = 0.1
"""What the line search leaves of a step below which a bold one is taken instead.

A stiff part moves as a whole. Where it is too high, and its lowest nodes are at their bounds already or next to them, a
line search lets it move by nothing; a full step, projected, holds a good part of it, and the forces that are needed for
that let go of most nodes at once, as in primal-dual active sets. There is one such step: more of them go in circles.
"""

_STALLING = 0.5
"""Contraction above which a cycle of a lattice at rest counts as stalling: it is 0.05 to 0.15 as a rule."""


Limits: TypeAlias = tuple[Grid, Grid]
"""Lower and upper bounds on a grid, see `contactqp.problem.contact_problem.ContactProblem.bound_grids`."""

NO_LIMITS: Limits = np.zeros((0, 0)), np.zeros((0, 0))


class ContactMultigrid:
    """The iteration on one lattice; a cycle is `relax` and `correct`.

    Parameters
    ----------
    lattice : Arms
    q : array, shape (rows + 2, columns + 2)
        Reaction that would hold the gap shut, on the layout's grid.
    team : Team
    limits : pair of arrays, shape (rows + 2, columns + 2)
        Bounds of the nodes that are `BOUNDED`; empty where there are none.

    Attributes
    ----------
    omega : array, shape (rows + 2, columns + 2)
        The gap.
    estimate : float
        After `relax`: the largest force that is out of balance: one that pulls a node from its bound, or R at a free
        node (but no more than the way to the bound that it pulls towards, over the lattice's reach).
    changes : int
        After `relax`: nodes that came into contact or left it since the last time; at first, nodes in contact.
    cut : int
        After `correct`: nodes at which a bound cut the correction short.
    damping : float
        After `correct`: the factor of the line search, 1 as a rule.
    work : float
        Work done, in sweeps over this lattice: a pass over a coarse lattice counts by its points.
    """

    def __init__(self, lattice: Arms, q: Grid, team: Team, limits: Limits = NO_LIMITS) -> None:
        self.lattice, self.q, self.team, self.limits = lattice, q, team, limits
        self.omega, self._next = lattice.layout.zeros(), np.zeros((0, 0))
        self.hierarchy = hierarchy_of(lattice, team)
        self.estimate, self.changes, self.cut, self.damping, self.work = np.inf, 0, 0, 1.0, 0.0
        self._kernels = lattice_kernels(lattice.kind)
        self._exchange = exchange_kernels(lattice.kind, self.hierarchy.levels[0].plan.precision)
        self._part = lattice.part
        self._strips = team.strips(*self._part.near(0), lattice.columns, _LEAST_STRIP)
        self._known = team.strips(*self._part.near(_AT_ONCE), lattice.columns, _LEAST_STRIP)
        self._swept = team.strips(*self._part.near(_AT_ONCE - 1), lattice.columns, _LEAST_STRIP)
        self._place = lattice.layout.runs, lattice.layout.row_start
        self._bounded_place = *limits, *self._place
        first = self.hierarchy.levels[0]
        self._coarsening = *first.factors, first.exchange_weights
        self._sweeps = _SWEEPS
        self._careful = lattice.varying
        self._past: list[Grid] = []
        self._may_be_bold = lattice.varying

    def restart(self, q: Grid, limits: Limits, team: Team) -> None:
        """Go on with other forces and other values of the bounds, by the hierarchy of the last free nodes."""
        self.q, self.limits, self.team = q, limits, team
        self.hierarchy.team = team
        self._bounded_place = *limits, *self._place
        self.estimate, self.changes, self.cut, self.damping, self.work = np.inf, 0, 0, 1.0, 0.0
        self._sweeps, self._careful = _SWEEPS, self.lattice.varying
        self._past = []
        self._may_be_bold = self.lattice.varying

    def start(self, height: Grid, coarse_deflection: Grid) -> None:
        """Start from ``height`` less the interpolated deflection of the next coarser lattice."""
        deflection = self.hierarchy.levels[0].beneath(coarse_deflection)
        arguments = self.omega, height, deflection, *self._coarsening, *self._bounded_place
        self.team.run(start_from_coarse, self._strips, *arguments)
        self._part.share(self.omega, reach=_AT_ONCE)

    def relax(self) -> None:
        """Sweep, and measure and restrict what is left."""
        before = self.estimate
        if self.lattice.varying:
            self._past.append(self.omega.copy())
        self._sweep(2 * self._sweeps)
        self.changes, self.estimate = self._restrict(self.lattice.layout.runs)
        self.work += self._sweeps + 1
        if self.changes == 0 and self.estimate > _STALLING * before:
            self._sweeps = min(2 * self._sweeps, _MOST_SWEEPS)
            self._careful = True

    def correct(self) -> None:
        """Correct the free nodes from the coarse levels; to be called after `relax`."""
        if self.hierarchy.stale:
            self.hierarchy.update()
            self.work += self.hierarchy.points
        self.hierarchy.cycle()
        if not self._next.size:
            self._next = self.lattice.layout.zeros()
        first = self.hierarchy.levels[0]
        first.part.hand_back(first.correction, VISITED)
        correction = first.beneath(first.correction)
        arguments = self.omega, self._next, correction, *self._coarsening, *self._bounded_place
        self.cut = sum(self._part.everyones(self.team.run(self._exchange.correct, self._strips, *arguments)))
        self._part.share(self._next, reach=_AT_ONCE)
        self.work += 1 + self.hierarchy.cycle_work
        careful = self.cut or (self._careful and len(self._past) < 2)
        self.damping = self._line_search() if careful else 1.0
        self.omega, self._next = self._next, self.omega
        if len(self._past) == 2:
            self._accelerate(*self._past)
            del self._past[0]

    def give_up_spare(self) -> None:
        """Free what only a `correct` needs, which makes it anew, for as long as the gap is judged."""
        self._next = np.zeros((0, 0))

    def rest(self) -> float:
        """Return the force out of balance that rounding errors alone may leave."""
        own = self.omega[self._part.first : self._part.last]
        largest = max(self._part.everyones([max(abs(float(own.max())), abs(float(own.min())))]))
        return 4 * float(np.finfo(np.float64).eps) * largest * self.lattice.stiffest

    def last_step(self) -> float:
        """Return by how much the gap has changed at most since the cycle before; infinite where that is not known."""
        if not self._past:
            return np.inf
        own = slice(self._part.first, self._part.last)
        return max(self._part.everyones([float(np.abs(self.omega[own] - self._past[-1][own]).max())]))

    def restrict_load(self) -> NDArray[Any]:
        """Return q + Gω, summed with the weights of bilinear interpolation, at the next coarser lattice's nodes."""
        unsupported = self.lattice.layout.runs.copy()
        unsupported[:, KIND] = FREE
        self._restrict(unsupported, reach=HALO)
        return np.negative(self.hierarchy.levels[0].residual[1:-1, 1:-1])

    def energy(self) -> float:
        """Return ½ωᵀGω + qᵀω."""
        inner = self.omega[1:-1, 1:-1]
        return float((inner * (0.5 * self.lattice.resistance(self.omega) + self.q[1:-1, 1:-1])).sum())

    def _sweep(self, half_sweeps: int) -> None:
        """Do red and black half-sweeps in turn; what strips leave out at their borders is done afterwards."""
        problem = self.omega, self.q, *self.lattice.stiffnesses, *self._bounded_place
        for first in range(0, half_sweeps, _AT_ONCE):
            count = min(_AT_ONCE, half_sweeps - first)
            self.team.run(self._kernels.sweep, self._swept, *problem, first, count)
            for border, _ in self._swept[1:]:
                for k in range(1, count):
                    self._kernels.sweep(*problem, first + k, 1, border - k, border + k)
            self._part.share(self.omega, reach=_AT_ONCE)

    def _restrict(self, runs: NDArray[np.int64], reach: int = 2) -> tuple[int, float]:
        """Restrict the residual, see `lattice_kernels`, and share it so far."""
        first = self.hierarchy.levels[0]
        place = *self.limits, runs, self.lattice.layout.row_start
        problem = self.omega, self.q, *self.lattice.stiffnesses, *place
        marks = self.hierarchy.free, self.hierarchy.changed
        arguments = *problem, *marks, first.beneath(first.residual), *self._coarsening, 1 / self.lattice.reach
        found = self._part.everyones(self.team.run(self._exchange.restrict_residual, first.given, *arguments))
        first.part.share(first.residual, reach=reach)
        changes = sum(changes for changes, _ in found)
        if changes:
            self.hierarchy.stale = True
            self._part.share(*marks, reach=2)
        return changes, max(worst for _, worst in found)

    def _accelerate(self, older: Grid, before: Grid) -> None:
        """Go to the least energy in the plane of this cycle's step and the last one's, unless that leaves the bounds.

        For a linear problem, and a symmetric cycle, that is a step of conjugate gradients.
        """
        self._past[1] = before.copy()
        self.team.run(self._kernels.directions, self._known, self.omega, before, older, *self._bounded_place)
        arguments = self.omega, before, older, self.q, *self.lattice.stiffnesses, *self._place
        found = self.team.run(self._kernels.plane, self._part.blocks, *arguments)
        first_slope, second_slope, first, common, second = self._part.sums(found)
        determinant = first * second - common * common
        self.work += 4
        if determinant > _DEPENDENT * first * second:
            lengths = common * second_slope - second * first_slope, common * first_slope - first * second_slope
            if self._moved(before, lengths[0] / determinant, older, lengths[1] / determinant):
                return
        if first_slope > 0.0:  # back, but no farther than to where the cycle began
            self._moved(before, -min(1.0, first_slope / first), older, 0.0)

    def _moved(self, first: Grid, first_length: float, second: Grid, second_length: float) -> bool:
        """Whether a combination of two directions does not leave the bounds; then it is gone along."""
        way = first, first_length, second, second_length
        beyond = self.team.run(self._kernels.advance, self._known, self.omega, self._next, *way, *self._bounded_place)
        if any(self._part.everyones(beyond)):
            return False
        self.omega, self._next = self._next, self.omega
        return True

    def _line_search(self) -> float:
        """Shorten the step to the least energy along it; it stays feasible, because both of its ends are."""
        arguments = self.omega, self._next, self.q, *self.lattice.stiffnesses, *self._place
        slope, curvature = self._part.sums(self.team.run(self._kernels.energy_slope, self._part.blocks, *arguments))
        self.work += 1
        if slope + curvature <= 0 or curvature <= 0:
            return 1.0
        damping = max(0.0, -slope / curvature)
        if damping < _BOLD and self._may_be_bold:
            self._may_be_bold = False
            self._past = []
            return 1.0
        self._next -= self.omega
        self._next *= damping
        self._next += self.omega
        return damping
