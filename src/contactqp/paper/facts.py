"""What the paper states of its example: Table 1, its stopping rule, and what the CPU times say about a misprint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..foundation.checks import Vector, read_only
from ..gallery.membranes import PAPER_LOADS

SURROGATE = "The rigid surface is a surrogate consistent with Table 1, not a reproduction."
"""Goes with everything that is shown of the example: the paper's Fig. 4 is lost."""

TOLERANCE = 1e-3
"""The paper's ε, in spacings Δ."""

FACTORS: Vector = read_only(np.round(np.arange(1.0, 2.0, 0.05), 2))
"""Relaxation factors 1.00, 1.05, …, 1.95: the paper's β₀ are multiples of 0.05."""

SECTION_LOADS = (0.01, 0.03, 0.05)
"""P′ of the middle sections, Figs. 6-8 of the paper."""

MISPRINTED_LOAD = 0.03
"""P′ at which the table's N contradicts its own CPU time, see `fit_cpu_time`."""


@dataclass(frozen=True)
class PaperRow:
    """A column of Table 1 of the paper.

    Attributes
    ----------
    load : float
        P′ = pΔ/T.
    factor : float
        β₀, the best relaxation factor.
    sweeps : int
        N, for ε = 0.001 from ω = 0.
    cpu_seconds : float
        Of a UNIVAC 1108.
    """

    load: float
    factor: float
    sweeps: int
    cpu_seconds: float


TABLE_1 = tuple(
    PaperRow(*column)
    for column in zip(
        PAPER_LOADS,
        (1.70, 1.65, 1.60, 1.50, 1.45, 1.45, 1.40, 1.40, 1.35, 1.35),
        (53, 45, 31, 27, 23, 21, 20, 19, 18, 17),
        (17.04, 14.74, 13.13, 8.97, 7.65, 7.02, 6.59, 6.39, 6.08, 5.80),
        strict=True,
    )
)
"""Table 1 of the paper, as it is printed."""


@dataclass(frozen=True)
class CpuFit:
    """CPU seconds = at_start + a_sweep N, fitted to all loads of Table 1 but the one in doubt.

    Attributes
    ----------
    at_start, a_sweep : float
        Seconds before the first sweep, and of each sweep.
    deviation : float
        Largest distance of a fitted load from the line, seconds.
    sweeps : float
        N that the line gives at the load in doubt, from its CPU time.
    """

    at_start: float
    a_sweep: float
    deviation: float
    sweeps: float


def fit_cpu_time() -> CpuFit:
    """Fit the CPU times of Table 1 by a line in N, by least squares without P′ = 0.03.

    Examples
    --------
    >>> fit = fit_cpu_time()
    >>> round(fit.at_start, 3), round(fit.a_sweep, 3), round(fit.deviation, 2), round(fit.sweeps)
    (0.381, 0.316, 0.13, 40)
    """
    trusted = [row for row in TABLE_1 if row.load != MISPRINTED_LOAD]
    (doubtful,) = (row for row in TABLE_1 if row.load == MISPRINTED_LOAD)
    sweeps = np.array([row.sweeps for row in trusted], dtype=np.float64)
    seconds = np.array([row.cpu_seconds for row in trusted])
    a_sweep, at_start = np.polyfit(sweeps, seconds, 1)
    return CpuFit(
        at_start=float(at_start),
        a_sweep=float(a_sweep),
        deviation=float(np.abs(seconds - at_start - a_sweep * sweeps).max()),
        sweeps=float((doubtful.cpu_seconds - at_start) / a_sweep),
    )
