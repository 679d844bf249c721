r"""The force that the support bears, to second order in the spacing: by a function that is one where it may press.

Let φ be twice continuously differentiable, 1 on all cells that are not certainly clear, and 0 near the frame. The
contact pressure ρ = q - TΔu* vanishes on the clear cells, so that, integrated by parts twice,

.. math:: \int ρ = \int ρφ = \int qφ - T \int u^* Δφ,

and with L ≤ u* ≤ U and m = (L + U)/2,

.. math:: \left| \int u^* Δφ - \int m Δφ \right| ≤ \tfrac12 \int (U - L) |Δφ|.

φ is a bicubic spline. m is one, but for a constant, for which ∫Δφ = 0, and half of (τ⁺ - τ⁻)v, for which ∫vΔφ = ∫φΔv =
-∫φ/T. Integrals of products of cubic B-splines are values of that of degree seven (de Boor, *A Practical Guide to
Splines*, 1978, ch. X): ∫B_i B_j = h B⁷(i - j), ∫B_i B_j'' is its second derivative over h. On a cell of area h²,
\|∫(q - q̄)φ\| is at most h² times the range of q, half that of φ; q̄ is the mean of q, which lies between the mean of its
values at the corners and what it may differ from its bilinear interpolant by.

Over a spline F in the place of the support, u is F - w, and q is p + TΔF: ∫ρ = ∫pφ + T∫wΔφ, where L ≤ F - w ≤ U.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..foundation.brackets import Bracket, sum_within
from ..foundation.checks import Mask
from ..foundation.loading import load_modules
from ..foundation.rounding import UNDERFLOW, gamma
from ..geometry.numbering import Grid
from .cells import Cells
from .obstacle import ObstacleProblem
from .pointwise import PointwiseBounds
from .splines import ranges_on_cells

_MASS = np.array([1.0, 120.0, 1191.0, 2416.0, 1191.0, 120.0, 1.0]) / 5040.0
_BENT = np.array([1.0, 24.0, 15.0, -80.0, 15.0, 24.0, 1.0]) / 120.0
_CELL = np.array([1.0, 11.0, 11.0, 1.0]) / 24.0

_ERROR = gamma(64)
"""Relative to the sum of moduli: each number is formed by fewer roundings than half of these."""


def reaction_bracket(problem: ObstacleProblem, bounds: PointwiseBounds, clear: Mask) -> Bracket:
    """Return a bracket of the force that the support bears; infinite where the frame is not certainly clear.

    Parameters
    ----------
    problem : ObstacleProblem
    bounds : PointwiseBounds
    clear : array of bool, shape (rows + 1, columns + 1)
        Cells that are certainly clear.
    """
    cells = problem.cells
    cutoff = cutoff_of(cells, clear)
    if cutoff is None or not (bounds.lower.holds and bounds.upper.holds):
        return Bracket(0.0, math.inf)
    lower, upper = bounds.lower, bounds.upper
    area, tension = cells.spacing**2, problem.tension
    weights, sizes = bent_weights(cutoff)
    middle = (lower.coefficients + upper.coefficients) / 2.0
    middle = middle if problem.floor is None else middle - problem.floor
    terms = weights * middle
    # Coefficients where no product with φ is left do not count.
    added, mean = sum_within(terms), _means(cutoff)
    pressed = sum_within(mean)
    work = tension * (added.lower + added.upper) / 2.0
    pushed = (upper.multiple - lower.multiple) / 2.0 * area * (pressed.lower + pressed.upper) / 2.0
    off = tension * (added.upper - added.lower)
    off += (upper.multiple + lower.multiple) * area * (pressed.upper - pressed.lower) + _ERROR * abs(pushed)
    off += (
        tension
        * _ERROR
        * float((sizes * (np.abs(middle) + np.abs(lower.coefficients) + np.abs(upper.coefficients))).sum())
    )
    bent = ranges_on_cells(cells, cutoff, 1.0, np.zeros(cells.nodes.shape))
    inside = cells.inside
    steep = np.maximum(np.abs(bent.least_excess), np.abs(bent.most_excess))
    between = ranges_on_cells(cells, upper.coefficients - lower.coefficients, tension, np.zeros(cells.nodes.shape)).most
    slip = problem.slip(upper.coefficients) + problem.slip(lower.coefficients)
    slip += 4 * _ERROR * float(np.abs(upper.coefficients).max() + np.abs(lower.coefficients).max())
    lifts = (upper.multiple + lower.multiple) * problem.largest_height + upper.shift + lower.shift
    apart = between + lifts + slip
    off += tension * area * float((steep * apart)[inside].sum()) / 2.0 * (1 + _ERROR)
    low, high = _loads(problem, mean, cutoff)
    least, most = low - work + pushed - off, high - work + pushed + off
    room = _ERROR * (abs(low) + abs(high) + abs(work) + abs(pushed))
    bracket = Bracket(least - room, most + room + UNDERFLOW)
    if not np.isfinite(bracket).all():  # what overflows on the way, and infinity less itself, bounds nothing
        return Bracket(0.0, math.inf)
    return Bracket(max(0.0, bracket.lower), max(0.0, bracket.upper))


def cutoff_of(cells: Cells, clear: Mask) -> Grid | None:
    """Return φ's coefficients, shape (rows + 4, columns + 4): a ramp from the frame; None where there is no room."""
    load_modules("scipy.ndimage")
    from scipy.ndimage import distance_transform_edt

    touched = cells.inside & ~clear
    if not touched.any():
        return np.zeros(tuple(np.array(cells.nodes.shape) + 2))
    ones = _blocks(touched)
    zeros = _blocks(~cells.whole) | ~_blocks(cells.whole)
    zeros[:3], zeros[-3:], zeros[:, :3], zeros[:, -3:] = True, True, True, True
    if (ones & zeros).any():
        return None
    to_one, to_zero = distance_transform_edt(~ones), distance_transform_edt(~zeros)
    way = to_zero / (to_one + to_zero)
    return np.asarray(np.where(ones, 1.0, np.where(zeros, 0.0, way * way * (3.0 - 2.0 * way))))


