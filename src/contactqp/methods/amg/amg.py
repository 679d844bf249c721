"""Algebraic multigrid by smoothed aggregation, as a preconditioner of conjugate gradients.

Vaněk, Mandel and Brezina (1996), see `aggregation`. A V-cycle with one Gauss-Seidel sweep forwards before and one
backwards after the coarse correction is symmetric, as conjugate gradients want it. One hierarchy serves all sets of
free unknowns of its matrix.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...algebra.power import generic_start, largest_growth
from ...foundation.checks import Mask, Vector
from ...foundation.loading import load_modules
from ...foundation.threads import shared_team
from ..factors import DIRECT_SIZE, Solve, factorised
from .aggregation import aggregate

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_STRONG, _FADING = 0.08, 0.5
"""A coupling counts as strong above this times the geometric mean of the two diagonal entries, and above half as much
on each coarser level (Vaněk, Mandel and Brezina 1996), whose matrices spread the couplings of a node over more entries:
with the finest level's threshold, aggregates in space cover few of their neighbours, and cycles are four times as many.
"""

_FAINTEST = 0.02
"""The threshold is no lower than this: couplings that jump are to stay apart."""

_COARSEST = 400
"""Unknowns that are solved for directly."""

_MOST_LEVELS = 25

_MOST_HELD = 0.3
"""Part of a coarse unknown's squared shape that may lie on held unknowns, if the coarse one is not to be held, too."""

_ENTRIES_WORTH_A_BLOCK, _MOST_BLOCKS = 300_000, 8
"""Handing a block to a thread takes as long as sweeping over 20,000 entries."""

_AS_MUCH = 1 + 1e-10
"""Times a number up to which another one counts as no more: both are rounded."""

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
    """A matrix, what its sweeps need, and the way to the next coarser level, if there is one.

    Attributes
    ----------
    matrix : csr_array, shape (n, n)
    candidate : array, shape (n,)
        A positive vector that the matrix nearly annihilates, away from where it is held.
    blocks : list of (int, int)
        First row of each block of rows that is swept apart, and the one after its last.
    coarser : Transfer or None
    """

    def __init__(self, matrix: csr_array, candidate: Vector) -> None:
        self.matrix, self.candidate = matrix, candidate
        self.rows = rows_of(matrix)
        diagonal = matrix.diagonal()
        self.inverse_diagonal = 1.0 / diagonal
        self.blocks = _blocks(matrix, diagonal)
        self.coarser: Transfer | None = None


class Transfer:
    """The way between a level and the next coarser one.

    Attributes
    ----------
    up, down : csr_array, shapes (n, m) and (m, n)
        Prolongation, and its transpose.
    group : array of int, shape (n,)
        The coarse unknown that each unknown belongs to; -1 for one without neighbours.
    """

    def __init__(self, up: csr_array, group: NDArray[np.int32]) -> None:
        self.up, self.down, self.group = up, up.T.tocsr(), group
        self.down.sort_indices()
        self.up_rows = rows_of(up)
        self._weight = self._weights @ np.ones(up.shape[0])

    @property
    def _weights(self) -> csr_array:
        """The shapes' squares, which are asked for too rarely to be kept."""
        load_modules("scipy.sparse")
        from scipy import sparse

        return sparse.csr_array((self.down.data**2, self.down.indices, self.down.indptr), shape=self.down.shape)

    def held(self, held: Mask) -> Mask:
        """Return the coarse unknowns whose shapes lie on held unknowns to no small part."""
        return np.asarray(self._weights @ held.astype(np.float64) > _MOST_HELD * self._weight)


