"""MembraneBounds: what an answer of the lattice proves of the membrane at every point."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..foundation.brackets import Bracket
from ..foundation.checks import Vector
from ..foundation.rounding import UNIT_ROUNDOFF
from ..geometry.lattice import Lattice
from ..geometry.numbering import Grid
from ..plotting.of_squares import Halves
from .barriers import Barrier
from .contact import ContactBounds, contact_bounds
from .data import Data
from .halves import halves_of
from .obstacle import Resolve
from .pointwise import PointwiseBounds, pointwise_bounds
from .posed import Posed, posed_of
from .reaction import reaction_bracket
from .splines import excess_on_cells

_ROUNDINGS = 16 * UNIT_ROUNDOFF

_RETURNS = 20
"""How often the lattice is solved again at most, to come back to its own answer."""

_WIDE = 2.0
"""Bounds that are farther apart, in units of what a membrane bends on a square, may be worse than they need be."""


@dataclass(frozen=True, eq=False)
class MembraneBounds:
    """The membrane at every point, enclosed.

    Attributes
    ----------
    lattice : Lattice
    lower, upper : array, shape (n,)
        Bounds of its deflection at the nodes, positive as the model's heights (length).
    gap_lower, gap_upper : array, shape (n,)
        Bounds of its gap there (length).
    gap_lower_in_cells, gap_upper_in_cells : array, shape (rows + 1, columns + 1)
        Bounds of its gap in the squares between the points of the lattice's array with a ring about it; nan in squares
        that do not belong to it.
    edges : pair of arrays, shapes (columns + 2,) and (rows + 2,)
        x and y of the lines between these squares (length).
    halves : Halves
        Those of the squares that slanted sides halve.
    error_bound : float
        Bound of the distance of the answer from the membrane at the nodes (length).
    largest_depth : Bracket
        Of the largest depth of the membrane, positive downwards (length).
    contact : ContactBounds
        Which of the squares it touches the support in.
    data_part : float
        How much of ``error_bound`` comes, at most, of data that are known up to a range between the nodes (length).
    part_undecided : float
        Part of the membrane's area that squares make up of which it is not certain whether it touches there; of a
        square that a slanted side halves its half counts.
    rounds : (int, int)
        How often the lattice's problem was solved again, for the lower and the upper bound of the gap.
    """

    lattice: Lattice
    lower: Vector
    upper: Vector
    gap_lower: Vector
    gap_upper: Vector
    gap_lower_in_cells: Grid
    gap_upper_in_cells: Grid
    edges: tuple[Vector, Vector]
    halves: Halves
    error_bound: float
    largest_depth: Bracket
    contact: ContactBounds
    data_part: float
    part_undecided: float
    rounds: tuple[int, int]


def membrane_bounds(data: Data, depths: Grid, gap: Vector, resolve: Callable[[Vector], Vector]) -> MembraneBounds:
    """Enclose a membrane at every point.

    Parameters
    ----------
    data : Data
    depths : array, shape (rows + 2, columns + 2)
        The answer's deflection at the points, positive downwards (length).
    gap : array, shape (n,)
        A gap to begin with (length).
    resolve : callable
        Returns the gap of the lattice's problem after a change of the load at the nodes, both of shape (n,).

    Raises
    ------
    ValueError
        See `contactqp.continuum.posed.posed_of`.
    """
    data = data.of_whole_squares
    numbering = data.plan.lattice.numbering

    def resolved(change: Grid) -> Grid:
        return np.asarray(numbering.to_grid(resolve(numbering.to_vector(change, ring=1)), ring=1))

    posed, bounds = _bounds(data, np.asarray(numbering.to_grid(gap, ring=1)), resolved)
    problem = bounds.lower.problem
    low, high = bounds.lower.at_points(), bounds.upper.at_points()
    support = np.where(problem.cells.closure, data.support.values, np.nan)
    # Depths are at most those of the support, where the gap is zero.
    least_depth = (posed.surface - high) - posed.surface_error
    most_depth = np.minimum(posed.surface - low, support) + posed.surface_error
    heights = np.abs(posed.surface) + np.abs(support)
    least_depth, most_depth = _outwards(least_depth, most_depth, heights)
    least_gap, most_gap = support - most_depth, support - least_depth
    least_gap, most_gap = _outwards(least_gap, most_gap, heights)
    in_cells = tuple(
        bound.on_cells() + np.broadcast_to(move, problem.cells.inside.shape)
        for bound, move in zip((bounds.lower, bounds.upper), problem.rest, strict=True)
    )
    off = _ROUNDINGS * (np.abs(in_cells[0]) + np.abs(in_cells[1]) + np.abs(problem.rest[0]) + np.abs(problem.rest[1]))
    in_cells = np.maximum(in_cells[0] - off, 0.0), in_cells[1] + off
    contact = contact_bounds(problem.cells, problem.tension, in_cells, posed.load)
    borne = reaction_bracket(problem, bounds, contact.clear)
    reaction = Bracket(max(borne.lower, contact.reaction.lower), min(borne.upper, contact.reaction.upper))
    contact = replace(contact, reaction=reaction)
    nodes = data.plan.nodes
    error = np.fmax(most_depth - depths, depths - least_depth)
    upwards = data.model.upwards
    low_depth, high_depth = (numbering.to_vector(bound, ring=1) for bound in (least_depth, most_depth))
    return MembraneBounds(
        lattice=data.plan.lattice,
        lower=-high_depth if upwards else low_depth,
        upper=-low_depth if upwards else high_depth,
        gap_lower=np.maximum(numbering.to_vector(least_gap, ring=1), 0.0),
        gap_upper=numbering.to_vector(most_gap, ring=1),
        gap_lower_in_cells=in_cells[0],
        gap_upper_in_cells=in_cells[1],
        edges=(data.plan.places[0].ravel(), data.plan.places[1].ravel()),
        halves=halves_of(problem.cells, data.plan.places),
        error_bound=float(error.max(where=nodes, initial=0.0)) * (1 + 1e-15),
        largest_depth=Bracket(float(low_depth.max()), _deepest(data, posed, bounds.lower)),
        contact=contact,
        data_part=posed.data_part(bounds),
        part_undecided=_part(problem.cells.shares, contact),
        rounds=bounds.rounds,
    )


def _bounds(data: Data, gap: Grid, resolve: Resolve) -> tuple[Posed, PointwiseBounds]:
    """Return bounds of a membrane's gap, and of which problem they are.

    On a lattice that is too coarse for what is known of a membrane at corners they are better without it, and over a
    support with kinks they may be.
    """
    posed = posed_of(data)
    settled = posed.problem.settled(gap, resolve)
    found = None if settled is None else pointwise_bounds(*settled)
    narrow = _WIDE * posed.problem.largest_bend if posed.problem.kinks is None else 0.0
    if found is not None and (posed.plain or found.width <= narrow):
        return posed, found
    plain = posed_of(data, plainly=True)
    for _ in range(_RETURNS):  # solves go on from the answer before, which may have been led astray
        if np.abs(resolve(np.zeros(gap.shape)) - gap).max() <= posed.problem.largest_bend:
            break
    other = pointwise_bounds(plain.problem, plain.problem.with_rim(gap), resolve)
    return (plain, other) if found is None or other.width < found.width else (posed, found)


def _part(shares: Grid, contact: ContactBounds) -> float:
    return float((shares * contact.undecided).sum() / shares.sum())


def _outwards(lower: Grid, upper: Grid, heights: Grid) -> tuple[Grid, Grid]:
    """Return two bounds that are formed from heights, moved apart by how sums are rounded."""
    off = _ROUNDINGS * (heights + np.abs(lower) + np.abs(upper))
    return lower - off, upper + off


def _deepest(data: Data, posed: Posed, lower: Barrier) -> float:
    """Return an upper bound of the largest depth, from the lower bound of the gap in the cells."""
    problem, support = lower.problem, data.support
    coefficients, beside = problem.depth_spline(lower.coefficients)
    if problem.floor is None:
        surface = np.where(problem.cells.corners, support.values, 0.0)
        excess, _ = excess_on_cells(problem.cells, coefficients, surface)
        depths = support.above - excess + beside
    else:
        excess, _ = excess_on_cells(problem.cells, coefficients - problem.floor, np.zeros(posed.surface.shape))
        depths = beside - excess
    # Where the spline follows little of it, the gap's least value still tells.
    depths = np.fmin(depths, support.range_upper - problem.rest[0] - lower.ranges.least)
    lift = lower.shift + lower.multiple * problem.largest_height
    highest = np.minimum(depths + lift, support.range_upper)
    found = float(highest.max(where=problem.cells.inside, initial=-np.inf))
    return found + _ROUNDINGS * (abs(found) + abs(lift))
