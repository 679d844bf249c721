"""The linear problem G x = force on a lattice, by the same cycle: every node without a support."""

from __future__ import annotations

import numpy as np

from ...algebra.stiffness import LatticeStiffness
from ...foundation.checks import Vector
from ...foundation.threads import Team
from ...geometry.runs import FREE
from .arms import arms_of
from .contact import NO_LIMITS, ContactMultigrid

_MAX_CYCLES = 60


class LatticeSolver:
    """Solves G x = force by cycles from zero, and keeps their hierarchy from force to force.

    Parameters
    ----------
    stencil : LatticeStiffness
        The stiffness G (force per length).
    threads : int, optional
        By default as many as cores.

    Examples
    --------
    >>> import numpy as np
    >>> from contactqp.algebra.stencil import Stencil
    >>> chain = LatticeSolver(Stencil(np.ones((1, 3), dtype=bool), 1.0, 0.0))
    >>> chain.solve(np.ones(3)).round(9)
    array([1.5, 2. , 1.5])
    """

    def __init__(self, stencil: LatticeStiffness, threads: int | None = None) -> None:
        self._lattice, self._threads = arms_of(stencil, stencil.layout.with_kind(FREE)), threads
        self._kept: ContactMultigrid | None = None

    def solve(self, force: Vector, tolerance: float = 1e-10) -> Vector:
        """Return G⁻¹ force (length), shape (n,); check it where arms jump, for it ends after some cycles in any case.

        Parameters
        ----------
        force : array, shape (n,)
            Force on each node (force).
        tolerance : float
            Largest force out of balance, relative to the largest force; rounding errors may leave more.
        """
        layout = self._lattice.layout
        # Another thread, or a call that is interrupted, finds nothing kept.
        solver, self._kept = self._kept, None
        with Team(self._threads) as team:
            if solver is None:
                solver = ContactMultigrid(self._lattice, layout.zeros(), team)
            solver.restart(layout.grid(-force), NO_LIMITS, team)
            solver.omega[...] = 0.0
            cycle_until(solver, tolerance * float(np.abs(force).max()))
            found = layout.vector(solver.omega)
        self._kept = solver
        return found


def cycle_until(solver: ContactMultigrid, enough: float) -> None:
    """Do cycles until no force out of balance is larger than such a one, or than what rounding errors may leave.

    It ends after some cycles in any case.
    """
    for _ in range(_MAX_CYCLES):
        solver.relax()
        if solver.estimate <= max(enough, solver.rest()):
            break
        solver.correct()
