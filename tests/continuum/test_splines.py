"""Ranges of splines on cells against rational arithmetic, and against a twin in plain numpy."""

from fractions import Fraction

import numpy as np
import pytest
from exact_splines import bilinear, fractions, laplacian, places_in, value
from hypothesis import given
from hypothesis import strategies as st

import contactqp as cq
from contactqp.continuum.cells import Cells
from contactqp.continuum.splines import at_points, excess_along_rim, excess_on_cells, ranges_on_cells


def some_numbers(rng, shape):
    """Return numbers of like or of widely different sizes, nearly equal ones and zeros among them."""
    numbers = rng.normal(size=shape) * 10.0 ** rng.uniform(-rng.choice([0, 8, 20]), 1, shape)
    if rng.uniform() < 0.4:
        numbers = 1.0 + rng.choice([1e-3, 1e-15]) * numbers
    return np.where(rng.uniform(size=shape) < 0.2, 0.0, numbers)


def some_cells(rng):
    if rng.uniform() < 0.4:
        corners = [(1, 0), (3, 0), (4, 1), (4, 2), (3, 3), (2, 3), (0, 1)]
        lattice = cq.Frame.polygon(corners).lattice(rng.choice([0.5, 1.0]))
        return Cells(lattice.mask, float(rng.choice([0.25, 1 / 3])), lattice.halved)
    mask = rng.uniform(size=rng.integers(1, 4, 2)) < rng.choice([0.7, 1.0])
    mask[0, 0] = True
    try:
        return Cells(mask, float(rng.choice([0.25, 1 / 3, 1e-6, 37.3])))
    except ValueError:
        return some_cells(rng)


@given(st.integers(0, 2**32 - 1))
def test_ranges_hold_everywhere_in_the_cells(seed):
    rng = np.random.default_rng(seed)
    cells = some_cells(rng)
    shape = np.array(cells.nodes.shape)
    c, q = some_numbers(rng, shape + 2), some_numbers(rng, shape)
    c, q = (c * 1e-300, q * 1e-300) if rng.uniform() < 0.02 else (c, q)
    tension = float(10.0 ** rng.uniform(-3, 3))
    found = ranges_on_cells(cells, c, tension, q)
    exact, exact_q = fractions(c), fractions(q)
    values, error = at_points(c)
    for i, j in rng.permutation(np.argwhere(cells.inside))[:3]:
        for row, column in places_in(rng, i, j, 2):
            excess = Fraction(tension) * laplacian(exact, row, column, cells.spacing) - bilinear(exact_q, row, column)
            assert Fraction(found.least_excess[i, j]) <= excess <= Fraction(found.most_excess[i, j])
            assert Fraction(found.least[i, j]) <= value(exact, row, column) <= Fraction(found.most[i, j])
        assert abs(value(exact, int(i), int(j)) - Fraction(values[i, j])) <= Fraction(error)
    assert np.isnan(found.least[~cells.inside]).all()


@given(st.integers(0, 2**32 - 1))
def test_a_spline_less_a_bilinear_field_keeps_to_its_range(seed):
    rng = np.random.default_rng(seed)
    cells = some_cells(rng)
    shape = np.array(cells.nodes.shape)
    c, f = some_numbers(rng, shape + 2), some_numbers(rng, shape)
    least, most = excess_on_cells(cells, c, np.where(cells.corners, f, np.inf))
    exact, exact_f = fractions(c), fractions(f)
    for i, j in rng.permutation(np.argwhere(cells.inside))[:3]:
        for row, column in places_in(rng, i, j, 2):
            excess = value(exact, row, column) - bilinear(exact_f, row, column)
            assert Fraction(least[i, j]) <= excess <= Fraction(most[i, j])
    assert np.isnan(least[~cells.inside]).all()
    assert np.isnan(most[~cells.inside]).all()
    assert (most - least)[cells.inside].max() <= 64 * (np.abs(c).max() + np.abs(f).max())


