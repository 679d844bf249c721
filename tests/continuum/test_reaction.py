"""The force that the support bears: integrals of splines by quadrature, and closed forms."""

from itertools import product

import numpy as np
import pytest
from continuous import ring
from exact_splines import laplacian, value

from contactqp.continuum.barriers import subsolution, supersolution
from contactqp.continuum.cells import Cells
from contactqp.continuum.obstacle import ObstacleProblem
from contactqp.continuum.pointwise import PointwiseBounds, pointwise_bounds
from contactqp.continuum.reaction import bent_weights, cutoff_of, reaction_bracket


def test_the_integral_of_a_spline_times_a_laplacian():
    """Products have degree six along x and y: four points of Gauss in a cell are exact."""
    rng = np.random.default_rng(1)
    c, cutoff = rng.integers(-3, 4, (8, 9)).astype(float), np.zeros((8, 9))
    cutoff[3:5, 3:6] = rng.integers(1, 3, (2, 3))
    weights, sizes = bent_weights(cutoff)
    ways, parts = np.polynomial.legendre.leggauss(4)
    total = 0.0
    for i, j in np.ndindex(5, 6):
        for (a, first), (b, second) in product(zip((ways + 1) / 2, parts / 2, strict=True), repeat=2):
            at = i + float(a), j + float(b)
            total += first * second * float(value(c, *at)) * float(laplacian(cutoff, *at, 1))
    assert total == pytest.approx((weights * c).sum(), abs=1e-11)
    assert (sizes >= np.abs(weights) * (1 - 1e-12)).all()


def test_the_cutoff_is_one_where_the_membrane_may_touch_and_vanishes_at_the_frame():
    cells = Cells(np.ones((11, 12), dtype=bool), 0.5)
    clear = np.ones(cells.inside.shape, dtype=bool)
    clear[5:7, 5:8] = False
    cutoff = cutoff_of(cells, clear)
    assert (cutoff[5:10, 5:11] == 1.0).all()
    assert not cutoff[:3].any()
    assert not cutoff[:, -3:].any()
    assert cutoff.min() == 0.0
    clear[0, 0] = False
    assert cutoff_of(cells, clear) is None


def test_the_ring_is_borne_by_the_disk():
    """ρ = 2 on the unit disk: 2π; the bracket closes as the square of the spacing."""
    widths = []
    for squares in (48, 96):
        posed = ring(squares)
        bounds = pointwise_bounds(posed.problem, posed.gap, posed.resolve)
        clear = posed.problem.cells.inside & (bounds.lower.on_cells() > 0)
        found = reaction_bracket(posed.problem, bounds, clear)
        assert found.lower <= 2 * np.pi <= found.upper
        widths.append(found.upper - found.lower)
    assert np.log2(widths[0] / widths[1]) >= 1.7


def test_without_contact_the_support_bears_nothing():
    posed = ring(24)
    bounds = pointwise_bounds(posed.problem, posed.gap, posed.resolve)
    found = reaction_bracket(posed.problem, bounds, posed.problem.cells.inside)
    assert found.lower == 0.0
    assert found.upper < 1e-12


def test_a_force_that_overflows_is_not_bounded():
    """The load is finite, as are both barriers, but not the force of the load on the region."""
    cells = Cells(np.ones((20, 20), dtype=bool), 1e100)
    points = np.ones(cells.nodes.shape)
    problem = ObstacleProblem(cells, 1e180, 1e200 * points, 1e200 * points)
    coefficients = np.ones((24, 24))
    bounds = PointwiseBounds(
        subsolution(problem, -1e200 * coefficients), supersolution(problem, 2e200 * coefficients), (0, 0)
    )
    clear = np.ones(cells.inside.shape, dtype=bool)
    clear[8:12, 8:12] = False
    with np.errstate(over="ignore", invalid="ignore"):
        bracket = reaction_bracket(problem, bounds, clear)
    assert bracket == (0.0, np.inf)
