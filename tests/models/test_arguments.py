"""Arguments in the forms that users bring: by name, functions of numbers, grids, masks, and solutions."""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import contactqp as cq
from contactqp.testing import assert_complementary, assert_encloses, assert_same_contact

LATTICE = cq.Lattice.from_mask([[True, True, False], [True, True, True]], spacing=1.0)


def membrane(**changed):
    return cq.Membrane(LATTICE, **({"tension": 1.0, "load": 1.0, "support": 0.3} | changed))


by_position: Any = cq.Membrane


def test_load_and_support_by_position_are_warned_of():
    with pytest.warns(DeprecationWarning, match=re.escape("write Membrane(..., load=0.3, support=1)")) as caught:
        old = by_position(LATTICE, 1.0, 0.3, 1.0)
    assert caught[0].filename == __file__
    np.testing.assert_array_equal(old.load, 0.3)
    np.testing.assert_array_equal(old.support, 1.0)
    with pytest.warns(DeprecationWarning, match=re.escape("Membrane(..., load=..., support=1, frame_height=0.5)")):
        raised = by_position(LATTICE, 1.0, np.ones(5), 1.0, 0.5)
    assert raised._datum == 0.5


def test_what_is_wrong_with_arguments_by_position_is_told():
    with pytest.raises(TypeError, match="at most 5 arguments, got 6"):
        by_position(LATTICE, 1.0, 0.3, 1.0, 0.0, 0.0)
    with pytest.raises(TypeError, match="two values for load"):
        by_position(LATTICE, 1.0, 0.3, load=1.0, support=1.0)


@pytest.mark.filterwarnings("error")
def test_functions_of_single_numbers_will_do():
    deep = membrane(support=lambda x, y: math.sqrt(x + y) if x > 0 else 5.0, load=lambda x, y: 2.0 if y else 1.0)
    np.testing.assert_allclose(deep.support, [5.0, 1.0, 5.0, np.sqrt(2.0), np.sqrt(3.0)])
    np.testing.assert_array_equal(deep.load, [1.0, 1.0, 2.0, 2.0, 2.0])
    raised = membrane(frame_height=lambda x, y: 0.1 if x > 1 else 0.0)
    by_vectors = membrane(frame_height=lambda x, y: 0.1 * (x > 1))
    np.testing.assert_array_equal(raised.problem.q, by_vectors.problem.q)
    cable = cq.Cable(span=4.0, spacing=1.0, tension=1.0, load=lambda x: math.cos(x), support=1.0)
    np.testing.assert_allclose(cable.load, np.cos([1.0, 2.0, 3.0]))
    net = cq.CableNet.orthogonal(LATTICE, tension=1.0, load=1.0, support=lambda x, y: math.exp(x) if y else 1.0)
    np.testing.assert_allclose(net.support, [1.0, 1.0, 1.0, np.e, np.e**2])


def test_functions_that_cannot_be_evaluated_say_why():
    with pytest.raises(TypeError, match="add"):
        membrane(support=lambda x, y: x + "deep")
    with pytest.raises(ValueError, match="truth value"):
        membrane(support=lambda x, y: math.sqrt(-1.0 - x) if x > 0 else math.sqrt(-1.0))


def laid_out(vector):
    """Yield a vector of the lattice's nodes in all forms."""
    grid = LATTICE.scatter(vector)
    yield vector
    yield grid
    yield grid.tolist()
    yield LATTICE.scatter(vector, fill=1e20)
    yield np.ma.masked_invalid(grid)
    yield xr.DataArray(grid, dims=("y", "x"), coords={"y": LATTICE.y, "x": LATTICE.x})
    yield xr.DataArray(grid.T[:, ::-1], dims=("x", "y"), coords={"y": LATTICE.y[::-1], "x": LATTICE.x})


def test_a_gap_may_be_laid_out_in_any_form():
    model = membrane()
    solution = cq.solve(model)
    bound = cq.certify(model, solution.gap).gap_bound
    for subject in (model, model.problem):
        assert cq.certify(subject, solution).gap_bound == bound
        assert_complementary(subject, solution)
        assert_encloses(solution, solution)
    for form in laid_out(solution.gap):
        assert cq.certify(model, form).gap_bound == bound
        assert_complementary(model, form)
        assert_encloses(solution, form)
        assert_encloses(solution.certificate, form)
    assert cq.certify(model, solution.to_dataset()).gap_bound == bound
    assert cq.certify(model.problem, LATTICE.scatter(solution.gap)).gap_bound == bound


def test_a_gap_that_misses_a_node_is_refused():
    model = membrane()
    gap = cq.solve(model).gap
    hidden = np.ma.masked_array(LATTICE.scatter(gap), mask=np.eye(2, 3, dtype=bool))
    with pytest.raises(ValueError, match="gap has masked entries"):
        cq.certify(model, hidden)
    grid = LATTICE.scatter(gap)
    grid[0, 0] = np.nan
    with pytest.raises(ValueError, match="gap must be finite, but is nan at node 0"):
        cq.certify(model, grid)
    for wrong in (gap[:-1], np.zeros((3, 3))):
        with pytest.raises(ValueError, match="shape"):
            cq.certify(model, wrong)


def test_masked_supports_count_where_there_are_nodes():
    grid = np.ma.masked_array(np.full((2, 3), 0.3), mask=~LATTICE.mask)
    np.testing.assert_array_equal(membrane(support=grid).support, 0.3)


def test_a_contact_set_may_be_a_mask():
    solution = cq.solve(membrane(support=0.45))
    assert 0 < solution.contact.sum() < 5
    for form in (solution.contact, LATTICE.scatter(solution.contact, fill=0).astype(bool)):
        assert assert_same_contact(solution, form).all()
        assert assert_same_contact(form, solution).all()
    dataset = xr.DataArray(LATTICE.scatter(solution.contact, fill=0).astype(bool), dims=("y", "x"))
    assert assert_same_contact(solution, dataset).all()
    other = ~solution.contact
    with pytest.raises(AssertionError, match="differ at 5 of 5 nodes") as error:
        assert_same_contact(solution, other)
    assert "in the mask" in str(error.value)
    with pytest.raises(TypeError, match="must be boolean"):
        assert_same_contact(solution, solution.gap)
    with pytest.raises(TypeError, match="first or second must be a Solution"):
        assert_same_contact(other, other)


@pytest.mark.parametrize("given", ["bed.tif", Path("bed.tif")])
@pytest.mark.parametrize("name", ["load", "support"])
def test_the_name_of_a_file_is_no_field_and_is_told_what_reads_it(name, given):
    fields = {"load": 1.0, "support": 1.0} | {name: given}
    told = rf"{name} must hold real numbers, got .*bed\.tif.*contactqp\.read_field .* contactqp\.read_surface"
    with pytest.raises(TypeError, match=told):
        cq.Cable(nodes=3, spacing=1.0, tension=1.0, **fields)
