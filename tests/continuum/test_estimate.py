"""Estimates of the discretisation error, held against closed forms."""

import numpy as np
import pytest

import contactqp as cq
from contactqp.continuum.data import Data
from contactqp.continuum.energy import points_of
from contactqp.continuum.relatives import coarser, finer, prolonged


@pytest.mark.parametrize("name", ["ball", "ring", "constant-obstacle"])
@pytest.mark.parametrize("nodes", [31, 47])
def test_estimates_are_near_the_true_error(name, nodes):
    known = cq.gallery.load(name, n=nodes)
    solution = cq.solve(known.model, tol=1e-8)
    found, true = solution.discretisation_estimate("pointwise"), solution.deflection - known.deflection
    assert 0.7 < found.error / np.abs(true).max() < 1.5
    assert 0.7 < found.mean_error / np.sqrt(np.mean(true**2)) < 1.5
    assert np.corrcoef(found.errors, true)[0, 1] > 0.9
    assert found.grid_convergence_index >= 1.25 * found.error * (1 - 1e-12)
    assert found.spacings == pytest.approx(known.spacing * np.array([0.5, 1, 2]))


def test_without_a_coarser_lattice_the_order_is_unknown():
    solution = cq.solve(cq.gallery.load("ring", n=30).model, tol=1e-8)
    found = solution.discretisation_estimate("pointwise")
    assert found.order is None
    assert len(found.spacings) == 2
    assert "an estimate, no bound" in str(found)
    assert "unknown" in str(found)
    assert max(map(len, str(found).splitlines())) <= 80


def test_answers_that_are_exact_at_the_nodes_have_no_error_and_no_order():
    found = cq.solve(cq.gallery.load("biactive", n=31).model, tol=1e-12).discretisation_estimate("pointwise")
    assert found.error < 1e-10
    assert found.order is None


def test_relatives_have_the_same_region_and_the_same_data():
    mask = np.ones((7, 11), dtype=bool)
    mask[:4, 7:] = False
    lattice = cq.Lattice.from_mask(mask, spacing=0.5, origin=(1.0, 2.0))
    places = lattice.node_x, lattice.node_y
    model = cq.Membrane(
        lattice,
        tension=(1.0 + places[0], 2.0),
        load=places[0] + places[1],
        support=-1.0 - places[1],
        ceiling=5.0,
        foundation=0.3,
        frame_height=lambda x, y: 0.1 * x,
        upwards=True,
    )
    half, double = finer(model), coarser(model)
    assert double is not None
    again = finer(double)
    box = again.lattice.numbering.box
    assert np.array_equal(again.lattice.mask[box], mask)
    for relative in (half, double, again):
        x, y = relative.lattice.node_x, relative.lattice.node_y
        inside = (x > 1.0) & (x < 6.0) & (y > 4.0) & (y < 5.0)  # away from where arrays are continued to the frame
        assert relative.load[inside] == pytest.approx((x + y)[inside])
        assert relative.support[inside] == pytest.approx((-1 - y)[inside])
        assert relative.ceiling == pytest.approx(5.0)
        assert relative.frame_heights[relative.frame_points()].max() == pytest.approx(0.1 * 6.5)
    assert half.lattice.spacing == 0.25


def energy_norm(points):
    """Of the bilinear interpolant of values at all points of a rectangle, with a tension of 1."""
    parts = []
    for axis in (0, 1):
        steps = np.moveaxis(np.diff(points, axis=axis), axis, 0)
        one, two = steps[:, 1:], steps[:, :-1]
        parts.append(((one**2 + one * two + two**2) / 3).sum())
    return np.sqrt(sum(parts))


def gap_of(known):
    return known.model.reference + (known.deflection if known.model.upwards else -known.deflection)


def heights(model, gap):
    """Depths at all points of a rectangle, its frame included."""
    data = Data.of(model)
    box = np.ix_(*(np.flatnonzero(data.plan.points.any(axis=axis)) for axis in (1, 0)))
    return points_of(data, model.padded_below(gap))[box]


@pytest.mark.parametrize("name", ["ball", "ring", "constant-obstacle", "biactive", "biactive-half"])
def test_the_energy_norm_is_told_by_coarser_lattices(name):
    """The truth: the closed form at the points of a lattice with eight times as many squares along each side."""
    for nodes in (15, 23, 31):
        known, finest = cq.gallery.load(name, n=nodes), cq.gallery.load(name, n=8 * nodes + 7)
        solution = cq.solve(known.model, tol=1e-9)
        exact = heights(finest.model, gap_of(finest))
        own = prolonged(prolonged(prolonged(heights(known.model, solution.gap))))
        found, true = solution.discretisation_estimate(), energy_norm(own - exact)
        assert 0.7 < found.error / true < 1.5
        assert found.relative_error == pytest.approx(true / energy_norm(exact), rel=0.3)
        assert found.grid_convergence_index >= 1.249999 * found.error
        assert found.spacings == pytest.approx(known.spacing * np.array([1, 2, 4]))


def test_the_energy_norm_needs_a_coarser_lattice():
    with pytest.raises(ValueError, match="take an even number of squares along each side, or effort='pointwise'"):
        cq.solve(cq.gallery.load("ring", n=30).model).discretisation_estimate()
    found = cq.solve(cq.gallery.load("ring", n=29).model).discretisation_estimate("energy")
    assert found.order is None
    assert "an estimate, no bound" in str(found)
    assert "unknown" in str(found)
    assert max(map(len, str(found).splitlines())) <= 80


def test_what_has_no_relatives_is_refused():
    with pytest.raises(TypeError, match="a Membrane can be made again"):
        cq.solve(cq.gallery.load("cable-on-floor").model).discretisation_estimate("pointwise")
    triangle = cq.Frame.polygon([(0, 0), (8, 0), (0, 8)]).lattice(1.0)
    with pytest.raises(ValueError, match="slanted sides"):
        cq.solve(cq.Membrane(triangle, 1.0, load=1.0, support=9.0)).discretisation_estimate("energy")
    with pytest.raises(ValueError, match="lies beside"):
        cq.solve(cq.Membrane(cq.Frame.disk(1.0).lattice(0.25), 1.0, load=1.0, support=0.1)).discretisation_estimate(
            "pointwise"
        )
