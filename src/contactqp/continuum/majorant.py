r"""Majorants: the parts of a bound of energies that follow from a trial function and a flux; see `energy`.

Where the frame halves squares, see `majorant_on_halves`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..foundation.brackets import sum_above
from ..foundation.checks import Mask
from ..foundation.rounding import UNDERFLOW, gamma
from ..geometry.numbering import Grid
from .cell_fields import CellField
from .data import Data, Surfaces, kept_at
from .fluxes import Flux, flux_of
from .majorant_on_halves import (
    BENT,
    BENT_SQUARED,
    apart_on_halves,
    mean_on_halves,
    misfit_of_triangles,
    stretch_of_triangles,
    unevenness_of_triangles,
)
from .plan import CORNERS, Plan
from .rounded import FEW, GROW, LESS_THAN_PI, rounded_up

_MEAN_OF_QUARTER = (9 / 16, 3 / 16, 3 / 16, 1 / 16)
"""Weights of a square's corners in the mean of a bilinear function over the quarter at the first of them; exact."""


def sum_of_parts(values: Grid) -> float:
    """Return an upper bound of the sum of numbers >= 0 that have been rounded a few times each."""
    return rounded_up(float(values.sum()) * (1 + gamma(values.size)) + values.size * UNDERFLOW)


class Stretch(NamedTuple):
    """What the tension stores in each square: ∫½T|∇v|² and a bound of its error, and the energy norm of v, bounded."""

    stored: Grid
    error: Grid
    norm: float


def differences_of(points: Grid) -> tuple[Grid, Grid]:
    """Return differences along x, shape (rows, columns - 1), and along y."""
    return np.diff(points, axis=1), np.diff(points, axis=0)


def sides_of(parts: tuple[Grid, Grid], axis: int, corner: int) -> tuple[Grid, Grid]:
    """Return what the side of each square has that begins at a corner, along an axis, and the side opposite to it."""
    down, right = CORNERS[corner]
    part, place = (parts[0], down) if axis == 1 else (parts[1], right)
    if axis == 1:
        return part[place : place + part.shape[0] - 1], part[1 - place : part.shape[0] - place]
    return part[:, place : place + part.shape[1] - 1], part[:, 1 - place : part.shape[1] - place]


def _sides_in(plan: Plan, parts: tuple[Grid, Grid], axis: int, corner: int) -> tuple[Grid, Grid]:
    """Return the same, in a square that is halved along the side at its node twice: a linear function has one slope."""
    near, far = sides_of(parts, axis, corner)
    for halves in plan.halves:
        if halves.corner == corner:
            far = far.copy()
            far[halves.place] = near[halves.place]
    return near, far


def stretch_of(data: Data, points: Grid) -> Stretch:
    """Return what the tension stores in the interpolant of values at the points."""
    plan = data.plan
    differences = differences_of(points)
    stored, error = np.zeros(plan.squares.shape), np.zeros(plan.squares.shape)
    if plan.halves:
        stored, error = stretch_of_triangles(data, points)
    for corner in range(4):
        for axis in (0, 1):
            near, far = _sides_in(plan, differences, axis, corner)
            tension = data.tensions(axis, corner)
            square = mean_square(near, far)
            stored += plan.quarters(corner, tension.middle / 8 * square)
            swing = np.abs(far - near) * np.maximum(np.abs(near), np.abs(far))
            error += plan.quarters(corner, tension.mean_apart / 8 * square + tension.spread / 8 * swing)
    error = error * GROW + FEW * stored + UNDERFLOW
    total = 2 * sum_of_parts((stored + error)[plan.squares])
    if data.foundation is not None:
        total += sum_of_parts(
            (most_of_foundation(data) * plan.spacing**2 * mean_at_corners(plan, points**2))[plan.squares]
        )
    return Stretch(stored, error, rounded_up(math.sqrt(total)))


def most_of_foundation(data: Data) -> Grid:
    """Return an upper bound of the stiffness of the foundation in each square."""
    assert data.foundation is not None
    return np.asarray(np.maximum(data.foundation.range_upper, 0.0))


