r"""Energy: bounds of a membrane's potential energy, and of how far the interpolant of an answer is from it.

**The membrane.** Over a region Ω that consists of squares of the lattice, w has the least energy

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
  tensions (Friedrichs);
* on a square of side h, ∫|u - ū|² ≤ (h/π)² ∫|∇u|² with ū its mean (Payne and Weinberger 1960), and on a square of side
  h/2 on one side of which u vanishes, ∫u² ≤ (h/π)² ∫|∇u|² (Friedrichs in one direction).

So ∫νu ≤ κ‖u‖, where κ sums up the norms of ν by these constants; a part of ν whose mean over a node's square is zero
pays the smaller one. With η² = ∫|T∇v - y|²/T and A = ½η² + Λ, (1) and (2) say for c ≤ v ≤ f

.. math:: ½‖v - w*‖² + \int R⁺(f - v) + \int R⁻(v - c) = J(v) - J(w*) ≤ A + κ‖v - w*‖,

.. math:: ‖v - w*‖ ≤ κ + \sqrt{κ² + 2A} =: e, \quad \text{contact error} ≤ A + ½κ², \quad
          J(v) - A - κe ≤ J(w*) ≤ J(v).                                                                      (3)

There is no unknown constant, and no assumption on how v was found. The lower bound of J(w*), and with it the bound of
the norm, need no v ≤ f where Λ may be of either sign: only (2) does.

**The flux.** v is the bilinear interpolant of the answer w, and y is made of its own differences: through the line
that separates two neighbouring nodes, halfway, the flux is T(w_j - w_i)/h, and on the square of side h about a node
y_x is linear in x and y_y in y (Raviart and Thomas 1977, on the dual squares). So div y is constant there, and h² div
y is the sum of the four differences: -P_i + R_i + kw_i h² for the lattice's own reaction R_i = p_i h² + Σ T(w_j - w_i)
- kw_i h². Thus λ is R_i/h² but for the difference of p - kv from its value at the node. The reaction of the lattice is
not negative where its support holds it: *the answer of five-point differences is its own equilibrated flux*. Nodes in
contact, by the rule gap_i G_ii < R_i, give λ⁺ = R_i/h², those at the ceiling λ⁻; all else of R_i goes to ν.

Squares about frame points lie in Ω in quarters. Counterclockwise from one edge of the frame to the next, the flux U
across the lines through the point follows from quarter to quarter by div y = -(p - kv) at the point; the one number
that is left free makes the differences from T∇v small in the mean. What flows through the frame itself is free.

**Where v must be lower.** The support lies below its interpolant If by at most ``below`` (see `cell_fields`). With v_i
= min(w_i, f_i - b_i), where b_i is the most of it in the squares at the node, Iv ≤ If - Ib ≤ f. In a square one edge
of which is the frame at y = 0, where g ≤ f, f is bounded from below by interpolating in y: there b_i = h²/8 max f_xx +
h²/2 max f_yy is enough, at most four times ``below``. The contact error is that of this v. The norm of w's own
interpolant differs from it by at most ‖I(w - v)‖.

**Curved supports.** That is more than it need be, for the true reaction works on the same gap. Let now v = Iw, w ≤ f
at the nodes, and let ψ vanish on the frame with c - v ≤ ψ ≤ f - v: near nodes that the support holds, ψ is f - If,
what is left between the nodes. Keep what (1) drops, φ² = ∫|T∇w* - y|²/T, and subtract (2): as ψ R* ≤ R⁺(f - v) + R⁻(v
- c) and, by Gauss's theorem, ∫(λ - R*)ψ = -∫(y - T∇w*)·∇ψ - ∫k(v - w*)ψ,

.. math:: ‖v - w*‖² + φ² ≤ η² + 2Λ' + 2κ(‖v - w*‖ + ‖ψ‖) + 2φ‖ψ‖_T + 2‖v - w*‖_k‖ψ‖_k - ‖v - w*‖_k²,

with Λ' = ∫λ⁺(f - v - ψ) + ∫λ⁻(v - c + ψ), which is zero within the contact. By 2ab ≤ a² + b² twice,

.. math:: ‖v - w*‖ ≤ κ + \sqrt{κ² + η² + ‖ψ‖² + 2Λ' + 2κ‖ψ‖}.

ψ = χ(f - If) with χ bilinear, 1 at the nodes near contact and 0 on the frame and beyond. In a square ∂_x(f - If) has
the part of f - I_x f, whose mean along each line is zero: with f_xx = m ± r its norm over the square is at most
h²(|m|/\sqrt{12} + r/π); and the part of I_x(f - I_y f), at most h²/4 (max f_xy - min f_xy). Where χ changes, |f - If|
is added.

**Frame.** Where the frame leaves the chord between two of its points, with |g″| ≤ γ, v has E = (g - Ig)(1 - t/h) added
in the squares beside it, t the distance from the frame: then v = g. As g - Ig vanishes at both ends of an edge, ∫|g -
Ig|² ≤ (h/π)⁴γ²h and ∫|g′ - Ig′|² ≤ (h/π)²γ²h, so that ∫|∇E|² ≤ γ²h⁴(1/(3π²) + 1/π⁴) for each edge.

**Rounding.** v's values and y's fluxes are the doubles in memory, whatever they are: v and y are then admissible
exactly. λ, the squares and their sums are bounded with all rounding (Higham 2002, ch. 3); sums are rounded once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..foundation.brackets import Bracket, sum_above, sum_below
from ..foundation.checks import Mask
from ..foundation.rounding import UNDERFLOW, gamma
from ..geometry.numbering import Grid
from .cell_fields import CellField
from .data import Data, Surfaces, kept_at
from .plan import CORNERS, Plan
from .rounded import FEW, GROW, LESS_THAN_PI, finite_or_nan, or_infinite, rounded_up

_TWELFTH_ROOT = 0.28867513459481292
"""No less than the square root of a twelfth."""

_MEAN_OF_QUARTER = (9 / 16, 3 / 16, 3 / 16, 1 / 16)
"""Weights of a square's corners in the mean of a bilinear function over the quarter at the first of them; exact."""


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
            return EnergyBounds(Bracket(-np.inf, np.inf), np.inf, np.inf, _stretch(data, own).norm)
        stretch = _stretch(data, admissible)
        flux = _flux(data, own, admissible, data.surfaces)
        rim = _norm_of_rim(data)
        misfit = rounded_up(_misfit(data, admissible, flux) + rim)
        gap = max(0.0, rounded_up(misfit * misfit / 2 + flux.cost))
        norm = rounded_up(flux.slack + math.sqrt(rounded_up(flux.slack * flux.slack + 2 * gap)))
        energy = _energy(data, admissible, stretch, rim)
        lower = sum_below([energy.lower, -gap, -rounded_up(flux.slack * norm)])
        contact = rounded_up(gap + flux.slack * flux.slack / 2)
        error, known = norm, stretch.norm
        if admissible is not own:
            known = _stretch(data, own).norm
            error = min(rounded_up(norm + _stretch(data, own - admissible).norm), curved_bound(data, own, rim))
    bounds = lower, energy.upper, rounded_up(error + rim) if rim else error, contact
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
    return _stretch(data, points).norm


