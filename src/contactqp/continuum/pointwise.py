r"""Bounds of the membrane's gap at every point, from an answer on the lattice that is solved again, slightly changed.

The spline through an answer misses the differential inequality (see `contactqp.continuum.barriers`) mostly in the cells
about the free boundary and next to corners, by an amount that does not shrink with the spacing. Paid for by a multiple
of the parabola v, this would be all that the bound tells. Instead the lattice problem is solved again with a load that
is less, for an upper bound, or more, by what the cells about each node have missed: a change that acts where it is
needed, and in contact is taken by the support. After a few rounds what is missed is of second order everywhere. The
loads that are solved for are no part of the proof: it is that of the spline that comes of them.

At a corner between a straight and a slanted side, at 135°, second derivatives of the membrane have no bound: what is
missed there is paid by loads that grow as the cells shrink, on fewer and fewer nodes, in more rounds.

At a corner that points inwards the membrane is singular. There the spline's coefficients are chosen by linear programs
(see `contactqp.continuum.inward`). Of so many such corners that these would take too long, coefficients are moved to
their own side of the frame's height, and for a lower bound to where a membrane without a frame were in balance; the
loads do the rest, in more rounds.

For an upper bound the spline's coefficients are the answer's values themselves, so that it is nowhere below zero; for a
lower one they are those less a sixth of their second differences, whose spline is nearer to the values.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..geometry.numbering import Grid
from .barriers import Barrier, subsolution, supersolution
from .cells import at_corners, largest_at_corners
from .inward import mended_at_corners
from .obstacle import ObstacleProblem, Resolve

_OVER = 1.15
"""How much more than what a cell has missed the load is changed by: the answer's response is spread out."""

_LEAST_RESPONSE = 0.2
"""Of what a change of the load was meant for, this part at least is taken to have been reached, when it is repeated."""

_SLIGHT = 0.2
"""For a lower bound a change counts as answered by a part if no more than this is left, and contact is not near."""

_FAR = 3.0
"""What is higher than so many times what a membrane bends on a cell is far from contact."""

_OUT = 5.0
"""Over a support with kinks it is also tried to mend it only higher than so many times what these stand out.

Loads next to an edge that the membrane leaves push it on along the edge, by a cell in each round.
"""

_ASKED = 2.5
"""About corners that point inwards a lower bound is chosen where it is higher than so many times the bend on a cell.

What it is not chosen for, a shift must leave out; chosen down to twice the bend, some at 315° did not close.
"""

_STEEP = 0.3
"""What a spline may miss of the frame's height before it is mended, in units of what a membrane bends on a cell."""

_MENDS, _MOVED = 4, 1.2

_WORTH = 0.9
"""A round that leaves more than this part of the distance ends the sharpening."""

_SPENT = 0.3
"""The sharpening ends where the multiple of the parabola makes no more than this part of the distance."""


@dataclass(frozen=True, eq=False)
class PointwiseBounds:
    """The membrane's gap lies between these, everywhere.

    Attributes
    ----------
    lower, upper : Barrier
    rounds : (int, int)
        How often the lattice problem was solved again for each.
    """

    lower: Barrier
    upper: Barrier
    rounds: tuple[int, int]

    @property
    def width(self) -> float:
        """The mean distance of the two at the points, infinite if they bound nothing (length)."""
        if not (self.lower.holds and self.upper.holds):
            return np.inf
        low, high = (bound.nearly_at_points() for bound in (self.lower, self.upper))
        return float((high - np.maximum(low, 0.0)).mean(where=self.lower.problem.cells.closure))

    def at_points(self) -> tuple[Grid, Grid]:
        """Return lower and upper bounds of u at the points; nan outside the region."""
        return self.lower.at_points(), self.upper.at_points()


def pointwise_bounds(
    problem: ObstacleProblem, gap: Grid, resolve: Resolve, *, rounds: int | None = None
) -> PointwiseBounds:
    """Enclose the membrane's gap from the lattice's answer.

    Parameters
    ----------
    problem : ObstacleProblem
    gap : array, shape (rows + 2, columns + 2)
        The lattice's answer at the points.
    resolve : callable
        See `Resolve`; it need not be exact.
    rounds : int, optional
        How often the lattice problem may be solved again, for each side; by default six times on a rectangle, and
        fourteen times where corners point inwards or sides are slanted.
    """
    if rounds is None:
        rounds = 6 if problem.cells.rectangular else 14
    upper, raised = _sharpened(problem, gap, resolve, rounds, upper_from)
    upper = min([upper, *_level(problem, upper)], key=lambda bound: _distance(bound, gap))
    spared = problem.near * problem.largest_bend
    lower, lowered = _sharpened(problem, gap, resolve, rounds, lower_from, spared)
    if problem.kinks is not None:
        above_kinks = spared + _OUT * problem.largest_kink
        other, more = _sharpened(problem, gap, resolve, rounds, lower_from, above_kinks)
        lowered += more
        lower = min(lower, other, key=lambda bound: _distance(bound, gap, largest=True))
    if not _distance(lower, gap) <= problem.near * problem.largest_bend:
        lower = min(lower, _bowl(problem), key=lambda bound: _distance(bound, gap))
    return PointwiseBounds(lower, upper, (lowered, raised))


def _bowl(problem: ObstacleProblem) -> Barrier:
    """Return the lower bound that asks for no answer: the frame's least height, less a parabola that the load bends.

    Where splines follow little of a membrane, as about holes with corners, it may be the better one.
    """
    level = np.zeros(tuple(np.array(problem.cells.nodes.shape) + 2)) if problem.floor is None else problem.floor
    above = float(problem.excess_along_rim(level)[1].max())
    return subsolution(problem, level - above if np.isfinite(above) else level)


