r"""A spline's coefficients about corners that point inwards, chosen by linear programs.

At such a corner, of angle ω > π, u falls from the frame as r^α, α = π/ω < 1. A spline that takes the lattice's values
there, and goes on beyond the frame by reflection, misses the differential inequality by about r^(α - 2), and the
frame's height by r^α; loads that are to make up for it move what lies on either side of the frame, and may miss more
from round to round. Yet there are splines that miss nothing, near that of a membrane whose corner lies a few spacings
farther in, for an upper bound, or out, for a lower one. They are found by what is wanted of them. With the coefficients
c of a window about the corner, m of them at points of the closed region, those around it given, and S = 1 for an upper
bound and -1 for a lower one, it is

.. math::

    \text{least } W τ + \frac{S}{m} \sum_{m} c
    \quad \text{of all } c, \, τ ≥ 0 \quad \text{with} \quad S(TΔs - q) ≤ τ, \quad S(s - γ) ≥ 0,

each at the Bernstein coefficients: little is missed, and evenly, and of the splines that miss no more the nearest to
the membrane is taken. W is large. What is still missed is paid by loads, like all else.

Nothing that is proven depends on it: where no program is solved, coefficients stay what they are.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..foundation.loading import load_modules
from ..geometry.numbering import Grid
from .cells import extreme_at_corners
from .obstacle import ObstacleProblem
from .windows import Window

_WEIGHT = 1e4
"""W τ in lengths, for a τ that bends a membrane on a cell by one; with a hundredth of it lower bounds did not close."""

_FLAT = 1e-6
"""Under no load lengths are measured by this part of how far the coefficients lie apart."""

_LARGEST = 1e100
"""Lengths for which no program is tried."""


def mended_at_corners(problem: ObstacleProblem, coefficients: Grid, side: Literal[1, -1], spared: float = 0.0) -> Grid:
    """Return coefficients with others about corners that point inwards.

    Parameters
    ----------
    problem : ObstacleProblem
    coefficients : array, shape (rows + 4, columns + 4)
        Of a spline that continues the lattice's answer (length).
    side : {1, -1}
        1 for an upper bound, -1 for a lower one.
    spared : float
        For a lower bound, nothing is asked where the spline is no higher than this (length).
    """
    if not problem.windows or not np.abs(coefficients).max() < _LARGEST:  # nan is not, either
        return coefficients
    held = np.zeros(problem.cells.inside.shape, dtype=np.bool_)
    if side < 0:
        heights, _ = problem.at_points(coefficients)
        held = extreme_at_corners(heights, np.maximum) + problem.rest[1] <= spared
    mended = coefficients.copy()
    for window in problem.windows:
        mended.flat[window.places[window.free]] += _moves(problem, window, mended, side, held.ravel())
    return mended


def _moves(
    problem: ObstacleProblem, window: Window, coefficients: Grid, side: Literal[1, -1], held: Mask
) -> Vector | float:
    """Return by how much the coefficients of a window are moved (length)."""
    load_modules("scipy.optimize", "scipy.sparse")
    from scipy.optimize import linprog
    from scipy.sparse import block_array

    now, free = coefficients.flat[window.places], window.free
    scale = max(problem.largest_bend, _FLAT * float(np.ptp(now)))
    within, asked = window.within[free], _asked(window, held)
    if not (scale > 0.0 and asked.size):
        return 0.0
    bends, heights = window.bends[asked], window.heights.weights
    missed, off = _missed(problem, window, now, side)
    # Where coefficients about the window enter, the frame's height may be missed whatever its own are.
    allowed = np.where(window.loose, 0.0, np.maximum(off, 0.0))
    limits = np.concatenate([-missed[asked], allowed - off]) / scale
    if not np.isfinite(limits).all():
        return 0.0
    program = block_array(
        [[side * bends[:, free], np.full((asked.size, 1), -1.0)], [-side * heights[:, free], np.zeros((off.size, 1))]],
        format="csr",
    )
    found = linprog(
        np.append(side * within / max(within.sum(), 1), _WEIGHT),
        program,
        limits,
        bounds=np.vstack([_ends(window, now, side, held) / scale, [0.0, np.inf]]),
        method="highs-ds",
    )
    return 0.0 if found.x is None else np.asarray(found.x[:-1] * scale)


def _asked(window: Window, held: Mask) -> NDArray[np.intp]:
    """Return which Bernstein coefficients of the Laplacian are asked, those that cells share once."""
    asked = np.flatnonzero(~held[window.cells])
    _, first = np.unique(window.shared[asked], return_index=True)
    return np.asarray(asked[first])


def _missed(problem: ObstacleProblem, window: Window, now: Vector, side: Literal[1, -1]) -> tuple[Vector, Vector]:
    """Return by how much a spline misses what a membrane wants to bend, and the frame's height (length)."""
    bent = now if problem.floor is None else now - problem.floor.flat[window.places]
    load = (window.weights * problem.load.flat[window.corners]).sum(axis=1)
    rim = window.heights
    start, end = problem.heights.flat[rim.start], problem.heights.flat[rim.end]
    frame = start + rim.way * (end - start) + problem.height_range[1 if side > 0 else 0]
    return side * (window.bends @ bent - problem.bend(load)), side * (frame - rim.weights @ now)


def _ends(window: Window, now: Vector, side: Literal[1, -1], held: Mask) -> Grid:
    """Return by how much each coefficient of a window may be lowered and raised at most (length).

    An upper bound is not to fall below the support. Where nothing is asked a lower one would rise without end.
    """
    ends = np.tile([-np.inf, np.inf], (now.size, 1))
    if side > 0:
        ends[:, 0] = np.minimum(-now, 0.0)
    else:
        ends[np.unique(window.bends[held[window.cells]].indices), 1] = 0.0
    return ends[window.free]