def points_of(data: Data, depths: Grid) -> Grid:
    """Return depths at nodes with those of the frame at its points, and zero elsewhere (length)."""
    plan = data.plan
    return np.where(plan.nodes, depths, np.where(plan.frame, data.frame.values, 0.0))


def _sum_above(values: Grid) -> float:
    """Return an upper bound of the sum of numbers >= 0 that have been rounded a few times each."""
    return rounded_up(float(values.sum()) * (1 + gamma(values.size)) + values.size * UNDERFLOW)


class _Stretch(NamedTuple):
    """What the tension stores in each square: ∫½T|∇v|² and a bound of its error, and the energy norm of v, bounded."""

    stored: Grid
    error: Grid
    norm: float


def _differences(points: Grid) -> tuple[Grid, Grid]:
    """Return differences along x, shape (rows, columns - 1), and along y."""
    return np.diff(points, axis=1), np.diff(points, axis=0)


def _sides(parts: tuple[Grid, Grid], axis: int, corner: int) -> tuple[Grid, Grid]:
    """Return what the side of each square has that begins at a corner, along an axis, and the side opposite to it."""
    down, right = CORNERS[corner]
    part, place = (parts[0], down) if axis == 1 else (parts[1], right)
    if axis == 1:
        return part[place : place + part.shape[0] - 1], part[1 - place : part.shape[0] - place]
    return part[:, place : place + part.shape[1] - 1], part[:, 1 - place : part.shape[1] - place]