def mean_square(near: Grid, far: Grid) -> Grid:
    """Return the mean of the square of what goes from a value to another one, over the half next to the first."""
    return np.asarray(((3 * near + far) / 4) ** 2 + ((far - near) / 2) ** 2 / 12)


def mean_at_corners(plan: Plan, points: Grid) -> Grid:
    """Return the mean of what points have at the corners of each square, half that of the three of a half."""
    found = np.asarray(sum(plan.at_corner(points, corner) for corner in range(4))) / 4
    mean_on_halves(plan, points, found)
    return found


def most_at_corners(plan: Plan, points: Grid) -> Grid:
    """Return the largest of what points have at the corners of each square."""
    return np.asarray(np.maximum.reduce(plan.at_corners(points)))


def least_at_corners(plan: Plan, points: Grid) -> Grid:
    """Return the least of what points have at the corners of each square."""
    return np.asarray(np.minimum.reduce(plan.at_corners(points)))


def apart_of(data: Data, points: Grid, share: float) -> Grid:
    """Return how far p - share k v lies from the interpolant of its values in each square, at most.

    The product of two bilinear functions leaves its interpolant by ¼(|Δk||Δv|) in each direction at most. On a half the
    interpolant is the linear one.
    """
    plan, foundation = data.plan, data.foundation
    if foundation is None:
        return data.load.apart
    deep = most_at_corners(plan, np.abs(points))
    product = np.zeros(deep.shape)
    for stiff, high in zip(differences_of(foundation.values), differences_of(np.asarray(points)), strict=True):
        axis = 1 if stiff.shape[1] < foundation.values.shape[1] else 0
        pairs = [sides_of((each, each), axis, 0) for each in (np.abs(stiff), np.abs(high))]
        product = product + np.maximum(*pairs[0]) * np.maximum(*pairs[1]) / 4
    apart_on_halves(plan, foundation.values, points, product)
    product = product + foundation.apart * deep
    rounding = FEW * most_at_corners(plan, np.abs(data.load.values) + np.abs(foundation.values * points))
    beside = most_of_foundation(data) * leaves_of(data)
    return np.asarray((data.load.apart + share * product + rounding + beside) * GROW)


def leaves_of(data: Data) -> Grid:
    """Return how far v lies from its interpolant beside the frame at most."""
    plan = data.plan
    return np.asarray(data.bend_of_frame * np.where(plan.halved, 2, plan.frame_edges) * plan.spacing**2 / 8 * GROW)


class Costs(NamedTuple):
    """What λ costs with a flux.

    Attributes
    ----------
    cost : float
        Upper bound of Λ (force times length).
    slack : float
        κ, upper bound (square root of force times length).
    """

    cost: float
    slack: float


def balanced_flux(data: Data, own: Grid, trial: Grid) -> tuple[Flux, Grid]:
    """Return the flux of an answer, and p - kv at the points."""
    load, foundation = data.load.values, data.foundation
    if foundation is None:
        return flux_of(data, own, load, np.abs(load)), load
    springs = foundation.values * trial
    force = load - springs
    return flux_of(data, own, force, np.abs(load) + np.abs(springs)), force


def costs_of(data: Data, own: Grid, trial: Grid, surfaces: Surfaces, flux: Flux, force: Grid) -> Costs:
    """Return what λ costs, for the surfaces that hold nodes.

    Parameters
    ----------
    data : Data
    own, trial : array, shape (rows + 2, columns + 2)
        Depths of the answer, by which nodes are held, and of v (length).
    surfaces : list of (CellField, float)
    flux : Flux
    force : array, shape (rows + 2, columns + 2)
        p - kv at the points (force per area).
    """
    nodes, reaction = data.plan.nodes, flux.reaction
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
    left = np.where(pressed, 0.0, np.abs(reaction)) + flux.rounding
    return Costs(cost, _slack(data, force, apart_of(data, trial, 1.0), left, flux))


