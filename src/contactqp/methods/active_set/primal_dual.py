"""Primal-dual active set iteration, safeguarded by energy.

Hintermüller, Ito and Kunisch, *The primal-dual active set strategy as a semismooth Newton method*, SIAM J. Optim. 13
(2002): hold the contact nodes at their bounds, solve for the others, exchange those of the wrong sign. From a cold
start the contact set moves by a node or so a step, so that the steps grow with the mesh; hence five additions. Large
problems start from coarser ones (nested iteration over an algebraic hierarchy), and each of their steps makes a
correction by coarser ones, which moves the contact set by many nodes at once. Nodes are exchanged by projected
relaxation, which moves them by the size of their violation. Where the set creeps all the same, layers of nodes are
released together (`widening`). And the energy ½ωᵀGω + qᵀω falls in every step, by a line search where need be, so
that no set can come back. Where the line search leaves next to nothing of the steps, plain ones are made: for a
Z-matrix from then on, as without upper bounds they come to an end from any start, although the energy may rise; for
others a few in a solve.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ...algebra.power import generic_start, largest_growth
from ...algebra.sparse import SparseStiffness
from ...foundation.checks import Mask, Vector
from ...foundation.loading import load_modules
from ..amg.amg import Amg, Part, rows_of
from ..factors import DIRECT_SIZE
from ..parts import parts_of
from .widening import Widening

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from ..amg.amg import Transfer

_SWEEPS = 3
_JACOBI_SWEEPS = 8
_JACOBI_DAMPING = 0.8
"""For an M-matrix, whose D⁻¹G has no eigenvalue above two; for others it is less in proportion."""

_POWER_STEPS = 8
_LOOSE = 0.1
"""Part of the residual, in the preconditioner's norm, that conjugate gradients leave while the contact set moves."""

_COARSE_STEPS = 1
"""Steps on a coarse problem, which itself goes to coarser ones in each."""

_FEW_EXCHANGED = 0.001
"""Where fewer unknowns changed sides in the last step than this part, coarse problems have nothing to add."""
_MOST_ITERATIONS = 500
_CREEPING = 0.2
"""A line search that leaves less of a step than this hinders more than it helps."""

_LONG, _STALLED = 30, 0.8
"""Conjugate gradient iterations after which factors take over, if each has left so much of the residual in the
preconditioner's norm, or more."""

_PLAIN_STEPS = 5
"""Steps in a solve that may be made whatever they cost, out of a point where the energy lets none be made."""

_PATIENCE = 3
"""Steps in a row of rounding errors alone after which it ends, and of creeping ones after which the plain method
takes over."""
_ROUNDING = float(np.finfo(np.float64).eps)


_EMPTY = np.zeros(0)


@dataclass
class Step:
    """What a step did.

    Attributes
    ----------
    exchanged : int
        Nodes that changed sides.
    finished : bool
        Whether the contact set no longer changes and the equations of the free nodes are solved, both to rounding.
    """

    exchanged: int
    finished: bool


