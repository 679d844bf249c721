r"""Where the membrane certainly touches its support, and where it certainly does not, between lattice points as well.

*Clear.* In a cell where the lower bound of the gap is positive, u* > 0.

*Contact* (nondegeneracy; Caffarelli, *The obstacle problem revisited*, J. Fourier Anal. Appl. 4, 1998, in the plane).
Let q ≥ q₀ > 0 on the disk B of radius r about x₀, which lies in Ω, and u* ≤ q₀r²/(4T) on its rim. Then u*(x₀) = 0. For
else let D be the part of B where u* > 0, and w = u* - q₀\|x - x₀\|²/(4T). In D it is TΔu* = q ≥ q₀, so that Δw ≥ 0, and
w takes its largest value, which is at least w(x₀) > 0, on the rim of D. Where that is within B, u* = 0 and w ≤ 0; so it
is on the rim of B, where then u* > q₀r²/(4T). So a cell is in contact if, for some r = kh, all of that holds for the
least q and the largest upper bound in the square of (2k + 1)² cells about it, which all the disks lie in.

*Area and force.* u* is in W^{2,p} within Ω (Kinderlehrer and Stampacchia, *An Introduction to Variational Inequalities
and Their Applications*, 1980, ch. IV), and Δu* = 0 almost everywhere where u* = 0; so the contact pressure ρ = q - TΔu*
is q in contact, up to sets of measure zero, and zero elsewhere: 0 ≤ ρ ≤ q⁺. The contact area is at least that of the
cells in contact, and at most that of those that are not clear; and the support bears at least the load on the former,
and at most q⁺ on those that are undecided besides.

*Free boundary.* It has no point in a cell that is clear or in contact, but for sides that these share with undecided
ones: it lies in the closed strip of the undecided cells. Conversely, let Ω be convex, x a point of the strip, and let
both a point in contact and a clear one be no farther from x than d. The line between these two lies in Ω and in the
disk of radius d about x, and meets the free boundary. So that is nowhere farther than d from x, and the Hausdorff
distance of strip and free boundary is no more than the largest d. Where the cell at x is shifted onto one in contact, x
moves as far as their middles are apart. (Onto a cell that the frame halves nothing is shifted: it might end outside.)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..foundation.brackets import Bracket, sum_above, sum_below
from ..foundation.checks import Mask
from ..foundation.loading import load_modules
from ..foundation.rounding import UNIT_ROUNDOFF
from ..geometry.numbering import Grid
from .cells import Cells

_SLACK = 16 * UNIT_ROUNDOFF

_MOST_RINGS = 24
"""Cells about a cell, at most, that are asked whether it is in contact."""


@dataclass(frozen=True, eq=False)
class ContactBounds:
    """What is certain of the membrane's contact.

    Attributes
    ----------
    clear, contact, undecided : array of bool, shape (rows + 1, columns + 1)
        Cells in all of which the gap is positive; in all of which it is zero; and the others of the region.
    area : Bracket
        Of the contact (length²).
    reaction : Bracket
        Of the force that the support bears (force).
    free_boundary_width : float
        The Hausdorff distance of the undecided cells from the free boundary is no more (length); infinite where
        nothing is known of it, zero without a free boundary.
    """

    clear: Mask
    contact: Mask
    undecided: Mask
    area: Bracket
    reaction: Bracket
    free_boundary_width: float


def contact_bounds(cells: Cells, tension: float, gap: tuple[Grid, Grid], load: tuple[Grid, Grid]) -> ContactBounds:
    """Return what bounds of the gap prove of the contact; see the module.

    Parameters
    ----------
    cells : Cells
    tension : float
        T (force per length).
    gap : pair of arrays, shape (rows + 1, columns + 1)
        A lower and an upper bound of the gap in each cell (length).
    load : pair of arrays, shape (rows + 1, columns + 1)
        A lower and an upper bound of q = p + TΔf in each cell (force per area); infinite where a support has a kink.
    """
    inside = cells.inside
    clear = inside & (gap[0] > 0.0)
    contact = _in_contact(cells, tension, gap[1], load[0]) & ~clear
    undecided = inside & ~clear & ~contact
    square, shares = cells.spacing**2, cells.shares
    touched = contact | undecided
    area = Bracket(
        float(shares[contact].sum() * square * (1 - _SLACK)), float(shares[touched].sum() * square * (1 + _SLACK))
    )
    # In contact the support bears q; a membrane may touch where that is not known to be positive.
    borne = (
        np.maximum(load[0], 0.0)[contact] * shares[contact],
        np.maximum(load[1], 0.0)[touched] * shares[touched],
    )
    reaction = Bracket(
        max(0.0, sum_below(borne[0]) * square * (1 - _SLACK)), max(0.0, sum_above(borne[1]) * square * (1 + _SLACK))
    )
    return ContactBounds(clear, contact, undecided, area, reaction, _width(cells, clear, contact, undecided))


def _in_contact(cells: Cells, tension: float, upper: Grid, load: Grid) -> Mask:
    """Return the cells that are in contact by nondegeneracy."""
    # Beyond the region nothing is known, so that no square may reach there.
    least_load, highest = np.where(cells.whole, load, -np.inf), np.where(cells.whole, upper, np.inf)
    found = np.zeros_like(cells.inside)
    for rings in range(1, _MOST_RINGS + 1):
        least_load, highest = _about(least_load, np.minimum, -np.inf), _about(highest, np.maximum, np.inf)
        radius = rings * cells.spacing
        enough = np.maximum(least_load, 0.0) * (radius**2 / (4.0 * tension)) * (1 - _SLACK)
        new = (least_load > 0.0) & (highest <= enough) & ~found
        if rings > 3 and found.any() and not new.any():
            break
        found |= new
    return found


def _about(cells: Grid, extreme: np.ufunc, beyond: float) -> Grid:
    """Return the extreme over each cell and the eight about it."""
    padded = np.pad(cells, 1, constant_values=beyond)
    rows = extreme(extreme(padded[:-2], padded[1:-1]), padded[2:])
    return np.asarray(extreme(extreme(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:]))


def _width(cells: Cells, clear: Mask, contact: Mask, undecided: Mask) -> float:
    if not undecided.any() and (clear.any() ^ contact.any()):
        return 0.0
    if not (cells.convex and (clear & cells.whole).any() and contact.any()):
        return np.inf
    load_modules("scipy.ndimage")
    from scipy.ndimage import distance_transform_edt

    apart = [distance_transform_edt(~known) for known in (clear & cells.whole, contact)]
    farthest = np.maximum(*apart).max(where=undecided, initial=0.0)
    return float(farthest * cells.spacing * (1 + _SLACK))
