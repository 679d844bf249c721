r"""Fluxes: a field y for bounds of energies, made of an answer of the lattice, which that answer balances.

**Between nodes.** Through the line that separates two neighbouring nodes, halfway, the flux is a = T(w_j - w_i)/h in
the mean, and on the square of side h about a node y_x is linear in x and y_y in y (Raviart and Thomas 1977, on the dual
squares). So div y is constant there, and h² div y is the sum of the four differences: -P_i + R_i + kw_i h² for the
lattice's own reaction R_i = p_i h² + Σ T(w_j - w_i) - kw_i h².

**Turned.** Such a y_x does not vary with y within a square, which T∇w does: where w = xy, all that is missed is a
gradient without divergence, and so a curl as well. Any stream function ψ that is continuous may be added by its curl
(ψ_y, -ψ_x), which changes no divergence. With A and B what y_x changes by along y, and y_y along x, in the square
between four nodes, the one that is wanted in the square about the node (X, Y) is

.. math:: ψ = \frac{A}{2} \Big((y - Y)² - \frac{h²}{4}\Big) - \frac{B}{2} \Big((x - X)² - \frac{h²}{4}\Big).

ψ is taken as linear between its values at the corners and in the middles of the dual squares and of their sides, with
the means of A and B there: bilinear on each quarter of a square, so that y is of Raviart and Thomas's kind on the
quarters. At the corners, the centres of the lattice's squares, it is zero. What is missed falls to a quarter of what it
was, in squares of norms.

**Bowed.** Where the load varies, p - kv differs from its value at the node by c_x(x - X) + c_y(y - Y) nearly. The field
z_x = c_x (h²/4 - (x - X)²)/2, and z_y alike, takes just that: div z = -c_x(x - X) - c_y(y - Y), and z does not flow
through the sides of the dual square.

**At the frame.** Squares about frame points lie in Ω in quarters. Counterclockwise from one edge of the frame to the
next, the flux U across the lines through the point follows from quarter to quarter by div y = -(p - kv) at the point;
the one number that is left free makes the differences from T∇v small in the mean. What flows through the frame itself
is free.

**In halves.** Of a square that the frame halves along the diagonal BC, a triangle with legs a = h/2 belongs to B, the
right angle of which is in the middle M of AB; another one alike belongs to C. With s counted from M towards B, and t
along the leg that it shares with the quarter of the node A, y is the lowest field of Raviart and Thomas,

.. math:: y_s = q - \frac{f_B}{2} s, \quad y_t = U - \frac{f_B}{2} t, \quad \operatorname{div} y = -f_B,

with f = p - kv, the flux q out of A's quarter, and the flux U through the half of AB next to B, on which t = 0: each is
the number that the other side of the leg has. Through the hypotenuse, which lies on the frame, flows what there is. So
a triangle begins or ends the turn about B, and U is one of the fluxes that turn there: it needs no balance, for the
hypotenuse takes what the legs leave. A's own quarter is as any other of a node. In the means that make ψ halves count
as zero, for T∇v is constant in each of them; ψ is linear on the triangles.

**Rounding.** The fluxes through lines are the doubles in memory, each of which either side of its line has: y is then
admissible exactly, whatever they are. In the quarters of a node's square div y is off from what the four differences
tell by no more than ``rounding``.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..foundation.checks import Mask
from ..geometry.numbering import Grid
from .data import Data
from .plan import CORNERS, FrameQuarter, Plan
from .rounded import FEW, rounded_up


class Flux(NamedTuple):
    """The flux y, times the spacing (force).

    Attributes
    ----------
    through : pair of pairs of arrays, shape (rows + 1, columns + 1)
        Through the lines halfway between two points, in each square: along x through the lower and the upper half,
        along y through the left and the right one.
    at_corners : list of pairs of arrays, shape (rows + 1, columns + 1)
        For each corner of the squares: y_x on the line x = const through it, and y_y on the line y = const.
    bow : pair of arrays, shape (rows + 2, columns + 2)
        z_x and z_y at the nodes, zero at other points.
    force : array, shape (rows + 2, columns + 2)
        p - kv at the points, which is -div y at the frame (force per area).
    reaction : array, shape (rows + 2, columns + 2)
        Force at the nodes that balances p - kv and y, zero at other points.
    rounding : array, shape (rows + 2, columns + 2)
        How far λ times the area may lie from that force anywhere in a node's square.
    loose : float
        ∫ν² of what rounding leaves in the quarters at frame points.
    """

    through: tuple[tuple[Grid, Grid], tuple[Grid, Grid]]
    at_corners: list[tuple[Grid, Grid]]
    bow: tuple[Grid, Grid]
    force: Grid
    reaction: Grid
    rounding: Grid
    loose: float

    def in_quarters(self, axis: int, corner: int) -> tuple[Grid, Grid]:
        """Return y along x (axis 1) or y (axis 0) in the quarters at a corner: farthest from the corner, and at it."""
        which = 1 - axis
        return self.through[which][CORNERS[corner][which]], self.at_corners[corner][which]


def flux_of(data: Data, points: Grid, force: Grid, size: Grid) -> Flux:
    """Return the flux of an answer.

    Parameters
    ----------
    data : Data
    points : array, shape (rows + 2, columns + 2)
        Depths of the answer and of the frame (length).
    force, size : array, shape (rows + 2, columns + 2)
        p - kv at the points, and the sum of the moduli of what it consists of (force per area).
    """
    plan, square = data.plan, data.plan.spacing**2
    across = data.arms[0] * np.diff(points, axis=1), data.arms[1] * np.diff(points, axis=0)
    at_points = np.zeros(points.shape), np.zeros(points.shape)
    at_points[0][:, 1:-1] = (across[0][:, :-1] + across[0][:, 1:]) / 2
    at_points[1][1:-1] = (across[1][:-1] + across[1][1:]) / 2
    through, halves = _turned(plan, across, at_points)
    at_corners = [(plan.at_corner(halves[0][d], k), plan.at_corner(halves[1][r], k)) for k, (d, r) in _NUMBERED]
    rounding = _rounding_in_quarters(plan, through, at_corners, at_points)
    at_corners = [(one.copy(), two.copy()) for one, two in at_corners]
    loose = _at_frame(plan, through, at_corners, force, size)
    pulls, sums = np.zeros(points.shape), np.zeros(points.shape)
    for part, axis in zip(across, (1, 0), strict=True):
        inner = (slice(None), slice(1, -1)) if axis == 1 else (slice(1, -1), slice(None))
        pulls[inner] += np.diff(part, axis=axis)
        size_of = np.abs(part)
        sums[inner] += size_of[:, :-1] + size_of[:, 1:] if axis == 1 else size_of[:-1] + size_of[1:]
    nodes = plan.nodes
    reaction = np.where(nodes, force * square + pulls, 0.0)
    rounding = np.where(nodes, rounding + FEW * (size * square + sums), 0.0)
    return Flux(through, at_corners, _bow(force, nodes, square), force, reaction, rounding, loose)


_NUMBERED = tuple(enumerate(CORNERS))


def _turned(
    plan: Plan, across: tuple[Grid, Grid], at_points: tuple[Grid, Grid]
) -> tuple[tuple[tuple[Grid, Grid], tuple[Grid, Grid]], tuple[tuple[Grid, Grid], tuple[Grid, Grid]]]:
    """Return fluxes through halves of lines: between points, per square, and through points, with curl ψ.

    What flows through the whole of a line between two points is not changed by it. Of lines through points the halves
    are above and below, to the right and to the left of the point.
    """
    along_y = np.where(plan.whole, np.diff(across[0], axis=0), 0.0)
    along_x = np.where(plan.whole, np.diff(across[1], axis=1), 0.0)
    # Twice ψ, by which the flux through half a line differs, is a quarter of A h² and B h² in the middle of a side.
    beside = -_mean_beside(plan.squares, along_y, (0,)) / 4
    above = _mean_beside(plan.squares, along_x, (1,)) / 4
    middle = _mean_beside(plan.squares, along_x - along_y, (0, 1)) / 4
    through = (
        (across[0][:-1] - beside[:-1], across[0][1:] + beside[1:]),
        (across[1][:, :-1] + above[:, :-1], across[1][:, 1:] - above[:, 1:]),
    )
    right, left = np.pad(beside, ((0, 0), (0, 1))), np.pad(beside, ((0, 0), (1, 0)))
    up, down = np.pad(above, ((0, 1), (0, 0))), np.pad(above, ((1, 0), (0, 0)))
    halves = (
        (at_points[0] + (up - middle), at_points[0] + (middle - down)),
        (at_points[1] + (middle - right), at_points[1] + (left - middle)),
    )
    return through, halves


def _mean_beside(squares: Mask, values: Grid, axes: tuple[int, ...]) -> Grid:
    """Return the mean over the squares beside each edge, or about each point, zero where there is none."""
    count = squares.astype(np.float64)
    for axis in axes:
        room = [(1, 1) if k == axis else (0, 0) for k in (0, 1)]
        values, count = np.pad(values, room), np.pad(count, room)
        low, high = ((slice(None), part) if axis == 1 else (part, slice(None)) for part in _SHIFTED)
        values, count = values[low] + values[high], count[low] + count[high]
    return np.asarray(values / np.maximum(count, 1.0))


_SHIFTED = slice(None, -1), slice(1, None)


def _rounding_in_quarters(
    plan: Plan,
    through: tuple[tuple[Grid, Grid], tuple[Grid, Grid]],
    at_corners: list[tuple[Grid, Grid]],
    at_points: tuple[Grid, Grid],
) -> Grid:
    """Return how far h² div y in any quarter of a node's square may be off from the sum of the four differences."""
    rounding = np.zeros(at_points[0].shape)
    for corner, places in _NUMBERED:
        parts = [np.abs(through[k][places[k]]) + np.abs(at_corners[corner][k]) for k in (0, 1)]
        parts += [np.abs(plan.at_corner(each, corner)) for each in at_points]
        plan.at_corner(rounding, corner)[...] += FEW * sum(parts)
    return rounding


