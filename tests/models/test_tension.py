"""Tension that varies and that goes by direction: how it may be given, and what it makes of arms."""

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from strategies import lattice_masks

import contactqp as cq

LATTICE = cq.Frame.rectangle(4.0, 3.0).lattice(0.5)
DATA = {"load": 1.0, "support": 0.3}


def smooth(x, y):
    return 1 + 0.2 * x + 0.1 * y**2


def arms(membrane):
    return membrane.stencil.horizontal, membrane.stencil.vertical


def test_equal_numbers_are_one_number():
    plain = cq.Membrane(LATTICE, 2.0, **DATA)
    for tension in (
        np.full(LATTICE.shape, 2.0),
        np.full(LATTICE.size, 2.0),
        (2.0, 2.0),
        lambda x, y: 2.0,
        np.float32(2),
    ):
        membrane = cq.Membrane(LATTICE, tension, **DATA)
        assert membrane.tension == 2.0
        assert repr(membrane) == repr(plain)
        np.testing.assert_array_equal(cq.solve(membrane).gap, cq.solve(plain).gap)


def test_a_pair_goes_along_x_and_along_y():
    membrane = cq.Membrane(LATTICE, (2.0, 1.0), **DATA)
    assert [float(arm) for arm in arms(membrane)] == [2.0, 1.0]
    assert membrane.tension == (2.0, 1.0)
    assert "tension=(2, 1)" in repr(membrane)
    data = cq.solve(membrane).to_dataset()
    assert (data.attrs["tension_x"], data.attrs["tension_y"]) == (2.0, 1.0)
    turned = cq.Lattice.from_mask(LATTICE.mask.T, 0.5)
    other = cq.solve(cq.Membrane(turned, (1.0, 2.0), **DATA))
    there, back = LATTICE.scatter(cq.solve(membrane).deflection), turned.scatter(other.deflection).T
    np.testing.assert_allclose(there, back, atol=1e-12)


def test_functions_are_asked_in_the_middle_of_arms():
    membrane = cq.Membrane(LATTICE, smooth, **DATA)
    horizontal, vertical = arms(membrane)
    x, y = LATTICE.x, LATTICE.y
    np.testing.assert_allclose(horizontal[1:-1, 1:-1], smooth((x[1:] + x[:-1]) / 2, y[1:-1, None]))
    np.testing.assert_allclose(vertical[1:-1, 1:-1], smooth(x[1:-1], (y[1:, None] + y[:-1, None]) / 2))
    np.testing.assert_array_equal(membrane.tension, smooth(LATTICE.node_x, LATTICE.node_y))
    cable = cq.Cable(nodes=3, spacing=0.5, tension=lambda x: 1 + x, load=1.0, support=1.0)
    np.testing.assert_allclose(cable.stencil.horizontal, [[2.5, 3.5, 4.5, 5.5]])
    np.testing.assert_array_equal(cable.tension, [1.5, 2.0, 2.5])


def test_arrays_have_harmonic_means_of_their_ends():
    values = np.arange(1.0, 1 + LATTICE.mask.size).reshape(LATTICE.shape)
    horizontal, vertical = arms(cq.Membrane(LATTICE, values, **DATA))
    np.testing.assert_allclose(horizontal[2, 1], 2 / (1 / values[2, 0] + 1 / values[2, 1]))  # one end is frame
    np.testing.assert_allclose(vertical[2, 3], 2 / (1 / values[1, 3] + 1 / values[2, 3]))
    vector = LATTICE.gather(values)
    horizontal, _ = arms(cq.Membrane(LATTICE, vector, **DATA))
    assert horizontal[2, 1] == values[2, 1]  # nothing is known of the frame
    unknown = np.where(LATTICE.mask, values, np.nan)
    np.testing.assert_array_equal(arms(cq.Membrane(LATTICE, unknown, **DATA))[0], horizontal)
    np.testing.assert_array_equal(arms(cq.Membrane(LATTICE, np.ma.masked_invalid(unknown), **DATA))[0], horizontal)
    down = cq.Membrane(LATTICE, values[::-1], rows="down", **DATA)
    np.testing.assert_array_equal(down.tension, vector)
    np.testing.assert_array_equal(down.stencil.vertical, vertical)
    placed = xr.DataArray(values[::-1], coords={"y": LATTICE.y[::-1], "x": LATTICE.x}, dims=("y", "x"))
    np.testing.assert_array_equal(cq.Membrane(LATTICE, placed, **DATA).stencil.vertical, vertical)
    by_node = xr.DataArray(vector, dims="node")
    np.testing.assert_array_equal(cq.Membrane(LATTICE, by_node, **DATA).stencil.horizontal, horizontal)
    pair = cq.Membrane(LATTICE, (placed, 3.0), **DATA)
    np.testing.assert_array_equal(pair.stencil.horizontal, arms(cq.Membrane(LATTICE, values, **DATA))[0])
    assert float(pair.stencil.vertical) == 3.0


def test_the_ends_of_a_cable_may_be_told():
    inner = cq.Cable(nodes=3, spacing=1.0, tension=[1.0, 2.0, 4.0], load=1.0, support=5.0)
    np.testing.assert_allclose(inner.stencil.horizontal, [[1.0, 4 / 3, 8 / 3, 4.0]])
    whole = cq.Cable(nodes=3, spacing=1.0, tension=[3.0, 1.0, 2.0, 4.0, 4.0], load=1.0, support=5.0)
    np.testing.assert_allclose(whole.stencil.horizontal, [[1.5, 4 / 3, 8 / 3, 4.0]])
    ring = np.pad(np.ones(LATTICE.shape), 1, constant_values=5.0)
    assert cq.Membrane(LATTICE, ring, **DATA).tension == 1.0


