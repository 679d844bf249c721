"""Bounds of the membrane's gap at every point: against closed forms and finer lattices, and how fast they close."""

import numpy as np
import pytest
from continuous import Posed, bowl, ring, ring_height

import contactqp as cq
from contactqp.continuum.pointwise import pointwise_bounds


def enclosed(posed, **options):
    bounds = pointwise_bounds(posed.problem, posed.gap, posed.resolve, **options)
    lower, upper = bounds.at_points()
    closure = posed.problem.cells.closure
    assert np.isfinite(lower[closure]).all()
    assert (lower[closure] <= upper[closure]).all()
    return bounds, lower[posed.box], upper[posed.box]


def test_the_ring_is_within_its_bounds():
    widths = []
    for squares in (12, 48):
        posed = ring(squares)
        bounds, lower, upper = enclosed(posed)
        exact = ring_height(posed.x, posed.y)[posed.box]
        assert (lower <= exact).all()
        assert (exact <= upper).all()
        widths.append((upper - lower).max())
        # Between the points as well.
        rng = np.random.default_rng(squares)
        i, j = rng.integers(0, squares, (2, 200))
        way = rng.uniform(size=(2, 200))
        between = ring_height(3 / squares * (j + way[0]) - 1.5, 3 / squares * (i + way[1]) - 1.5)
        on_cells = [bound.on_cells()[posed.problem.cells.inside] for bound in (bounds.lower, bounds.upper)]
        assert (on_cells[0][i * squares + j] <= between).all()
        assert (between <= on_cells[1][i * squares + j]).all()
    assert np.log(widths[0] / widths[1]) / np.log(4) >= 1.8


def test_bounds_of_the_bowl_close_as_the_square_of_the_spacing_and_as_near_as_the_error():
    finest = bowl(256)
    distances = []
    for squares in (16, 64):
        posed = bowl(squares)
        _, lower, upper = enclosed(posed)
        truth, gap = finest.gap[finest.box][:: 256 // squares, :: 256 // squares], posed.gap[posed.box]
        error = np.abs(gap - truth).max()
        assert (lower <= truth).all()
        assert (truth <= upper).all()
        distances.append(((upper - gap).max(), (gap - lower).max()))
        assert distances[-1][0] <= 5 * error
        assert distances[-1][1] <= 25 * error
    assert (np.log(np.divide(*distances)) / np.log(4) >= 1.8).all()


@pytest.mark.parametrize("seed", range(6))
def test_rectangles_under_smooth_loads_against_finer_lattices(seed):
    rng = np.random.default_rng(seed)
    columns, rows = rng.integers(6, 14, 2)
    width, height = 1.0, float(rows / columns)
    mean, part = rng.choice([1.0, 0.3]), rng.uniform(0.5, 1.5)
    wave, phase, rise = rng.uniform(1, 6, 2), rng.uniform(0, 6, 2), rng.uniform(-0.02, 0.02, 2)

    def load(x, y):
        return mean + part * np.sin(wave[0] * x + phase[0]) * np.cos(wave[1] * y + phase[1])

    def heights(x, y):
        return 0.04 + rise[0] * x + rise[1] * y

    found = []
    for finer in (1, 8):
        lattice = cq.Frame.rectangle(width, height).lattice(width / columns / finer)
        posed = Posed(lattice, load, heights, float(part * (wave**2).sum()))
        _, lower, upper = enclosed(posed)
        found.append((lower[::finer, ::finer], upper[::finer, ::finer]))
    (lower, upper), (fine_lower, fine_upper) = found
    assert (lower <= fine_upper).all()
    assert (fine_lower <= upper).all()
    assert (fine_upper - fine_lower).max() < (upper - lower).max()


def test_corners_that_point_inwards_are_worse_but_never_wrong():
    def corner(squares):
        outline = [(0, 0), (1, 0), (1, 0.5), (0.5, 0.5), (0.5, 1), (0, 1)]
        lattice = cq.Frame.polygon(outline).lattice(1 / squares)
        return Posed(lattice, lambda x, y: 1.0 + 0 * x, lambda x, y: 0.015 + 0 * x)

    _, lower, upper = enclosed(corner(16))
    _, fine_lower, fine_upper = enclosed(corner(64))
    closure = np.isfinite(lower)
    assert (lower[closure] <= fine_upper[::4, ::4][closure]).all()
    assert (fine_lower[::4, ::4][closure] <= upper[closure]).all()
    assert np.nanmean(fine_upper - fine_lower) < 0.2 * np.nanmean(upper - lower)


def test_what_the_lattice_is_solved_for_is_no_part_of_the_proof():
    """Answers that are nowhere near still give bounds, wide ones."""
    posed = ring(12)
    rng = np.random.default_rng(3)
    exact = ring_height(posed.x, posed.y)
    for nonsense in (lambda load: rng.normal(size=load.shape), lambda load: np.zeros(load.shape)):
        bounds = pointwise_bounds(posed.problem, posed.problem.with_rim(nonsense(exact)), nonsense, rounds=2)
        for bound, side in zip(bounds.at_points(), (-1, 1), strict=True):
            assert (side * (bound - exact)[posed.box] >= 0).all()


def test_without_a_support_in_reach_the_membrane_hangs_between_its_bounds():
    """No contact: u = 1 - w with Poisson's equation on the unit square, w = 0.0736713... in its middle."""
    lattice = cq.Frame.rectangle(1, 1).lattice(1 / 32)
    posed = Posed(lattice, lambda x, y: 1.0 + 0 * x, lambda x, y: 1.0 + 0 * x)
    _, lower, upper = enclosed(posed)
    odd = np.arange(1, 200, 2)
    middle = (1 - (1 / odd**3) @ ((-1.0) ** (odd // 2) / np.cosh(odd * np.pi / 2)) * 32 / np.pi**3) / 8
    assert lower[16, 16] <= 1 - middle <= upper[16, 16]
    assert upper[16, 16] - lower[16, 16] < 5e-4
