"""Coefficients about corners that point inwards: what a window says of a spline, and what is chosen in it."""

import numpy as np
import pytest
from continuous import Posed

import contactqp as cq
from contactqp.continuum.barriers import subsolution, supersolution
from contactqp.continuum.cells import Cells
from contactqp.continuum.inward import mended_at_corners
from contactqp.continuum.obstacle import ObstacleProblem
from contactqp.continuum.pointwise import pointwise_bounds
from contactqp.continuum.splines import excess_along_rim, ranges_on_cells
from contactqp.continuum.windows import windows_of

STRAIGHT = [(0, 0), (24, 0), (24, 12), (12, 12), (12, 24), (0, 24)]
TURNED = [(0, 0), (24, 0), (24, 24), (20, 24), (12, 16), (4, 24), (0, 24)]
BLUNT = [(0, 0), (24, 0), (24, 8), (16, 16), (16, 24), (0, 24)]
SHARP = [(0, 0), (24, 0), (24, 24), (20, 24), (12, 16), (12, 24), (0, 24)]
SHAPES = {"270": STRAIGHT, "270 turned": TURNED, "225": BLUNT, "315": SHARP}

shapes = pytest.mark.parametrize("corners", SHAPES.values(), ids=SHAPES)


def cells_of(corners, spacing=1.0):
    lattice = cq.Frame.polygon(corners).lattice(spacing)
    return Cells(lattice.mask, spacing, lattice.halved)


def at_ends(cells, end=0):
    """Return where the edges of a rim begin or end, counted flat."""
    return np.concatenate([np.ravel_multi_index(edges.ends[end], cells.nodes.shape) for edges in cells.rim])


def moved(window, coefficients, by):
    """Return coefficients of which a window's own are larger."""
    found = coefficients.copy()
    found.flat[window.places[window.free]] += by
    return found


@shapes
def test_windows_know_the_laplacian_on_their_cells(corners):
    cells = cells_of(corners)
    (window,) = windows_of(cells)
    rng = np.random.default_rng(1)
    shape = np.array(cells.nodes.shape)
    c, q = rng.normal(size=shape + 2), rng.normal(size=shape)
    found = ranges_on_cells(cells, c, 3.0, q)
    own = 3.0 * (window.bends @ c.flat[window.places]) - (window.weights * q.flat[window.corners]).sum(axis=1)
    touched = np.unique(window.cells)
    for cell in touched:
        assert own[window.cells == cell].min() == pytest.approx(found.least_excess.flat[cell])
        assert own[window.cells == cell].max() == pytest.approx(found.most_excess.flat[cell])
    # Those that cells share are the same for each.
    _, number = np.unique(window.shared, return_inverse=True)
    assert number.max() + 1 < window.shared.size
    least = np.full(number.max() + 1, np.inf)
    np.minimum.at(least, number, own)
    np.testing.assert_allclose(least[number], own, atol=1e-12)
    # No other cell depends on what is free.
    far = ranges_on_cells(cells, moved(window, c, 1e6), 3.0, q)
    np.testing.assert_array_equal(np.flatnonzero(cells.inside & (far.most != found.most)), touched)


@shapes
def test_windows_know_the_height_on_their_edges(corners):
    cells = cells_of(corners)
    (window,) = windows_of(cells)
    rng = np.random.default_rng(2)
    shape = np.array(cells.nodes.shape)
    c, heights = rng.normal(size=shape + 2), rng.normal(size=shape)
    rim = window.heights
    start, end = heights.flat[rim.start], heights.flat[rim.end]
    own = rim.weights @ c.flat[window.places] - (start + rim.way * (end - start))
    least, most = excess_along_rim(cells, c, heights)
    changed = excess_along_rim(cells, moved(window, c, 1e6), heights)[1] != most
    firsts, lasts = at_ends(cells, 0), at_ends(cells, 1)
    assert changed.any()
    for first, last, low, high, near in zip(firsts, lasts, least, most, changed, strict=True):
        chosen = (rim.start == first) & (rim.end == last)
        assert chosen.any() == near
        if chosen.sum() in (4, 7):  # all of them: of others some depend on nothing that is free
            assert own[chosen].min() == pytest.approx(low)
            assert own[chosen].max() == pytest.approx(high)
        assert ((low - 1e-9 <= own[chosen]) & (own[chosen] <= high + 1e-9)).all()
    # Where nothing but free coefficients enters, a height follows them.
    rise = rim.weights @ (moved(window, c, 1.0) - c).flat[window.places]
    np.testing.assert_allclose(rise[window.loose], 1.0)
    assert (rise[~window.loose] < 1.0).all()


