"""Hierarchy: Galerkin operators of a lattice truncated at its contact nodes, and the linear cycle through them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...foundation.threads import Team
from ..multigrid import galerkin_kernels
from .arms import Arms, coarsening
from .level_kernels import LevelKernels, TransferKernels, level_kernels, transfer_kernels
from .rows import DIRECT, Rows

_COARSEST_SWEEPS = 10

VISITED = 2
"""So far vectors are looked at on a visit of their level, see `Hierarchy.cycle`."""

COARSENED = 4
"""So far an operator is looked at when the next coarser one is made."""

_SINGLE_PRECISION_REACH = 5e5
"""Up to this error per rounding error (see `lattice.Net.reach`) a correction may be rounded to single precision.

Twice the error a unit of residual makes, times 6e-8, is what a cycle loses: 0.03 here.
"""


@dataclass(frozen=True)
class Plan:
    """Shape of a coarse level, how it follows from the finer one, and the precision of its vectors.

    Attributes
    ----------
    rows, columns : int
    row_coarsening, column_coarsening : int
    precision : str
        "float32" or "float64".
    weighted : bool
        Whether interpolation follows the arms, see `weighted_kernels`; else it is bilinear.
    """

    rows: int
    columns: int
    row_coarsening: int
    column_coarsening: int
    precision: str
    weighted: bool

    @property
    def points(self) -> int:
        """Points of the whole level, with the ring about it."""
        return (self.rows + 2) * (self.columns + 2)

    @property
    def stencil_precision(self) -> str:
        """Precision of its operator."""
        return "float64" if self.weighted else "float32"


class Level:
    """One coarse level: its operator and the vectors of a cycle.

    Parameters
    ----------
    plan : Plan
    team : Team
    above : Rows
        Of the level above, or of the lattice.
    finer : Plan, optional
        Of the level above; None for the first one, above which the lattice is.

    Attributes
    ----------
    part : Rows
        The rows that its arrays hold, as those see them who divide the level above.
    within : Rows
        The same rows, as those see them who work on the level.
    strips, beside, about : list of (int, int)
        The rows that are worked on; those and the next ones on either side, and the next two.
    given : list of (int, int)
        Its own rows, as kernels number them that come from the level above: see `beneath`.
    weights : array, shape (8, rows, columns + 2)
        Those of the interpolation, on rows that are numbered so; without any rows where it is bilinear.
    """

    def __init__(self, plan: Plan, team: Team, above: Rows, finer: Plan | None = None) -> None:
        self.plan, self._finer = plan, finer
        self.factors = plan.row_coarsening, plan.column_coarsening
        self.part = above.coarser(plan.rows, plan.columns, plan.row_coarsening)
        self.within = self.part.alone
        shape = (self.part.height, plan.columns + 2)
        self.strips, self.beside, self.about = (
            team.strips(*self.within.near(reach), plan.columns) for reach in range(3)
        )
        highest = above.offset // plan.row_coarsening
        self._shift = highest - self.part.offset
        self.given = team.strips(self.part.own[0] - highest, self.part.own[1] - highest, plan.columns)
        self.stencil = np.zeros((6, *shape), dtype=plan.stencil_precision)
        weighed = (8, self.part.height - self._shift, plan.columns + 2)
        self.weights = np.zeros(weighed if plan.weighted else (0, 0, 0), dtype=np.float32)
        self.exchange_weights: Any = self.weights if plan.weighted else 0.0
        self.kind = np.zeros((0, 0) if plan.weighted else shape, dtype=np.uint8)
        self.changed = np.zeros(self.part.height, dtype=np.uint8)
        self.constant = np.zeros(6, dtype=np.float32)
        self.residual, self.correction, self.spare = (np.zeros(shape, dtype=plan.precision) for _ in range(3))
        self.kept, self.image = (np.zeros(shape if plan.weighted else (0, 0)) for _ in range(2))

    def beneath(self, array: NDArray[Any]) -> NDArray[Any]:
        """Return the rows of an array from where the arrays of the level above begin, as kernels count them."""
        return array[self._shift :] if self._shift else array

    def coarsen(self, run: Callable[..., None], *marks: NDArray[np.uint8]) -> None:
        """Let a kernel write the operator's own rows, with marks of what has changed in them, and share these.

        Parameters
        ----------
        run : callable
            Called with the operator, and the marks.
        marks : array
            Kinds of points, if there are any, and last the rows that have changed.
        """
        beneath = [self.beneath(mark) for mark in marks]
        changed = beneath[-1]
        if not self._shift:
            run(self.stencil, *beneath)
        else:
            written = np.zeros((6, changed.size, self.stencil.shape[2]), dtype=self.stencil.dtype)
            run(written, *beneath)
            rows = self.given[0][0] + np.flatnonzero(changed[self.given[0][0] : self.given[-1][1]])
            self.stencil[:, rows + self._shift] = written[:, rows]
        # The factors of smoothing, which follow, are those of who works on a row.
        self.part.share(self.stencil[:-1], reach=COARSENED, axis=1)
        self.part.share(*marks, reach=COARSENED)

    @cached_property
    def kernels(self) -> LevelKernels:
        """The passes over it; looked up once, as a cycle visits small levels dozens of times."""
        return level_kernels(self.plan.precision, self.plan.stencil_precision)

    @cached_property
    def transfers(self) -> TransferKernels:
        """The passes between the level above and it."""
        assert self._finer is not None
        return transfer_kernels(self._finer.precision, self.plan.precision)


class Hierarchy:
    """The coarse levels below a lattice, finest first, down to the first one on which the process is idle.

    Attributes
    ----------
    free : array of uint8, shape (rows + 2, columns + 2)
        At the free nodes 1, or 2 where there are springs; at those in contact, and where springs are stiff, 0: there
        the operators are truncated.
    changed : array of uint8, shape (rows + 2,)
        1 for the rows in which `free` has changed since the operators were computed.
    stale : bool
        Whether there are any.
    """

    def __init__(self, lattice: Arms, team: Team) -> None:
        self.lattice, self.team = lattice, team
        self.free: NDArray[np.uint8] = lattice.layout.zeros(np.uint8)
        self.free[1:-1, 1:-1] = lattice.marks()
        self.changed, self.stale = np.ones(lattice.part.height, dtype=np.uint8), True
        self.levels: list[Level] = []
        self._plans = plans(lattice)
        above = lattice.part
        for finer, plan in pairwise([None, *self._plans]):
            if plan is not None and not above.idle:
                self.levels.append(Level(plan, team, above, finer))
                above = self.levels[-1].within
        self._works_on_last = not above.idle
        self._set_up()

    def update(self) -> None:
        """Compute the rows of all operators that changed rows have a share in."""
        first, lattice = self.levels[0], self.lattice
        coarsen = galerkin_kernels.coarsen_lattice(lattice.kind)
        self._coarsen(first, coarsen, self.free, self.changed, *lattice.stiffnesses, more=(True,))
        for finer, level in pairwise(self.levels):
            self._coarsen(level, galerkin_kernels.coarsen_level, finer.stencil, finer.kind, finer.changed)
        self.settled()

    def settled(self) -> None:
        """Take note that the operators are those of the free nodes."""
        self.changed[:] = 0
        self.stale = False

    def _coarsen(self, level: Level, kernel: Any, *finer: Any, more: tuple[Any, ...] = ()) -> None:
        def run(stencil: NDArray[Any], kind: NDArray[Any], changed: NDArray[Any]) -> None:
            operator = level.constant, stencil, kind, changed
            self.team.run(kernel, level.given, *finer, *operator, *level.factors, *more)

        level.coarsen(run, level.kind, level.changed)
        operator = level.stencil, level.kind, level.changed, level.constant
        self.team.run(galerkin_kernels.set_factors, level.about, *operator)

    def cycle(self, depth: int = 0, *, full: bool = True) -> None:
        """Do a cycle from zero for the ``residual`` of the level; its ``correction`` is the result.

        An F-cycle: the next coarser level is corrected by an F-cycle and then by a V-cycle, which costs little more
        than a V-cycle where each level has a quarter of the points, and half of the contraction factor.

        Where others hold the rows beside, what they hold is known two rows far, of ``residual`` and ``correction``; the
        first smoothing and the interpolation go as far as what follows looks, so that two messages a visit suffice.
        """
        level = self.levels[depth]
        if depth == len(self.levels) - 1:
            self._solve_last(level)
            return
        run, coarse = self.team.run, self.levels[depth + 1]
        kernels = level.kernels
        run(kernels.smooth_from_zero, level.about, level.stencil, level.residual, level.correction)
        for full_below in (True, False) if full else (False,):
            self._restrict(level, coarse)
            self.cycle(depth + 1, full=full_below)
            self._interpolate(level, coarse)
            run(kernels.smooth, level.strips, level.stencil, level.residual, level.correction, level.spare)
            level.correction, level.spare = level.spare, level.correction
            level.within.share(level.correction, reach=VISITED)

    def _solve_last(self, level: Level) -> None:
        if self._works_on_last:
            self._solve_coarsest(level)

    def _solve_coarsest(self, level: Level) -> None:
        level.kernels.solve_coarsest(level.stencil, level.residual, level.correction, _COARSEST_SWEEPS)

    def _restrict(self, level: Level, coarse: Level) -> None:
        state = level.stencil, level.residual, level.correction
        self.team.run(coarse.transfers.restrict, coarse.given, *state, coarse.beneath(coarse.residual), *coarse.factors)
        coarse.part.share(coarse.residual, reach=VISITED)

    def _interpolate(self, level: Level, coarse: Level) -> None:
        coarse.part.hand_back(coarse.correction, VISITED)
        vectors = level.correction, coarse.beneath(coarse.correction)
        self.team.run(coarse.transfers.add_interpolated, level.beside, *vectors, *coarse.factors)

    @cached_property
    def points(self) -> float:
        """Points of all levels over the lattice's nodes."""
        return sum(plan.points for plan in self._plans) / self.lattice.size

    @cached_property
    def cycle_work(self) -> float:
        """Passes of a `cycle`, each counted by its points over the lattice's nodes.

        A level is visited once more than the one above it; a visit is four passes (two steps of Jacobi's method, the
        residual and the interpolation).
        """
        visits = sum((depth + 1) * plan.points for depth, plan in enumerate(self._plans))
        return 4 * visits / self.lattice.size

    def _set_up(self) -> None:
        """Compute each level's operator far from frame and contact, on a small lattice without either."""
        width = 9
        middle, every = width // 2 + 1, np.ones(2 * width + 3, dtype=np.uint8)
        example = np.ones((every.size, every.size), dtype=np.uint8)
        stencil = np.zeros((6, width + 2, width + 2), dtype=np.float32)
        kind, rows = np.zeros((width + 2, width + 2), dtype=np.uint8), np.ones(width + 2, dtype=np.uint8)
        target = np.zeros(6, dtype=np.float32), stencil, kind, rows
        lattice, first = self.lattice, self.levels[0]
        arms = lattice.across, lattice.along, 0.0
        coarsen = galerkin_kernels.coarsen_lattice("equal")
        coarsen(example, every, *arms, *target, *first.factors, False, 1, width + 1)
        galerkin_kernels.set_factors(stencil, kind, rows, target[0], 1, width + 1)
        first.constant = stencil[:, middle, middle].copy()
        for finer, level in pairwise(self.levels):
            everywhere = np.ascontiguousarray(np.broadcast_to(finer.constant[:, None, None], (6, *example.shape)))
            mixed = np.full(example.shape, 2, dtype=np.uint8)
            galerkin_kernels.coarsen_level(everywhere, mixed, every, *target, *level.factors, 1, width + 1)
            galerkin_kernels.set_factors(stencil, kind, rows, target[0], 1, width + 1)
            level.constant = stencil[:, middle, middle].copy()


def plans(lattice: Arms) -> list[Plan]:
    """Return levels down to the smallest; a lattice that is not coarsened gets one of its own size."""
    rows, columns = lattice.rows, lattice.columns
    across, along = lattice.typical_arms
    reach = lattice.reach * lattice.stiffest_corrected
    found: list[Plan] = []
    while True:
        down, right = coarsening(rows, columns, across, along)
        if down * right == 1 and found:
            return found
        precision = "float64" if lattice.varying or reach > _SINGLE_PRECISION_REACH else "float32"
        rows, columns = rows // down, columns // right
        across, along = across * down / right, along * right / down
        reach /= down * right
        found.append(Plan(rows, columns, down, right, precision, lattice.varying))
        if down * right == 1 or (lattice.varying and rows * columns <= DIRECT):
            return found