def _stretch(data: Data, points: Grid) -> _Stretch:
    plan = data.plan
    differences = _differences(points)
    stored, error = np.zeros(plan.squares.shape), np.zeros(plan.squares.shape)
    for corner in range(4):
        for axis in (0, 1):
            near, far = _sides(differences, axis, corner)
            tension = data.tensions(axis, corner)
            square = _mean_square(near, far)
            stored += tension.middle / 8 * square
            swing = np.abs(far - near) * np.maximum(np.abs(near), np.abs(far))
            error += tension.mean_apart / 8 * square + tension.spread / 8 * swing
    error = error * GROW + FEW * stored + UNDERFLOW
    total = 2 * _sum_above((stored + error)[plan.squares])
    if data.foundation is not None:
        total += _sum_above((_most_of_foundation(data) * plan.spacing**2 * _mass(plan, points**2))[plan.squares])
    return _Stretch(stored, error, rounded_up(math.sqrt(total)))


def _most_of_foundation(data: Data) -> Grid:
    assert data.foundation is not None
    return np.asarray(np.maximum(data.foundation.range_upper, 0.0))


def _mean_square(near: Grid, far: Grid) -> Grid:
    """Return the mean of the square of what goes from a value to another one, over the half next to the first."""
    return np.asarray(((3 * near + far) / 4) ** 2 + ((far - near) / 2) ** 2 / 12)


def _mass(plan: Plan, points: Grid) -> Grid:
    """Return the mean of what points have at the corners of each square."""
    return np.asarray(sum(plan.at_corner(points, corner) for corner in range(4))) / 4


def _energy(data: Data, points: Grid, stretch: _Stretch, rim: float) -> Bracket:
    """Return a bracket of J(v) of the interpolant of values at the points, with what is added at the frame."""
    plan, load, foundation = data.plan, data.load, data.foundation
    force = load.values if foundation is None else load.values - foundation.values * points / 2
    size = np.abs(load.values) + (0.0 if foundation is None else np.abs(foundation.values * points))
    apart = _apart(data, points, 0.5)
    work, most = np.zeros(plan.squares.shape), np.zeros(plan.squares.shape)
    # The mass matrix of bilinear functions on a square of side 1: 4, 2, 2 and 1 over 36.
    for corner in range(4):
        for which, weight in enumerate((4.0, 2.0, 2.0, 1.0)):
            own, other = plan.at_corner(points, corner), kept_at(plan, force, corner, which)
            work += weight * own * other
            most += weight * np.abs(own) * kept_at(plan, size, corner, which)
    square = plan.spacing**2
    work, most = square / 36 * work, square / 36 * most
    error = stretch.error + FEW * most + square * apart * _mass(plan, np.abs(points)) * GROW
    known = finite_or_nan(stretch.stored - work)[plan.squares]
    error = error[plan.squares] + FEW * np.abs(known) + UNDERFLOW
    extra = 0.0
    if rim:
        bend, edges = data.bend_of_frame, plan.frame_edges
        touched = np.where(plan.squares, (_corner_most(plan, size) + load.apart) * bend * edges, 0.0)
        beside = math.sqrt(2 * _sum_above((stretch.stored + stretch.error)[edges > 0]))
        extra = rounded_up(rim * beside) + rounded_up(rim * rim / 2) + _sum_above(plan.spacing**4 / 24 * touched)
        if foundation is not None:
            extra += (
                _sum_above(np.where(plan.squares, _most_of_foundation(data) * (edges * bend) ** 2, 0.0)) * square**3
            )
    return Bracket(
        sum_below([*(known - error).tolist(), -rounded_up(extra)]),
        sum_above([*(known + error).tolist(), rounded_up(extra)]),
    )


