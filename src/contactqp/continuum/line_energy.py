r"""Energies of cables: bounds of the energy of a continuous cable, and of how far the interpolant of an answer is off.

**Energy.** With one dimension less, all of `contactqp.continuum.energy` holds of -(Tw′)′ + kw = p - R between two ends:
v is the linear interpolant of the nodes, y is linear between the middles of neighbouring arms, where it is T(w_j -
w_i)/h, and λ = R_i/h² about node i. On a stretch of length h the constants are those of squares, on the whole span L
Friedrichs' is π/L. The interpolant of a support leaves it by h²/8 max f″ at most. Over curved supports the bound of the
norm is that of `contactqp.continuum.relief`: on a stretch ψ = χ(f - If) has ∫ψ_x² ≤ M²h³/12, M the largest modulus of
f″, and what χ varies by.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from ..foundation.brackets import Bracket, sum_above, sum_below
from ..foundation.checks import Mask, Vector
from ..foundation.rounding import UNDERFLOW
from .cell_fields import CellField
from .data import Surfaces, kept_within, require_positive
from .energy import EnergyBounds
from .line import Line
from .relief import Relief, reliefs_near
from .rounded import FEW, GROW, LESS_THAN_PI, TWELFTH_ROOT, finite_or_nan, or_infinite, rounded_up

_THIRD_ROOT = 0.5773502691896258
"""No less than the square root of a third."""


def cable_energy(line: Line, depths: Vector) -> EnergyBounds:
    """Return what an answer of a cable's nodes proves of the energy of the cable itself.

    Parameters
    ----------
    line : Line
    depths : array, shape (n,)
        Of the nodes, positive downwards (length).

    Raises
    ------
    ValueError
        If support or ceiling leave no room for the ends.
    """
    own = np.concatenate([line.ends[:1], depths, line.ends[1:]])
    trial = own
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        limits = [(_most(line, surface, sign * own), sign) for surface, sign in line.surfaces]
        for most, sign in limits:
            trial = trial if most is None else kept_within(line.nodes, trial, sign, most)
        if any(most is None or (sign * trial > most)[1:-1].any() for most, sign in limits):
            return EnergyBounds(Bracket(-np.inf, np.inf), np.inf, np.inf, _norm(line, own))
        misfit, cost, slack = _misfit_and_costs(line, own, trial, line.surfaces)
        gap = max(0.0, rounded_up(misfit / 2 + cost))
        norm = rounded_up(slack + math.sqrt(rounded_up(slack * slack + 2 * gap)))
        energy, known = _energy(line, trial), _norm(line, own)
        error = norm
        if (own != trial).any():
            error = min(rounded_up(norm + _norm(line, own - trial)), _curved_bound(line, own))
    lower = sum_below([energy.lower, -gap, -rounded_up(slack * norm)])
    bracket = Bracket(or_infinite(lower, -1), or_infinite(energy.upper, 1))
    return EnergyBounds(bracket, or_infinite(error, 1), rounded_up(gap + slack * slack / 2), known)


def _sum(values: Vector) -> float:
    return rounded_up(sum_above(values.tolist()) + values.size * UNDERFLOW)


def _most(line: Line, surface: CellField, points: Vector) -> Vector | None:
    """Return how deep nodes may be so that chords stay above a surface, None if that cannot be told."""
    below = np.where(np.isfinite(surface.below), surface.below, 0.0)
    steep = (
        ~np.isfinite(surface.below)
        | np.isinf(line.at_corner(surface.values, 0))
        | np.isinf(line.at_corner(surface.values, 1))
    )
    bottom = np.where(steep, surface.range_lower, np.inf)
    drop = np.where(steep, 0.0, below * GROW)
    for stretch in (0, -1):
        if steep[stretch]:
            if points[stretch] > surface.range_lower[stretch]:
                return None
        elif np.isfinite(surface.bent_below[stretch]):
            drop[stretch] = 4 * surface.bent_below[stretch] * GROW
        elif surface.values[stretch] - points[stretch] < drop[stretch]:
            return None
    room = np.maximum(np.append(drop, 0.0), np.append(0.0, drop))
    least = np.minimum(np.append(bottom, np.inf), np.append(np.inf, bottom))
    reach = np.where(room > 0, np.nextafter(surface.values - room, -np.inf), surface.values)
    return np.asarray(np.minimum(reach, least))


def _norm(line: Line, points: Vector) -> float:
    """Return an upper bound of the energy norm of the interpolant of values at the points."""
    square = np.diff(points) ** 2
    stored = sum((t.middle + t.spread) * square / 2 for t in (line.tensions(0), line.tensions(1))) / line.spacing
    if line.foundation is not None:
        most = np.maximum(line.foundation.range_upper, 0.0) * line.spacing
        stored = stored + most * (points[1:] ** 2 + points[:-1] ** 2) / 2
    return rounded_up(math.sqrt(_sum(stored * GROW)))


def _energy(line: Line, points: Vector) -> Bracket:
    """Return a bracket of J(v) of the interpolant of values at the points."""
    h, load, foundation = line.spacing, line.load, line.foundation
    springs = 0.0 if foundation is None else foundation.values * points
    force, size = load.values - springs / 2, np.abs(load.values) + np.abs(springs)
    apart = _apart(line, points)
    square = np.diff(points) ** 2
    stored, error = np.zeros(square.shape), np.zeros(square.shape)
    for tension in (line.tensions(0), line.tensions(1)):
        stored += tension.middle * square / (4 * h)
        error += tension.mean_apart * square / (4 * h)
    left, right = slice(None, -1), slice(1, None)
    work = h / 6 * (points[left] * (2 * force[left] + force[right]) + points[right] * (force[left] + 2 * force[right]))
    most = h / 2 * (np.abs(points[left]) + np.abs(points[right])) * np.maximum(size[left], size[right])
    error = error * GROW + FEW * (stored + most) + h * apart * (np.abs(points[left]) + np.abs(points[right])) / 2
    error, known = error * GROW + UNDERFLOW, finite_or_nan(stored - work)
    return Bracket(sum_below((known - error).tolist()), sum_above((known + error).tolist()))


def _apart(line: Line, points: Vector) -> Vector:
    """Return how far p - kv lies from the interpolant of its values on each stretch, at most."""
    foundation = line.foundation
    if foundation is None:
        return np.asarray(line.load.apart)
    high = np.maximum(np.abs(points[1:]), np.abs(points[:-1]))
    product = foundation.apart * high + np.abs(np.diff(foundation.values) * np.diff(points)) / 4
    size = np.abs(line.load.values) + np.abs(foundation.values * points)
    return np.asarray((line.load.apart + product + FEW * np.maximum(size[1:], size[:-1])) * GROW)


def _misfit_and_costs(line: Line, own: Vector, trial: Vector, surfaces: Surfaces) -> tuple[float, float, float]:
    """Return upper bounds of η², Λ and κ."""
    h = line.spacing
    least = require_positive(min(float(np.min(line.tensions(side).least)) for side in (0, 1)))
    flux = line.arms * np.diff(own)
    foundation = line.foundation
    springs = 0.0 if foundation is None else foundation.values * trial
    force, size = line.load.values - springs, np.abs(line.load.values) + np.abs(springs)
    middles = (flux[:-1] + flux[1:]) / 2
    at_points = np.concatenate([[flux[0] + force[0] * h**2 / 2], middles, [flux[-1] - force[-1] * h**2 / 2]])
    misfit, swing = np.zeros(flux.shape), np.zeros(flux.shape)
    difference = np.diff(trial)
    for side in (0, 1):
        tension, at_point = line.tensions(side), line.at_corner(at_points, side)
        rounding = FEW * (tension.middle * np.abs(difference) + np.abs(flux) + np.abs(at_point))
        square = (np.abs(tension.middle * difference - (flux + at_point) / 2) + rounding) ** 2
        square += (np.abs(flux - at_point) + rounding) ** 2 / 12
        misfit += square / (2 * h * tension.least)
        swing += tension.spread**2 / (2 * h * tension.least) * difference**2
    root = rounded_up(math.sqrt(_sum(misfit))) + (rounded_up(math.sqrt(_sum(swing))) if swing.any() else 0.0)
    nodes = line.nodes
    reaction, rounding = np.zeros(own.shape), np.zeros(own.shape)
    reaction[1:-1] = force[1:-1] * h**2 + np.diff(flux)
    rounding[1:-1] = FEW * (size[1:-1] * h**2 + np.abs(flux[1:]) + np.abs(flux[:-1]))
    stiffness = np.zeros(own.shape)
    stiffness[1:-1] = line.arms[1:] + line.arms[:-1]
    pressed, cost = np.zeros_like(nodes), 0.0
    for surface, sign in surfaces:
        push = sign * reaction
        gap, large = surface.values - sign * trial, np.abs(surface.values) + np.abs(trial)
        mean, room = np.zeros(own.shape), np.zeros(own.shape)
        for side in (0, 1):
            part = slice(None, -1) if side == 0 else slice(1, None)
            mean[part] += (0.75 * line.at_corner(gap, side) + 0.25 * line.at_corner(gap, 1 - side)) / 2
            mean[part] += surface.mean_above / 2
            room[part] += line.at_corner(large, side) + line.at_corner(large, 1 - side) + np.abs(surface.mean_above)
        held = nodes & (push > 0) & ((surface.values - sign * own) * stiffness < push)
        paid = np.where(held, (mean + FEW * room) * push / h, 0.0)
        held &= np.isfinite(paid)
        paid = paid[held]
        cost += sum_above((paid + FEW * np.abs(paid) + UNDERFLOW).tolist())
        pressed |= held
    left = np.where(pressed, 0.0, np.abs(reaction)) + rounding
    apart = _apart(line, trial)
    uneven = np.diff(force) / 2
    drift = np.zeros(own.shape)
    drift[1:-1] = np.abs(uneven[1:] - uneven[:-1]) / 4 + (apart[1:] + apart[:-1]) / 2 + FEW * size[1:-1]
    wide = (np.abs(uneven) * _THIRD_ROOT + apart + FEW * (size[1:] + size[:-1])) ** 2
    loose = math.sqrt(_sum(((left + h**2 * drift)[1:-1]) ** 2 / h**3))
    span = h * flux.size
    slack = loose * span / LESS_THAN_PI + h / LESS_THAN_PI * math.sqrt(_sum(h * wide))
    ends = FEW * h * float(size[0] + size[-1] + (np.abs(flux[0]) + np.abs(flux[-1])) / h**2)
    return rounded_up(root * root), cost, rounded_up((slack + ends * math.sqrt(span)) / math.sqrt(least))


def _curved_bound(line: Line, own: Vector) -> float:
    """Return a bound of the norm of Iw - w* that takes curved supports as they are, infinite where there is none."""
    trial = own
    for surface, sign in line.surfaces:
        trial = kept_within(line.nodes, trial, sign, surface.values)
    near = reliefs_near(line.surfaces, trial, partial(_relief, line))
    if near is None:
        return math.inf
    reliefs, lifted = near
    misfit, cost, slack = _misfit_and_costs(line, own, trial, lifted)
    bump = rounded_up(math.sqrt(_sum(np.add.reduce([relief.square for relief in reliefs]))))
    squares = misfit + bump * bump + 2 * max(0.0, cost) + 2 * slack * bump + slack * slack
    clipped = _norm(line, own - trial) if (own != trial).any() else 0.0
    return rounded_up(slack + math.sqrt(rounded_up(squares)) + clipped)


def _relief(line: Line, surface: CellField, sign: float, points: Vector) -> Relief | None:
    """Return ψ near a surface, None if there is none that is known to be admissible."""
    bends = line.bends_of(surface, sign)
    gap = (surface.values - sign * points) * (1 - FEW)
    ends = line.at_corner(gap, 0), line.at_corner(gap, 1)
    touching = line.nodes & (gap <= 0)
    flagged = (np.minimum(*ends) < surface.below) | line.at_corner(touching, 0) | line.at_corner(touching, 1)
    whole = np.isfinite(surface.below) & np.isfinite(surface.above)
    if bends is None or (flagged & ~whole).any():
        return None
    share = np.zeros(gap.shape)
    for side, places in ((0, slice(None, -1)), (1, slice(1, None))):
        needed = 1.0 + FEW - ends[side] / surface.below
        needed = np.where(flagged, np.where(np.isnan(needed), 1.0, np.clip(needed, 0.0, 1.0)), 0.0)
        share[places] = np.maximum(share[places], needed)
    share = np.where(line.nodes, share, 0.0)
    shares = line.at_corner(share, 0), line.at_corner(share, 1)
    most, fewest = np.maximum(*shares), np.minimum(*shares)
    if _crosses_ends(surface, gap, most):
        return None
    h, magnitude = line.spacing, np.maximum(np.abs(bends[0]), np.abs(bends[1]))
    some: Mask = most > 0
    tension = np.maximum.reduce([np.broadcast_to(t.middle + t.spread, some.shape) for t in map(line.tensions, (0, 1))])
    steep = most * h**2 * magnitude * TWELFTH_ROOT + (most - fewest) * surface.apart + 2 * surface.rounding
    square = tension * steep**2 / h * GROW
    apart = most * surface.apart
    if line.foundation is not None:
        square = square + np.maximum(line.foundation.range_upper, 0.0) * h * apart**2
    square = np.where(some, square, 0.0)
    if not np.isfinite(square).all():
        return None
    left = np.where(some, (1.0 - fewest) * np.maximum(surface.above, 0.0) + surface.rounding, surface.mean_above)
    return Relief(square, left, np.where(some, apart, 0.0), np.where(some, -1.0, np.minimum(*ends) - surface.below))


def _crosses_ends(surface: CellField, gap: Vector, most: Vector) -> bool:
    """Whether v + ψ may cross a surface beside an end, where χ is zero.

    It does not where the end has room for what the surface bends away by, or where it does not bend away.
    """
    for end in (0, -1):
        straight = surface.bent_below[end] <= surface.rounding[end]
        bent = not straight or (most[end] > 0 and surface.apart[end] > 0)
        if gap[end] < surface.below[end] and bent:
            return True
    return False