def _blocks(chosen: Mask) -> Mask:
    """Return the coefficients that a spline has on any of some cells."""
    rows, columns = chosen.shape
    found = np.zeros((rows + 3, columns + 3), dtype=bool)
    for down in range(4):
        for right in range(4):
            found[down : down + rows, right : right + columns] |= chosen
    return found


def bent_weights(cutoff: Grid) -> tuple[Grid, Grid]:
    """Return ∫B_kl Δφ, and the sum of the moduli that they are formed from."""
    load_modules("scipy.ndimage")
    from scipy.ndimage import correlate1d

    def both(across: NDArray[np.float64], along: NDArray[np.float64]) -> Grid:
        return np.asarray(
            correlate1d(correlate1d(cutoff, across, axis=0, mode="constant"), along, axis=1, mode="constant")
        )

    weights = both(_BENT, _MASS) + both(_MASS, _BENT)
    return weights, both(np.abs(_BENT), _MASS) + both(_MASS, np.abs(_BENT))


def _means(cutoff: Grid) -> Grid:
    """Return the mean of φ in each cell."""
    rows, columns = cutoff.shape[0] - 3, cutoff.shape[1] - 3
    down = sum(_CELL[k] * cutoff[k : k + rows] for k in range(4))
    return np.asarray(sum(_CELL[k] * down[:, k : k + columns] for k in range(4)))


def _loads(problem: ObstacleProblem, mean: Grid, cutoff: Grid) -> tuple[float, float]:
    """Return bounds of the integral of the load times φ."""
    cells = problem.cells
    inside, area = cells.inside, cells.spacing**2
    load = np.where(cells.corners, problem.load, 0.0)
    corners = np.stack([load[:-1, :-1], load[1:, :-1], load[:-1, 1:], load[1:, 1:]])
    below, above = (np.where(inside, end, 0.0) for end in problem.load_range)
    spread = (corners.max(axis=0) - corners.min(axis=0)) + (above - below)
    # φ lies between the least and the largest of 16 coefficients.
    rows, columns = inside.shape
    blocks = [cutoff[i : i + rows, j : j + columns] for i in range(4) for j in range(4)]
    largest, smallest = np.maximum.reduce(blocks), np.minimum.reduce(blocks)
    # Where φ vanishes the load does not count, though nothing be known of it.
    counts = inside & ((largest > 0.0) | (smallest < 0.0))
    size = _ERROR * (np.abs(corners).sum(axis=0) + np.abs(below) + np.abs(above))[counts]
    with np.errstate(invalid="ignore"):  # of an endless range nothing finite comes, with or without a swing
        off = spread[counts] * (largest - smallest)[counts] / 2.0 + size
        average, shares = corners.mean(axis=0)[counts], mean[counts]
        least = (average + below[counts]) * shares - off
        most = (average + above[counts]) * shares + off
    low, high = sum_within(least).lower * area, sum_within(most).upper * area
    return low - _ERROR * abs(low), high + _ERROR * abs(high)
