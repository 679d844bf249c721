"""Barrier: a vector v > 0 with G v > 0, by which a Z-matrix G is proven to be an M-matrix.

A Z-matrix (off-diagonal entries <= 0) is a nonsingular M-matrix exactly if such a v exists (Berman and
Plemmons, *Nonnegative Matrices in the Mathematical Sciences*, 1994, ch. 6, condition I27). Discretised
elliptic problems call v a barrier function. Every bound of a `Certificate` is a multiple of v.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..algebra.balanced import balanced
from ..algebra.band import Band
from ..algebra.stiffness import LatticeStiffness, growth_bound
from ..foundation.checks import Mask, Vector
from ..foundation.rounding import UNDERFLOW, UNIT_ROUNDOFF
from ..geometry.numbering import Layout
from ..methods.factors import DIRECT_SIZE, Solve, factorised
from ..methods.linear import hierarchy_cycle, solver

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from ..algebra.stiffness import Stiffness


_TOLERANCES = 1e-3, 1e-6
"""Residuals, relative in the Euclidean norm, at which an iterated vector is looked at whether it is a barrier."""

_FEW_STEPS, _MOST_STEPS = 60, 400
"""Conjugate gradient iterations without a preconditioner and with one."""

_SLOW = 0.1
"""A residual above this after a third of the few iterations tells that a preconditioner is needed."""


class Barrier:
    """A vector v > 0 and a proven lower bound s > 0 of G v.

    Parameters
    ----------
    v : array, shape (n,)
        The barrier.
    s : array, shape (n,)
        Lower bound of G v, rounding errors included; without the entries that count as zero, see `Stiffness.surplus`.
    kind : str
        How v was found: ``"paraboloid"``, ``"strip along x"``, ``"strip along y"`` or ``"linear solve"``.
    """

    def __init__(self, v: Vector, s: Vector, kind: str) -> None:
        self.kind = kind
        self._v, self._s = v, s

    @property
    def v(self) -> Vector:
        """The barrier, shape (n,)."""
        return self._v

    @property
    def s(self) -> Vector:
        """Lower bound of G v, rounding errors included, shape (n,)."""
        return self._s

    def mean_deflection(self, force: Vector, v: Vector | None = None) -> Vector:
        """Return an upper bound of the mean over the unknowns of G⁻¹ force, for a force >= 0 and a symmetric G.

        The mean is that of force · G⁻¹1, as G is symmetric (for one that is not, the barrier of its transposed matrix
        will do), and G⁻¹1 <= v / min s because G(v / min s) >= 1. It is exact, up to rounding, where v is G⁻¹1, as the
        paraboloid is on a disk; a force on one node does not spoil it.

        Parameters
        ----------
        force : array, shape (..., n)
            Force, >= 0.
        v : array, shape (n,), optional
            The barrier's, where it is at hand: a parabola's is made anew each time.

        Returns
        -------
        array, shape (...)
        """
        v = self.v if v is None else v
        with np.errstate(over="ignore"):
            share = force / self.s.min()
            share /= v.size
            return np.asarray(np.vecdot(share, v))

    @property
    def reach(self) -> float:
        """Largest v for a smallest s of one: the error per unit of residual that this barrier can promise."""
        return float(self.v.max() / self.s.min())


class Parabola(Barrier):
    """A sum of parabolas along rows and columns, on a lattice whose arms are equal in each direction.

    It is >= 0 on the frame, and has whole numbers as values at nodes and frame points (the two parabolas have multiples
    of 1/4), so that v and its differences are exact. Only the two parabolas are kept.

    Parameters
    ----------
    rows, columns : array, shape (rows + 2,) and (columns + 2,)
        v = rows[i] + columns[j], counted from the ring about the layout.
    least_s : float
        Lower bound of G v: what the second differences give, without the positive share of the frame.
    kind : str
    layout : Layout
    """

    def __init__(self, rows: Vector, columns: Vector, least_s: float, kind: str, layout: Layout) -> None:
        self.rows, self.columns, self.least_s, self.kind = rows, columns, least_s, kind
        self._layout = layout

    @property
    def v(self) -> Vector:
        """The barrier, shape (n,)."""
        grid = self.rows[1:-1, None] + self.columns[None, 1:-1]
        mask = self._layout.mask
        return grid.ravel() if mask.all() else grid[mask]

    @property
    def s(self) -> Vector:
        """Lower bound of G v, shape (n,), read-only: the same everywhere."""
        return np.broadcast_to(self.least_s, (self._layout.size,))

    @property
    def reach(self) -> float:
        """See `Barrier`."""
        return self.largest_v / self.least_s

    @cached_property
    def largest_v(self) -> float:
        """Largest v: in every run of nodes the one nearest to the columns' summit counts."""
        runs = self._layout.runs
        nearest = np.clip(int(self.columns.argmax()), runs[:, 1], runs[:, 2] - 1)
        return float((self.rows[runs[:, 0]] + self.columns[nearest]).max())