def _corner_most(plan: Plan, points: Grid) -> Grid:
    return np.asarray(np.maximum.reduce([plan.at_corner(points, corner) for corner in range(4)]))


def _apart(data: Data, points: Grid, share: float) -> Grid:
    """Return how far p - share k v lies from the interpolant of its values in each square, at most.

    The product of two bilinear functions leaves its interpolant by ¼(|Δk||Δv|) in each direction at most.
    """
    plan, foundation = data.plan, data.foundation
    if foundation is None:
        return data.load.apart
    deep = _corner_most(plan, np.abs(points))
    product = foundation.apart * deep
    for stiff, high in zip(_differences(foundation.values), _differences(np.asarray(points)), strict=True):
        axis = 1 if stiff.shape[1] < foundation.values.shape[1] else 0
        pairs = [_sides((each, each), axis, 0) for each in (np.abs(stiff), np.abs(high))]
        product = product + np.maximum(*pairs[0]) * np.maximum(*pairs[1]) / 4
    rounding = FEW * _corner_most(plan, np.abs(data.load.values) + np.abs(foundation.values * points))
    beside = _most_of_foundation(data) * _leaves(data)
    return np.asarray((data.load.apart + share * product + rounding + beside) * GROW)


def _leaves(data: Data) -> Grid:
    """Return how far v lies from its interpolant beside the frame at most."""
    return np.asarray(data.bend_of_frame * data.plan.frame_edges * data.plan.spacing**2 / 8 * GROW)


class _Flux(NamedTuple):
    """The flux y, times the spacing, and what λ costs with it.

    Attributes
    ----------
    across : pair of arrays
        Through the lines halfway between two points: along x, shape (rows + 2, columns + 1), and along y.
    at_corners : list of pairs of arrays, shape (rows + 1, columns + 1)
        For each corner of the squares: y_x on the line x = const through it, and y_y on the line y = const.
    cost : float
        Upper bound of Λ (force times length).
    slack : float
        κ, upper bound (square root of force times length).
    """

    across: tuple[Grid, Grid]
    at_corners: list[tuple[Grid, Grid]]
    cost: float
    slack: float


def _flux(data: Data, own: Grid, trial: Grid, surfaces: Surfaces) -> _Flux:
    plan, square = data.plan, data.plan.spacing**2
    along_x, along_y = _differences(own)
    across = data.arms[0] * along_x, data.arms[1] * along_y
    load, foundation = data.load.values, data.foundation
    force = load if foundation is None else load - foundation.values * trial
    size = np.abs(load) if foundation is None else np.abs(load) + np.abs(foundation.values * trial)
    at_points = np.zeros(own.shape), np.zeros(own.shape)
    at_points[0][:, 1:-1] = (across[0][:, :-1] + across[0][:, 1:]) / 2
    at_points[1][1:-1] = (across[1][:-1] + across[1][1:]) / 2
    at_corners = [(plan.at_corner(at_points[0], k).copy(), plan.at_corner(at_points[1], k).copy()) for k in range(4)]
    loose = _at_frame(plan, across, at_corners, force, size)
    # The reaction at the nodes, as the fluxes have it.
    pulls, sums = np.zeros(own.shape), np.zeros(own.shape)
    for part, axis in zip(across, (1, 0), strict=True):
        inner = (slice(None), slice(1, -1)) if axis == 1 else (slice(1, -1), slice(None))
        pulls[inner] += np.diff(part, axis=axis)
        size_of = np.abs(part)
        sums[inner] += size_of[:, :-1] + size_of[:, 1:] if axis == 1 else size_of[:-1] + size_of[1:]
    nodes = plan.nodes
    reaction = np.where(nodes, force * square + pulls, 0.0)
    rounding = np.where(nodes, FEW * (size * square + sums), 0.0)
    pressed, cost = np.zeros_like(nodes), 0.0
    for surface, sign in surfaces:
        push = sign * reaction
        mean, room = _mean_gap(data, surface, sign * trial)
        with np.errstate(invalid="ignore"):  # where there is neither node nor support
            held = nodes & (push > 0) & ((surface.values - sign * own) * data.stiffness < push)
            paid = (mean + room) * push
        held &= np.isfinite(paid)
        paid = paid[held]
        cost += sum_above((paid + FEW * np.abs(paid) + UNDERFLOW).tolist())
        pressed |= held
    left = np.where(pressed, 0.0, np.abs(reaction)) + rounding
    return _Flux(across, at_corners, cost, _slack(data, force, _apart(data, trial, 1.0), left, loose))