def test_corners_next_to_each_other_share_a_window():
    corners = [(0, 0), (24, 0), (24, 12), (15, 12), (12, 15), (12, 24), (0, 24)]
    assert len(windows_of(cells_of(corners))) == 1
    assert len(windows_of(cells_of(corners, 0.25))) == 2


def test_of_too_many_corners_there_are_no_windows():
    teeth = [(x, 12 + x % 4) for x in range(200, -1, -2)]
    cells = cells_of([(0, 0), (200, 0), *teeth])
    assert cells.inward_corners[0].size > 40
    assert windows_of(cells) == ()


def problem_of(corners, spacing=1.0, load=1.0, height=30.0):
    cells = cells_of(corners, spacing)
    ones = np.ones(cells.nodes.shape)
    return ObstacleProblem(cells, 1.0, load * ones, height * ones)


@shapes
@pytest.mark.parametrize("side", [1, -1])
def test_programs_miss_less_than_a_continued_answer(corners, side):
    lattice = cq.Frame.polygon(corners).lattice(1.0)
    posed = Posed(lattice, lambda x, y: 1.0 + 0 * x, lambda x, y: 30.0 + 0 * x)
    problem = posed.problem
    bend = problem.bend(problem.load)
    before = problem.continuation(posed.gap, bend, "less" if side > 0 else "more")
    after = mended_at_corners(problem, before, side)
    (window,) = problem.windows
    still = np.ones(before.size, dtype=bool)
    still[window.places[window.free]] = False
    np.testing.assert_array_equal(after.flat[still], before.flat[still])
    barrier = supersolution if side > 0 else subsolution
    near = np.unique(window.cells)
    defects = [barrier(problem, c).defects.flat[near].max() for c in (before, after)]
    assert defects[1] < 0.25 * defects[0]
    loose, tied = (window.heights.start[chosen] for chosen in (window.loose, ~window.loose))
    edge = np.isin(at_ends(problem.cells), np.setdiff1d(loose, tied))
    missing = [(-side * problem.excess_along_rim(c)[0 if side > 0 else 1])[edge].max() for c in (before, after)]
    assert missing[1] < 1e-6 < missing[0]


def test_a_membrane_that_does_not_bend_stays_as_it_is():
    problem = problem_of(TURNED, load=0.0)
    flat = np.full(np.array(problem.cells.nodes.shape) + 2, 30.0)
    for side in (1, -1):
        np.testing.assert_array_equal(mended_at_corners(problem, flat, side), flat)


def test_what_is_no_number_stays_as_it_is():
    problem = problem_of(TURNED)
    for number in (np.nan, np.inf, 1e308):
        wild = np.full(np.array(problem.cells.nodes.shape) + 2, number)
        wild[::2] *= -1.0
        np.testing.assert_array_equal(mended_at_corners(problem, wild, 1), wild)


def test_lower_bounds_in_contact_are_not_asked_for_anything():
    problem = problem_of(STRAIGHT)
    touching = np.zeros(np.array(problem.cells.nodes.shape) + 2)
    np.testing.assert_array_equal(mended_at_corners(problem, touching, -1, spared=1.0), touching)


@shapes
def test_bounds_close_at_corners_that_point_inwards(corners):
    found = []
    for spacing in (1.0, 0.25):
        lattice = cq.Frame.polygon(corners).lattice(spacing)
        posed = Posed(lattice, lambda x, y: 1.0 + 0 * x, lambda x, y: 9.0 + 0 * x)
        bounds = pointwise_bounds(posed.problem, posed.gap, posed.resolve)
        lower, upper = bounds.at_points()
        found.append((np.maximum(lower, 0.0)[posed.box], upper[posed.box]))
    (lower, upper), (fine_lower, fine_upper) = found[0], [one[::4, ::4] for one in found[1]]
    inside = np.isfinite(lower)
    assert (lower <= fine_upper)[inside].all()
    assert (fine_lower <= upper)[inside].all()
    widths, fine_widths = (upper - lower)[inside], (fine_upper - fine_lower)[inside]
    # r^α has α = 4/7 at 315°: a quarter of the spacing leaves 0.45 of what is missed at the corner.
    assert fine_widths.max() < 0.6 * widths.max()
    assert fine_widths.mean() < 0.15 * widths.mean()