class Preconditioner(NamedTuple):
    """What does little to a residual but what is needed to solve fast.

    Attributes
    ----------
    balance : array, shape (n,)
        Factors of the unknowns that it is made for, the diagonal of D.
    cycle : callable
        Returns a symmetric positive definite map for DGD; None where there is none.
    """

    balance: Vector
    cycle: Callable[[], Solve | None]


def find_barrier(stiffness: Stiffness, preconditioner: Preconditioner | None = None) -> Barrier | None:
    """Return a barrier of a Z-matrix, or None where none is found (then G is no M-matrix, to rounding).

    On a lattice the candidates cost one pass at most: a paraboloid about the middle of the nodes, and a
    parabola across them along x or y, each >= 0 on the frame; the one with the least `Barrier.reach` is
    taken, also for a matrix that is recognised as a lattice's, where it is checked. Otherwise v is found by a linear
    solve: with D = diag(G)^(-1/2), which takes out the units of the unknowns, D G D y = 1 and v = D y.

    Parameters
    ----------
    stiffness : Stiffness
    preconditioner : Preconditioner, optional
        For iterative solutions, in place of that D and of a hierarchy that is made for the purpose.
    """
    # Small matrices are solved with in less time than it takes to look for a lattice in them.
    stencil = stiffness.lattice if stiffness.size <= DIRECT_SIZE else stiffness.recognised_lattice()
    if stencil is not None:
        parabolas = _parabolas(stencil)
        candidates: list[Barrier] = list(parabolas)
        if stiffness is not stencil or not stencil.rimmed:
            checked = [_checked(stiffness, parabola.v, parabola.kind) for parabola in parabolas]
            candidates = [candidate for candidate in checked if candidate is not None]
        if candidates:
            return min(candidates, key=lambda candidate: candidate.reach)
    return _solved(stiffness, preconditioner)


def _parabolas(stencil: LatticeStiffness) -> list[Parabola]:
    """Return the parabolas that are >= 0 on the frame and > 0 at the nodes.

    The second difference of each is -2, so G v >= 2 x arm for equal arms, and arms to the ground only add to it. The
    rim of the paraboloid is the farthest frame point; no node is as far from the middle, because farther out along its
    row or its column there is one.
    """
    layout = stencil.layout
    arms = _least(stencil.horizontal), _least(stencil.vertical)
    joined = bool(stencil.horizontal.any()), bool(stencil.vertical.any())
    ends = ends_of_lines(layout.mask), ends_of_lines(layout.mask.T)
    found = parabolas((layout.rows, layout.columns), arms, joined, ends, layout)
    return [parabola for parabola in found if not stencil.rimmed or 0 < parabola.least_s < np.inf]


class Ends(NamedTuple):
    """Where the nodes of lines begin and end.

    Attributes
    ----------
    lines, first, last : array of int, shape (k,)
        The number of each line that holds a node, and the places of its first and last one.
    """

    lines: NDArray[np.int64]
    first: NDArray[np.int64]
    last: NDArray[np.int64]


def ends_of_lines(points: Mask) -> Ends:
    """Return where the nodes of the rows of an array begin and end.

    Examples
    --------
    >>> ends_of_lines(np.array([[False, True, True], [False, False, False], [True, False, False]]))
    Ends(lines=array([0, 2]), first=array([1, 0]), last=array([2, 0]))
    """
    lines = np.flatnonzero(points.any(axis=1))
    first = points[lines].argmax(axis=1)
    return Ends(lines, first, points.shape[1] - 1 - points[lines, ::-1].argmax(axis=1))


def parabolas(
    shape: tuple[int, int],
    arms: tuple[float, float],
    joined: tuple[bool, bool],
    ends: tuple[Ends, Ends],
    layout: Layout,
) -> list[Parabola]:
    """Return the parabolas on a lattice that are >= 0 on the frame and > 0 at the nodes.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns of the smallest rectangle that holds all nodes.
    arms : (float, float)
        Stiffness of the arms along rows and along columns; 1 where they differ.
    joined : (bool, bool)
        Whether there are such arms at all.
    ends : (Ends, Ends)
        Of all rows and of all columns.
    layout : Layout
        The nodes, or those that a process holds.
    """
    row, column = np.arange(-1.0, shape[0] + 1), np.arange(-1.0, shape[1] + 1)
    across, along = arms
    reach_x, reach_y = (1.0 if there else 0.0 for there in joined)
    left, right = -reach_x, shape[1] - 1 + reach_x
    bottom, top = -reach_y, shape[0] - 1 + reach_y
    twice_row, twice_column = 2 * row - (bottom + top), 2 * column - (left + right)
    rim = _rim(ends, twice_row, twice_column, reach_x, reach_y)
    flat_rows, flat_columns = np.zeros_like(row), np.zeros_like(column)
    exact = 1 - 4 * UNIT_ROUNDOFF
    found: list[Parabola] = [
        Parabola(
            (rim - twice_row**2) / 4, -(twice_column**2) / 4, exact * (2 * across + 2 * along), "paraboloid", layout
        )
    ]
    if reach_x:
        across_strip = (column - left) * (right - column)
        found.append(Parabola(flat_rows, across_strip, exact * 2 * across, "strip along y", layout))
    if reach_y:
        found.append(Parabola((row - bottom) * (top - row), flat_columns, exact * 2 * along, "strip along x", layout))
    return found