def _blocks(matrix: csr_array, diagonal: Vector) -> list[tuple[int, int]]:
    """Divide the rows of a matrix into blocks for Gauss-Seidel sweeps, one beside the other.

    A forwards sweep solves with M = D + L, D the diagonal of A and L what lies below it inside the blocks, and a
    backwards one with Mᵀ. So a cycle is symmetric, and positive definite if M + Mᵀ - A = D - O is, O the entries of A
    between blocks (Baker, Falgout, Kolev and Yang, *Multigrid smoothers for ultraparallel computing*, SIAM J. Sci.
    Comput. 33, 2011). That is so for a definite A if in no row the moduli of O add up to more than the diagonal entry:
    where they are as much in all rows that hang together by O, these rows have no other entries. Else all rows are one
    block. The number of blocks, and so the result, is the same on every machine.
    """
    size = diagonal.size
    count = min(_MOST_BLOCKS, matrix.nnz // _ENTRIES_WORTH_A_BLOCK)
    whole = [(0, size)]
    if count < 2:
        return whole
    edges = np.array([size * k // count for k in range(count + 1)])
    row_of = np.repeat(np.arange(size, dtype=np.int32), np.diff(matrix.indptr))
    block = np.searchsorted(edges, np.arange(size), side="right").astype(np.int8)
    between = np.flatnonzero(block[row_of] != block[matrix.indices])
    sums = np.bincount(row_of[between], weights=np.abs(matrix.data[between]), minlength=size)
    return list(pairwise(edges.tolist())) if (sums <= _AS_MUCH * diagonal).all() else whole


def rows_of(matrix: csr_array) -> tuple[Any, Any, Vector]:
    """Return a sparse array's pointers, column numbers and entries as the kernels take them."""
    return matrix.indptr.astype(np.int32, copy=False), matrix.indices.astype(np.int32, copy=False), matrix.data


class Amg:
    """A hierarchy for a symmetric positive definite matrix.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        With ascending column numbers.
    candidate : array, shape (n,), optional
        A positive vector that the matrix nearly annihilates, away from where it is held; ones by default.

    Attributes
    ----------
    levels : list of Level
        Finest first.

    Raises
    ------
    LinAlgError
        If the coarsest matrix is not positive definite.
    """

    def __init__(self, matrix: csr_array, candidate: Vector | None = None) -> None:
        load_modules("contactqp.methods.amg.sparse_kernels", kernels="active-set")
        self.levels = [Level(matrix, np.ones(matrix.shape[0]) if candidate is None else candidate)]
        while self.levels[-1].matrix.shape[0] > _COARSEST and len(self.levels) < _MOST_LEVELS:
            finer = self.levels[-1]
            found = _prolongation(finer, max(_FAINTEST, _STRONG * _FADING ** (len(self.levels) - 1)))
            if found is None:
                break
            finer.coarser, vector = found
            coarse = (finer.coarser.down @ (finer.matrix @ finer.coarser.up)).tocsr()
            coarse.sort_indices()
            self.levels.append(Level(coarse, vector))
        self._all = Part(self.levels, None)

    def below(self) -> Amg:
        """Return the hierarchy without its finest level."""
        amg = Amg.__new__(Amg)
        amg.levels = self.levels[1:]
        amg._all = Part(amg.levels, None)
        return amg

    def part(self, free: Mask) -> Part:
        """Return what does a cycle for the equations of some unknowns, with the others held.

        Parameters
        ----------
        free : array of bool, shape (n,)
            Those that are not held.
        """
        return self._all if free.all() else Part(self.levels, free)

    def cycle(self, right: Vector) -> Vector:
        """Return the result of a V-cycle from zero."""
        return self._all.cycle(right)

    def __repr__(self) -> str:
        sizes = " > ".join(str(level.matrix.shape[0]) for level in self.levels)
        entries = sum(level.matrix.nnz for level in self.levels) / self.levels[0].matrix.nnz
        return f"Amg({sizes} unknowns, operator complexity {entries:.2f})"


class Part:
    """V-cycles for some of the unknowns, the others of which are held.

    Held unknowns are left out of sweeps and transfers, and so are coarse ones whose shapes lie on them to no small part
    (Kornhuber, *Monotone multigrid methods for elliptic variational inequalities*, Numerische Mathematik 69, 1994,
    drops or truncates them). The coarse matrices remain those of the whole: a set costs no more than its masks. Each
    cycle is a symmetric positive definite map of the free unknowns, as conjugate gradients want it, because the sweeps
    are those of the free unknowns' own matrix, and what is added between them is symmetric and positive semidefinite.

    Parameters
    ----------
    levels : list of Level
    free : array of bool, shape (n,), or None
        None for all.
    """

    def __init__(self, levels: list[Level], free: Mask | None) -> None:
        self._levels = levels
        self._inverse_diagonals = [level.inverse_diagonal for level in levels]
        held = None if free is None else ~free
        for depth, level in enumerate(levels):
            if held is None:
                break
            self._inverse_diagonals[depth] = np.where(held, 0.0, level.inverse_diagonal)
            if level.coarser is not None:
                held = level.coarser.held(held)
        self._solve = _coarsest(levels[-1], None if held is None else np.flatnonzero(~held))

    def cycle(self, right: Vector, depth: int = 0) -> Vector:
        """Return the result of a V-cycle from zero, which is zero at held unknowns."""
        from . import sparse_kernels

        level, inverse_diagonal = self._levels[depth], self._inverse_diagonals[depth]
        if level.coarser is None:
            return self._solve(right)
        run, blocks = shared_team().run, level.blocks
        x, rest = np.empty_like(right), np.empty_like(right)
        run(sparse_kernels.sweep_from_zero, blocks, *level.rows, inverse_diagonal, right, x)
        run(sparse_kernels.residual_after_sweep, blocks, *level.rows, inverse_diagonal, x, rest)
        correction = self.cycle(level.coarser.down @ rest, depth + 1)
        before = rest
        run(sparse_kernels.add_prolongation, blocks, *level.coarser.up_rows, inverse_diagonal, correction, x, before)
        run(sparse_kernels.sweep_backwards, blocks, *level.rows, inverse_diagonal, right, before, x)
        return x


def _prolongation(level: Level, threshold: float) -> tuple[Transfer, Vector] | None:
    """Return the smoothed prolongation and the coarse candidate; None if grouping does not make it smaller.

    Unknowns are grouped by couplings that are stronger than a threshold, see `_STRONG`.
    """
    load_modules("scipy.sparse")
    from scipy import sparse

    (indptr, indices, data), candidate = level.rows, level.candidate
    size = indptr.size - 1
    rows = np.repeat(np.arange(size, dtype=np.int32), np.diff(indptr))
    root = np.sqrt(level.inverse_diagonal)
    strong = (np.abs(data) * root[rows] * root[indices] > threshold) & (rows != indices)
    strong_indptr = np.zeros(size + 1, dtype=np.int32)
    np.cumsum(np.bincount(rows[strong], minlength=size), out=strong_indptr[1:])
    group, count = aggregate(strong_indptr, indices[strong])
    if count == 0 or count > 0.9 * size:
        return None
    member = np.flatnonzero(group >= 0).astype(np.int32)
    norms = np.sqrt(np.bincount(group[member], weights=candidate[member] ** 2, minlength=count))
    values = candidate[member] / norms[group[member]]
    tentative = sparse.csr_array((values, (member, group[member])), shape=(size, count))
    scaled = -data * level.inverse_diagonal[rows]
    smoother = sparse.csr_array((scaled, indices, indptr), shape=(size, size))
    scaled *= 4.0 / 3.0 / _spectral_radius(smoother)
    scaled[rows == indices] += 1.0
    prolongation = (smoother @ tentative).tocsr()
    prolongation.sort_indices()
    return Transfer(prolongation, group), norms


def _spectral_radius(matrix: csr_array) -> float:
    """Return the spectral radius of D⁻¹A, from some steps of the power method, which come close enough from below."""
    start = generic_start(matrix.shape[0])
    return 1.1 * largest_growth(lambda x: np.asarray(matrix @ x), start, _POWER_STEPS)


def _coarsest(level: Level, free: NDArray[np.intp] | None) -> Solve:
    """Return a function that solves with the coarsest matrix, for some unknowns where not for all.

    Dense factors are no faster at this size, and the threads of a LAPACK stall on a busy machine. Where unknowns do not
    group, so that the coarsest matrix is a large one, it is divided by the diagonal: its factors may fill.

    Raises
    ------
    LinAlgError
        If it is not positive definite.
    """
    load_modules("scipy.linalg")
    from scipy.linalg import LinAlgError

    matrix = level.matrix
    chosen = np.arange(matrix.shape[0]) if free is None else free
    if chosen.size > DIRECT_SIZE:
        inverse = level.inverse_diagonal[chosen]
        return lambda right: _spread(right.size, chosen, right[chosen] * inverse)
    if not chosen.size:
        return np.zeros_like
    solve = factorised(matrix if free is None else matrix[free][:, free], definite=True)
    if solve is None:
        raise LinAlgError(f"a coarse matrix of {chosen.size} unknowns is not positive definite")
    return solve if free is None else lambda right: _spread(right.size, chosen, solve(right[chosen]))


def _spread(size: int, places: NDArray[np.intp], values: Vector) -> Vector:
    """Return a vector with values at some places, and zeros elsewhere."""
    spread = np.zeros(size)
    spread[places] = values
    return spread