class ActiveSet:
    """The iteration on min ½ωᵀGω + qᵀω between bounds l ≤ 0 ≤ u.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Symmetric positive definite, with ascending column numbers.
    q : array, shape (n,)
    lower, upper : array, shape (n,)
        Bounds, -inf and inf where there is none; ``upper`` is empty where there is none at all.
    monotone : bool
        Whether it is a Z-matrix, hence an M-matrix, for which the plain method may take over.
    amg : callable, optional
        Returns a hierarchy for the matrix, by default a new one; it is called where one is needed.

    Attributes
    ----------
    omega : array, shape (n,)
        The gap.
    """

    def __init__(
        self,
        matrix: csr_array,
        q: Vector,
        lower: Vector,
        upper: Vector = _EMPTY,
        monotone: bool = True,
        amg: Callable[[], Amg] | None = None,
    ) -> None:
        self.matrix = matrix
        self._make_amg = amg or (lambda: Amg(matrix))
        self._diagonal = matrix.diagonal()
        self._parts = parts_of(matrix)
        self.direct = q.size <= DIRECT_SIZE or SparseStiffness(matrix).without_fill or self._parts.in_lines
        self._monotone, self._widening = monotone, Widening(matrix)
        self._rows = rows_of(matrix)
        self._part: Part | None = None
        self.restart(q, lower, upper)
        self._part_free = self._free

    def restart(self, q: Vector, lower: Vector, upper: Vector) -> None:
        """Go back to ω = 0 with other forces and other values of the bounds; the hierarchy is kept."""
        self.q, self._lower, self._upper = q, np.ascontiguousarray(lower), np.ascontiguousarray(upper)
        self.omega = np.zeros(q.size)
        self._free: Mask = np.isneginf(self._lower)
        self._at_upper: Mask = np.zeros(q.size, dtype=np.bool_)
        self._idle = self._creeping = 0
        self._exchanged = q.size
        self._guessed, self._plain_steps = False, 0
        self._seen: set[int] = set()
        self._widening.restart()

    def start(self, report: Callable[[str], None] = lambda text: None) -> None:
        """Start from the solution of coarser problems, whose unknowns are weights of smooth shapes.

        Up to some thousand unknowns it is ω = 0: the few steps that would be saved take less time than the hierarchy.
        """
        coarse = self._coarse
        if coarse is None:
            return
        report(f"coarse problem with {coarse.q.size} unknowns")
        transfer = coarse.transfer
        weight = transfer.down @ np.ones(self.q.size)
        lower = _averaged(transfer.down, weight, self._lower)
        upper = -_averaged(transfer.down, weight, -self._upper) if self._upper.size else self._upper
        coarse.restart(transfer.down @ self.q, lower, upper)
        coarse.start(report)
        coarse.take_steps(_COARSE_STEPS)
        self.omega, self._guessed = self.projected(transfer.up @ coarse.omega), True

    def start_from(self, gap: Vector) -> None:
        """Start from a gap, shape (n,), whose contact set is taken for nearly right: the first step is a fine one."""
        self.omega = gap
        self._take(*self._held())
        self._exchanged = 0

    def take_steps(self, most: int) -> None:
        """Do so many steps, or fewer where no node changes sides any more."""
        for _ in range(most):
            if self.step().exchanged == 0:
                break

    def step(self) -> Step:
        """Relax, so that nodes change sides, and solve the equations of the free nodes."""
        if self._monotone and self._creeping == _PATIENCE:
            return self._exchange()
        before = self.omega
        self._relax()
        self._correct()
        held = self._widening.widened(self._held(), (~self._free & ~self._at_upper, self._at_upper))
        self._exchanged = exchanged = self._take(*held)
        reaction = self._parts.product(self.omega) + self.q
        target = self._solve(reaction, _LOOSE if exchanged else 0.0)
        if target is None:
            self._turn_to_factors()
            return Step(exchanged, False)
        damping = self._move_to(target, reaction)
        if not self._monotone and exchanged == 0 and damping < _CREEPING and self._plain_steps < _PLAIN_STEPS:
            # Points between admissible ones never meet a bound that the target lies beyond. The plain step takes all
            # such nodes into contact; from too large a contact set the energy falls again.
            self._plain_steps += 1
            self.omega = self.projected(target)
        self._widening.learn(exchanged, self.omega, self._lower, self._upper)
        moved = float(np.abs(self.omega - before).max())
        rounding = 4 * _ROUNDING * float(np.abs(self.omega).max())
        self._idle = self._idle + 1 if moved <= rounding else 0
        self._creeping = self._creeping + 1 if damping < _CREEPING else 0
        finished = exchanged == 0 and self._admits(target, rounding) and self._presses()
        return Step(exchanged, finished or self._idle == _PATIENCE)

    def feasible(self) -> Vector:
        """Return ω between its bounds, which it may leave on its way."""
        return self.projected(self.omega)

    def projected(self, gap: Vector) -> Vector:
        """Return the admissible vector nearest to a gap."""
        above = np.maximum(self._lower, gap)
        return np.minimum(self._upper, above, out=above) if self._upper.size else above

    def _held(self) -> tuple[Mask, Mask]:
        """Return the nodes at their lower and at their upper bound."""
        at_lower = self.omega <= self._lower
        return at_lower, (self.omega >= self._upper) & ~at_lower if self._upper.size else np.zeros_like(at_lower)

    def _take(self, at_lower: Mask, at_upper: Mask) -> int:
        """Take nodes for in contact, and the others for free; return how many changed sides."""
        free = ~(at_lower | at_upper)
        exchanged = int(np.count_nonzero((free != self._free) | (at_upper != self._at_upper)))
        self._free, self._at_upper = free, at_upper
        return exchanged

    def _admits(self, target: Vector, rounding: float) -> bool:
        below = self._upper.size == 0 or bool((target <= self._upper + rounding).all())
        return below and bool((target >= self._lower - rounding).all())

    def _presses(self) -> bool:
        """Whether no contact node is pulled from its bound by more than rounding errors."""
        reaction = self._parts.product(self.omega) + self.q
        rounding = 8 * _ROUNDING * float((self._diagonal * np.abs(self.omega)).max())
        pressed = np.where(self._at_upper, -reaction, reaction) >= -rounding
        return bool(pressed[~self._free].all())

    def _exchange(self) -> Step:
        """Do a step of the plain method, which for an M-matrix needs no safeguard but rounding errors.

        Where nodes at which gap and reaction both vanish are exchanged for ever, a set comes back, and it ends.
        """
        at_bound = np.where(self._at_upper, self._upper, self._lower) if self._upper.size else self._lower
        self.omega = np.where(self._free, self.omega, at_bound)
        solved = self._solve(self._parts.product(self.omega) + self.q, 0.0)
        if solved is None:
            self._turn_to_factors()
            return Step(self.q.size, False)
        self.omega = solved
        reaction = self._parts.product(self.omega) + self.q
        leaves = np.where(self._at_upper, reaction > 0, reaction < 0)
        below, above = self._held()
        exchanged = self._take(
            np.where(self._free, below, ~leaves & ~self._at_upper),
            np.where(self._free, above, ~leaves & self._at_upper),
        )
        mark = hash((np.packbits(self._free).tobytes(), np.packbits(self._at_upper).tobytes()))
        finished = exchanged == 0 or mark in self._seen
        self._seen.add(mark)
        return Step(exchanged, finished)

    def _solve(self, reaction: Vector, left: float) -> Vector | None:
        """Solve the equations of the free nodes but for a part of the residual; zero means to rounding.

        None is returned where that takes too many iterations, and factors will do.
        """
        if self.direct:
            return self._solve_direct(reaction, refined=left == 0.0)
        return self._solve_iteratively(reaction, left)

    def _relax(self) -> None:
        """Do projected relaxation sweeps: Gauss-Seidel, or damped Jacobi where nothing is to be compiled."""
        if self.direct:
            for _ in range(_JACOBI_SWEEPS):
                correction = (self._parts.product(self.omega) + self.q) / self._diagonal
                self.omega = self.projected(self.omega - self._damping * correction)
            return
        load_modules("contactqp.methods.amg.sparse_kernels", kernels="active-set")
        from ..amg import sparse_kernels

        self.omega = np.array(self.omega)
        bounds = self._lower, self._upper
        sparse_kernels.projected_sweeps(*self._rows, 1 / self._diagonal, self.q, *bounds, self.omega, _SWEEPS)

    @cached_property
    def _amg(self) -> Amg:
        return self._make_amg()

    @cached_property
    def _coarse(self) -> Coarse | None:
        """The next coarser problem of corrections, None where there is none or none is needed."""
        level = None if self.direct else self._amg.levels[0]
        if level is None or level.coarser is None:
            return None
        return Coarse(self._amg.below(), level.coarser, level.candidate, self._monotone, self._upper.size > 0)

    def _correct(self) -> None:
        """Move to a better point by shapes of the coarse problem, which moves the contact set by many nodes at once."""
        if self._exchanged <= _FEW_EXCHANGED * self.q.size:
            return
        coarse = self._coarse
        if coarse is None:
            return
        reaction = self._parts.product(self.omega) + self.q
        above = self._upper - self.omega if self._upper.size else self._upper
        correction = coarse.correction(reaction, self._lower - self.omega, above)
        self._move_to(self.omega + correction, reaction)

    @cached_property
    def _damping(self) -> float:
        """A factor by which damped Jacobi sweeps, and projected ones, lower the energy.

        For an M-matrix D⁻¹G has no eigenvalue above two. Else it is below 2/ρ, ρ the largest eigenvalue of D⁻¹G, which
        is estimated from below, and at most the largest sum of moduli in a row of D^(-1/2)GD^(-1/2).
        """
        if self._monotone:
            return _JACOBI_DAMPING
        root = 1 / np.sqrt(self._diagonal)
        rows = np.repeat(np.arange(root.size), np.diff(self.matrix.indptr))
        moduli = np.abs(self.matrix.data) * root[rows] * root[self.matrix.indices]
        most = float(np.bincount(rows, weights=moduli).max())
        start = generic_start(root.size)
        estimate = largest_growth(lambda x: root * self._parts.product(root * x), start, _POWER_STEPS)
        return 2 * _JACOBI_DAMPING / max(2.0, min(most, 1.3 * estimate))

    def _solve_direct(self, reaction: Vector, refined: bool) -> Vector:
        """Return ω after a correction that takes the reaction of free nodes away, by a factorisation."""
        free = self._free
        target = self.omega.copy()
        if not free.any():
            return target
        solve = self._parts.solver(free)
        if solve is None:
            raise np.linalg.LinAlgError("the matrix of the free nodes is singular in double precision")
        target[free] -= solve(reaction[free])
        if refined:
            rest = (self._parts.product(target) + self.q)[free]
            target[free] -= solve(rest)
        return target

    def _solve_iteratively(self, reaction: Vector, left: float) -> Vector | None:
        """Return the same by preconditioned conjugate gradients that leave such a part of the residual."""
        keep = self._free
        target = self.omega.copy()
        residual = np.where(keep, -reaction, 0.0)
        floor = 4 * _ROUNDING * float((self._diagonal * np.abs(self.omega)).max())
        direction = np.zeros_like(target)
        before, first, done = 1.0, 0.0, 0
        part = None
        for done in range(_MOST_ITERATIONS):
            if float(np.abs(residual).max()) <= floor:
                break
            if part is None:
                part = self._free_part()
            preconditioned = part.cycle(residual)
            product = float((residual * preconditioned).sum())
            direction *= product / before
            direction += preconditioned
            before, first = product, first or product
            if product <= left**2 * first:
                break
            image = np.where(keep, self._parts.product(direction), 0.0)
            curvature = float((direction * image).sum())
            if not curvature > 0:
                break
            length = product / curvature
            target += length * direction
            residual -= length * image
            if done == _LONG and before > _STALLED ** (2 * done) * first and self._parts.affordable:
                return None
        return target

    def _turn_to_factors(self) -> None:
        """Go on by factors: aggregates of constants are no good for bending, whose energy does not see slopes.

        Then a start from coarse problems is none either.
        """
        if self._guessed:
            self.restart(self.q, self._lower, self._upper)
        self.direct = True

    def _free_part(self) -> Part:
        """Return what does cycles for the free nodes."""
        if self._part is None or not np.array_equal(self._part_free, self._free):
            self._part, self._part_free = self._amg.part(self._free), self._free
        return self._part

    def _move_to(self, target: Vector, reaction: Vector) -> float:
        """Go to the projected ``target``, or to the point of least energy on the way; return the part of it gone.

        What projection leaves at nodes that have met their bound is short-waved, and costs so much energy that the
        line search may leave next to nothing of a good step. Relaxation takes it away, so where that ends lower, the
        whole step is made.
        """
        projected = self.projected(target)
        way = projected - self.omega
        slope = float((way * reaction).sum())
        curvature = float((way * self._parts.product(way)).sum())
        if slope + curvature <= 0 or curvature <= 0:
            self.omega = projected
            return 1.0
        damping = max(0.0, -slope / curvature)
        before, self.omega = self.omega, projected
        self._relax()
        if self._gain(self.omega - before, reaction) < damping * (slope + 0.5 * damping * curvature):
            return 1.0
        self.omega = before + damping * way
        return damping

    def _gain(self, way: Vector, reaction: Vector) -> float:
        """Return by how much the energy rises on a way from where there is such a reaction."""
        return float((way * (reaction + 0.5 * self._parts.product(way))).sum())


