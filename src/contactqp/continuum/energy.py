r"""Energy: bounds of a membrane's potential energy, and of how far the interpolant of an answer is from it.

**The membrane.** Over a region Ω that consists of squares of the lattice, and of halves of squares along their
diagonals, w has the least energy

.. math:: J(w) = \int_Ω ½(T_x w_x² + T_y w_y² + kw²) - pw

of all w with c ≤ w ≤ f and w = g on the frame; depths are positive downwards. R* = p + div(T∇w*) - kw* is its
reaction, R* = R⁺ - R⁻ with R⁺ ≥ 0 where w* = f and R⁻ ≥ 0 where w* = c. Write ‖·‖ for the energy norm, ‖u‖² = ∫ T|∇u|²
+ ku².

**The identity.** Let v be any function with v = g on the frame, y any field of fluxes, of which the component across a
line does not jump, and λ = p + div y - kv. By expanding squares and Gauss's theorem,

.. math:: J(v) - J(w*) = ½\int |T∇v - y|²/T - ½\int |T∇w* - y|²/T + \int λ(w* - v) - ½\int k(w* - v)².          (1)

On the other hand J(v) - J(w*) = ½‖v - w*‖² + ∫R*(w* - v), because w* is in balance, and

.. math:: \int R*(w* - v) = \int R⁺(f - v) + \int R⁻(v - c)                                                  (2)

is the *contact error*: not negative where c ≤ v ≤ f. (Prager and Synge 1947 is (1) for a membrane without contact;
Repin, *Estimates of deviations from exact solutions of elliptic variational inequalities*, 2000, has the obstacle.)

**What λ costs.** Split λ = λ⁺ - λ⁻ + ν with λ⁺, λ⁻ ≥ 0. As c ≤ w* ≤ f,

.. math:: \int λ(w* - v) ≤ \int λ⁺(f - v) + \int λ⁻(v - c) + \int ν(w* - v) =: Λ + \int ν(w* - v).

What is left, ν, is of either sign and small: the rounding of the fluxes, the residual of an inexact answer, a reaction
of the wrong sign, and how the load differs from its values at the nodes. The function u = w* - v vanishes on the
frame, and

* on the whole Ω, which fits into a rectangle with the sides a and b: ∫T|∇u|² ≥ π²(T_x/a² + T_y/b²) ∫u² with the least
  tensions (Friedrichs), and the same holds of a rectangle along diagonals, with the less of both tensions;
* on a square of side h, ∫|u - ū|² ≤ (h/π)² ∫|∇u|² with ū its mean (Payne and Weinberger 1960), and on a square of side
  h/2 on one side of which u vanishes, ∫u² ≤ (h/π)² ∫|∇u|² (Friedrichs in one direction).

So ∫νu ≤ κ‖u‖, where κ sums up the norms of ν by these constants; a part of ν whose mean over a node's square is zero
pays the smaller one. With η² = ∫|T∇v - y|²/T and A = ½η² + Λ, (1) and (2) say for c ≤ v ≤ f

.. math:: ½‖v - w*‖² + \int R⁺(f - v) + \int R⁻(v - c) = J(v) - J(w*) ≤ A + κ‖v - w*‖,

.. math:: ‖v - w*‖ ≤ κ + \sqrt{κ² + 2A} =: e, \quad \text{contact error} ≤ A + ½κ², \quad
          J(v) - A - κe ≤ J(w*) ≤ J(v).                                                                      (3)

There is no unknown constant, and no assumption on how v was found. The lower bound of J(w*), and with it the bound of
the norm, need no v ≤ f where Λ may be of either sign: only (2) does.

**The flux.** v is the bilinear interpolant of the answer w, and y is made of its own differences, see `fluxes`: λ is
R_i/h² in the square about node i, for the lattice's own reaction R_i, but for the difference of p - kv from its value
at the node and from what y takes of that. The reaction of the lattice is not negative where its support holds it: *the
answer of five-point differences is its own equilibrated flux*. Nodes in contact, by the rule gap_i G_ii < R_i, give λ⁺
= R_i/h², those at the ceiling λ⁻; all else of R_i goes to ν.

**Along diagonals.** In a square that the frame halves v is linear on the half, which consists of a quarter that belongs
to the square's node and of two triangles that belong to points of the frame. The squares about nodes stay whole; what
differs on the triangles has a module of its own, `majorant_on_halves`.

**Where v must be lower.** The support lies below its interpolant If by at most ``below`` (see `cell_fields`). With v_i
= min(w_i, f_i - b_i), where b_i is the most of it in the squares at the node, Iv ≤ If - Ib ≤ f. In a square one edge of
which is the frame at y = 0, where g ≤ f, f is bounded from below by interpolating in y: there b_i = h²/8 max f_xx +
h²/2 max f_yy is enough, at most four times ``below``. Where the support does not bend away from its chords there, and
no other edge of the frame is bent, v lies above it as soon as its nodes and the frame do. Four times ``below`` serves a
square that touches the frame at a corner, or at two opposite ones: for ξ and η as parts of its sides, counted from that
corner, lowering the other nodes by b lowers v by b(ξ + η - ξη), or b(ξ + η - 2ξη), none of which is less than b ξ(1 -
ξ) or b η(1 - η). The contact error is that of this v. The norm of w's own interpolant differs from it by at most ‖I(w -
v)‖.

**Curved supports.** That is more than it need be, for the true reaction works on the same gap: see `relief`.

**Frame.** Where the frame leaves the chord between two of its points, with |g″| ≤ γ, v has E = (g - Ig)(1 - t/h) added
in the squares beside it, t the distance from the frame: then v = g. As g - Ig vanishes at both ends of an edge, ∫|g -
Ig|² ≤ (h/π)⁴γ²h and ∫|g′ - Ig′|² ≤ (h/π)²γ²h, so that ∫|∇E|² ≤ γ²h⁴(1/(3π²) + 1/π⁴) for each edge.

**Rounding.** v's values and y's fluxes are the doubles in memory, whatever they are: v and y are then admissible
exactly. λ, the squares and their sums are bounded with all rounding (Higham 2002, ch. 3); sums are rounded once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..foundation.brackets import Bracket, sum_above, sum_below
from ..foundation.rounding import UNDERFLOW
from ..geometry.numbering import Grid
from .cell_fields import CellField
from .data import Data, kept_at, kept_within
from .majorant import (
    Stretch,
    apart_of,
    balanced_flux,
    costs_of,
    least_at_corners,
    leaves_of,
    mean_at_corners,
    misfit_in_squares,
    most_at_corners,
    most_in_squares,
    most_of_foundation,
    norm_over,
    rim_in_squares,
    stays_above,
    stretch_of,
    sum_of_parts,
)
from .majorant_on_halves import BENT_MEAN, BENT_SQUARED, fall_on_halves, product_on_halves
from .relief import curved_bound
from .rounded import FEW, GROW, finite_or_nan, or_infinite, rounded_up


@dataclass(frozen=True)
class EnergyBounds:
    """What is proven of a membrane's energy by one answer of its lattice; see `contactqp.continuum.energy`.

    Attributes
    ----------
    energy : Bracket
        Of J(w*) (force times length).
    error : float
        Bound of the energy norm of the difference of w* and the bilinear interpolant of the answer (square root of
        force times length).
    contact_error : float
        Bound of the contact error of the interpolant, lowered where it would cross the support (force times length).
    norm : float
        Energy norm of the interpolant itself.
    """

    energy: Bracket
    error: float
    contact_error: float
    norm: float


def energy_bounds(data: Data, depths: Grid) -> EnergyBounds:
    """Return what an answer of the lattice proves of its membrane's energy.

    Parameters
    ----------
    data : Data
    depths : array, shape (rows + 2, columns + 2)
        Of the answer's nodes, positive downwards (length); what it has at other points is not used.

    Raises
    ------
    ValueError
        If support or ceiling leave no room for the frame.
    """
    own = points_of(data, depths)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        admissible = _admissible(data, own)
        if admissible is None:
            return EnergyBounds(Bracket(-np.inf, np.inf), np.inf, np.inf, stretch_of(data, own).norm)
        stretch = stretch_of(data, admissible)
        flux, force = balanced_flux(data, own, admissible)
        cost, slack = costs_of(data, own, admissible, data.surfaces, flux, force)
        rims = rim_in_squares(data)
        rim = norm_over(rims) if rims.any() else 0.0
        misfit = norm_over(misfit_in_squares(data, admissible, flux) + rims)
        gap = max(0.0, rounded_up(misfit * misfit / 2 + cost))
        norm = rounded_up(slack + math.sqrt(rounded_up(slack * slack + 2 * gap)))
        energy = _energy(data, admissible, stretch, rim)
        lower = sum_below([energy.lower, -gap, -rounded_up(slack * norm)])
        contact = rounded_up(gap + slack * slack / 2)
        error, known = norm, stretch.norm
        if admissible is not own:
            known = stretch_of(data, own).norm
            error = rounded_up(norm + stretch_of(data, own - admissible).norm)
        if rim or admissible is not own:
            error = min(rounded_up(error + rim), curved_bound(data, own, rims))
    bounds = lower, energy.upper, error, contact
    lower, upper, error, contact = (or_infinite(bound, away) for bound, away in zip(bounds, (-1, 1, 1, 1), strict=True))
    return EnergyBounds(Bracket(lower, upper), error, contact, known)


def energy_norm(data: Data, points: Grid) -> float:
    """Return the energy norm of the bilinear interpolant of values at the points, rounded upwards.

    Parameters
    ----------
    data : Data
    points : array, shape (rows + 2, columns + 2)
        Lengths, zero at points that do not belong to the membrane.
    """
    return stretch_of(data, points).norm


def points_of(data: Data, depths: Grid) -> Grid:
    """Return depths at nodes with those of the frame at its points, and zero elsewhere (length)."""
    plan = data.plan
    return np.where(plan.nodes, depths, np.where(plan.frame, data.frame.values, 0.0))


def _energy(data: Data, points: Grid, stretch: Stretch, rim: float) -> Bracket:
    """Return a bracket of J(v) of the interpolant of values at the points, with what is added at the frame."""
    plan, load, foundation = data.plan, data.load, data.foundation
    force = load.values if foundation is None else load.values - foundation.values * points / 2
    size = np.abs(load.values) + (0.0 if foundation is None else np.abs(foundation.values * points))
    apart = apart_of(data, points, 0.5)
    work, most = np.zeros(plan.squares.shape), np.zeros(plan.squares.shape)
    # The mass matrix of bilinear functions on a square of side 1: 4, 2, 2 and 1 over 36.
    for corner in range(4):
        for which, weight in enumerate((4.0, 2.0, 2.0, 1.0)):
            own, other = plan.at_corner(points, corner), kept_at(plan, force, corner, which)
            work += weight * own * other
            most += weight * np.abs(own) * kept_at(plan, size, corner, which)
    work, most = work / 36, most / 36
    product_on_halves(plan, force, points, work)
    product_on_halves(plan, size, np.abs(points), most)
    square = plan.spacing**2
    work, most = square * work, square * most
    error = stretch.error + FEW * most + square * apart * mean_at_corners(plan, np.abs(points)) * GROW
    known = finite_or_nan(stretch.stored - work)[plan.squares]
    error = error[plan.squares] + FEW * np.abs(known) + UNDERFLOW
    extra = 0.0
    if rim:
        bend, edges = data.bend_of_frame, plan.frame_edges
        # What is added meets p - kv, the whole of the springs.
        most_force = most_at_corners(plan, size) + apart_of(data, points, 1.0)
        touched = most_force * bend * np.where(plan.halved, BENT_MEAN, edges / 24)
        beside = math.sqrt(2 * sum_of_parts((stretch.stored + stretch.error)[(edges > 0) | plan.halved]))
        extra = rounded_up(rim * beside) + rounded_up(rim * rim / 2)
        extra += sum_of_parts(plan.spacing**4 * touched[plan.squares])
        if foundation is not None:
            bent = most_of_foundation(data) * bend**2 * np.where(plan.halved, BENT_SQUARED, edges**2)
            extra += sum_of_parts(bent[plan.squares]) * square**3
    return Bracket(
        sum_below([*(known - error).tolist(), -rounded_up(extra)]),
        sum_above([*(known + error).tolist(), rounded_up(extra)]),
    )


def _admissible(data: Data, own: Grid) -> Grid | None:
    """Return values at the points whose interpolant crosses neither support nor ceiling, and which are the frame's.

    They are the answer's own, moved no farther than that takes; None if there is no telling how. The same array is
    returned where nothing is to be moved.

    Raises
    ------
    ValueError
        If the frame's own height lies beyond them.
    """
    sides = data.surfaces
    lowered = own
    for surface, sign in sides:
        most = _most(data, surface, sign * own, "support" if sign > 0 else "ceiling")
        if most is None:
            return None
        if (sign * lowered > most)[data.plan.nodes].any():
            lowered = kept_within(data.plan.nodes, lowered, sign, most)
    return (
        None
        if len(sides) > 1 and any(_crosses(data, surface, sign * lowered, sign) for surface, sign in sides)
        else lowered
    )


def _crosses(data: Data, surface: CellField, points: Grid, sign: float) -> bool:
    most = _most(data, surface, points, "support" if sign > 0 else "ceiling")
    return most is None or bool((points > most)[data.plan.nodes].any())


def _most(data: Data, surface: CellField, points: Grid, name: str) -> Grid | None:
    """Return how deep nodes may be so that their interpolant stays above a surface, None if that cannot be told."""
    plan = data.plan
    # A roof that begins at the frame may have been rounded to the other side of it.
    frame, rounding = points[plan.frame], most_in_squares(plan, surface.rounding)
    beyond = frame > surface.values[plan.frame] + rounding[plan.frame]
    if beyond.any():
        worst = int(np.argmax(beyond))
        row, column = np.argwhere(plan.frame)[worst]
        x, y = plan.lattice.ring_coordinates(np.array([row]), np.array([column]))
        raise ValueError(
            f"the frame at x={x[0]:g}, y={y[0]:g} lies beyond the {name}, by "
            f"{frame[worst] - surface.values[plan.frame][worst]:.3g}: no membrane can be held there; the {name} must "
            "leave room for the frame"
        )
    steep = (
        ~np.isfinite(surface.below)
        | np.isinf(surface.range_lower)
        | ~np.isfinite(most_at_corners(plan, np.abs(surface.values)))
    )
    fall = np.where(steep, 0.0, surface.below) * GROW
    leaves = leaves_of(data)
    gap = least_at_corners(plan, surface.values - points)
    spare = gap * (1 - FEW) >= fall + leaves
    # Along lines on which the support does not bend away from its chords, it is enough that nodes are not below it.
    straight = stays_above(data, surface)
    beside = 4.0 * surface.bent_below * GROW
    fall_on_halves(data, surface, 1.0 if name == "support" else -1.0, beside)
    corners = plan.squares & (plan.frame_corners > 0)
    # No edge of these holds more of v than its ends do.
    free = corners & (plan.frame_edges == 0)
    beside = np.where(free & spare, 0.0, np.where(free & straight & (fall < beside), fall, beside))
    on_edge = corners & (plan.frame_edges <= 1) & np.isfinite(beside)
    at_frame = corners & ~on_edge
    if (at_frame & ~steep & ~straight & ~spare).any():
        return None
    bottom = np.where(steep, surface.range_lower, np.inf)
    drop = np.where(at_frame & spare & ~straight, 0.0, np.where(on_edge, beside, fall))
    room, least = np.zeros(points.shape), np.full(points.shape, np.inf)
    for corner in range(4):
        at, low = plan.at_corner(room, corner), plan.at_corner(least, corner)
        np.maximum(at, np.where(plan.having(corner), drop, 0.0), out=at)
        np.minimum(low, np.where(plan.having(corner), bottom, np.inf), out=low)
    bulge = plan.spacing**2 / 8 * np.where(plan.halved, 2, 1) * data.bend_of_frame
    if (points + most_in_squares(plan, bulge) > least)[plan.frame].any():
        return None
    reach = surface.values - room
    reach = np.where(room > 0, np.nextafter(reach, -np.inf), reach)
    return np.asarray(np.minimum(reach, least))