def _bow(force: Grid, nodes: Mask, square: float) -> tuple[Grid, Grid]:
    """Return z at the nodes, from central differences of p - kv, times the spacing (force)."""
    bow = np.zeros(force.shape), np.zeros(force.shape)
    bow[0][:, 1:-1] = square / 16 * (force[:, 2:] - force[:, :-2])
    bow[1][1:-1] = square / 16 * (force[2:] - force[:-2])
    return np.where(nodes, bow[0], 0.0), np.where(nodes, bow[1], 0.0)


def _at_frame(
    plan: Plan,
    through: tuple[tuple[Grid, Grid], tuple[Grid, Grid]],
    at_corners: list[tuple[Grid, Grid]],
    force: Grid,
    size: Grid,
) -> float:
    """Choose the flux in the quarters at frame points, and return ∫ν² of what rounding leaves in them."""
    half, loose = plan.spacing**2 / 2, 0.0
    for chain in plan.chains:
        outflows = [_outflows(through, quarter) for quarter in chain.quarters]
        begins, ends = chain.quarters[0].halved, chain.quarters[-1].halved
        whole = slice(int(begins), len(outflows) - int(ends))
        own = float(force[chain.row, chain.column])
        turned = [0.0]
        for behind, ahead in outflows[whole]:
            turned.append(turned[-1] - (behind + ahead) - own * half)
        between = [[-before[0], after[1]] for before, after in pairwise(outflows)]
        wanted = [[outflows[0][1]], *between, [-outflows[-1][0]]][whole.start : len(between) + 2 - int(ends)]
        free = sum(sum(each) / len(each) - known for each, known in zip(wanted, turned, strict=True)) / len(turned)
        turned = [free + each for each in turned]
        # A triangle has one line through the point that flows turn across, and whole quarters have two.
        _turn(at_corners, chain.quarters, [*[0.0] * int(begins), *turned, *[0.0] * int(ends)])
        for (behind, ahead), first, last in zip(outflows[whole], turned, turned[1:], strict=False):
            parts = abs(behind) + abs(ahead) + abs(first) + abs(last) + float(size[chain.row, chain.column]) * half
            loose += (FEW * parts) * (FEW * parts) / (2 * half)
    return rounded_up(loose)


