"""The hierarchy of a lattice whose arms differ: interpolation follows the arms, see `weighted_kernels`.

The weights are those of the lattice without contact, and stay; only the operators are truncated at contact nodes.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...foundation.loading import once
from ...foundation.threads import Team
from .arms import Arms
from .galerkin_kernels import coarsen_lattice
from .hierarchy import VISITED, Hierarchy, Level, plans
from .lattice_kernels import ArmKind, exchange_kernels, lattice_kernels
from .level_kernels import level_kernels, transfer_kernels
from .weighted_kernels import weighted_kernels


class WeightedHierarchy(Hierarchy):
    """See `Hierarchy`."""

    def __init__(self, lattice: Arms, team: Team) -> None:
        self._kernels = weighted_kernels()
        super().__init__(lattice, team)

    def _set_up(self) -> None:
        """Find the weights, and with them the operators of the lattice without contact."""
        lattice, first, kernels = self.lattice, self.levels[0], self._kernels
        weights = first.weights
        strips = self._cells(first)
        place = lattice.layout.mask.copy(), *self._arms()
        self.team.run(kernels.weigh_lattice, strips, *place, weights, *first.factors)
        if first.factors == (2, 2):
            self.team.run(kernels.weigh_lattice_cells, strips, *place, weights)
        self._coarsen_lattice()
        for finer, level in pairwise(self.levels):
            strips = self._cells(level)
            self.team.run(kernels.weigh_level, strips, finer.stencil, level.weights, *level.factors)
            if level.factors == (2, 2):
                self.team.run(kernels.weigh_level_cells, strips, finer.stencil, level.weights)
            self._coarsen_level(finer, level)
        last = self.levels[-1].plan
        if self._works_on_last:
            self._factor = np.zeros((last.rows * last.columns, last.columns + 2))
        self._factorise()
        self.settled()

    def update(self) -> None:
        """See `Hierarchy.update`."""
        self._coarsen_lattice()
        for finer, level in pairwise(self.levels):
            self._coarsen_level(finer, level)
        self._factorise()
        self.settled()

    def _factorise(self) -> None:
        last = self.levels[-1]
        if self._works_on_last and last.changed.any():
            self._kernels.factorise(last.stencil, self._factor)

    def _arms(self) -> list[np.ndarray]:
        return [np.asarray(arms) for arms in self.lattice.stiffnesses]

    def _cells(self, level: Level) -> list[tuple[int, int]]:
        return self.team.strips(0, level.weights.shape[1], level.plan.columns)

    def _coarsen_lattice(self) -> None:
        fine = self.free, self.changed, *self._arms()
        self._coarsen(self.levels[0], self._kernels.coarsen_lattice, *fine)

    def _coarsen_level(self, finer: Level, level: Level) -> None:
        self._coarsen(level, self._kernels.coarsen_level, finer.stencil, finer.changed)

    def _coarsen(self, level: Level, kernel: Any, *finer: Any, more: tuple[Any, ...] = ()) -> None:
        def run(stencil: NDArray[Any], changed: NDArray[Any]) -> None:
            self.team.run(kernel, level.given, *finer, level.weights, stencil, changed, *level.factors, *more)

        level.coarsen(run, level.changed)
        self.team.run(self._kernels.set_factors, level.about, level.stencil, level.changed)

    def cycle(self, depth: int = 0, *, full: bool = True) -> None:
        """See `Hierarchy.cycle`: a cycle that solves on the next coarser level by two steps of conjugate gradients.

        Where stiff blocks meet at their corners, a coarse level takes some couplings for several times too stiff. A
        cycle would reduce the error of what they hold by no more than a third, conjugate gradients find the right
        length (the K-cycle: Notay and Vassilevski 2008).
        """
        level = self.levels[depth]
        if depth == len(self.levels) - 1:
            self._solve_last(level)
            return
        run, coarse = self.team.run, self.levels[depth + 1]
        smoothing = level_kernels("float64", "float64")
        run(smoothing.smooth_from_zero, level.about, level.stencil, level.residual, level.correction)
        self._restrict(level, coarse)
        self._solve(depth + 1)
        self._interpolate(level, coarse)
        run(smoothing.smooth, level.strips, level.stencil, level.residual, level.correction, level.spare)
        level.correction, level.spare = level.spare, level.correction
        level.within.share(level.correction, reach=VISITED)

    def _solve_coarsest(self, level: Level) -> None:
        self._kernels.solve_coarsest(self._factor, level.residual, level.correction)

    def _solve(self, depth: int) -> None:
        """Write the ``correction`` of a level by two steps of conjugate gradients; its ``residual`` is overwritten."""
        self.cycle(depth)
        if depth == len(self.levels) - 1:
            return
        level, run, kernels = self.levels[depth], self.team.run, self._kernels
        first = level.correction
        blocks, sums = level.within.blocks, level.within.sums
        energy, work = sums(run(kernels.apply, blocks, level.stencil, first, level.image, level.residual))
        if not energy > 0.0:
            return
        length = work / energy
        run(kernels.subtract, level.strips, level.residual, length, level.image)
        level.within.share(level.residual, reach=VISITED)
        level.correction, level.kept = level.kept, first
        self.cycle(depth)
        second = level.correction
        state = level.stencil, second, level.image, level.residual, level.spare
        own, common, work = sums(run(kernels.apply_again, blocks, *state))
        rest = own - common * common / energy
        factor = work / rest if rest > 0.0 else 0.0
        run(kernels.combine, level.about, second, factor, level.kept, length - factor * common / energy)

    def _restrict(self, level: Level, coarse: Level) -> None:
        state = level.stencil, level.residual, level.correction
        below = coarse.beneath(coarse.residual), *coarse.factors, coarse.weights
        self.team.run(self._kernels.restrict, coarse.given, *state, *below)
        coarse.part.share(coarse.residual, reach=VISITED)

    def _interpolate(self, level: Level, coarse: Level) -> None:
        coarse.part.hand_back(coarse.correction, VISITED)
        given = level.correction, coarse.beneath(coarse.correction), *coarse.factors, coarse.weights
        self.team.run(self._kernels.add_interpolated, level.beside, *given)


def hierarchy_of(lattice: Arms, team: Team) -> Hierarchy:
    """Return the hierarchy of a lattice: one that follows the arms where they differ."""
    return WeightedHierarchy(lattice, team) if lattice.varying else Hierarchy(lattice, team)


def load_kernels(lattice: Arms) -> None:
    """Compile or load whatever a solution on ``lattice`` and its coarser ones calls."""
    kind, precisions = lattice.kind, tuple(plan.precision for plan in plans(lattice))
    once(("multigrid", kind, precisions), lambda: _load_kernels(kind, precisions), "multigrid")


def _load_kernels(kind: ArmKind, precisions: tuple[str, ...]) -> None:
    lattice_kernels(kind)
    for own in precisions:
        exchange_kernels(kind, own)
        level_kernels(own, "float64" if kind == "varying" else "float32")
    if kind == "varying":
        weighted_kernels()
        return
    coarsen_lattice(kind)
    for own, coarser in pairwise(precisions):
        transfer_kernels(own, coarser)