def test_a_jump_midway_is_exact():
    """A cable of two tensions, loaded in one node: its slopes are flux over tension."""
    tension = np.array([1.0, 1.0, 1.0, 4.0, 4.0])
    cable = cq.Cable(nodes=5, spacing=1.0, tension=tension, load=[0, 0, 1.0, 0, 0], support=np.inf)
    solution = cq.solve(cable, "active-set")
    # The parts have softness 3.5/1 + 2.5/4 in all; the load is 3/1 from the left.
    left, right = 3.0, 0.5 + 2.5 / 4
    assert solution.deflection[2] == pytest.approx(left * right / (left + right))
    assert solution.force_balance.frame == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("tension", "wanted"),
    [
        (0.0, r"tension must be > 0, got 0"),
        ((1.0, -1.0), r"tension along y must be > 0, got -1"),
        ((1.0, 2.0, 3.0), r"tension must be a pair, along x and along y, got a tuple of 3"),
        ([1.0, 2.0], r"tension must be a number, an array of the lattice's shape \(7, 9\).*got shape \(2,\)"),
        (lambda x, y: x, r"tension must be finite and > 0, but is -1.75 in the middle of an arm \(x=-1.75, y=-1\)"),
        (np.where(LATTICE.mask, 1.0, 0.0), r"but is 0 at the frame point \(x=-2, y=-1\), where nan leaves it to"),
        (np.where(LATTICE.mask, np.inf, 1.0), r"tension must be finite and > 0, but is inf at node 0"),
    ],
)
def test_what_is_no_tension_is_refused(tension, wanted):
    with pytest.raises(ValueError, match=wanted):
        cq.Membrane(LATTICE, tension, **DATA)


def test_a_cable_has_one_tension():
    with pytest.raises(ValueError, match="tension must be one, a cable's, got a tuple of 2"):
        cq.Cable(nodes=3, spacing=1.0, tension=(1.0, 2.0), load=1.0, support=1.0)


@given(st.integers(0, 2**32 - 1), lattice_masks(5, 5), st.booleans())
def test_a_reflected_fabric_has_the_reflected_answer(seed, mask, as_array):
    rng = np.random.default_rng(seed)
    lattice, mirror = cq.Lattice.from_mask(mask, 0.5), cq.Lattice.from_mask(mask[:, ::-1], 0.5)
    width = 0.5 * (mask.shape[1] - 1)
    load = rng.normal(size=mask.shape)
    load[mask] += 0.01 - load[mask].min()  # nothing lifts it off alone
    if as_array:
        values = rng.uniform(0.2, 3.0, (2, *mask.shape))
        tensions = tuple(values), tuple(values[:, :, ::-1])
    else:
        a, b = rng.uniform(0.1, 1.0, 2)
        tensions = (
            (lambda x, y: 1 + a * x, lambda x, y: 2 + np.sin(b * x + y)),
            (lambda x, y: 1 + a * (width - x), lambda x, y: 2 + np.sin(b * (width - x) + y)),
        )
    one = cq.solve(cq.Membrane(lattice, tensions[0], load=load, support=0.2), "active-set", tol=1e-10)
    other = cq.solve(cq.Membrane(mirror, tensions[1], load=load[:, ::-1], support=0.2), "active-set", tol=1e-10)
    there, back = lattice.scatter(one.deflection), mirror.scatter(other.deflection)[:, ::-1]
    np.testing.assert_allclose(there, back, atol=1e-9)
    assert abs(one.force_balance.imbalance) < 1e-10
    assert one.max_slope == pytest.approx(other.max_slope, abs=1e-9)


def test_paths_vary_it_by_a_factor():
    model = cq.Membrane(LATTICE, smooth, **DATA, foundation=0.1)
    path = cq.trace(model, tensions=[1.0, 2.0])
    np.testing.assert_array_equal(path.solutions[0].gap, cq.solve(model).gap)
    twice = cq.Membrane(LATTICE, lambda x, y: 2 * smooth(x, y), **DATA, foundation=0.1)
    np.testing.assert_allclose(path.solutions[1].gap, cq.solve(twice).gap, atol=1e-7)
    assert isinstance(path.solutions[1].model, cq.Membrane)
    np.testing.assert_array_equal(path.solutions[1].model.tension, twice.tension)
    pair = cq.trace(cq.Membrane(LATTICE, (1.0, 3.0), **DATA), tensions=[2.0]).solutions[0].model
    assert isinstance(pair, cq.Membrane)
    assert pair.tension == (2.0, 6.0)


def test_no_support_that_can_be_reached_counts_as_none():
    """Where arms vary, the bound of what the load alone does is another one."""
    for tension in (smooth, (lambda x, y: 1e-3 + 0 * x + (x > 0), 1e-3), np.where(LATTICE.mask, 1e-2, 10.0)):
        free = cq.Membrane(LATTICE, tension, load=1.0, support=np.inf)
        reach = cq.solve(free).deflection.max()
        assert reach <= free._reach() * (1 + 1e-12)
        assert cq.Membrane(LATTICE, tension, load=1.0, support=0.99 * reach).supported.all()
    assert not cq.Membrane(LATTICE, smooth, load=1.0, support=1e30).supported.any()