def _mean_gap(data: Data, surface: CellField, points: Grid) -> tuple[Grid, Grid]:
    """Return the mean distance of a surface from the interpolant over the square about each point, and its rounding."""
    plan = data.plan
    mean, room = np.zeros(points.shape), np.zeros(points.shape)
    distance, size = surface.values - points, np.abs(surface.values) + np.abs(points)
    leaves = _leaves(data)
    for corner in range(4):
        for which, weight in enumerate(_MEAN_OF_QUARTER):
            plan.at_corner(mean, corner)[...] += weight / 4 * kept_at(plan, distance, corner, which)
            plan.at_corner(room, corner)[...] += weight / 4 * kept_at(plan, size, corner, which)
        plan.at_corner(mean, corner)[...] += (surface.mean_above + leaves) / 4
        plan.at_corner(room, corner)[...] += np.abs(surface.mean_above) / 4
    return mean, FEW * room


def _slack(data: Data, force: Grid, apart: Grid, left: Grid, loose: float) -> float:
    """Return κ: what the parts of λ that are of either sign cost for each unit of the norm.

    Parameters
    ----------
    data : Data
    force : array
        p - kv at the points.
    apart : array
        How far it lies from its interpolant in each square at most.
    left : array
        Forces at the nodes that are not paid for otherwise, >= 0.
    loose : float
        ∫ν² of what is left at the frame.
    """
    plan, square = data.plan, data.plan.spacing**2
    drift, swing = np.zeros(force.shape), 0.0
    if apart.any() or not _even(force, plan.points):
        mean, room, wide = np.zeros(force.shape), np.zeros(force.shape), np.zeros(force.shape)
        for corner in range(4):
            parts = [kept_at(plan, force, corner, which) for which in range(4)]
            part = sum(weight * each for weight, each in zip(_MEAN_OF_QUARTER, parts, strict=True)) - parts[0]
            plan.at_corner(mean, corner)[...] += part / 4
            plan.at_corner(room, corner)[...] += (apart + FEW * sum(np.abs(each) for each in parts)) / 4
            uneven = _swing(parts, apart) / 4
            plan.at_corner(wide, corner)[...] += uneven
            of_frame = plan.squares & plan.at_corner(plan.frame, corner)
            between_nodes = kept_at(plan, plan.nodes, corner, 1) & kept_at(plan, plan.nodes, corner, 2)
            swing += square * float(uneven[of_frame & ~between_nodes].sum()) * GROW
            loose += square * float(uneven[of_frame & between_nodes].sum()) * GROW
        drift = np.where(plan.nodes, np.abs(mean) + room, 0.0)
        swing = swing + square * float(np.where(plan.nodes, wide, 0.0).sum()) * GROW
    loose += _sum_above(((left + square * drift) ** 2 / square)[plan.nodes])
    width, height = plan.sides
    along_x, along_y = data.least_tension
    stiff = along_x / width**2 + along_y / height**2
    least = min(along_x, along_y)
    inner = plan.spacing * math.sqrt(swing / least) / LESS_THAN_PI
    return rounded_up(math.sqrt(loose / stiff) / LESS_THAN_PI + inner * (1 + gamma(plan.nodes.size)))