def _level(problem: ObstacleProblem, upper: Barrier) -> list[Barrier]:
    """Return the upper bound that is the same everywhere, if that may be worth a look.

    Where a load presses, the gap is nowhere larger than at the frame: little, but no worse if all else fails.
    """
    height = problem.highest
    if height is None or upper.shift + upper.multiple * problem.largest_height <= height:
        return []
    return [supersolution(problem, np.full(upper.coefficients.shape, height))]


def upper_from(problem: ObstacleProblem, gap: Grid, load: Grid) -> Barrier:
    """Return an upper bound from the lattice's answer under a load at the points."""
    values, bend = problem.with_rim(gap), problem.bend(load)
    if problem.kinks is not None:
        # There the floor's kink is left to the floor, and the deflection is the spline of its values.
        values = values + problem.kinks
    held = _held_at_rim(problem, problem.upper_coefficients(values, bend), 1)
    return supersolution(problem, mended_at_corners(problem, held, 1))


def lower_from(problem: ObstacleProblem, gap: Grid, load: Grid) -> Barrier:
    """Return a lower bound from the lattice's answer under a load at the points."""
    held = _held_at_rim(problem, problem.lower_coefficients(problem.with_rim(gap), problem.bend(load)), -1)
    return subsolution(problem, mended_at_corners(problem, held, -1, _ASKED * problem.largest_bend))


def _held_at_rim(problem: ObstacleProblem, coefficients: Grid, side: int) -> Grid:
    """Return coefficients of a spline that keeps to its side of the frame's height where a membrane bends sharply.

    At a corner that points inwards the gap falls from the frame steeper than a spline can follow. What it misses there
    is paid at the corner, and the loads make up for it, not by a shift of the whole.
    """
    for _ in range(_MENDS):
        least, most = problem.excess_along_rim(coefficients)
        missing = problem.height_range[1] - least if side > 0 else most - problem.height_range[0]
        if not np.isfinite(missing).all() or missing.max() <= _STEEP * problem.largest_bend:
            break
        coefficients = coefficients + (side * _MOVED) * problem.moved_at_rim(np.maximum(missing, 0.0))
    return coefficients


def _sharpened(
    problem: ObstacleProblem,
    gap: Grid,
    resolve: Resolve,
    rounds: int,
    bound_from: Callable[[ObstacleProblem, Grid, Grid], Barrier],
    spared: float = 0.0,
) -> tuple[Barrier, int]:
    """Return the best bound of some rounds, and how many there were."""
    # At a corner that points inwards much is missed at first, so that the best bound long remains that of nothing.
    patience = 1 if problem.cells.rectangular else problem.patience
    load = np.array(problem.wanted)
    best = bound_from(problem, gap, load)
    least = _distance(best, gap)
    state: tuple[Grid, Barrier, Grid | None] = (load, best, None)
    share = 1.0
    for done in range(rounds):
        load, latest, before = state
        missed = largest_at_corners(_to_be_paid(latest, spared))
        if not np.isfinite(missed).all() or problem.largest_height * missed.max() <= _SPENT * least:
            return best, done
        load = load - latest.side * (share * _over(latest, missed, before) * missed)
        latest = bound_from(problem, resolve(load - problem.wanted), load)
        distance = _distance(latest, gap)
        improved, worth = distance < least, distance <= _WORTH * least
        if improved:
            best, least = latest, distance
        if done >= patience and not worth:
            return best, done + 1
        if improved or latest.side < 0:
            state, share = (load, latest, missed), 1.0
        else:
            # Where a support hardly presses, a membrane that is raised at its edge leaves it ever farther.
            share /= 2.0
    return best, rounds


def _to_be_paid(barrier: Barrier, spared: float) -> Grid:
    """Return the defects of cells that the load is to be changed for; of a lower bound those above a height."""
    if barrier.side > 0:
        return barrier.defects
    near = min(barrier.shift, spared)
    return np.where(barrier.ranges.most + barrier.problem.rest[1] > near, barrier.defects, 0.0)


def _over(barrier: Barrier, missed: Grid, before: Grid | None) -> Grid | float:
    """Return how many times what is missed the load is changed by; where a change was answered by a part, more.

    For a lower bound that would push the free boundary ahead of the load: there, more load is no load on the support.
    It is done at the corners of a rectangle, which otherwise take a round or two more than all else.
    """
    if before is None:
        return _OVER
    left = np.divide(missed, before, out=np.zeros_like(missed), where=before > 0.0)
    if barrier.side > 0:
        return np.asarray(_OVER / np.maximum(1.0 - left, _LEAST_RESPONSE))
    far = barrier.problem.cells.inside & (barrier.ranges.least > _FAR * barrier.problem.largest_bend)
    return np.where(at_corners(far) & (left < _SLIGHT), _OVER / np.maximum(1.0 - left, 1.0 - _SLIGHT), _OVER)


def _distance(barrier: Barrier, gap: Grid, *, largest: bool = False) -> float:
    """Return how far a bound is from the lattice's answer: in the mean, not decided by a corner alone, or at most."""
    if not barrier.holds:
        return np.inf
    values = barrier.nearly_at_points()
    away = values - gap if barrier.side > 0 else gap - np.maximum(values, 0.0)
    within = barrier.problem.cells.closure
    return float(away.max(where=within, initial=0.0) if largest else away.mean(where=within))
