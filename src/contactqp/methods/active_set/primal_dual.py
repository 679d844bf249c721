"""Primal-dual active set iteration, safeguarded by energy.

Hintermüller, Ito and Kunisch, *The primal-dual active set strategy as a semismooth Newton method*, SIAM J. Optim. 13
(2002): hold the contact nodes at zero, solve for the others, exchange those of the wrong sign. From a
cold start the contact set moves by a node or so a step, so that the steps grow with the mesh; hence three additions.
The start comes from coarser problems (nested iteration over an algebraic hierarchy). Nodes are exchanged by
projected relaxation, which moves them by the size of their violation. And the energy ½ωᵀGω + qᵀω falls in every
step, by a line search where need be, so that no set can come back. Where the line search leaves next to nothing of the
steps, the plain method takes over, which for an M-matrix is finite from any start, although not downhill.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...foundation.checks import Mask, Vector
from ..amg.amg import Amg, rows_of

if TYPE_CHECKING:
    from scipy.sparse import csr_array

DIRECT_SIZE = 4000
"""Up to this many unknowns linear systems are factorised, and nothing needs compiling."""

_SWEEPS = 3
_JACOBI_SWEEPS = 8
_JACOBI_DAMPING = 0.8
_STALE = 0.05
"""Part of the unknowns that may have changed sides before a preconditioner is made anew."""

_LOOSE_ITERATIONS = 2, 6
"""Conjugate gradient iterations a step while the contact set moves, and while only few nodes still do."""

_FEW = 0.005
"""Part of the unknowns that counts as few."""

_COARSE_STEPS = 3
_MOST_ITERATIONS = 500
_CREEPING = 0.2
"""A line search that leaves less of a step than this hinders more than it helps."""

_PATIENCE = 3
"""Steps in a row of rounding errors alone after which it ends, and of creeping ones after which the plain method
takes over."""
_ROUNDING = float(np.finfo(np.float64).eps)


@dataclass
class Step:
    """What a step did.

    Attributes
    ----------
    exchanged : int
        Nodes that changed sides.
    finished : bool
        Whether the contact set is at rest and the equations of the open nodes are solved, both to rounding.
    """

    exchanged: int
    finished: bool


class ActiveSet:
    """The iteration on min ½ωᵀGω + qᵀω, ω ≥ 0 at supported nodes.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Symmetric positive definite, with ascending column numbers.
    q : array, shape (n,)
    supported : array of bool, shape (n,)
    candidate : array, shape (n,), or None
        See `Amg`.

    Attributes
    ----------
    omega : array, shape (n,)
        The gap.
    """

    def __init__(self, matrix: csr_array, q: Vector, supported: Mask, candidate: Vector | None = None) -> None:
        self.matrix, self.q, self.supported, self._candidate = matrix, q, supported, candidate
        self.omega = np.zeros(q.size)
        self._diagonal = matrix.diagonal()
        self._lower = np.where(supported, 0.0, -np.inf)
        # Where unknowns hang together in lines, a factorisation has no fill.
        self.direct = q.size <= DIRECT_SIZE or int(np.diff(matrix.indptr).max()) <= 3
        self._rows = rows_of(matrix)
        self._open: Mask = ~supported
        self._idle = self._creeping = 0
        self._seen: set[int] = set()
        self._amg: Amg | None = None
        self._amg_open: Mask = ~supported

    def start(self, report: Callable[[str], None] = lambda text: None) -> None:
        """Start from the solution of coarser problems, whose unknowns are weights of smooth shapes."""
        if self.q.size <= 1:
            return
        hierarchy = Amg(self.matrix, self._candidate)
        forces, supports = [self.q], [self.supported.astype(np.float64)]
        for down, _ in hierarchy.transfers:
            forces.append(down @ forces[-1])
            supports.append(down @ supports[-1] / (down @ np.ones(supports[-1].size)))
        gap = np.zeros(forces[-1].size)
        for depth in range(len(hierarchy.transfers), 0, -1):
            report(f"coarse problem with {forces[depth].size} unknowns")
            coarse = ActiveSet(hierarchy.levels[depth].matrix, forces[depth], supports[depth] > 0.5)
            coarse.omega = np.maximum(coarse._lower, gap)
            for _ in range(_COARSE_STEPS):
                if coarse.step().exchanged == 0:
                    break
            _, up = hierarchy.transfers[depth - 1]
            gap = up @ coarse.omega
        self.omega = np.maximum(self._lower, gap)

    def step(self) -> Step:
        """Relax, so that nodes change sides, and solve the equations of the open nodes."""
        if self._creeping == _PATIENCE:
            return self._exchange()
        before = self.omega
        self._relax()
        now_open = ~self.supported | (self.omega > 0)
        exchanged = int(np.count_nonzero(now_open != self._open))
        self._open = now_open
        reaction = self.matrix @ self.omega + self.q
        target = self._solve(reaction, self._iterations(exchanged))
        damping = self._move_to(target, reaction)
        moved = float(np.abs(self.omega - before).max())
        rounding = 4 * _ROUNDING * float(np.abs(self.omega).max())
        self._idle = self._idle + 1 if moved <= rounding else 0
        self._creeping = self._creeping + 1 if damping < _CREEPING else 0
        finished = exchanged == 0 and bool((target >= self._lower - rounding).all()) and self._rests()
        return Step(exchanged, finished or self._idle == _PATIENCE)

    def feasible(self) -> Vector:
        """Return ω without negative gaps at supported nodes, which it may have on its way."""
        return np.maximum(self._lower, self.omega)

    def _rests(self) -> bool:
        """Whether no shut node is pulled open by more than rounding errors."""
        reaction = self.matrix @ self.omega + self.q
        rounding = 8 * _ROUNDING * float((self._diagonal * np.abs(self.omega)).max())
        return bool((reaction >= -rounding)[~self._open].all())

    def _exchange(self) -> Step:
        """Do a step of the plain method, which for an M-matrix needs no safeguard but rounding errors.

        Where nodes at which gap and reaction both vanish are exchanged for ever, a set comes back, and it ends.
        """
        self.omega = np.where(self._open, self.omega, 0.0)
        self.omega = self._solve(self.matrix @ self.omega + self.q, _MOST_ITERATIONS)
        reaction = self.matrix @ self.omega + self.q
        now_open = ~self.supported | np.where(self._open, self.omega > 0, reaction < 0)
        exchanged = int(np.count_nonzero(now_open != self._open))
        self._open = now_open
        mark = hash(np.packbits(now_open).tobytes())
        finished = exchanged == 0 or mark in self._seen
        self._seen.add(mark)
        return Step(exchanged, finished)

    def _iterations(self, exchanged: int) -> int:
        if exchanged == 0:
            return _MOST_ITERATIONS
        return _LOOSE_ITERATIONS[exchanged <= _FEW * self.q.size]

    def _solve(self, reaction: Vector, iterations: int) -> Vector:
        return self._solve_direct(reaction) if self.direct else self._solve_iteratively(reaction, iterations)

    def _relax(self) -> None:
        """Do projected relaxation sweeps: Gauss-Seidel, or damped Jacobi where nothing is to be compiled."""
        if self.direct:
            for _ in range(_JACOBI_SWEEPS):
                correction = (self.matrix @ self.omega + self.q) / self._diagonal
                self.omega = np.maximum(self._lower, self.omega - _JACOBI_DAMPING * correction)
            return
        from ..amg import sparse_kernels

        self.omega = np.array(self.omega)
        sparse_kernels.projected_sweeps(*self._rows, 1 / self._diagonal, self.q, self._lower, self.omega, _SWEEPS)

    def _solve_direct(self, reaction: Vector) -> Vector:
        """Return ω after a correction that takes the reaction of open nodes away, by a factorisation."""
        from scipy.sparse import linalg

        chosen = np.flatnonzero(self._open)
        target = self.omega.copy()
        if not chosen.size:
            return target
        part = self.matrix[chosen][:, chosen].tocsc()
        factors = linalg.splu(part, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        target[chosen] -= factors.solve(reaction[chosen])
        rest = (self.matrix @ target + self.q)[chosen]
        target[chosen] -= factors.solve(rest)
        return target

    def _solve_iteratively(self, reaction: Vector, iterations: int) -> Vector:
        """Return the same by at most so many preconditioned conjugate gradient iterations; rounding errors end them."""
        keep = self._open
        target = self.omega.copy()
        residual = np.where(keep, -reaction, 0.0)
        floor = 4 * _ROUNDING * float((self._diagonal * np.abs(self.omega)).max())
        direction = np.zeros_like(target)
        before = 1.0
        amg = None
        for _ in range(iterations):
            if float(np.abs(residual).max()) <= floor:
                break
            if amg is None:
                amg = self._preconditioner(iterations < _MOST_ITERATIONS)
            preconditioned = amg.cycle(residual)
            product = float((residual * preconditioned).sum())
            direction *= product / before
            direction += preconditioned
            before = product
            image = np.where(keep, self.matrix @ direction, 0.0)
            curvature = float((direction * image).sum())
            if not curvature > 0:
                break
            length = product / curvature
            target += length * direction
            residual -= length * image
        return target

    def _preconditioner(self, loosely: bool) -> Amg:
        """Return a hierarchy for the open nodes; loosely, one that was made for nearly the same."""
        changed = np.count_nonzero(self._amg_open != self._open)
        if self._amg is None or changed > (_STALE * self.q.size if loosely else 0):
            self._amg, self._amg_open = Amg(self.matrix, self._candidate, self._open), self._open
        else:
            self._amg.restrict_to(self._open)
        return self._amg

    def _move_to(self, target: Vector, reaction: Vector) -> float:
        """Go to the projected ``target``, or to the point of least energy on the way; return the part of it gone."""
        projected = np.maximum(self._lower, target)
        way = projected - self.omega
        slope = float((way * reaction).sum())
        curvature = float((way * (self.matrix @ way)).sum())
        if slope + curvature <= 0 or curvature <= 0:
            self.omega = projected
            return 1.0
        damping = max(0.0, -slope / curvature)
        self.omega = self.omega + damping * way
        return damping
