"""Fields on squares that slanted sides halve: arrays are linear there, functions lie within margins of their chords."""

from typing import Any

import numpy as np
import pytest
from quadratics import Quadratic

import contactqp as cq
from contactqp.continuum.cells import Cells
from contactqp.continuum.data import Data
from contactqp.continuum.halves import away_from_chords, halves_of, linear_on_halves

CORNERS = [(0, 0), (6, 0), (6, 4), (4, 6), (0, 6)]
DIAMOND = [(2, 0), (0, 2), (-2, 0), (0, -2)]


def known(corners, support):
    lattice = cq.Frame.polygon(corners).lattice(1.0)
    data = Data.of(cq.Membrane(lattice, 1.0, load=1.0, support=support, frame_height=-100.0))
    return data, Cells(lattice.mask, lattice.spacing, lattice.halved)


@pytest.mark.parametrize("corners", [CORNERS, DIAMOND], ids=["pentagon", "diamond"])
def test_an_array_is_linear_on_the_half(corners):
    rng = np.random.default_rng(5)
    size = cq.Frame.polygon(corners).lattice(1.0).size
    data, cells = known(corners, rng.uniform(1, 2, size))
    field = linear_on_halves(data.support, cells)
    inner = cells.closure
    np.testing.assert_array_equal(field.values[inner], data.support.values[inner])
    x, y = data.plan.places
    halves = halves_of(cells, (x, y))
    for (row, column), triangle in zip(np.argwhere(cells.cut), halves.corners, strict=True):
        places = [(round(b - y[0, 0]), round(a - x[0, 0])) for a, b in triangle]
        heights = np.array([field.values[place] for place in places])
        for weights in rng.dirichlet(np.ones(3), 20):
            at_x, at_y = weights @ triangle
            t, s = at_x - x[0, column], at_y - y[row, 0]
            f = field.values
            bilinear = (1 - s) * ((1 - t) * f[row, column] + t * f[row, column + 1]) + s * (
                (1 - t) * f[row + 1, column] + t * f[row + 1, column + 1]
            )
            linear = weights @ heights
            assert bilinear - field.below[row, column] <= linear <= bilinear + field.above[row, column]
            assert field.range_lower[row, column] - 1e-15 <= linear <= field.range_upper[row, column] + 1e-15


def test_chords_of_a_function():
    """Of f = 3 + 0.1xy the bilinear interpolant is itself, and leaves chords by a twentieth at most."""
    surface = cq.Smooth(lambda x, y: 3 + 0.1 * x * y, second_derivative=0.1)
    data, cells = known(CORNERS, surface)
    below, above = away_from_chords(data.support, cells, linear=False)
    assert (below[~cells.cut] == 0).all()
    x, y = data.plan.places
    for row, column in np.argwhere(cells.cut):
        _, start, end = halves_of(cells, (x, y)).corners[np.argwhere(cells.cut).tolist().index([row, column])]
        for t in np.linspace(0, 1, 9):
            place = (1 - t) * start + t * end
            chord = (1 - t) * surface(*start) + t * surface(*end)
            assert chord - below[row, column] <= surface(*place) <= chord + above[row, column]
    same = away_from_chords(data.support, cells, linear=True)
    assert not np.any(same)


def test_corners_of_halves_begin_at_the_node():
    data, cells = known(DIAMOND, 1.0)
    halves = halves_of(cells, data.plan.places)
    assert halves.corners.shape == (8, 3, 2)
    sums = np.abs(halves.corners).sum(axis=2)
    np.testing.assert_allclose(sums, np.tile([1.0, 2.0, 2.0], (8, 1)))
    assert len(halves.of(cells.cut)) == 8
    assert not len(halves.of(cells.whole))


