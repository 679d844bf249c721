"""Barrier: a vector v > 0 with G v > 0, by which a Z-matrix G is proven to be an M-matrix.

A Z-matrix (off-diagonal entries <= 0) is a nonsingular M-matrix exactly if such a v exists (Berman and
Plemmons, *Nonnegative Matrices in the Mathematical Sciences*, 1994, ch. 6, condition I27). Discretised
elliptic problems call v a barrier function. Every bound of a `Certificate` is a multiple of v.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ._checks import Vector
from .rounding import UNDERFLOW, growth_bound
from .stencil import Stencil

if TYPE_CHECKING:
    from .stiffness import Stiffness

_DIRECT_SIZE = 2000
"""Up to this many rows a factorisation is faster than conjugate gradients."""


@dataclass(frozen=True)
class Barrier:
    """A vector v > 0 and a proven lower bound s > 0 of G v.

    Attributes
    ----------
    v : array, shape (n,)
        The barrier.
    s : array, shape (n,)
        Lower bound of G v, rounding errors included.
    kind : str
        How v was found: ``"paraboloid"``, ``"strip along x"``, ``"strip along y"`` or ``"linear solve"``.
    """

    v: Vector
    s: Vector
    kind: str

    def mean_deflection(self, force: Vector) -> float:
        """Return an upper bound of the mean over the unknowns of G⁻¹ force, for a force >= 0.

        The mean is that of force · G⁻¹1, as G is symmetric, and G⁻¹1 <= v / min s because G(v / min s) >= 1. It is
        exact where v is G⁻¹1, as the paraboloid is on a disk; a force on one node does not spoil it.
        """
        return float((self.v @ force) / (self.v.size * self.s.min()))

    @property
    def reach(self) -> float:
        """Largest v for a smallest s of one: the error per unit of residual that this barrier can promise."""
        return float(self.v.max() / self.s.min())


def find_barrier(stiffness: Stiffness) -> Barrier | None:
    """Return a barrier of a symmetric Z-matrix, or None where none is found (then G is no M-matrix).

    On a lattice the candidates cost one pass each: a paraboloid about the middle of the nodes, and a
    parabola across them along x or y, each >= 0 on the frame; the one with the least `Barrier.reach` is
    taken. Otherwise v is found by a linear solve: with D = diag(G)^(-1/2), which takes out the units of the unknowns,
    D G D y = 1 and v = D y.
    """
    if isinstance(stiffness, Stencil):
        candidates = [_checked(stiffness, v, kind) for kind, v in _parabolas(stiffness)]
        good = [candidate for candidate in candidates if candidate is not None]
        if good:
            return min(good, key=lambda candidate: candidate.reach)
    return _solved(stiffness)


def _parabolas(stencil: Stencil) -> list[tuple[str, Vector]]:
    """Return concave functions that are >= 0 on the frame; whole numbers, so that they are exact."""
    frame_rows, frame_columns = np.nonzero(stencil.frame_points())
    rows, columns = np.nonzero(stencil.mask)
    rows, columns = rows + 1, columns + 1
    left, right = frame_columns.min(), frame_columns.max()
    bottom, top = frame_rows.min(), frame_rows.max()
    twice_row, twice_column = bottom + top, left + right

    def distance_squared(row: np.ndarray, column: np.ndarray) -> np.ndarray:
        return np.asarray((2 * row - twice_row) ** 2 + (2 * column - twice_column) ** 2)

    rim = distance_squared(frame_rows, frame_columns).max()
    return [
        ("paraboloid", (rim - distance_squared(rows, columns)) / 4.0),
        ("strip along x", ((rows - bottom) * (top - rows)).astype(np.float64)),
        ("strip along y", ((columns - left) * (right - columns)).astype(np.float64)),
    ]


def _checked(stiffness: Stiffness, v: Vector, kind: str) -> Barrier | None:
    """Return the barrier if v > 0 and G v > 0 hold beyond rounding; nothing is assumed of v."""
    if not (np.isfinite(v).all() and v.min() > 0):
        return None
    product = stiffness.matvec(v)
    magnitude = 2 * stiffness.diagonal() * v - product
    s = product - growth_bound(stiffness) * magnitude - UNDERFLOW
    return Barrier(v, s, kind) if s.min() > 0 else None


def _solved(stiffness: Stiffness) -> Barrier | None:
    from scipy import sparse
    from scipy.sparse import linalg

    balance = 1 / np.sqrt(stiffness.diagonal())
    ones = np.ones(stiffness.size)
    if stiffness.size > _DIRECT_SIZE:
        operator = linalg.LinearOperator(
            (stiffness.size, stiffness.size),
            matvec=lambda y: balance * stiffness.matvec(balance * np.ravel(y)),
            dtype=np.float64,
        )
        for tolerance in (1e-3, 1e-6):
            y, _ = linalg.cg(operator, ones, rtol=tolerance, maxiter=4000)
            barrier = _checked(stiffness, balance * y, "linear solve")
            if barrier is not None:
                return barrier
    scaling = sparse.diags_array(balance)
    try:
        factors = linalg.splu((scaling @ stiffness.tocsr() @ scaling).tocsc(), permc_spec="MMD_AT_PLUS_A")
    except RuntimeError:
        return None
    return _checked(stiffness, balance * factors.solve(ones), "linear solve")
