"""Which way the rows of an array go is either known or asked for: nothing is mirrored without a word."""

import numpy as np
import pytest
import xarray as xr

import contactqp as cq
from contactqp import testing

LATTICE = cq.Frame.rectangle(5.0, 4.0).lattice(spacing=0.5)
HEIGHTS = 0.2 + 0.05 * np.arange(float(LATTICE.shape[0]))[:, None] * np.ones(LATTICE.shape[1])


def membrane(rows):
    return cq.Membrane(LATTICE, tension=1.0, load=1.0, support=HEIGHTS if rows == "up" else HEIGHTS[::-1], rows=rows)


@pytest.fixture
def solution():
    return cq.solve(membrane("down"), tol=1e-9)


def test_a_plain_array_of_an_answer_must_say_its_rows_where_the_model_s_own_go_down(solution):
    model, grid = solution.model, solution.to_dataset()["gap"].values
    for use in (
        lambda **rows: cq.certify(model, grid, **rows),
        lambda **rows: cq.certify(model, grid.tolist(), **rows),
        lambda **rows: testing.assert_complementary(model, grid, **rows),
        lambda **rows: testing.assert_encloses(solution, grid, slack=1e-6, **rows),
        lambda **rows: testing.assert_same_contact(solution, grid <= 0, **rows),
    ):
        with pytest.raises(ValueError, match=r'is an array without coordinates.*say rows="down".*DataArray') as told:
            use()
        assert "mask" in str(told.value) or str(told.value).startswith("gap is")
        use(rows="up")
    assert cq.certify(model, grid, rows="up").gap_bound < 1e-8
    assert cq.certify(model, grid[::-1], rows="down").gap_bound < 1e-8
    assert cq.certify(model, grid[::-1], rows="up").gap_bound > 1e-2


def test_what_tells_its_rows_itself_is_taken_as_before(solution):
    model, data = solution.model, solution.to_dataset()
    for rows in ({}, {"rows": "up"}, {"rows": "down"}):
        for gap in (data["gap"], data["gap"][::-1], data, solution, solution.gap):
            assert cq.certify(model, gap, **rows).gap_bound < 1e-8
    bare = xr.DataArray(data["gap"].values[::-1], dims=("y", "x"))
    with pytest.raises(ValueError, match="without coordinates"):
        cq.certify(model, bare)
    assert cq.certify(model, bare, rows="down").gap_bound < 1e-8
    assert cq.certify(model, bare.T, rows="down").gap_bound < 1e-8
    assert cq.certify(model, bare[::-1], rows="up").gap_bound < 1e-8


def test_a_model_whose_rows_go_up_reads_arrays_so_unless_told_otherwise(solution):
    grid = solution.to_dataset()["gap"].values
    for problem in (membrane("up"), membrane("up").problem):
        assert cq.certify(problem, grid).gap_bound < 1e-8
        assert cq.certify(problem, grid[::-1], rows="down").gap_bound < 1e-8
    with pytest.raises(ValueError, match="rows must be one of 'up', 'down', got 'north'"):
        cq.certify(membrane("up"), grid, rows="north")


def test_a_load_or_support_that_is_given_later_must_say_its_rows_too(solution):
    solver = cq.Solver(membrane("down"), tol=1e-9)
    for name in ("load", "support"):
        with pytest.raises(ValueError, match=f'{name} is an array without coordinates.*rows="down"'):
            solver.solve(**{name: HEIGHTS})
    for rows, heights in (("up", HEIGHTS), ("down", HEIGHTS[::-1])):
        again = solver.solve(support=heights, rows=rows)
        np.testing.assert_allclose(again.gap, solution.gap, atol=1e-7)
    assert solver.solve(load=np.ones(LATTICE.size)).status.ok
    plain = cq.Solver(membrane("up"), tol=1e-9).solve(support=HEIGHTS)
    np.testing.assert_allclose(plain.gap, solution.gap, atol=1e-7)


def test_a_warm_start_is_a_vector_in_node_order(solution):
    grid = solution.to_dataset()["gap"].values
    with pytest.raises(ValueError, match=r"warm_start must have shape \(63,\)"):
        cq.solve(solution.model, warm_start=grid)


def test_a_single_row_goes_no_way():
    lattice = cq.Lattice.from_mask(np.ones((1, 5), dtype=bool), spacing=1.0)
    strip = cq.Membrane(lattice, tension=1.0, load=1.0, support=[[0.1, 0.2, 0.3, 0.2, 0.1]], rows="down")
    solution = cq.solve(strip)
    assert cq.certify(strip, solution.gap[None, :]).gap_bound < 1e-8
