"""Refinement towards the free boundary: how near it comes, what it leaves alone, and how it ends."""

import numpy as np
import pytest
import skfem
from triangulations import obtuse_rings, touching

import contactqp as cq
from contactqp.refinement.indicator import crossed, residuals, too_large
from contactqp.refinement.refine import start_on


def square(refinements=3, **changes):
    """Return a membrane on the square (-1, 1)² whose frame is where the disk's closed form has it."""
    given = {"load": 4.0, "support": 0.5, "frame_height": outside} | changes
    mesh = skfem.MeshTri().refined(refinements)
    return cq.MeshMembrane(2 * mesh.p.T - 1, mesh.t.T, 1.0, **given)


def outside(x, y):
    """Return the deflection of the unit disk over a floor, carried on beyond it."""
    r, a = np.hypot(x, y), touching(4.0, 0.5)
    return 1 - r * r + 2 * a * a * np.log(np.maximum(r, a))


def hausdorff(solution):
    """Return the distance of the free boundary's points from the circle, and of the circle from them."""
    points = solution.model.free_boundary(solution.contact)
    radius = touching(4.0, 0.5)
    angle = np.linspace(0, 2 * np.pi, 500)
    circle = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    apart = np.linalg.norm(circle[:, None] - points, axis=2).min(axis=1).max()
    return max(np.abs(np.hypot(*points.T) - radius).max(), apart)


def test_the_free_boundary_comes_as_near_as_its_triangles_are_small():
    coarse = cq.solve(square())
    distances, widths = [], []
    for target in (0.1, 0.025, 0.0125):
        refinement = cq.refine(coarse, target)
        assert refinement.reached
        assert refinement.solution.status == "certified"
        widths.append(refinement.free_boundary_widths[-1])
        distances.append(hausdorff(refinement.solution))
        assert max(widths[-1], distances[-1]) <= target
    rate = np.log(distances[0] / distances[-1]) / np.log(widths[0] / widths[-1])
    assert rate >= 0.95
    squares = 2 / (widths[-1] / np.sqrt(2))  # along a side of the mesh whose triangles are all as small
    assert refinement.solution.model.size < squares**2 / 3


def test_what_it_tells():
    refinement = cq.refine(cq.solve(square()), 0.1)
    table = refinement.to_frame()
    assert list(table) == ["nodes", "triangles", "contact", "width", "status", "seconds"]
    assert (np.diff(table["nodes"]) > 0).all()
    assert (np.diff(table["seconds"]) > 0).all()
    assert table["width"].tolist() == refinement.free_boundary_widths.tolist()
    assert repr(refinement).startswith(f"Refinement({len(table)} solved, 49 to {table['nodes'].iloc[-1]} nodes, free")
    assert "target reached" in refinement._repr_html_()
    assert refinement.solution is refinement.solutions[-1]


def test_it_ends_at_limits():
    solution = cq.solve(square())
    few = cq.refine(solution, 1e-3, max_nodes=500)
    assert few.ended == "the next mesh has more than 500 nodes"
    assert few.solution.problem.size <= 500
    assert not few.reached
    short = cq.refine(solution, 1e-6, time_limit=1e-6)
    assert short.ended == "time limit"
    assert len(short.solutions) == 1


def test_a_start_is_the_coarser_answer():
    for changes in ({}, {"upwards": True, "support": -0.5, "frame_height": lambda x, y: -outside(x, y)}):
        model = square(4, **changes)
        solution = cq.solve(model)
        finer = model.refined()
        start = start_on(finer, model, solution)
        assert (start >= 0).all()
        old = finer.halving.ends[finer.free, 0] == finer.halving.ends[finer.free, 1]
        np.testing.assert_allclose(np.sort(start[old]), np.sort(solution.gap), atol=1e-12)
        exact = cq.solve(finer)
        assert np.abs(start - exact.gap).max() < 0.02
        assert cq.solve(finer, warm_start=start).iterations <= exact.iterations


def test_both_bounds_and_supports_that_are_not_everywhere():
    points, triangles = obtuse_rings(8)
    model = cq.MeshMembrane(
        *(points, triangles, lambda x, y: 1 + x**2),
        load=lambda x, y: np.where(x < 0, 6.0, -6.0),
        support=lambda x, y: np.where(y > 0.3, np.inf, 0.12),
        ceiling=-0.1,
        foundation=0.5,
    )
    refinement = cq.refine(cq.solve(model), 0.08)
    assert refinement.reached
    assert refinement.solution.status == "certified"
    assert refinement.solution.contact_upper.any()


def test_residuals_vanish_where_the_membrane_rests_and_are_those_of_linear_elements():
    """Of a parabola's interpolant the flux jumps by its curvature times the distance of the triangles' middles."""
    model = square(4, support=np.inf, frame_height=lambda x, y: 1 - x * x)
    below = cq.solve(model)
    found = residuals(below, model)
    has_node = (~np.isin(model.triangles, model.fixed)).any(axis=1)
    assert found[has_node].min() > 0
    finer = model.refined()
    ratio = np.median(found) / np.median(residuals(cq.solve(finer), finer))
    assert ratio == pytest.approx(4.0, rel=0.2)  # as the square of the size
    floor = square(4)
    resting = cq.solve(floor)
    contact = np.zeros(len(floor.positions), dtype=bool)
    contact[floor.free] = resting.contact
    inside = contact[floor.triangles].all(axis=1)
    assert inside.any()
    assert not residuals(resting, floor)[inside].any()
    assert not (crossed(floor, resting.contact) & inside).any()


def test_without_load_and_contact_there_is_nothing_to_refine():
    solution = cq.solve(square(load=0.0, frame_height=0.0))
    assert not too_large(solution, solution.model, 1e-9).any()
    assert cq.refine(solution, 1e-9).reached


def test_what_cannot_be_refined_is_told():
    with pytest.raises(TypeError, match="must be that of a MeshMembrane, whose mesh can be refined, got Membrane"):
        cq.refine(cq.solve(cq.gallery.bowl(7)), 0.1)
    with pytest.raises(TypeError, match="whose mesh can be refined, got MeshMembrane"):
        cq.refine(square(), 0.1)
    with pytest.raises(ValueError, match="target must be > 0"):
        cq.refine(cq.solve(square()), 0.0)
