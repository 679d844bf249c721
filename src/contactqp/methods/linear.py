"""Linear systems with a stiffness: by factors, by multigrid on a lattice, or by conjugate gradients."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..algebra.stiffness import Stiffness
from ..foundation.checks import Mask, Vector
from ..foundation.loading import can_compile, load_modules
from .factors import DIRECT_SIZE, Solve, factorised

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from .amg.ordered import Ordered

_FREE_SET_TOLERANCE = 1e-3


def solver(stiffness: Stiffness, tolerance: float) -> tuple[Solve, bool] | None:
    """Return a function that solves G x = f, and whether it does so to rounding.

    Up to some thousand unknowns, and where unknowns hang together in lines, the matrix is factorised. Otherwise it is
    solved by multigrid on a lattice, and by conjugate gradients with smoothed aggregation for other matrices. It is
    factorised at any size where it is not symmetric, and without numba, which both need.

    Parameters
    ----------
    stiffness : Stiffness
        Symmetric positive definite, or an M-matrix; iterations are few for that, and for what comes near one.
    tolerance : float
        Of iterative solutions: the largest force out of balance, relative to the largest force.

    Returns
    -------
    solve, exact : callable and bool, or None
        None where the matrix turns out not to be positive definite, or numbers underflow.

    Examples
    --------
    >>> import numpy as np
    >>> from contactqp.algebra.sparse import SparseStiffness
    >>> solve, exact = solver(SparseStiffness.of([[2.0, -1.0], [-1.0, 2.0]]), 1e-3)
    >>> solve(np.array([1.0, 1.0])), exact
    (array([1., 1.]), True)
    """
    direct = stiffness.size <= DIRECT_SIZE or stiffness.without_fill or not stiffness.symmetric
    if direct or not can_compile():
        factors = factorised(stiffness.tocsr())
        return None if factors is None else (factors, True)
    lattice = stiffness.lattice
    if lattice is not None:
        load_modules("contactqp.methods.multigrid.linear", kernels="multigrid")
        from .multigrid.linear import LatticeSolver

        kept = LatticeSolver(lattice)
        return lambda force: kept.solve(force, tolerance), False
    iterations = iterated(stiffness, tolerance)
    return None if iterations is None else (iterations, False)


def iterated(stiffness: Stiffness, tolerance: float) -> Solve | None:
    """Return a function that solves G x = f by conjugate gradients with smoothed aggregation; see `solver`.

    None also without numba.
    """
    if not can_compile():
        return None
    from .amg.amg import conjugate_gradients

    solve = conjugate_gradients(stiffness.tocsr())
    return None if solve is None else lambda force: solve(force, tolerance)


def hierarchy_cycle(matrix: csr_array, candidate: Vector) -> Solve | None:
    """Return a cycle of smoothed aggregation, which does little to a residual but what is needed to solve fast.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Symmetric; its column numbers are put into order.
    candidate : array, shape (n,)
        A positive vector that the matrix nearly annihilates, away from where it is held.

    Returns
    -------
    callable or None
        None where the matrix turns out not to be positive definite, or without numba.
    """
    if not can_compile():
        return None
    from .amg.ordered import Ordered

    matrix.sort_indices()
    return cycle_of(Ordered(matrix, candidate))


def cycle_of(ordered: Ordered) -> Solve | None:
    """Return a cycle of a matrix's hierarchy; None as for `hierarchy_cycle`."""
    if not can_compile():
        return None
    load_modules("scipy.linalg")
    from scipy.linalg import LinAlgError

    try:
        _ = ordered.amg
    except LinAlgError:
        return None
    return ordered.cycle


def free_set_solver(stiffness: Stiffness, free: Mask) -> tuple[Solve, bool] | None:
    """Return a function that solves G_FF x = f for the free nodes F, the others held; see `solver`.

    Iterative solutions are good to about a thousandth of the largest force.

    Parameters
    ----------
    stiffness : Stiffness
        Symmetric positive definite; iterations are few for an M-matrix, and for what comes near one.
    free : array of bool, shape (n,)
        F, at least one node.

    Examples
    --------
    >>> import numpy as np
    >>> from contactqp.algebra.sparse import SparseStiffness
    >>> stiffness = SparseStiffness.of([[2.0, -1.0], [-1.0, 2.0]])
    >>> solve, exact = free_set_solver(stiffness, np.array([True, False]))
    >>> solve(np.array([1.0])), exact
    (array([0.5]), True)
    """
    return solver(stiffness.restricted(free), _FREE_SET_TOLERANCE)
