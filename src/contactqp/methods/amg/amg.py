"""Algebraic multigrid by smoothed aggregation, as a preconditioner of conjugate gradients.

Vaněk, Mandel and Brezina (1996), see `aggregation`. A V-cycle with one Gauss-Seidel sweep forwards before and one
backwards after the coarse correction is symmetric, as conjugate gradients want it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ...algebra.power import largest_growth
from ...foundation.checks import Mask, Vector
from ...foundation.loading import load_modules
from ..factors import DIRECT_SIZE, Solve, factorised
from .aggregation import aggregate

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_STRONG = 0.08
"""A coupling counts as strong above this times the geometric mean of the two diagonal entries."""

_COARSEST = 400
"""Unknowns that are solved for directly."""

_MOST_LEVELS = 25

_POWER_STEPS = 6
_MOST_ITERATIONS = 400


def conjugate_gradients(matrix: csr_array, candidate: Vector | None = None) -> Callable[[Vector, float], Vector] | None:
    """Return a function that solves with a matrix by conjugate gradients with smoothed aggregation.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Symmetric; its column numbers are put into order.
    candidate : array, shape (n,), optional
        See `Amg`.

    Returns
    -------
    callable or None
        Of a right-hand side and a tolerance of the residual relative to it, in the Euclidean norm; None if the matrix
        turns out not to be positive definite.
    """
    load_modules("scipy.linalg", "scipy.sparse.linalg")
    from scipy.linalg import LinAlgError
    from scipy.sparse import linalg

    matrix.sort_indices()
    try:
        amg = Amg(matrix, candidate)
    except LinAlgError:
        return None
    preconditioner = linalg.LinearOperator(matrix.shape, matvec=lambda y: amg.cycle(np.ravel(y)), dtype=np.float64)
    return lambda right, tolerance: np.asarray(
        linalg.cg(matrix, right, rtol=tolerance, maxiter=_MOST_ITERATIONS, M=preconditioner)[0]
    )


class Level:
    """A matrix, and what its sweeps need."""

    def __init__(self, matrix: csr_array) -> None:
        self.matrix = matrix
        self.rows = rows_of(matrix)
        self.inverse_diagonal = 1.0 / matrix.diagonal()


def rows_of(matrix: csr_array) -> tuple[Any, Any, Vector]:
    """Return a sparse array's pointers, column numbers and entries as the kernels take them."""
    return matrix.indptr.astype(np.int32, copy=False), matrix.indices.astype(np.int32, copy=False), matrix.data


class Amg:
    """A hierarchy for a symmetric positive definite M-matrix, or for its part that belongs to the free nodes.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        With ascending column numbers.
    candidate : array, shape (n,), optional
        A positive vector that the matrix nearly annihilates, away from where it is held; ones by default.
    free : array of bool, shape (n,), optional
        The part, all by default; at the other nodes the result of a cycle is zero.

    Attributes
    ----------
    levels : list of Level
        Finest first.
    transfers : list of (csr_array, csr_array)
        Restriction from each level to the next, and prolongation back.
    """

    def __init__(self, matrix: csr_array, candidate: Vector | None = None, free: Mask | None = None) -> None:
        self.levels = [Level(matrix if free is None else _part(matrix, free))]
        self.transfers: list[tuple[csr_array, csr_array]] = []
        vector = np.ones(matrix.shape[0]) if candidate is None else candidate
        while self.levels[-1].matrix.shape[0] > _COARSEST and len(self.levels) < _MOST_LEVELS:
            finer = self.levels[-1]
            found = _prolongation(finer, vector)
            if found is None:
                break
            prolongation, vector = found
            restriction = prolongation.T.tocsr()
            coarse = (restriction @ (finer.matrix @ prolongation)).tocsr()
            coarse.sort_indices()
            self.transfers.append((restriction, prolongation))
            self.levels.append(Level(coarse))
        self._factors = _coarsest(self.levels[-1])
        self._free_nodes: Mask | None = None
        if free is not None:
            self.levels[0] = Level(matrix)
            self.restrict_to(free)

    def restrict_to(self, free: Mask) -> None:
        """Take another part, for the finest sweeps only: good enough for a few nodes more or less."""
        level = self.levels[0]
        self._free_nodes = free
        level.inverse_diagonal = np.where(free, 1.0 / level.matrix.diagonal(), 0.0)

    def cycle(self, right: Vector, depth: int = 0) -> Vector:
        """Return the result of a V-cycle from zero."""
        load_modules("contactqp.methods.amg.sparse_kernels", kernels="active-set")
        from ..amg import sparse_kernels

        level = self.levels[depth]
        if depth == len(self.transfers):
            return np.asarray(self._factors(right))
        down, up = self.transfers[depth]
        x, rest = np.empty_like(right), np.empty_like(right)
        sparse_kernels.sweep_from_zero(*level.rows, level.inverse_diagonal, right, x)
        sparse_kernels.residual(*level.rows, right, x, rest)
        if depth == 0 and self._free_nodes is not None:
            rest[~self._free_nodes] = 0.0
        x += up @ self.cycle(down @ rest, depth + 1)
        sparse_kernels.sweep(*level.rows, level.inverse_diagonal, right, x, True)
        return x

    def __repr__(self) -> str:
        sizes = " > ".join(str(level.matrix.shape[0]) for level in self.levels)
        entries = sum(level.matrix.nnz for level in self.levels) / self.levels[0].matrix.nnz
        return f"Amg({sizes} unknowns, operator complexity {entries:.2f})"