class Coarse(ActiveSet):
    """A problem whose unknowns are weights of smooth shapes, each of them of a group of finer unknowns.

    Parameters
    ----------
    amg : Amg
        The hierarchy from the coarse level on.
    transfer : Transfer
        The way to it.
    candidate : array, shape (n,)
        The finer level's.
    monotone : bool
        See `ActiveSet`.
    bounded_above : bool
        Whether there are upper bounds.
    """

    def __init__(self, amg: Amg, transfer: Transfer, candidate: Vector, monotone: bool, bounded_above: bool) -> None:
        self.transfer = transfer
        level = amg.levels[0]
        size, grouped = level.candidate.size, np.flatnonzero(transfer.group >= 0)
        none = np.full(size, np.inf)
        super().__init__(level.matrix, np.zeros(size), -none, none if bounded_above else _EMPTY, monotone, lambda: amg)
        self.direct = level.coarser is None
        self._candidate, self._grouped, self._group = candidate[grouped], grouped, transfer.group[grouped]
        self._shape = level.candidate

    def correction(self, reaction: Vector, lower: Vector, upper: Vector) -> Vector:
        """Return a sum of shapes that lowers the energy at a point with such a reaction.

        It is that of the bounds which each group has in common: (Mandel, *A multilevel iterative method for symmetric,
        positive definite linear complementarity problems*, Applied Mathematics and Optimization 11, 1984), of the
        groups' tentative shapes, before they are smoothed; so the sum leaves the bounds by little.

        Parameters
        ----------
        reaction : array, shape (n,)
            Of the finer unknowns, at the point.
        lower, upper : array, shape (n,)
            Bounds of the correction, ≤ 0 and ≥ 0; ``upper`` is empty where there is none at all.
        """
        above = -self._common(-upper) if upper.size else upper
        self.restart(self.transfer.down @ reaction, self._common(lower), above)
        self.take_steps(_COARSE_STEPS)
        return np.asarray(self.transfer.up @ self.feasible())

    def _common(self, lower: Vector) -> Vector:
        """Return the bounds of the weights by which no unknown of a group falls below its lower bound."""
        common = np.full(self.q.size, -np.inf)
        np.maximum.at(common, self._group, lower[self._grouped] / self._candidate)
        return np.asarray(common * self._shape)


def _averaged(down: csr_array, weight: Vector, bound: Vector) -> Vector:
    """Return the mean of lower bounds over the unknowns of each coarse one; -inf where most of them have none."""
    known = np.isfinite(bound)
    mean = (down @ np.where(known, bound, 0.0)) / weight
    return np.where((down @ known.astype(np.float64)) / weight > 0.5, mean, -np.inf)