FUNCTIONS: dict[str, Any] = {
    "all known": Quadratic(3.0, 0.0, 0.1, 0.0),
    "all known, turned": Quadratic(3.0, 0.05, -0.2, -0.03),
    "twist": cq.Smooth(lambda x, y: 3 + 0.1 * x * y, second_derivative=0.1),
    "turned": cq.Smooth(lambda x, y: 3 - 0.1 * x * y + 0.03 * x * x, second_derivative=0.14),
    "wave": cq.Smooth(lambda x, y: 3 + 0.2 * np.sin(x + 2 * y), second_derivative=1.0),
    "steep": cq.Smooth(lambda x, y: 3 + 0.2 * np.abs(x - y / 2), lipschitz=0.25),
    "hill": cq.profiles.Paraboloid(3.0, 5.0, (0.3, 0.2)),
    "kink": cq.profiles.Uppermost(cq.profiles.Plane(3.0, 0.1), cq.profiles.Plane(3.1, -0.1, 0.05)),
}


@pytest.mark.parametrize("corners", [CORNERS, DIAMOND], ids=["pentagon", "diamond"])
@pytest.mark.parametrize("name", FUNCTIONS)
def test_margins_about_the_linear_interpolant(corners, name):
    """Of the half all of it, of the quarter at the node the mean; values beyond the frame do not count."""
    function = FUNCTIONS[name]
    data, _ = known(corners, function)
    plan, field = data.plan, data.support
    assert field.exact
    x, y = (np.broadcast_to(part, plan.nodes.shape) for part in plan.places)
    parts = (np.arange(40) + 0.5) / 40
    along, up = (part.ravel() for part in np.meshgrid(parts, parts))
    seen = 0
    for halves in plan.halves:
        for k, place in enumerate(zip(*halves.place, strict=True)):
            (a_x, b_x, _), (a_y, _, c_y), heights = (
                [part[k] for part in halves.of(each)] for each in (x, y, field.values)
            )

            def off(s, t, heights=heights, a=(a_x, a_y), b_x=b_x, c_y=c_y):
                linear = heights[0] + s * (heights[1] - heights[0]) + t * (heights[2] - heights[0])
                return np.asarray(function(a[0] + s * (b_x - a[0]), a[1] + t * (c_y - a[1]))) - linear

            within = along + up <= 1
            here = off(along[within], up[within])
            assert -field.below[place] <= here.min()
            assert here.max() <= field.above[place]
            assert -field.bent_below[place] <= here.min()
            assert here.max() <= field.bent_above[place]
            mean = off(along / 2, up / 2).mean()
            slack = 1e-3 * (field.above[place] + field.below[place])  # of the midpoint rule
            assert -field.mean_below[place] - slack <= mean <= field.mean_above[place] + slack
            seen += 1
    assert seen == plan.halved.sum() > 0
    assert (field.values[~plan.points] == 0).all()
    whole = data.of_whole_squares
    assert whole.of_whole_squares is whole
    np.testing.assert_array_equal(whole.support.values[plan.points], field.values[plan.points])


@pytest.mark.parametrize("name", ["twist", "wave", "hill", "kink"])
def test_tensions_on_the_parts_of_halves(name):
    lattice = cq.Frame.polygon(CORNERS).lattice(1.0)
    data = Data.of(cq.Membrane(lattice, FUNCTIONS[name], load=1.0, support=9.0))
    plan = data.plan
    x, y = (np.broadcast_to(part, plan.nodes.shape) for part in plan.places)
    parts = (np.arange(60) + 0.5) / 60
    s, t = (part.ravel() / 2 for part in np.meshgrid(parts, parts))
    for halves in plan.halves:
        (a_x, b_x, _), (a_y, _, c_y) = halves.of(x), halves.of(y)
        triangle = t < 0.5 - s
        for corner, (right, up) in zip(
            halves.corners, ((s, t), (0.5 + s[triangle], t[triangle]), (s[triangle], 0.5 + t[triangle])), strict=True
        ):
            told = data.tensions(1, corner)
            middle, spread, apart = (np.broadcast_to(part, plan.squares.shape)[halves.place] for part in told)
            there = FUNCTIONS[name](a_x + np.outer(right, b_x - a_x), a_y + np.outer(up, c_y - a_y))
            assert (np.abs(there - middle) <= spread).all()
            assert (np.abs(there.mean(axis=0) - middle) <= apart + 2e-3 * spread).all()
    for corner in range(4):  # nothing of what lies beyond
        least = np.broadcast_to(data.tensions(0, corner).least, plan.squares.shape)[plan.squares]
        assert least.min() > 2.0
