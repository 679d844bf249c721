"""Solving with the stiffness of the free nodes, the others held: by factors, multigrid or conjugate gradients."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..algebra.stencil import Stencil
from ..foundation.checks import Mask, Vector
from .active_set.primal_dual import DIRECT_SIZE

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from ..algebra.stiffness import Stiffness

_TOLERANCE = 1e-3


def free_set_solver(stiffness: Stiffness, free: Mask) -> tuple[Callable[[Vector], Vector], bool] | None:
    """Return a function that solves G_FF x = f, and whether it does so to rounding; None where underflow prevents it.

    Up to some thousand free nodes the matrix is factorised. For more, it is multigrid on a lattice, and conjugate
    gradients with smoothed aggregation otherwise, each to about a thousandth of the largest force.

    Parameters
    ----------
    stiffness : Stiffness
        An M-matrix.
    free : array of bool, shape (n,)
        F, at least one node.

    Examples
    --------
    >>> import numpy as np
    >>> from contactqp.algebra.sparse import SparseStiffness, checked_matrix
    >>> stiffness = SparseStiffness(checked_matrix([[2.0, -1.0], [-1.0, 2.0]]))
    >>> solve, exact = free_set_solver(stiffness, np.array([True, False]))
    >>> solve(np.array([1.0])), exact
    (array([0.5]), True)
    """
    part = _part(stiffness, free) if isinstance(stiffness, Stencil) else None
    if np.count_nonzero(free) <= DIRECT_SIZE or (part is not None and 1 in part.mask.shape):
        factors = _factorised(_rows_and_columns(stiffness.tocsr(), free) if part is None else part.tocsr())
        return None if factors is None else (factors, True)
    if part is not None:
        return _by_multigrid(part), False
    solve = _by_conjugate_gradients(_rows_and_columns(stiffness.tocsr(), free))
    return None if solve is None else (solve, False)


def _part(stencil: Stencil, free: Mask) -> Stencil:
    """Return the lattice of the free nodes, for which the others are frame."""
    mask = np.zeros(stencil.mask.shape, dtype=np.bool_)
    mask[stencil.mask] = free
    return Stencil(mask, stencil.horizontal, stencil.vertical)


def _rows_and_columns(matrix: csr_array, free: Mask) -> csr_array:
    chosen = np.flatnonzero(free)
    return matrix if chosen.size == free.size else matrix[chosen][:, chosen]


def _factorised(matrix: csr_array) -> Callable[[Vector], Vector] | None:
    from scipy.sparse import linalg

    options = {"SymmetricMode": True}
    try:
        factors = linalg.splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    except RuntimeError:
        return None
    return lambda force: np.asarray(factors.solve(force))


def _by_multigrid(stencil: Stencil) -> Callable[[Vector], Vector]:
    from .multigrid.linear import solve_linear

    return lambda force: solve_linear(stencil, force, _TOLERANCE)


def _by_conjugate_gradients(matrix: csr_array) -> Callable[[Vector], Vector] | None:
    from .amg.amg import conjugate_gradients

    solve = conjugate_gradients(matrix)
    return None if solve is None else lambda force: solve(force, _TOLERANCE)