def _even(force: Grid, points: Mask) -> bool:
    values = force[points]
    return bool((values == values[0]).all())


def _swing(parts: list[Grid], apart: Grid) -> Grid:
    """Return the mean square over a quarter of what p - kv differs by from its value at the corner, bounded.

    A bilinear function has there values that are convex combinations of those at the quarter's corners.
    """
    own, beside, above, far = parts
    ends = (beside - own) / 2, (above - own) / 2, (beside + above + far - 3 * own) / 4
    square = sum(end**2 for end in ends) / 4
    rounding = FEW * sum(np.abs(part) for part in parts)
    return np.asarray((np.sqrt(square) + apart + rounding) ** 2)


def _at_frame(
    plan: Plan, across: tuple[Grid, Grid], at_corners: list[tuple[Grid, Grid]], force: Grid, size: Grid
) -> float:
    """Choose the flux in the quarters at frame points, and return ∫ν² of what rounding leaves in them."""
    half, loose = plan.spacing**2 / 2, 0.0
    for chain in plan.chains:
        outflows = []
        for quarter in chain.quarters:
            down, right = CORNERS[quarter.corner]
            along_x = float(across[0][quarter.row + down, quarter.column]) * (1 - 2 * right)
            along_y = float(across[1][quarter.row, quarter.column + right]) * (1 - 2 * down)
            # In the first quarter the flux that turns towards the next direction is that along y, and so on in turn.
            outflows.append((along_x, along_y) if quarter.corner % 2 == 0 else (along_y, along_x))
        own = float(force[chain.row, chain.column])
        turned = [0.0]
        for behind, ahead in outflows:
            turned.append(turned[-1] - (behind + ahead) - own * half)
        between = [[-before[0], after[1]] for before, after in pairwise(outflows)]
        wanted = [[outflows[0][1]], *between, [-outflows[-1][0]]]
        free = sum(sum(each) / len(each) - known for each, known in zip(wanted, turned, strict=True)) / len(turned)
        turned = [free + each for each in turned]
        for (behind, ahead), quarter, first, last in zip(outflows, chain.quarters, turned, turned[1:], strict=False):
            at_x, at_y = at_corners[quarter.corner]
            sign = 1.0 if quarter.corner in (0, 3) else -1.0
            place = quarter.row, quarter.column
            if quarter.corner % 2 == 0:
                at_y[place], at_x[place] = sign * first, -sign * last
            else:
                at_x[place], at_y[place] = sign * first, sign * last
            parts = abs(behind) + abs(ahead) + abs(first) + abs(last) + float(size[chain.row, chain.column]) * half
            loose += (FEW * parts) * (FEW * parts) / (2 * half)
    return rounded_up(loose)


def _misfit(data: Data, points: Grid, flux: _Flux) -> float:
    """Return η, rounded upwards: the norm of T∇v - y.

    In the quarter of a square at one of its corners T v_x is linear in y and y_x linear in x. So the mean square of
    their difference is the square of the means' difference, and a twelfth of the square of what each changes by.
    """
    plan = data.plan
    differences = _differences(points)
    misfit, swing = np.zeros(plan.squares.shape), np.zeros(plan.squares.shape)
    for corner in range(4):
        for axis, at_line in zip((1, 0), flux.at_corners[corner], strict=True):
            near, far = _sides(differences, axis, corner)
            through, _ = _sides(flux.across, axis, corner)
            tension = data.tensions(axis, corner)
            stretch, change = tension.middle * (3 * near + far) / 4, tension.middle * (far - near) / 2
            middle, turn = (through + at_line) / 2, through - at_line
            rounding = FEW * (tension.middle * (np.abs(near) + np.abs(far)) + np.abs(through) + np.abs(at_line))
            square = (np.abs(stretch - middle) + rounding) ** 2
            square += ((np.abs(change) + rounding) ** 2 + (np.abs(turn) + rounding) ** 2) / 12
            misfit += square / (4 * tension.least)
            swing += tension.spread**2 / (4 * tension.least) * _mean_square(near, far)
    total = math.sqrt(_sum_above(misfit[plan.squares]))
    return rounded_up(total + (math.sqrt(_sum_above(swing[plan.squares])) if swing.any() else 0.0))


