"""Starts: which gaps are worth starting from."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..foundation.checks import Vector, vector
from ..problem.contact_problem import ContactProblem
from ..problem.posed import Units

if TYPE_CHECKING:
    from ..models.records import Answered


def started_from(value: ArrayLike | Answered | None, problem: ContactProblem) -> Vector | None:
    """Return the gap that a warm start stands for, checked; None for a cold start."""
    if value is None:
        return None
    return vector(value if isinstance(value, np.ndarray) else getattr(value, "gap", value), problem.size, "warm_start")


def useful_start(gap: Vector, scaled: ContactProblem, units: Units) -> Vector | None:
    """Return a gap to start from, dimensionless; None where a cold start is nearer to the solution by its energy.

    Every method lowers the energy ½ωᵀGω + qᵀω, and a cold start is one at ω = 0, where that is zero. A gap whose energy
    is more has outlived its forces: after they have fallen by orders of magnitude it is so far away that methods need
    longer from there than from nothing, or break down.

    Parameters
    ----------
    gap : array, shape (n,)
        Length.
    scaled, units
        The dimensionless problem, in which zero is the admissible gap nearest to zero, and its units.

    Examples
    --------
    >>> import contactqp as cq
    >>> scaled, units = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0], gap_scale=1.0).scaled()
    >>> useful_start(np.array([0.75, 0.0]), scaled, units) is None
    False
    >>> useful_start(np.array([50.0, 0.0]), scaled, units) is None
    True
    """
    with np.errstate(over="ignore", invalid="ignore"):
        start = units.dimensionless(gap)
        admissible = scaled.project(start)
        return start if scaled.prefers(admissible) else None