def _part(matrix: csr_array, free: Mask) -> csr_array:
    """Return the matrix without the couplings to nodes that are not free."""
    load_modules("scipy.sparse")
    from scipy import sparse

    rows = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
    kept = (free[rows] & free[matrix.indices]) | (rows == matrix.indices)
    return sparse.csr_array((np.where(kept, matrix.data, 0.0), matrix.indices, matrix.indptr), shape=matrix.shape)


def _prolongation(level: Level, candidate: Vector) -> tuple[csr_array, Vector] | None:
    """Return the smoothed prolongation and the coarse candidate; None if grouping does not make it smaller."""
    load_modules("scipy.sparse")
    from scipy import sparse

    indptr, indices, data = level.rows
    size = indptr.size - 1
    rows = np.repeat(np.arange(size, dtype=np.int32), np.diff(indptr))
    root = np.sqrt(level.inverse_diagonal)
    strong = (np.abs(data) * root[rows] * root[indices] > _STRONG) & (rows != indices)
    strong_indptr = np.zeros(size + 1, dtype=np.int32)
    np.cumsum(np.bincount(rows[strong], minlength=size), out=strong_indptr[1:])
    group, count = aggregate(strong_indptr, indices[strong])
    if count == 0 or count > 0.9 * size:
        return None
    member = np.flatnonzero(group >= 0)
    norms = np.sqrt(np.bincount(group[member], weights=candidate[member] ** 2, minlength=count))
    values = candidate[member] / norms[group[member]]
    tentative = sparse.csr_array((values, (member, group[member])), shape=(size, count))
    # Weak couplings are added to the diagonal before smoothing, so that they do not spread the prolongation.
    kept = strong | (rows == indices)
    weak = np.bincount(rows[~kept], weights=data[~kept], minlength=size)
    filtered = np.where(kept, data, 0.0)
    diagonal = 1.0 / level.inverse_diagonal + weak
    diagonal = np.where(diagonal > 0, diagonal, 1.0 / level.inverse_diagonal)
    scaled = -filtered / diagonal[rows]
    scaled[rows == indices] = -1.0
    all_kept = bool(kept.all())
    smoother = sparse.csr_array((scaled, indices, indptr), shape=(size, size), copy=not all_kept)
    scaled = smoother.data
    scaled *= 4.0 / 3.0 / _spectral_radius(smoother)
    scaled[rows == indices] += 1.0
    if not all_kept:
        smoother.eliminate_zeros()
    prolongation = (smoother @ tentative).tocsr()
    prolongation.sort_indices()
    return prolongation, norms


def _spectral_radius(matrix: csr_array) -> float:
    """Return the spectral radius of D⁻¹A, from some steps of the power method, which come close enough from below."""
    start = np.cos(np.arange(matrix.shape[0]) ** 2.0)
    return 1.1 * largest_growth(lambda x: np.asarray(matrix @ x), start, _POWER_STEPS)


def _coarsest(level: Level) -> Solve:
    """Return a function that solves with the coarsest matrix; a LinAlgError where it is not positive definite.

    Dense factors are no faster at this size, and the threads of a LAPACK stall on a busy machine. Where unknowns do not
    group, so that the coarsest matrix is a large one, it is divided by the diagonal: its factors may fill.
    """
    load_modules("scipy.linalg")
    from scipy.linalg import LinAlgError

    matrix = level.matrix
    if matrix.shape[0] > DIRECT_SIZE:
        return lambda right: right * level.inverse_diagonal
    solve = factorised(matrix, definite=True)
    if solve is None:
        raise LinAlgError(f"a coarse matrix of {matrix.shape[0]} unknowns is not positive definite")
    return solve