def test_a_spline_less_a_field_is_its_largest_and_least_by_hand():
    cells = Cells(np.ones((1, 1), dtype=bool), 1.0)
    rising = np.tile(np.arange(-1.0, 4.0), (5, 1))  # the spline of linear coefficients is x itself
    least, most = excess_on_cells(cells, rising, np.full((3, 3), 0.5))
    assert least == pytest.approx(np.array([[-0.5, 0.5]] * 2))
    assert most == pytest.approx(np.array([[0.5, 1.5]] * 2))


def test_what_overflows_has_no_range():
    cells = Cells(np.ones((1, 1), dtype=bool), 1.0)
    least, most = excess_on_cells(cells, np.full((5, 5), 1e300), np.zeros((3, 3)))
    assert (least == -np.inf).all()
    assert (most == np.inf).all()


@given(st.integers(0, 2**32 - 1))
def test_ranges_along_the_rim_hold(seed):
    rng = np.random.default_rng(seed)
    cells = some_cells(rng)
    shape = np.array(cells.nodes.shape)
    c, heights = some_numbers(rng, shape + 2), some_numbers(rng, shape)
    exact, exact_heights = fractions(c), fractions(heights)
    edges = [(i, j, edges.step) for edges in cells.rim for i, j in zip(edges.row, edges.column, strict=True)]
    for (i, j, step), low, high in zip(edges, *excess_along_rim(cells, c, heights), strict=True):
        way = Fraction(int(rng.integers(33)), 32)
        at = int(i) + way * step[0], int(j) + way * step[1]
        start, end = exact_heights[i, j], exact_heights[i + step[0], j + step[1]]
        excess = value(exact, *at) - ((1 - way) * start + way * end)
        assert Fraction(low) <= excess <= Fraction(high)


def bernstein(c):
    """Return the matrix that takes four coefficients of a cubic spline to Bernstein coefficients, applied to c."""
    return np.array([[1, 4, 1, 0], [0, 4, 2, 0], [0, 2, 4, 0], [0, 1, 4, 1]]) / 6 @ c


def test_the_pass_says_what_plain_numpy_says():
    rng = np.random.default_rng(7)
    cells, tension = Cells(np.ones((3, 4), dtype=bool), 0.5), 2.0
    c, q = rng.normal(size=(7, 8)), rng.normal(size=(5, 6))
    found = ranges_on_cells(cells, c, tension, q)
    raised = np.array([[3, 0], [2, 1], [1, 2], [0, 3]]) / 3
    for i, j in np.ndindex(cells.inside.shape):
        block = c[i : i + 4, j : j + 4]
        value_net = bernstein(bernstein(block).T).T
        along = bernstein(np.diff(block, n=2, axis=1)) @ raised.T
        across = raised @ bernstein(np.diff(block, n=2, axis=0).T).T
        excess = tension * (along + across) / 0.25 - raised @ q[i : i + 2, j : j + 2] @ raised.T
        assert found.most[i, j] == pytest.approx(value_net.max(), abs=1e-13)
        assert found.least[i, j] == pytest.approx(value_net.min(), abs=1e-13)
        assert found.most_excess[i, j] == pytest.approx(excess.max(), abs=1e-12)
        assert found.least_excess[i, j] == pytest.approx(excess.min(), abs=1e-12)


def test_a_parabola_is_met_exactly_but_for_rounding():
    """s = x² + y² has the coefficients x² + y² - 2h²/3, and Δs = 4."""
    cells, h = Cells(np.ones((4, 4), dtype=bool), 0.25), 0.25
    at = h * np.arange(-1, 7)
    c = at[:, None] ** 2 + at**2 - 2 * h**2 / 3
    found = ranges_on_cells(cells, c, 1.0, np.full((6, 6), 4.0))
    assert max(np.abs(found.least_excess).max(), np.abs(found.most_excess).max()) < 1e-11
    values, _ = at_points(c)
    np.testing.assert_allclose(values, at[1:-1, None] ** 2 + at[1:-1] ** 2, atol=1e-15)


def test_overflow_proves_nothing():
    cells = Cells(np.ones((2, 2), dtype=bool), 0.25)
    c = np.full((6, 6), 1e308)
    c[2, 2] = -1e308
    with np.errstate(over="ignore"):
        found = ranges_on_cells(cells, c, 1.0, np.zeros((4, 4)))
    assert (found.most_excess == np.inf).all()
    assert (found.least == -np.inf).all()
