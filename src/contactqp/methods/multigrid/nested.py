"""Nested iteration: a lattice's problem is started from the solution of the same problem on coarser lattices."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from ...foundation.checks import Vector
from ...foundation.threads import Team
from ...geometry.numbering import Grid
from .arms import Arms
from .contact import NO_LIMITS, ContactMultigrid, Limits
from .hierarchy import VISITED

_CYCLES_A_LEVEL = 2
_CYCLES_FOR_A_CHANGE = 1
"""Cycles on each coarse lattice, from the coarser ones, and from its own solution for other forces."""

_CYCLES_FOR_A_START = 16


def nested_start(
    lattice: Arms,
    q: Grid,
    height: Grid,
    team: Team,
    report: Callable[[int], None] = lambda nodes: None,
    limits: Limits = NO_LIMITS,
) -> ContactMultigrid:
    """Return the iteration on a lattice, started from the solution of the same problem on coarser lattices.

    Parameters
    ----------
    lattice : Arms
    q, height : array, shape (rows + 2, columns + 2)
        Reaction that would hold the gap zero, and the ordinates that the gap is measured from, on the frame its own.
    team : Team
    report : callable
        Called with the number of nodes of each lattice that is begun.
    limits : pair of arrays
        See `ContactMultigrid`.
    """
    nest = Nest(lattice, team)
    nest.begin(q, height, report, limits, keep=False)
    return nest.solver


class Nest:
    """The iterations on a lattice and its coarser ones, which can be kept to go on from when the forces change.

    Parameters
    ----------
    lattice : Arms
    team : Team

    Attributes
    ----------
    solver : ContactMultigrid
        The iteration on the lattice itself.
    complete : bool
        Whether the coarser lattices are kept, at the same forces as this one.
    """

    def __init__(self, lattice: Arms, team: Team) -> None:
        self.solver = ContactMultigrid(lattice, lattice.layout.zeros(), team)
        self._coarse: Arms | None = None
        self._coarser: Nest | None = None
        self.complete = False

    def begin(
        self,
        q: Grid,
        height: Grid,
        report: Callable[[int], None] = lambda nodes: None,
        limits: Limits = NO_LIMITS,
        *,
        keep: bool = True,
    ) -> None:
        """Start from the coarser lattices; see `nested_start`.

        What is interpolated is the deflection height - ω, because the gap itself jumps at the frame.
        """
        solver, self.complete = self.solver, keep
        solver.restart(q, limits, solver.team)
        solver.omega[...] = 0.0
        coarse = solver.lattice.coarser()
        if coarse is None:
            return
        coarse_q, coarse_height, coarse_limits = self._coarse_problem(coarse, height)
        work, self._coarse = 0.0, coarse if keep else None
        if not coarse.part.idle:
            coarser = Nest(coarse, solver.team)
            coarser.begin(coarse_q, coarse_height, report, coarse_limits, keep=keep)
            report(coarse.size)
            coarser.cycle(_CYCLES_A_LEVEL)
            work = coarser.solver.work * coarse.size
            np.subtract(coarse_height, coarser.solver.omega, out=coarse_height)
            self._coarser = coarser if keep else None
            del coarser
        self._start(height, coarse_height, work)

    def _start(self, height: Grid, coarse_deflection: Grid, work: float) -> None:
        """Start from what those know who work on the next coarser lattice: all processes, or the first and others."""
        solver = self.solver
        solver.hierarchy.levels[0].part.hand_back(coarse_deflection, VISITED)
        solver.work = solver.lattice.part.everyones([work])[0] / solver.lattice.size + 1
        solver.start(height, coarse_deflection)

    def start(self, gap: Vector, q: Vector, limits: Limits = NO_LIMITS) -> None:
        """Go on with other forces from a gap that is near the solution; the coarser lattices are given up.

        Parameters
        ----------
        gap, q : array, shape (n,)
            Nodes in the order of the lattice's layout.
        limits
            See `nested_start`.
        """
        solver, layout = self.solver, self.solver.lattice.layout
        solver.restart(layout.grid(q, out=solver.q), limits, solver.team)
        layout.grid(gap, out=solver.omega)
        solver.lattice.part.share(solver.omega)
        self._coarse, self._coarser, self.complete = None, None, False

    def change(self, q: Grid, height: Grid, limits: Limits = NO_LIMITS, *, factor: float = 1.0) -> None:
        """Go on with other forces: add to the last solution what the coarser lattices' solutions change by.

        Where contact comes and goes over many nodes, the coarse lattices know of it before the fine one could.

        Parameters
        ----------
        q, height, limits
            See `nested_start`; the heights are those of before.
        factor : float
            What the last solution is to be multiplied by: the ratio of the units of length, before over now.
        """
        solver = self.solver
        before = solver.omega * factor
        solver.restart(q, limits, solver.team)
        coarse, coarser = self._coarse, self._coarser
        if coarse is None:
            np.copyto(solver.omega, before)
            return
        coarse_q, coarse_height, coarse_limits = self._coarse_problem(coarse, height)
        work, decrease = 0.0, coarse.layout.zeros()
        if coarser is not None:
            decrease = coarser.solver.omega * factor
            coarser.change(coarse_q, coarse_height, coarse_limits, factor=factor)
            coarser.cycle(_CYCLES_FOR_A_CHANGE)
            work = coarser.solver.work * coarse.size
            decrease -= coarser.solver.omega
        self._start(before, decrease, work)

    def cycle(self, count: int) -> None:
        """Do some cycles on the lattice itself."""
        for _ in range(count):
            self.solver.relax()
            self.solver.correct()

    def work_with(self, team: Team) -> None:
        """Share the work with other threads from now on."""
        self.solver.team = self.solver.hierarchy.team = team
        if self._coarser is not None:
            self._coarser.work_with(team)

    def _coarse_problem(self, coarse: Arms, height: Grid) -> tuple[Grid, Grid, Limits]:
        """Return forces, heights and bounds on the next coarser lattice; ω is overwritten."""
        solver, lattice = self.solver, self.solver.lattice
        np.copyto(solver.omega, height)
        load = solver.restrict_load()
        solver.omega[...] = 0.0
        columns = np.minimum(lattice.column_coarsening * np.arange(coarse.columns + 2), lattice.columns + 1)
        part = solver.hierarchy.levels[0].part

        def picked(grid: Grid) -> Grid:
            return part.picked(grid[:, columns], lattice.part, lattice.row_coarsening)

        coarse_height = picked(height)
        floor, ceiling = (picked(bound) if bound.size else bound for bound in solver.limits)
        coarse_q = coarse.layout.zeros()
        coarse_q[1:-1, 1:-1] = np.where(coarse.layout.mask, load - coarse.resistance(coarse_height), 0.0)
        return coarse_q, coarse_height, (floor, ceiling)


class Scaled(Protocol):
    """A dimensionless problem on a lattice; see `contactqp.problem.contact_problem.ContactProblem`."""

    @property
    def q(self) -> Vector: ...  # noqa: D102
    def force_grid(self) -> Grid: ...  # noqa: D102
    def reference_grid(self) -> Grid: ...  # noqa: D102
    def bound_grids(self) -> Limits: ...  # noqa: D102
    def project(self, gap: Vector) -> Vector: ...  # noqa: D102


class Succession:
    """Problems on one lattice, one after the other, and the iteration that goes on from one to the next.

    Parameters
    ----------
    lattice : Arms
    keeps : bool
        Whether there may be a next problem: then the hierarchy is kept, and after a start from the coarser lattices
        those as well.
    """

    def __init__(self, lattice: Arms, *, keeps: bool) -> None:
        self._lattice, self._keeps = lattice, keeps
        self._nest: Nest | None = None
        self._unit = 1.0

    def begun(
        self,
        problem: Scaled,
        team: Team,
        start: Vector | None,
        *,
        unit: float,
        predicted: bool = False,
        resumes: bool = False,
        report: Callable[[int], None] = lambda nodes: None,
    ) -> ContactMultigrid:
        """Return the iteration for a problem, at its start.

        After its own last answer it goes on from a prediction, or from what the coarser lattices' solutions change by;
        from another gap that it is given. Else it starts from the coarser lattices.

        Parameters
        ----------
        problem : Scaled
        team : Team
        start : array, shape (n,), or None
            A gap to start from.
        unit : float
            The unit of length.
        predicted, resumes : bool
            See `contactqp.backends.base.Task`.
        report : callable
            See `nested_start`.
        """
        # What is interrupted is not gone on with.
        kept, self._nest = self._nest, None
        nest = Nest(self._lattice, team) if kept is None else kept
        nest.work_with(team)
        limits, resumes = problem.bound_grids(), resumes and kept is not None
        if start is None or (resumes and not predicted and not nest.complete):
            nest.begin(problem.force_grid(), problem.reference_grid(), report, limits, keep=self._keeps)
        elif resumes and not predicted:
            factor = self._unit / unit
            nest.change(problem.force_grid(), problem.reference_grid(), limits, factor=factor)
        else:
            nest.start(problem.project(start), problem.q, limits)
        goes_on = self._keeps and (start is None or predicted or resumes)
        self._nest, self._unit = nest if goes_on else None, unit
        return nest.solver


def nearly_solved(lattice: Arms, q: Grid, team: Team, give_up: Callable[[], bool], limits: Limits = NO_LIMITS) -> Grid:
    """Return a gap that cycles have brought close to rounding errors, or as far as a start is worth it."""
    solver = nested_start(lattice, q, lattice.layout.zeros(), team, limits=limits)
    for _ in range(_CYCLES_FOR_A_START):
        solver.relax()
        if solver.estimate <= solver.rest() or give_up():
            break
        solver.correct()
    return solver.omega
