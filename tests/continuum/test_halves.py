"""Fields on squares that slanted sides halve: arrays are linear there, functions lie within margins of their chords."""

import numpy as np
import pytest

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