def _mean_gap(data: Data, surface: CellField, points: Grid) -> tuple[Grid, Grid]:
    """Return the mean distance of a surface from the interpolant over the square about each point, and its rounding."""
    plan = data.plan
    mean, room = np.zeros(points.shape), np.zeros(points.shape)
    distance, size = surface.values - points, np.abs(surface.values) + np.abs(points)
    leaves = leaves_of(data)
    for corner in range(4):
        for which, weight in enumerate(_MEAN_OF_QUARTER):
            plan.at_corner(mean, corner)[...] += weight / 4 * kept_at(plan, distance, corner, which)
            plan.at_corner(room, corner)[...] += weight / 4 * kept_at(plan, size, corner, which)
        plan.at_corner(mean, corner)[...] += (surface.mean_above + leaves) / 4
        plan.at_corner(room, corner)[...] += np.abs(surface.mean_above) / 4
    return mean, FEW * room


def _slack(data: Data, force: Grid, apart: Grid, left: Grid, flux: Flux) -> float:
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
    flux : Flux
    """
    plan, square, loose = data.plan, data.plan.spacing**2, flux.loose
    drift, swing = np.zeros(force.shape), 0.0
    if apart.any() or not _even(force, plan.points):
        below, above = (data.load.mean_below, data.load.mean_above) if data.foundation is None else (apart, apart)
        least, most, wide = np.zeros(force.shape), np.zeros(force.shape), np.zeros(force.shape)
        for corner, (down, right) in enumerate(CORNERS):
            parts = [kept_at(plan, force, corner, which) for which in range(4)]
            part = sum(weight * each for weight, each in zip(_MEAN_OF_QUARTER, parts, strict=True)) - parts[0]
            room = FEW * (sum(np.abs(each) for each in parts) + np.abs(below) + np.abs(above))
            plan.at_corner(least, corner)[...] += (part - below - room) / 4
            plan.at_corner(most, corner)[...] += (part + above + room) / 4
            # div z at the far ends of the quarter, with the sign that it has there.
            bowed = [plan.at_corner(each, corner) * (4 / square) for each in flux.bow]
            ends = bowed[0] * (1 - 2 * right), bowed[1] * (1 - 2 * down)
            uneven = _swing(parts, ends, apart) / 4
            plan.at_corner(wide, corner)[...] += uneven
            of_frame = plan.whole & plan.at_corner(plan.frame, corner)
            between_nodes = kept_at(plan, plan.nodes, corner, 1) & kept_at(plan, plan.nodes, corner, 2)
            beside_half = between_nodes & plan.beside_halves(corner)
            swing += square * float(uneven[of_frame & ~between_nodes].sum()) * GROW
            swing += square * float(uneven[of_frame & beside_half].sum()) * (4 * GROW)
            loose += square * float(uneven[of_frame & between_nodes & ~beside_half].sum()) * GROW
        swing += 4 * unevenness_of_triangles(plan, force, apart) * GROW
        drift = np.where(plan.nodes, np.maximum(np.abs(least), np.abs(most)), 0.0)
        swing = swing + square * float(np.where(plan.nodes, wide, 0.0).sum()) * GROW
    loose += sum_of_parts(((left + square * drift) ** 2 / square)[plan.nodes])
    (width, height), turned = plan.sides, plan.slanted_sides
    along_x, along_y = data.least_tension
    least_tension = min(along_x, along_y)
    stiff = max(along_x / width**2 + along_y / height**2, least_tension * (1 / turned[0] ** 2 + 1 / turned[1] ** 2))
    inner = plan.spacing * math.sqrt(swing / least_tension) / LESS_THAN_PI
    return rounded_up(math.sqrt(loose / stiff) / LESS_THAN_PI + inner * (1 + gamma(plan.nodes.size)))


def _even(force: Grid, points: Mask) -> bool:
    values = force[points]
    return bool((values == values[0]).all())


def _swing(parts: list[Grid], bowed: tuple[Grid, Grid], apart: Grid) -> Grid:
    """Return the mean square over a quarter of what p - kv + div z differs by from its value at the corner, bounded.

    A bilinear function has there values that are convex combinations of those at the quarter's corners.
    """
    own, beside, above, far = parts
    ends = (
        (beside - own) / 2 - bowed[0],
        (above - own) / 2 - bowed[1],
        (beside + above + far - 3 * own) / 4 - bowed[0] - bowed[1],
    )
    square = sum(end**2 for end in ends) / 4
    rounding = FEW * sum(np.abs(part) for part in (*parts, *bowed))
    return np.asarray((np.sqrt(square) + apart + rounding) ** 2)


def misfit_in_squares(data: Data, points: Grid, flux: Flux) -> Grid:
    """Return η in each square, rounded upwards: the norm of T∇v - y there; zero outside.

    In the quarter of a square at one of its corners T v_x is linear in y, and y_x is linear in x but for z. So the mean
    square of their difference is the square of the means' difference, and a twelfth of the square of what each changes
    by. Along the quarter, with s from 0 at the node to 1, z_x = Z(1 - s²) = Z(2/3 - (s - ½) - (s² - s + 1/6)); the
    last function is orthogonal to linear ones, and has the mean square 1/180.
    """
    plan = data.plan
    differences = differences_of(points)
    misfit, swing = misfit_of_triangles(data, points, flux)
    for corner in range(4):
        for axis in (1, 0):
            near, far = _sides_in(plan, differences, axis, corner)
            through, at_line = flux.in_quarters(axis, corner)
            bow = plan.at_corner(flux.bow[1 - axis], corner)
            tension = data.tensions(axis, corner)
            stretch, change = tension.middle * (3 * near + far) / 4, tension.middle * (far - near) / 2
            middle, turn = (through + at_line) / 2 + bow * (2 / 3), through - at_line - bow
            sizes = tension.middle * (np.abs(near) + np.abs(far)) + np.abs(through) + np.abs(at_line) + np.abs(bow)
            square = (np.abs(stretch - middle) + FEW * sizes) ** 2
            square += ((np.abs(change) + FEW * sizes) ** 2 + (np.abs(turn) + FEW * sizes) ** 2) / 12 + bow**2 / 180
            misfit += plan.quarters(corner, square / (4 * tension.least))
            swing += plan.quarters(corner, tension.spread**2 / (4 * tension.least) * mean_square(near, far))
    norms = np.sqrt(misfit) + np.sqrt(swing) if swing.any() else np.sqrt(misfit)
    return np.where(plan.squares, norms, 0.0)


def norm_over(squares: Grid) -> float:
    """Return an upper bound of a norm from what it is in each square."""
    return rounded_up(math.sqrt(sum_of_parts(squares**2)))


def rim_in_squares(data: Data) -> Grid:
    """Return the norm of what v has beside its interpolant where the frame leaves the chords between its points."""
    plan, bend = data.plan, data.bend_of_frame
    if not bend.any():
        return np.zeros(plan.squares.shape)
    most = np.zeros(plan.squares.shape)
    for corner in range(4):
        for axis in (0, 1):
            tension = data.tensions(axis, corner)
            most = np.maximum(most, tension.middle + tension.spread)
    square = plan.spacing**2
    share = most * (1 / (3 * LESS_THAN_PI**2) + 1 / LESS_THAN_PI**4)
    on_halves = most * BENT
    if data.foundation is not None:
        share = share + most_of_foundation(data) * square / (3 * LESS_THAN_PI**4)
        on_halves = on_halves + most_of_foundation(data) * square * BENT_SQUARED
    found = np.where(plan.halved, np.sqrt(on_halves), np.sqrt(share) * plan.frame_edges) * (bend * square)
    return np.where(plan.squares, found, 0.0)


def at_any_corner(plan: Plan, points: Mask) -> Mask:
    """Return which squares have one of some points at a corner."""
    return np.asarray(np.logical_or.reduce(plan.at_corners(points)))


def stays_above(data: Data, surface: CellField) -> Mask:
    """Return in which squares v stays above a surface wherever its nodes and the frame do.

    That is where the surface does not bend away from its chords, and the frame is bent along one direction at most: v
    is then in between the frame's height and its values at nodes, linear across.
    """
    return np.asarray((surface.bent_below <= surface.rounding) & (data.bent_edges <= 1))


def most_in_squares(plan: Plan, squares: Grid) -> Grid:
    """Return at each point the largest of what the squares about it have, zero where that is less."""
    found = np.zeros(plan.nodes.shape)
    for corner in range(4):
        at = plan.at_corner(found, corner)
        np.maximum(at, np.where(plan.having(corner), squares, 0.0), out=at)
    return found
