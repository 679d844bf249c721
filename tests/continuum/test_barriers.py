"""Upper and lower bounds from any spline: their differential inequalities and their values in rational arithmetic."""

from fractions import Fraction

import numpy as np
import pytest
from exact_splines import bilinear, fractions, laplacian, places_in, value
from hypothesis import given
from hypothesis import strategies as st

import contactqp as cq
from contactqp.continuum.barriers import subsolution, supersolution
from contactqp.continuum.cells import Cells
from contactqp.continuum.obstacle import ObstacleProblem

REGIONS = {
    "rectangle": np.ones((2, 4), dtype=bool),
    "tall": np.ones((4, 1), dtype=bool),
    "corner inwards": np.array([[0, 0, 1], [1, 1, 1], [1, 1, 1]], dtype=bool),
    "two slanted sides": [(1, 0), (3, 0), (4, 1), (4, 3), (3, 3), (0, 3), (0, 1)],
    "diamond": [(3, 0), (0, 3), (-3, 0), (0, -3)],
    "two parts": np.array([[1, 0, 0, 0], [0, 0, 0, 1], [0, 0, 0, 1]], dtype=bool),
}


def some_problem(rng, mask):
    lattice = cq.Frame.polygon(mask).lattice(1.0) if isinstance(mask, list) else cq.Lattice.from_mask(mask, 1.0)
    cells = Cells(lattice.mask, float(rng.choice([0.25, 0.1, 1 / 3])), lattice.halved)
    shape = cells.nodes.shape
    load = rng.choice([1.0, -1.0, 3.0]) + rng.choice([0.0, 1e-3, 1.0]) * rng.normal(size=shape)
    spread = rng.choice([0.0, 1e-12, 0.3])
    heights = rng.choice([0.0, 0.2]) + rng.choice([0.0, 0.1]) * rng.uniform(size=shape)
    return ObstacleProblem(
        cells,
        float(rng.choice([1.0, 0.7, 12.0])),
        load,
        heights,
        (-spread * rng.uniform(size=cells.inside.shape), spread),
        (-0.01 * spread, 0.02 * spread),
    )


def some_coefficients(rng, problem):
    """Return coefficients of any spline, or of one that is nearly flat, or nearly a parabola."""
    shape = np.array(problem.cells.nodes.shape) + 2
    row, column = np.indices(shape) * problem.cells.spacing
    parabola = (row**2 + column**2) * problem.load.mean() / (4 * problem.tension)
    noise = rng.choice([1e-14, 1e-3, 1.0]) * rng.normal(size=shape) * problem.cells.spacing**2
    return rng.choice([0.0, 1.0]) * parabola + rng.choice([-0.1, 0.0, 0.1]) + noise


class Exactly:
    """A barrier in rational arithmetic."""

    def __init__(self, barrier):
        problem = barrier.problem
        self.problem, self.side = problem, barrier.side
        self.c, self.load = fractions(barrier.coefficients), fractions(problem.load)
        self.multiple, self.shift = Fraction(barrier.multiple), Fraction(barrier.shift)
        self.spacing, self.tension = Fraction(problem.cells.spacing), Fraction(problem.tension)

    def at(self, row, column):
        axis, first, width = self.problem.cells.strip
        across = (row, column)[axis] - first
        height = across * (width - across) * self.spacing**2 / (2 * self.tension)
        return value(self.c, row, column) + self.side * (self.multiple * height + self.shift)

    def excess(self, cell, row, column):
        """Return the least and the largest of TΔ - q, by what is known of q."""
        bent = self.tension * laplacian(self.c, row, column, self.spacing) - self.side * self.multiple
        q = bilinear(self.load, row, column)
        low, high = (
            Fraction(float(np.broadcast_to(end, self.problem.cells.inside.shape)[cell]))
            for end in self.problem.load_range
        )
        return bent - (q + high), bent - (q + low)


@given(st.sampled_from(sorted(REGIONS)), st.integers(0, 2**32 - 1))
def test_whatever_the_spline_the_inequalities_hold(region, seed):
    rng = np.random.default_rng(seed)
    problem = some_problem(rng, REGIONS[region])
    c, cells = some_coefficients(rng, problem), problem.cells
    upper, lower = supersolution(problem, c), subsolution(problem, c)
    above, below = Exactly(upper), Exactly(lower)
    on_cells, points = (upper.on_cells(), lower.on_cells()), (upper.at_points(), lower.at_points())
    for cell in map(tuple, rng.permutation(np.argwhere(cells.inside))[:2]):
        for row, column in places_in(rng, cell[0], cell[1], 2):
            high, low = above.at(row, column), below.at(row, column)
            assert 0 <= high <= Fraction(on_cells[0][cell])
            assert low >= Fraction(on_cells[1][cell])
            assert above.excess(cell, row, column)[1] <= 0
            assert low <= 0 or below.excess(cell, row, column)[0] >= 0
            if row.denominator == column.denominator == 1 and cells.closure[int(row), int(column)]:
                assert high <= Fraction(points[0][int(row), int(column)])
                assert low >= Fraction(points[1][int(row), int(column)])
    heights, (least, most) = fractions(problem.heights), map(Fraction, problem.height_range)
    for edges in cells.rim:
        if not edges.row.size:
            continue
        (i, j), step = map(int, rng.permutation(np.transpose(edges[:2]))[0]), edges.step
        way = Fraction(int(rng.integers(33)), 32)
        at = i + way * step[0], j + way * step[1]
        height = (1 - way) * heights[i, j] + way * heights[i + step[0], j + step[1]]
        assert above.at(*at) >= height + most
        assert below.at(*at) <= height + least


def test_numbers_that_are_not_finite_bound_nothing():
    cells = Cells(np.ones((2, 2), dtype=bool), 0.5)
    problem = ObstacleProblem(cells, 1.0, np.ones((4, 4)), np.zeros((4, 4)))
    for bad in (np.nan, np.inf):
        c = np.zeros((6, 6))
        c[2, 2] = bad
        with np.errstate(invalid="ignore"):
            assert not supersolution(problem, c).holds
            assert not subsolution(problem, c).holds


def test_the_best_shift_leaves_out_what_is_dear():
    """A flat spline at 0.01 lacks the whole load; it is dear to pay for that, and cheap to move it below zero."""
    cells = Cells(np.ones((3, 3), dtype=bool), 0.25)
    problem = ObstacleProblem(cells, 1.0, np.ones((5, 5)), np.ones((5, 5)))
    flat = subsolution(problem, np.full((7, 7), 0.01))
    assert flat.multiple == 0.0
    assert flat.shift == pytest.approx(0.01, abs=1e-12)
    high = subsolution(problem, np.full((7, 7), 0.9))
    assert high.multiple == pytest.approx(1.0, abs=1e-9)
    assert high.shift == pytest.approx(0.0, abs=1e-12)


def test_data_of_other_shapes_are_refused():
    cells = Cells(np.ones((2, 3), dtype=bool), 0.5)
    with pytest.raises(ValueError, match=r"load must have the shape \(4, 5\) of the points, got \(2, 3\)"):
        ObstacleProblem(cells, 1.0, np.ones((2, 3)), np.ones((4, 5)))
