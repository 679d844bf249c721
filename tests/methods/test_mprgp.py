"""MPRGP: its steps by hand, its promises, and agreement with what is proven."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from meshes import bowl_on_triangles
from scipy import sparse

import contactqp as cq
from contactqp.methods.face import Face


def boxed(seed, size):
    """A dense definite problem with one, two, equal and no bounds."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(size, size))
    lower = np.where(rng.uniform(size=size) < 0.2, -np.inf, -rng.uniform(size=size))
    upper = np.where(rng.uniform(size=size) < 0.3, np.inf, rng.uniform(size=size))
    equal = rng.uniform(size=size) < 0.1
    upper = np.where(equal & np.isfinite(lower), lower, upper)
    return cq.ContactQP(root @ root.T + 0.01 * np.eye(size), rng.normal(size=size), lower=lower, upper=upper)


def test_a_step_up_to_a_bound_and_one_along_it():
    """G = [[2, -1], [-1, 2]], q = (-1, 3) from (1, 1): the gradient (0, 4) meets the lower bound of the second."""
    bounds = np.zeros(2), np.full(2, np.inf)
    face = Face(sparse.csr_array([[2.0, -1.0], [-1.0, 2.0]]), np.array([-1.0, 3.0]), *bounds, np.ones(2), 1.0)
    np.testing.assert_array_equal(face.gradient, [0.0, 4.0])
    assert face.move(face.gradient) is None
    assert face.x[1] == 0.0
    free, pulled = face.split()
    assert free.tolist() == [True, False]
    assert not pulled.any()  # the reaction 3 - x presses
    image = face.move(np.array([1.0, 0.0]))
    np.testing.assert_array_equal(image, [2.0, -1.0])
    np.testing.assert_allclose(face.x, [0.5, 0.0])
    np.testing.assert_allclose(face.gradient, [0.0, 2.5])


def test_what_is_held_by_two_equal_bounds_is_never_pulled():
    bounds = np.array([0.5]), np.array([0.5])
    free, pulled = Face(sparse.csr_array([[1.0]]), np.array([-7.0]), *bounds, np.array([0.5]), 1.0).split()
    assert (free.tolist(), pulled.tolist()) == ([False], [0.0])


@settings(max_examples=60)
@given(st.integers(0, 10_000), st.integers(1, 12), st.booleans())
def test_it_agrees_with_active_sets_and_its_energy_falls(seed, size, preconditioned):
    problem = boxed(seed, size)
    solution = cq.solve(problem, "mprgp", tol=1e-8, history=True, preconditioned=preconditioned)
    assert solution.status == "certified"
    exact = cq.solve(problem, "active-set", tol=1e-10)
    np.testing.assert_allclose(solution.gap, exact.gap, atol=2e-8 * problem.gap_scale)
    energy = solution.history["energy"]
    assert (np.diff(energy) <= 1e-12 * np.abs(energy).max(initial=1.0)).all()


def test_a_stiff_beam_is_certified_though_its_gradient_vanishes_before_the_error_does():
    nodes, length, drop = 1000, 10.0, 0.5
    spacing = length / (nodes + 1)
    second = sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(nodes, nodes))
    stiffness = (second.T @ second).tocsr() / spacing**3
    solution = cq.solve(cq.ContactQP(stiffness, spacing - stiffness @ np.full(nodes, drop)), "mprgp", tol=1e-8)
    assert solution.status == "certified"
    free = (1 + np.flatnonzero(solution.certificate.contact)[0]) * spacing
    np.testing.assert_allclose(free, (24 * drop) ** 0.25, rtol=3e-3)  # of the beam itself, with p = EI = 1


def test_a_mesh_with_obtuse_angles_is_certified():
    problem = cq.ContactQP(*bowl_on_triangles(70))
    solution = cq.solve(problem, "mprgp")
    assert solution.status == "certified"
    assert solution.iterations < 200
    assert solution.certificate.intersects(cq.solve(problem, "active-set").certificate)


def test_preconditioning_saves_iterations_and_a_good_start_more():
    problem = cq.ContactQP(*bowl_on_triangles(40))
    plain, better = (cq.solve(problem, "mprgp", preconditioned=choice) for choice in (False, True))
    assert better.iterations < plain.iterations / 2
    again = cq.solve(problem, "mprgp", warm_start=better.gap)
    assert again.iterations <= 1


def test_its_limits_are_kept():
    problem = cq.ContactQP(*bowl_on_triangles(40))
    with pytest.warns(cq.ContactWarning, match="iteration limit"):
        assert cq.solve(problem, "mprgp", max_iter=3).iterations == 3
    with pytest.warns(cq.ContactWarning, match="time limit"):
        cq.solve(problem, "mprgp", time_limit=1e-9)
    with pytest.raises(ValueError, match="expansion"):
        cq.solve(problem, "mprgp", expansion=2.5)
