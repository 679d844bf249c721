"""FreeSystem: the equations of free nodes, made ready once for many forces, and solved as accurately as can be told."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeAlias

import numpy as np

from ..algebra.stiffness import Stiffness, growth_bound
from ..foundation.checks import Mask, Vector, read_only
from ..foundation.rounding import UNIT_ROUNDOFF
from ..foundation.text import counted
from .factors import Solve, factorised
from .linear import iterated, solver

_PRECISE = 1e-12
"""Force out of balance over the largest force that a solution is not improved beyond."""

_REFINEMENTS = 6
_USEFUL = 0.5
"""What a refinement should at least multiply the force out of balance by to be followed by another one."""

_AFFORDABLE = 100_000
"""Unknowns up to which a matrix is factorised where iterations fail: seconds on a lattice."""

_Method: TypeAlias = Callable[[], Solve | None]


class FreeSystem:
    """The equations G_FF x = f of the free nodes F, the others held.

    What solves them, factors or a hierarchy, is made at the first force and kept. Every solution is checked: each force
    left out of balance must be at most 1e-12 of the largest one, or what rounding makes of it. One that is not is
    refined (Higham, *Accuracy and Stability of Numerical Algorithms*, 2002, ch. 12), and where that does not help the
    next method is taken.

    Parameters
    ----------
    stiffness : Stiffness
        G, symmetric positive definite or an M-matrix.
    free : array of bool, shape (n,)
        F.

    Examples
    --------
    >>> from contactqp.algebra.sparse import SparseStiffness
    >>> stiffness = SparseStiffness.of([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]])
    >>> system = FreeSystem(stiffness, np.array([True, False, True]))
    >>> system.solve(np.array([1.0, 5.0, -4.0]))
    array([ 0.5,  0. , -2. ])
    """

    def __init__(self, stiffness: Stiffness, free: Mask) -> None:
        self.free: Mask = read_only(np.array(free))
        self._stiffness, self._symmetric = stiffness, stiffness.symmetric
        self._checked: dict[bool, _Checked] = {}

    def solve(self, force: Vector, *, transposed: bool = False) -> Vector:
        """Return the solution x, shape (n,), zero at nodes that are held.

        Parameters
        ----------
        force : array, shape (n,)
            f; what it is at held nodes does not matter.
        transposed : bool
            Whether to solve with the transposed matrix.

        Raises
        ------
        ValueError
            If no method leaves little enough out of balance; the message tells how much.
        """
        found, own = np.zeros_like(force), force[self.free]
        if own.any():
            found[self.free] = self._of(transposed and not self._symmetric).solve(own)
        return found

    def _of(self, transposed: bool) -> _Checked:
        if transposed not in self._checked:
            restricted = self._stiffness.restricted(self.free)
            self._checked[transposed] = _Checked(restricted.transposed if transposed else restricted)
        return self._checked[transposed]


class _Checked:
    """Solves with a matrix by the first method that does so accurately."""

    def __init__(self, stiffness: Stiffness) -> None:
        self._stiffness = stiffness
        self._others = _methods(stiffness)
        self._solve: Solve | None = None
        self._least = np.inf

    def solve(self, force: Vector) -> Vector:
        """Return the solution for forces that are not all zero."""
        while True:
            if self._solve is None:
                self._solve = self._next()
            found = self._refined(self._solve, force)
            if found is not None:
                return found
            self._solve = None

    def _next(self) -> Solve:
        for method in self._others:
            solve = method()
            if solve is not None:
                return solve
        size = counted(self._stiffness.size, "free node")
        if np.isfinite(self._least):
            raise ValueError(
                f"the equations of {size} are too ill-conditioned: what is left out of balance is {self._least:.2g} "
                "times what rounding and a tolerance of 1e-12 allow"
            )
        raise ValueError(f"the matrix of {size} is singular in double precision")

    @np.errstate(over="ignore", invalid="ignore")
    def _refined(self, solve: Solve, force: Vector) -> Vector | None:
        """Return an accurate solution, or None where refinements do not lead to one."""
        stiffness, largest = self._stiffness, float(np.abs(force).max())
        found, before = solve(force), np.inf
        for _ in range(_REFINEMENTS):
            rest = force - stiffness.matvec(found)
            if np.abs(rest).max() <= _PRECISE * largest:
                return found
            rounding = (growth_bound(stiffness) + 4 * UNIT_ROUNDOFF) * stiffness.modulus_matvec(np.abs(found))
            excess = float((np.abs(rest) / (_PRECISE * largest + rounding)).max())
            if excess <= 1:
                return found
            if not excess <= _USEFUL * before:
                break
            before = excess
            found = found + solve(rest)
        self._least = min(self._least, before)
        return None


def _methods(stiffness: Stiffness) -> Iterator[_Method]:
    """Return what solves with a matrix, the fastest first."""

    def first() -> Solve | None:
        found = solver(stiffness, _PRECISE)
        return None if found is None else found[0]

    yield first
    if stiffness.lattice is not None:
        yield lambda: iterated(stiffness, _PRECISE)
    if stiffness.size <= _AFFORDABLE:
        yield lambda: factorised(stiffness.tocsr(), pivoting=True)