def _norm_of_rim(data: Data) -> float:
    """Return the norm of what v has beside its interpolant where the frame leaves the chords between its points."""
    plan, bend = data.plan, data.bend_of_frame
    if not bend.any():
        return 0.0
    most = np.zeros(plan.squares.shape)
    for corner in range(4):
        for axis in (0, 1):
            tension = data.tensions(axis, corner)
            most = np.maximum(most, tension.middle + tension.spread)
    square = plan.spacing**2
    share = most * (1 / (3 * LESS_THAN_PI**2) + 1 / LESS_THAN_PI**4)
    if data.foundation is not None:
        share = share + _most_of_foundation(data) * square / (3 * LESS_THAN_PI**4)
    return rounded_up(math.sqrt(_sum_above((share * (plan.frame_edges * bend * square) ** 2)[plan.squares])))


def curved_bound(data: Data, own: Grid, rim: float) -> float:
    """Return a bound of the norm of Iw - w* that takes curved supports as they are, infinite where there is none.

    Parameters
    ----------
    data : Data
    own : array, shape (rows + 2, columns + 2)
        Depths of the answer w and of the frame (length).
    rim : float
        What v has beside its interpolant at the frame.
    """
    plan = data.plan
    trial = own
    for surface, sign in data.surfaces:
        trial = np.where(plan.nodes, sign * np.minimum(sign * trial, surface.values), trial)
    reliefs: Surfaces = []
    bumps, swell = 0.0, list[_Relief]()
    for surface, sign in data.surfaces:
        relief = _relief(data, surface, sign, trial)
        if relief is None:
            return math.inf
        reliefs.append((replace(surface, mean_above=relief.left), sign))
        bumps += relief.square
        swell.append(relief)
    if len(swell) > 1 and any((one.apart > other.room).any() for one, other in (swell, swell[::-1])):
        return math.inf
    flux = _flux(data, own, trial, reliefs)
    misfit, bump, slack = rounded_up(_misfit(data, trial, flux) + rim), rounded_up(math.sqrt(bumps)), flux.slack
    total = rounded_up(misfit * misfit + bump * bump + 2 * max(0.0, flux.cost) + 2 * slack * bump + slack * slack)
    clipped = 0.0 if trial is own or (trial == own).all() else _stretch(data, own - trial).norm
    found = rounded_up(slack + math.sqrt(total) + clipped)
    return or_infinite(found, 1)


class _Relief(NamedTuple):
    """A function ψ near one of the surfaces.

    Attributes
    ----------
    square : float
        Upper bound of ‖ψ‖².
    left : array, shape (rows + 1, columns + 1)
        Upper bound of the mean of (1 - χ)(f - If) over a quarter of each square.
    apart : array, shape (rows + 1, columns + 1)
        Upper bound of |ψ| in each square.
    room : array, shape (rows + 1, columns + 1)
        How far v stays clear of the surface in each square at least, below 0 where it may touch.
    """

    square: float
    left: Grid
    apart: Grid
    room: Grid


