"""The linear problem G x = force on a lattice, by the same cycle: every node without a support."""

from __future__ import annotations

import numpy as np

from ...algebra.stiffness import LatticeStiffness
from ...foundation.checks import Vector
from ...foundation.threads import Team
from ...geometry.runs import FREE
from .arms import arms_of
from .nested import nested_start

_MAX_CYCLES = 60


def solve_linear(
    stencil: LatticeStiffness, force: Vector, tolerance: float = 1e-10, threads: int | None = None
) -> Vector:
    """Return G⁻¹ force (length), shape (n,); check it where arms jump, for it ends after some cycles in any case.

    Parameters
    ----------
    stencil : LatticeStiffness
        The stiffness G (force per length).
    force : array, shape (n,)
        Force on each node (force).
    tolerance : float
        Largest force out of balance, relative to the largest force; rounding errors may leave more.
    threads : int, optional
        By default as many as cores.

    Examples
    --------
    >>> import numpy as np
    >>> from contactqp.algebra.stencil import Stencil
    >>> chain = Stencil(np.ones((1, 3), dtype=bool), 1.0, 0.0)
    >>> solve_linear(chain, np.ones(3)).round(9)
    array([1.5, 2. , 1.5])
    """
    layout = stencil.layout.with_kind(FREE)
    lattice = arms_of(stencil, layout)
    with Team(threads) as team:
        solver = nested_start(lattice, layout.grid(-force), layout.zeros(), team)
        enough = tolerance * float(np.abs(force).max())
        for _ in range(_MAX_CYCLES):
            solver.relax()
            if solver.estimate <= max(enough, solver.rest()):
                break
            solver.correct()
    return layout.vector(solver.omega)
