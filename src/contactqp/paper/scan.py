"""Relaxation factors scanned: how many sweeps projected over-relaxation takes with each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..foundation.checks import Vector, real_array
from ..models.stretched import StretchedModel
from ..solving.solve import solve
from .facts import FACTORS, TOLERANCE

StoppingRule = Literal["step", "residual"]


@dataclass(frozen=True, eq=False)
class Scan:
    """Sweeps N against the relaxation factor β.

    Attributes
    ----------
    stopping : {"step", "residual"}
        The stopping rule, see the backend ``psor``.
    stopping_length : float
        Its ε (length).
    factors : array, shape (k,)
        β.
    sweeps : array of int, shape (k,)
        N, the sweep that passes included.
    """

    stopping: StoppingRule
    stopping_length: float
    factors: Vector
    sweeps: NDArray[np.int64]

    @property
    def least(self) -> int:
        """The least number of sweeps."""
        return int(self.sweeps.min())

    @property
    def best(self) -> tuple[float, ...]:
        """All factors that take the least number of sweeps, ascending."""
        return tuple(sorted(float(factor) for factor in self.factors[self.sweeps == self.least]))


def scan(
    model: StretchedModel,
    stopping: StoppingRule,
    *,
    stopping_length: float = TOLERANCE,
    factors: ArrayLike = FACTORS,
) -> Scan:
    """Count the sweeps, row by row from ω = 0, that each relaxation factor takes.

    Parameters
    ----------
    model : Membrane or Cable
    stopping : {"step", "residual"}
        "step": a sweep changes no gap by ε or more; "residual": max|min(ω, R/T)| < ε after a sweep.
    stopping_length : float
        ε (length); by default the paper's, for unit spacing.
    factors : array, shape (k,)
        β, each in (0, 2); by default 1.00, 1.05, …, 1.95.

    Returns
    -------
    Scan

    Raises
    ------
    ValueError
        If a factor, the rule or the length is out of range, or there is no factor.

    Examples
    --------
    >>> import contactqp as cq
    >>> found = scan(cq.gallery.paper_hexagon(0.10), "step")
    >>> found.least, found.best
    (17, (1.35, 1.4))
    """
    chosen = real_array(factors, "factors")
    if chosen.ndim != 1 or not chosen.size:
        raise ValueError(f"factors must be a sequence of numbers, got shape {chosen.shape}")
    sweeps = [
        solve(
            model,
            "psor",
            relaxation=float(factor),
            stopping=stopping,
            stopping_length=stopping_length,
            on_failure="ignore",
        ).iterations
        for factor in chosen
    ]
    return Scan(stopping, stopping_length, chosen, np.array(sweeps, dtype=np.int64))
