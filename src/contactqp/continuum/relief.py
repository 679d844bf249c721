r"""Reliefs: bounds of the norm that take curved supports and frames as they are between the nodes.

To lower v = Iw until it does not cross a curved support is more than need be, for the true reaction works on the same
gap. Let w ≤ f at the nodes, and let ψ vanish on the frame with c - v ≤ ψ ≤ f - v: near nodes that the support holds, ψ
is f - If, what is left between the nodes. λ, κ, η and the norms are those of `contactqp.continuum.energy`.

Keep what (1) drops there, φ² = ∫|T∇w* - y|²/T, and subtract (2): as ψ R* ≤ R⁺(f - v) + R⁻(v - c) and, by Gauss's
theorem, ∫(λ - R*)ψ = -∫(y - T∇w*)·∇ψ - ∫k(v - w*)ψ,

.. math:: ‖v - w*‖² + φ² ≤ η² + 2Λ' + 2κ(‖v - w*‖ + ‖ψ‖) + 2φ‖ψ‖_T + 2‖v - w*‖_k‖ψ‖_k - ‖v - w*‖_k²,

with Λ' = ∫λ⁺(f - v - ψ) + ∫λ⁻(v - c + ψ), which is zero within the contact. By 2ab ≤ a² + b² twice,

.. math:: ‖v - w*‖ ≤ κ + \sqrt{κ² + η² + ‖ψ‖² + 2Λ' + 2κ‖ψ‖}.                                                 (4)

ψ = χ(f - If), and χ is the least bilinear function that does: at a node 1 - gap/b, if that is positive, b being the
most by which the support lies below If in a square at the node that needs it, and zero on the frame. For then f - v - ψ
= I(f - w) + (1 - χ)(f - If) ≥ 0.

**Frames.** Where v = Iw + E at the frame, ‖Iw - w*‖² = ‖v - w*‖² + ‖E‖² - 2a(E, v - w*), with the product a of the
norm, and -a(E, v - w*) is no more than X + φ‖E‖_T + ‖E‖_k‖v - w*‖_k, X the sum over the squares at the frame of the
norm of E times that of T∇v - y. To the inequality above, in which 2κ‖v - w*‖ is bounded by (4), this adds what makes

.. math:: ‖Iw - w*‖² ≤ η² + 2Λ' + 2κ(‖v - w*‖ + ‖ψ‖) + (‖ψ‖ + ‖E‖)² + ‖E‖² + 2X,

where (‖ψ‖ + ‖E‖)² is summed up square by square.

**In the squares.** ∂_x(f - If) consists of two parts. The one of f - I_x f has the mean zero along each line; with f_xx
= m ± r its norm over the square is at most h²(|m|/√12 + r/π), and, for g = f - I_x f vanishes at both ends and so
∫g_x² = -∫g g_xx ≤ M² h³/12 on each line with M = |m| + r, at most h² M/√12. The one of I_x(f - I_y f) does not vary
with x, so that it is orthogonal to the first; it is a mean over x of f_x - I_y f_x, which vanishes at both ends, and
with f_xy known up to ± s its norm is at most h² s/π. ∂_x χ is at most the difference of the largest and the least value
of χ, over h.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask
from ..geometry.numbering import Grid
from .cell_fields import CellField
from .data import Data, Surfaces, kept_within
from .majorant import (
    at_any_corner,
    balanced_flux,
    costs_of,
    least_at_corners,
    leaves_of,
    misfit_in_squares,
    most_at_corners,
    most_of_foundation,
    norm_over,
    stays_above,
    stretch_of,
    sum_of_parts,
)
from .rounded import FEW, GROW, LESS_THAN_PI, TWELFTH_ROOT, or_infinite, rounded_up


def curved_bound(data: Data, own: Grid, rims: Grid) -> float:
    """Return a bound of the norm of Iw - w* that takes curved supports and frames as they are; infinite without one.

    Parameters
    ----------
    data : Data
    own : array, shape (rows + 2, columns + 2)
        Depths of the answer w and of the frame (length).
    rims : array, shape (rows + 1, columns + 1)
        Norm of what v has beside its interpolant at the frame, in each square.
    """
    plan = data.plan
    trial = own
    for surface, sign in data.surfaces:
        trial = kept_within(plan.nodes, trial, sign, surface.values)
    near = reliefs_near(data.surfaces, trial, partial(_relief, data))
    if near is None:
        return math.inf
    reliefs, lifted = near
    flux, force = balanced_flux(data, own, trial)
    cost, slack = costs_of(data, own, trial, lifted, flux, force)
    bumps, misfits = np.sqrt(np.add.reduce([relief.square for relief in reliefs])), misfit_in_squares(data, trial, flux)
    bump, misfit = norm_over(bumps), norm_over(misfits + rims)
    squares = misfit * misfit + bump * bump + 2 * max(0.0, cost) + 2 * slack * bump + slack * slack
    found = rounded_up(slack + math.sqrt(rounded_up(squares)))
    if rims.any():
        rim, both = norm_over(rims), norm_over(bumps + rims)
        squares = misfit * misfit + both * both + rim * rim + 2 * sum_of_parts(rims * (misfits + rims))
        squares += 2 * max(0.0, cost) + 2 * slack * (bump + found)
        found = min(rounded_up(found + rim), rounded_up(math.sqrt(rounded_up(squares))))
    clipped = 0.0 if trial is own or (trial == own).all() else stretch_of(data, own - trial).norm
    return or_infinite(rounded_up(found + clipped), 1)


class Relief(NamedTuple):
    """A function ψ near one of the surfaces, in each square or, of a cable, on each stretch.

    Attributes
    ----------
    square : array
        Upper bound of ‖ψ‖² there.
    left : array
        Upper bound of the mean of (1 - χ)(f - If) there, in a quarter of a square, on a half of a stretch.
    apart : array
        Upper bound of |ψ| there.
    room : array
        How far v stays clear of the surface at least, below 0 where it may touch.
    """

    square: NDArray[np.float64]
    left: NDArray[np.float64]
    apart: NDArray[np.float64]
    room: NDArray[np.float64]


def reliefs_near(
    surfaces: Surfaces,
    points: NDArray[np.float64],
    near: Callable[[CellField, float, NDArray[np.float64]], Relief | None],
) -> tuple[list[Relief], Surfaces] | None:
    """Return ψ near each surface, and the surfaces with what they then leave; None without ψ that is admissible.

    Parameters
    ----------
    surfaces : list of (CellField, float)
        With their signs.
    points : array
        Depths of the interpolant's points, between the surfaces at the nodes (length).
    near : callable
        Returns ψ near a surface of a sign, None if there is none.
    """
    lifted: Surfaces = []
    reliefs = list[Relief]()
    for surface, sign in surfaces:
        relief = near(surface, sign, points)
        if relief is None:
            return None
        lifted.append((replace(surface, mean_above=relief.left), sign))
        reliefs.append(relief)
    if len(reliefs) > 1 and any((one.apart > other.room).any() for one, other in (reliefs, reliefs[::-1])):
        return None
    return reliefs, lifted


def _relief(data: Data, surface: CellField, sign: float, points: Grid) -> Relief | None:
    """Return ψ near a surface, None if there is none that is known to be admissible."""
    plan = data.plan
    gap = np.where(plan.points, surface.values - sign * points, np.inf)
    least = least_at_corners(plan, gap) * (1 - FEW)
    leaves = leaves_of(data)
    touching = plan.nodes & (gap <= 0)
    flagged = plan.squares & ((least < surface.below) | at_any_corner(plan, touching))
    open_frame = np.where(plan.frame, gap, np.inf) * (1 - FEW)
    beside = least_at_corners(plan, open_frame)
    bends = data.bends_of(surface, sign)
    whole = np.isfinite(surface.below) & np.isfinite(surface.above)
    share, close = _shares(data, surface, gap, flagged), plan.squares & (beside < surface.below + leaves)
    closed = close & (~stays_above(data, surface) | (at_any_corner(plan, share > 0) & (surface.apart > 0)))
    some = plan.squares & at_any_corner(plan, share > 0)
    if bends is None or (flagged & ~whole).any() or closed.any() or (some & plan.halved).any():
        return None
    most, fewest = most_at_corners(plan, share), least_at_corners(plan, share)
    apart, turns = np.where(some, most * surface.apart, 0.0), most - fewest
    area = plan.spacing**2
    squares = np.zeros(some.shape)
    for axis, own in ((1, bends.xx), (0, bends.yy)):
        middle, radius = (own.lower + own.upper) / 2, (own.upper - own.lower) / 2 * GROW
        with np.errstate(invalid="ignore"):
            along = np.minimum(
                np.abs(middle) * TWELFTH_ROOT + radius / LESS_THAN_PI, (np.abs(middle) + radius) * TWELFTH_ROOT
            )
            across = (bends.xy.upper - bends.xy.lower) / (2 * LESS_THAN_PI)
            steep = np.sqrt(along**2 + across**2)
            part = np.where(some, area * most * steep + turns * surface.apart + 2 * surface.rounding, 0.0)
        tension = np.maximum.reduce(
            [np.broadcast_to(t.middle + t.spread, some.shape) for t in (data.tensions(axis, k) for k in range(4))]
        )
        squares += tension * part**2
    if data.foundation is not None:
        squares += most_of_foundation(data) * area * apart**2
    squares = np.where(some, squares, 0.0)
    if not np.isfinite(squares).all():
        return None
    left = np.where(most > 0, (1.0 - fewest) * np.maximum(surface.above, 0.0) + surface.rounding, surface.mean_above)
    room = np.where(plan.squares, least - surface.below - leaves, np.inf)
    return Relief(squares, left, apart, np.where(some, -1.0, room))


def _shares(data: Data, surface: CellField, gap: Grid, flagged: Mask) -> Grid:
    """Return χ at the points: no less at nodes than 1 - gap/below in the squares about them, zero at others."""
    plan = data.plan
    share = np.zeros(gap.shape)
    with np.errstate(divide="ignore", invalid="ignore"):
        for corner in range(4):
            needed = 1.0 + FEW - plan.at_corner(gap, corner) * (1 - FEW) / surface.below
            at = plan.at_corner(share, corner)
            np.maximum(at, np.where(flagged, np.where(np.isnan(needed), 1.0, np.clip(needed, 0.0, 1.0)), 0.0), out=at)
    return np.where(plan.nodes, share, 0.0)