def _relief(data: Data, surface: CellField, sign: float, points: Grid) -> _Relief | None:
    """Return ψ near a surface, None if there is none that is known to be admissible."""
    plan = data.plan
    gap = np.where(plan.points, surface.values - sign * points, np.inf)
    least = np.minimum.reduce([plan.at_corner(gap, k) for k in range(4)]) * (1 - FEW)
    leaves = _leaves(data)
    touching = plan.nodes & (gap <= 0)
    flagged = plan.squares & (least < surface.below + leaves)
    flagged |= plan.squares & _any_corner(plan, touching)
    open_frame = np.where(plan.frame, gap, np.inf) * (1 - FEW)
    beside = np.minimum.reduce([plan.at_corner(open_frame, k) for k in range(4)])
    bends = data.bends_of(surface, sign)
    whole = np.isfinite(surface.below) & np.isfinite(surface.above)
    if bends is None or (flagged & ((beside < surface.below + leaves) | ~whole)).any():
        return None
    chosen = plan.nodes & (_corner_to_points(plan, flagged.astype(np.float64)) > 0)
    inside = np.logical_and.reduce([plan.at_corner(chosen, k) for k in range(4)])
    some = _any_corner(plan, chosen)
    apart = np.where(some, surface.apart, 0.0)
    slope = np.where(some & ~inside, surface.apart, 0.0)
    parts = []
    for axis, own in ((1, bends.xx), (0, bends.yy)):
        middle, radius = (own.lower + own.upper) / 2, (own.upper - own.lower) / 2
        steep = np.abs(middle) * _TWELFTH_ROOT + radius / LESS_THAN_PI + (bends.xy.upper - bends.xy.lower) / 4
        part = np.where(some, plan.spacing**2 * steep, 0.0) + slope + 2 * surface.rounding
        tension = np.maximum.reduce(
            [np.broadcast_to(t.middle + t.spread, some.shape) for t in (data.tensions(axis, k) for k in range(4))]
        )
        parts.append(tension * part**2)
    square = parts[0] + parts[1]
    if data.foundation is not None:
        square = square + _most_of_foundation(data) * plan.spacing**2 * apart**2
    square = np.where(some, square, 0.0)
    if not np.isfinite(square).all():
        return None
    left = np.where(inside, surface.rounding, np.maximum(surface.above, 0.0))
    room = np.where(plan.squares, least - surface.below - leaves, np.inf)
    return _Relief(_sum_above(square), left, apart, np.where(some, -1.0, room))


def _any_corner(plan: Plan, points: Mask) -> Mask:
    return np.asarray(np.logical_or.reduce([plan.at_corner(points, k) for k in range(4)]))


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
            lowered = np.where(data.plan.nodes, sign * np.minimum(sign * lowered, most), lowered)
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
    frame, rounding = points[plan.frame], _corner_to_points(plan, surface.rounding)
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
        | ~np.isfinite(_corner_most(plan, np.abs(surface.values)))
    )
    fall = np.where(steep, 0.0, surface.below) * GROW
    bend = surface.bent_below * GROW
    on_edge = (plan.frame_edges == 1) & np.isfinite(bend)
    at_frame = plan.squares & (plan.frame_corners > 0) & ~on_edge
    leaves = _leaves(data)
    gap = np.minimum.reduce([plan.at_corner(surface.values - points, k) for k in range(4)])
    spare = gap * (1 - FEW) >= fall + leaves
    # Along lines on which the support does not bend away from its chords, it is enough that nodes are not below it.
    straight = (surface.bent_below <= surface.rounding) & (leaves == 0)
    if (at_frame & ~steep & ~straight & ~spare).any():
        return None
    bottom = np.where(steep, surface.range_lower, np.inf)
    drop = np.where(at_frame & spare & ~straight, 0.0, np.where(on_edge, 4.0 * bend, fall))
    room, least = np.zeros(points.shape), np.full(points.shape, np.inf)
    for corner in range(4):
        at, low = plan.at_corner(room, corner), plan.at_corner(least, corner)
        np.maximum(at, np.where(plan.squares, drop, 0.0), out=at)
        np.minimum(low, np.where(plan.squares, bottom, np.inf), out=low)
    if (points + plan.spacing**2 / 8 * _corner_to_points(plan, data.bend_of_frame) > least)[plan.frame].any():
        return None
    reach = surface.values - room
    reach = np.where(room > 0, np.nextafter(reach, -np.inf), reach)
    return np.asarray(np.minimum(reach, least))


def _corner_to_points(plan: Plan, squares: Grid) -> Grid:
    found = np.zeros(plan.nodes.shape)
    for corner in range(4):
        at = plan.at_corner(found, corner)
        np.maximum(at, np.where(plan.squares, squares, 0.0), out=at)
    return found
