"""Pictures of membranes on meshes: triangles in the colours of their nodes' states, and sections across them."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import skfem
from matplotlib.figure import Figure
from triangulations import obtuse_rings

import contactqp as cq
from contactqp.models.records import NodeState, states_of
from contactqp.plotting.on_mesh import cut_across, states_of_triangles


def ring(**changes):
    """Return a membrane between a floor and a ceiling with a hole whose rim is free, and no floor in one part."""
    points, triangles = obtuse_rings(10)
    triangles = triangles[~(np.hypot(*points.T) < 0.25)[triangles].all(axis=1)]
    used, number = np.unique(triangles, return_inverse=True)
    given = {
        "load": lambda x, y: np.where(x < 0, 6.0, -6.0),
        "support": lambda x, y: np.where(y > 0.3, np.inf, 0.12),
        "ceiling": -0.1,
        "fixed": lambda x, y: np.hypot(x, y) > 0.99,
        "frame_height": lambda x, y: 0.01 * y,
    }
    return cq.MeshMembrane(points[used], number.reshape(-1, 3), 1.0, **given | changes)


@pytest.fixture(scope="module")
def solution():
    return cq.solve(ring())


def test_a_solution_is_drawn_by_its_triangles(solution, tmp_path):
    figure = solution.plot(section=-0.3, units="m")
    states, shape, section = figure.axes[:3]
    assert [axes.get_title() for axes in (states, shape, section)] == [
        "Contact map",
        "Deflection",
        "Section at y = -0.3",
    ]
    drawn: Any = states.collections[0]
    assert len(drawn.get_paths()) == len(solution.model.triangles)
    np.testing.assert_array_equal(
        drawn.get_array(), states_of_triangles(solution.model, states_of(solution.certificate))
    )
    figure.savefig(tmp_path / "ring.png")
    for picture in (solution.model.plot(), solution.certificate.plot(), solution.plot()):
        picture.savefig(tmp_path / "picture.png")
    with pytest.raises(ValueError, match=r"section must lie between y = -1 and 1, got 2"):
        solution.plot(section=2.0)


def test_a_triangle_is_in_contact_where_all_its_nodes_are():
    model = cq.MeshMembrane.from_skfem(skfem.MeshTri().refined(2), 1.0, load=1.0, support=1.0)
    states = np.zeros(model.size, dtype=int)
    assert not states_of_triangles(model, states).any()
    everything = states_of_triangles(model, np.full(model.size, NodeState.CONTACT.value))
    inside = (~np.isin(model.triangles, model.fixed)).any(axis=1)
    np.testing.assert_array_equal(everything == NodeState.CONTACT, inside)
    states[0] = NodeState.UNDECIDED
    undecided = states_of_triangles(model, states) == NodeState.UNDECIDED
    np.testing.assert_array_equal(undecided, (model.triangles == model.free[0]).any(axis=1))


@pytest.mark.parametrize("place", [-0.3, 0.0, 0.501])
def test_a_section_is_linear_in_each_triangle(solution, place):
    model = solution.model
    cut = cut_across(model, solution.gap, place)
    x = cut.x.reshape(-1, 3)
    assert np.isnan(x[:, 2]).all()
    assert (x[:, 0] <= x[:, 1]).all()
    length = (x[:, 1] - x[:, 0]).sum()
    outer = 2 * np.sqrt(1 - place**2)
    assert length == pytest.approx(outer - (0.5 if abs(place) < 0.2 else 0.0), abs=0.15)
    for support in (lambda x, y: 0.3 + 0.2 * x - 0.1 * y, np.inf):
        flat = ring(support=support, ceiling=None, frame_height=lambda x, y: 0.3 + 0.2 * x - 0.1 * y)
        plane = cut_across(flat, flat.reference - (0.3 + 0.2 * flat.node_x - 0.1 * flat.node_y), place)
        known = np.isfinite(plane.x)
        np.testing.assert_allclose(plane.heights[known], 0.3 + 0.2 * plane.x[known] - 0.1 * place, atol=1e-12)
        seen = np.isfinite(plane.ground)
        np.testing.assert_allclose(plane.ground[seen], plane.heights[seen], atol=1e-12)


def test_load_paths_and_comparisons_are_drawn(tmp_path):
    model = cq.MeshMembrane.from_skfem(skfem.MeshTri.init_circle(3), 1.0, load=4.0, support=0.5)
    path = cq.trace(model, loads=[0.25, 0.6, 1.0])
    path.plot().savefig(tmp_path / "path.png")
    path.touchdown().plot().savefig(tmp_path / "touchdown.png")
    comparison = cq.compare(model, ["active-set", "clarabel"])
    comparison.plot().savefig(tmp_path / "comparison.png")
    comparison.plot_disagreement().savefig(tmp_path / "disagreement.png")
    figure = Figure()
    cq.solve(model).plot(ax=figure.subplots())
    figure.savefig(tmp_path / "axes.png")


def test_views_in_space_show_triangles_in_contact():
    model = ring()
    solution = cq.solve(model)
    for figure in (model.plot3d(), solution.plot3d(), solution.plot(kind="surface", title="T")):
        axes: Any = figure.axes[0]
        low, high = axes.get_zlim()
        assert low > high  # heights are positive downwards
        assert axes.get_xlim()[0] < -0.9
    membrane, below, above = solution.plot3d().axes[0].collections[:3]
    assert len(membrane.get_facecolors()) == len(model.triangles)
    assert 0 < len(below.get_facecolors()) < len(model.triangles)
    assert len(above.get_facecolors()) > 0
    up = cq.MeshMembrane(model.positions, model.triangles, 1.0, load=1.0, support=-9.0, upwards=True)
    figure = cq.solve(up).plot3d()
    low, high = figure.axes[0].get_zlim()
    assert low < high
    assert high - low < 1
    assert "The support goes on below" in figure.get_suptitle()


def test_numbers_along_the_small_map_do_not_touch_each_other(solution):
    figure = solution.plot()
    figure.draw_without_rendering()
    shape = figure.axes[1]
    low, high = shape.get_xlim()
    labels = [label for at, label in zip(shape.get_xticks(), shape.get_xticklabels(), strict=True) if low <= at <= high]
    boxes = [label.get_window_extent() for label in labels]
    assert len(boxes) > 2
    assert all(left.x1 < right.x0 for left, right in pairwise(boxes))
