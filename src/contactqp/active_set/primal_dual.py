"""Primal-dual active set iteration, safeguarded by energy.

Hintermüller, Ito and Kunisch, *The primal-dual active set strategy as a semismooth Newton method*, SIAM J. Optim. 13
(2002), algorithm 2.1: hold the contact nodes at zero, solve for the others, exchange those of the wrong sign. From a
cold start the contact set moves by a node or so a step, so that the steps grow with the mesh; hence three additions.
The start comes from coarser problems (nested iteration over an algebraic hierarchy). Nodes are exchanged by
projected relaxation, which moves them by the size of their violation. And the energy ½ωᵀGω + qᵀω falls in every
step, by a line search where need be, so that no set can come back. Where the line search leaves next to nothing of the
steps, the plain method takes over, which for an M-matrix is finite from any start.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .._checks import Mask, Vector
from .amg import Amg

if TYPE_CHECKING:
    from scipy.sparse import csr_array

DIRECT_SIZE = 4000
"""Up to this many unknowns linear systems are factorised, and nothing needs compiling."""

_SWEEPS = 3
_JACOBI_SWEEPS = 8
_JACOBI_DAMPING = 0.8
_STALE = 0.05
"""Part of the unknowns that may have changed sides before a preconditioner is made anew."""

_LOOSE = 0.3
"""Factor by which the residual is reduced while the contact set moves."""

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
        self.direct = q.size <= DIRECT_SIZE or matrix.nnz <= 3 * q.size
        self._rows = matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32), matrix.data
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
        self._relax()
        now_open = ~self.supported | (self.omega > 0)
        exchanged = int(np.count_nonzero(now_open != self._open))
        self._open = now_open
        reaction = self.matrix @ self.omega + self.q
        target = self._solve(reaction, exchanged > 0)
        damping, moved = self._move_to(target, reaction)
        rounding = 4 * _ROUNDING * float(np.abs(self.omega).max())
        admissible = bool((target >= self._lower - rounding).all())
        self._idle = self._idle + 1 if moved <= rounding else 0
        self._creeping = self._creeping + 1 if damping < _CREEPING else 0
        return Step(exchanged, (exchanged == 0 and admissible) or self._idle == _PATIENCE)

    def _exchange(self) -> Step:
        """Do a step of the plain method, which for an M-matrix needs no safeguard but rounding errors.

        Where nodes at which gap and reaction both vanish are exchanged for ever, a set comes back, and it ends.
        """
        self.omega = np.where(self._open, self.omega, 0.0)
        self.omega = self._solve(self.matrix @ self.omega + self.q, False)
        reaction = self.matrix @ self.omega + self.q
        now_open = ~self.supported | np.where(self._open, self.omega > 0, reaction < 0)
        exchanged = int(np.count_nonzero(now_open != self._open))
        self._open = now_open
        mark = hash(np.packbits(now_open).tobytes())
        finished = exchanged == 0 or mark in self._seen
        self._seen.add(mark)
        if finished:
            self.omega = np.maximum(self._lower, self.omega)
        return Step(exchanged, finished)

    def _solve(self, reaction: Vector, loosely: bool) -> Vector:
        return self._solve_direct(reaction) if self.direct else self._solve_iteratively(reaction, loosely)

    def _relax(self) -> None:
        """Do projected relaxation sweeps: Gauss-Seidel, or damped Jacobi where nothing is to be compiled."""
        if self.direct:
            for _ in range(_JACOBI_SWEEPS):
                correction = (self.matrix @ self.omega + self.q) / self._diagonal
                self.omega = np.maximum(self._lower, self.omega - _JACOBI_DAMPING * correction)
            return
        from . import sparse_kernels

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

    def _solve_iteratively(self, reaction: Vector, loosely: bool) -> Vector:
        """Return the same by preconditioned conjugate gradients, down to rounding or, loosely, to a first guess."""
        amg = self._preconditioner()
        keep = self._open
        target = self.omega.copy()
        residual = np.where(keep, -reaction, 0.0)
        scale = float(np.abs(residual).max())
        floor = 4 * _ROUNDING * float((self._diagonal * np.abs(self.omega)).max())
        wanted = max(_LOOSE * scale, floor) if loosely else floor
        direction = np.zeros_like(target)
        before = 1.0
        for _ in range(_MOST_ITERATIONS):
            if float(np.abs(residual).max()) <= wanted:
                break
            preconditioned = np.where(keep, amg.cycle(residual), 0.0)
            product = float((residual * preconditioned).sum())
            direction *= product / before
            direction += preconditioned
            before = product
            image = np.where(keep, self.matrix @ direction, 0.0)
            length = product / float((direction * image).sum())
            target += length * direction
            residual -= length * image
        return target

    def _preconditioner(self) -> Amg:
        """Return a hierarchy of the open nodes' matrix, in which the others are rows without couplings."""
        changed = np.count_nonzero(self._amg_open != self._open)
        if self._amg is None or changed > _STALE * self.q.size:
            from scipy import sparse

            rows = np.repeat(np.arange(self.q.size), np.diff(self.matrix.indptr))
            indices = self.matrix.indices
            kept = (self._open[rows] & self._open[indices]) | (rows == indices)
            data = np.where(kept, self.matrix.data, 0.0)
            masked = sparse.csr_array((data, indices, self.matrix.indptr), shape=self.matrix.shape)
            self._amg, self._amg_open = Amg(masked, self._candidate), self._open
        return self._amg

    def _move_to(self, target: Vector, reaction: Vector) -> tuple[float, float]:
        """Go to the projected ``target``, or to the point of least energy on the way.

        Returns which part of the way it was, and the largest step.
        """
        projected = np.maximum(self._lower, target)
        way = projected - self.omega
        slope = float((way * reaction).sum())
        curvature = float((way * (self.matrix @ way)).sum())
        damping = 1.0
        if slope + curvature > 0 and curvature > 0:
            damping = max(0.0, -slope / curvature)
            way *= damping
            projected = self.omega + way
        self.omega = projected
        return damping, float(np.abs(way).max())