def _outflows(through: tuple[tuple[Grid, Grid], tuple[Grid, Grid]], quarter: FrameQuarter) -> tuple[float, float]:
    """Return what flows out of a quarter along the directions in which it begins and ends, counterclockwise.

    Along the direction in which there is no node a triangle has the flux that leaves the node's quarter beside it: it
    tells what T∇v is there.
    """
    down, right = CORNERS[quarter.corner]
    place = quarter.row, quarter.column
    lower, left = down, right
    if quarter.node is not None:
        beside = CORNERS[quarter.node][0] == down
        lower, left = (down, 1 - right) if beside else (1 - down, right)
    along_x = float(through[0][lower][place]) * (1 - 2 * right)
    along_y = float(through[1][left][place]) * (1 - 2 * down)
    # In the first quarter the flux that turns towards the next direction is that along y, and so on in turn.
    return (along_x, along_y) if quarter.corner % 2 == 0 else (along_y, along_x)


def _turn(at_corners: list[tuple[Grid, Grid]], quarters: tuple[FrameQuarter, ...], turned: list[float]) -> None:
    """Lay down what flows counterclockwise across the lines between quarters, and those at both ends."""
    for quarter, (first, last) in zip(quarters, pairwise(turned), strict=True):
        at_x, at_y = at_corners[quarter.corner]
        sign = 1.0 if quarter.corner in (0, 3) else -1.0
        place = quarter.row, quarter.column
        if quarter.corner % 2 == 0:
            at_y[place], at_x[place] = sign * first, -sign * last
        else:
            at_x[place], at_y[place] = sign * first, sign * last