def _least(arms: Vector) -> float:
    return float(arms) if arms.ndim == 0 else 1.0


def _rim(ends: tuple[Ends, Ends], twice_row: Vector, twice_column: Vector, reach_x: float, reach_y: float) -> float:
    """Return the largest squared distance from the middle, doubled, of a frame point that a node is joined to."""
    rim = 0.0
    for (lines, first, last), own, other, reach in (
        (ends[0], twice_row, twice_column, reach_x),
        (ends[1], twice_column, twice_row, reach_y),
    ):
        if not reach:
            continue
        # Offset 1 for the ring; the frame point lies one beyond the outermost node.
        for end in (first, last + 2):
            rim = max(rim, float((own[lines + 1] ** 2 + other[end] ** 2).max()))
    return rim


def _checked(stiffness: Stiffness, v: Vector, kind: str) -> Barrier | None:
    """Return the barrier if v > 0 and G v > 0 hold beyond rounding; nothing is assumed of v."""
    if not (np.isfinite(v).all() and v.min() > 0):
        return None
    s = image_below(stiffness, v)
    return Barrier(v, s, kind) if s.min() > 0 else None


def image_below(stiffness: Stiffness, v: Vector) -> Vector:
    """Return a lower bound of G v for a finite v >= 0, rounding errors included, shape (n,).

    What counts as zero of G is left out, see `Stiffness.surplus`.
    """
    product = stiffness.matvec(v)
    magnitude = stiffness.diagonal() * (2 * v) - product
    if stiffness.surplus is not None:
        surplus = (stiffness.surplus @ v) * (1 + growth_bound(stiffness))
        magnitude += 2 * surplus
        product = product - surplus
    return np.asarray(product - growth_bound(stiffness) * magnitude - UNDERFLOW)


def _solved(stiffness: Stiffness, preconditioner: Preconditioner | None) -> Barrier | None:
    """Return a barrier from a linear solve, and None where the matrix turns out not to be positive definite."""
    ones = np.ones(stiffness.size)
    if stiffness.lattice is not None and stiffness.size > DIRECT_SIZE:
        found = solver(stiffness, 1e-3)
        barrier = None if found is None else _checked(stiffness, found[0](ones), "linear solve")
        if barrier is not None:
            return barrier
    balance = 1 / np.sqrt(stiffness.diagonal()) if preconditioner is None else preconditioner.balance
    matrix = balanced(stiffness.tocsr(), balance)
    if stiffness.size <= DIRECT_SIZE or stiffness.without_fill or not stiffness.symmetric:
        solve = factorised(matrix, pivoting=True)
    else:
        if preconditioner is None:
            preconditioner = Preconditioner(balance, lambda: hierarchy_cycle(matrix, 1 / balance))
        barrier, indefinite = _iterated(stiffness, matrix, preconditioner)
        if barrier is not None or indefinite:
            return barrier
        band = Band(matrix)
        factors = band.factors() if band.affordable else None
        solve = None if factors is None else factors.solve
    return None if solve is None else _checked(stiffness, balance * solve(ones), "linear solve")


def _iterated(stiffness: Stiffness, matrix: csr_array, preconditioner: Preconditioner) -> tuple[Barrier | None, bool]:
    """Return the barrier from conjugate gradients, if that finds one, and whether the matrix is not positive definite.

    Without a preconditioner a few iterations tell whether the matrix needs one.
    """
    for preconditioned, steps in ((False, _FEW_STEPS), (True, _MOST_STEPS)):
        cycle = None
        if preconditioned:
            cycle = preconditioner.cycle()
            if cycle is None:
                return None, False
        for candidate in _approximations(matrix, cycle, steps):
            if candidate is None:
                return None, True
            barrier = _checked(stiffness, preconditioner.balance * candidate, "linear solve")
            if barrier is not None:
                return barrier, False
    return None, False


def _approximations(matrix: csr_array, cycle: Callable[[Vector], Vector] | None, steps: int) -> Iterator[Vector | None]:
    """Yield solutions x of Ax = 1 by conjugate gradients, to a rough and a finer tolerance; None if A is indefinite."""
    right = np.ones(matrix.shape[0])
    x, residual, direction = np.zeros_like(right), right.copy(), np.zeros_like(right)
    size, before = float(np.sqrt(right.size)), 1.0
    tolerances = list(_TOLERANCES)
    for step in range(steps):
        if cycle is None and step == _FEW_STEPS // 3 and float(np.sqrt((residual * residual).sum())) > _SLOW * size:
            return
        better = residual if cycle is None else cycle(residual)
        product = float((residual * better).sum())
        direction *= product / before
        direction += better
        before = product
        image = matrix @ direction
        curvature = float((direction * image).sum())
        if not curvature > 0:
            yield None
            return
        x += (product / curvature) * direction
        residual -= (product / curvature) * image
        if float(np.sqrt((residual * residual).sum())) <= tolerances[0] * size:
            yield x.copy()
            tolerances.pop(0)
            if not tolerances:
                return
