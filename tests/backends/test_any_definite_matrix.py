"""Active sets on matrices that are no M-matrices: meshes with obtuse angles, beams, plates, any definite matrix."""

import numpy as np
import pytest
from meshes import beam_on_floor, bowl_in_space, bowl_on_a_checkerboard, bowl_on_triangles, plate_over_bowl
from rational import assert_certificate_holds, exact_solution

import contactqp as cq
from contactqp.methods.active_set.primal_dual import ActiveSet
from contactqp.problem.eigenvalue import proven_least_eigenvalue


@pytest.mark.parametrize("nodes", [100, 1000])
def test_a_beam_leaves_the_floor_where_it_should(nodes):
    """Between touchdown and its pinned end a beam of weight p spans (24 EI f/p)^(1/4)."""
    matrix, q, spacing = beam_on_floor(nodes)
    solution = cq.solve(cq.ContactQP(matrix, q), tol=1e-8)
    assert solution.status == cq.Status.CERTIFIED
    assert solution.backend == "active-set"
    contact = np.flatnonzero(solution.contact)
    assert abs((contact[0] + 1) * spacing - 12.0**0.25) <= spacing
    assert abs((nodes - contact[-1]) * spacing - 12.0**0.25) <= spacing
    assert solution.certificate.undecided.sum() == 0


def test_a_long_beam_comes_to_rest_in_few_steps():
    matrix, q, spacing = beam_on_floor(10_000)
    iteration = ActiveSet(matrix, q, np.zeros(q.size), monotone=False)
    steps = 1
    while not iteration.step().finished:
        steps += 1
        assert steps < 60
    contact = np.flatnonzero(iteration.omega == 0)
    assert abs((contact[0] + 1) * spacing - 12.0**0.25) <= spacing


def test_a_mesh_with_obtuse_angles_is_solved_and_proven():
    problem = cq.ContactQP(*bowl_on_triangles(70))
    assert problem.size > 4000
    solution = cq.solve(problem)
    assert solution.status == cq.Status.CERTIFIED
    assert solution.backend == "active-set"
    assert solution.certificate.undecided.sum() == 0
    assert solution.certificate.least_eigenvalue.proof == "an M-matrix below"
    assert "smallest eigenvalue >= " in repr(solution.certificate)
    assert "by an M-matrix below" in repr(solution.certificate)
    other = cq.solve(problem, "osqp", tol=1e-6)
    assert np.abs(solution.gap - other.gap).max() < 1e-5 * solution.problem.gap_scale


def test_the_eigenvalue_of_a_mesh_is_bounded_closely():
    from scipy.sparse import linalg

    matrix, _ = bowl_on_triangles(70)
    least = proven_least_eigenvalue(matrix)
    scaled = least.units[:, None] * matrix.toarray() * least.units
    exact = linalg.eigsh(scaled, 1, sigma=0.0, return_eigenvectors=False)[0]
    assert 0.1 * exact < least.bound < exact


@pytest.mark.slow
@pytest.mark.parametrize("nodes", [80, pytest.param(127, marks=pytest.mark.slow)])
def test_a_plate_is_solved_and_proven(nodes):
    """By factors as soon as aggregates turn out to be no good for it, and out of a point where no step is made."""
    solution = cq.solve(cq.ContactQP(*plate_over_bowl(nodes)))
    assert solution.iterations < 40
    assert solution.status == cq.Status.CERTIFIED
    assert solution.certificate.undecided.sum() == 0


@pytest.mark.parametrize("two_sided", [False, True])
@pytest.mark.parametrize("seed", range(12))
def test_the_energy_never_rises(seed, two_sided):
    rng = np.random.default_rng(seed)
    size = int(rng.integers(5, 60))
    root = rng.normal(size=(size, size)) * (rng.uniform(size=(size, size)) < 0.3)
    matrix = root @ root.T + 10.0 ** rng.uniform(-4, 0) * np.eye(size)
    matrix = (matrix + matrix.T) / 2
    upper = rng.uniform(0.1, 1.0, size) if two_sided else np.inf
    problem = cq.ContactQP(matrix, rng.normal(size=size), upper=upper)
    solution = cq.solve(problem, "active-set", history=True)
    assert solution.status.ok
    energy = solution.history["energy"]
    assert (np.diff(energy) <= 1e-12 * np.abs(energy).max()).all()


@pytest.mark.parametrize("seed", range(60))
def test_answers_are_those_of_rational_arithmetic(seed):
    rng = np.random.default_rng(seed)
    size = int(rng.integers(2, 6))
    root = rng.normal(size=(size, size))
    matrix = root @ root.T + 10.0 ** rng.uniform(-6, 0) * np.eye(size)
    matrix = (matrix + matrix.T) / 2
    upper = rng.uniform(0.1, 1.0, size) if seed % 2 else np.inf
    problem = cq.ContactQP(matrix, rng.normal(size=size), upper=upper)
    solution = cq.solve(problem, "active-set")
    gap, reaction = exact_solution(problem)
    assert solution.status.ok
    assert_certificate_holds(solution.certificate, gap, reaction, solution.gap)


@pytest.mark.parametrize("jump", [1e3, 1e6])
def test_coefficients_that_jump_cost_no_more_steps(jump):
    """Five points on 96 by 96 cells, stiff and soft in a checkerboard of blocks of 16, over a bowl."""
    problem = cq.ContactQP(*bowl_on_a_checkerboard(96, 16, jump))
    solution = cq.solve(problem)
    assert solution.status == cq.Status.CERTIFIED
    assert solution.iterations <= 12
    assert solution.certificate.undecided.sum() == 0


def test_seven_points_in_space_are_solved_and_proven():
    solution = cq.solve(cq.ContactQP(*bowl_in_space(24)))
    assert solution.status == cq.Status.CERTIFIED
    assert solution.iterations <= 8
    assert solution.certificate.undecided.sum() == 0


def test_scattered_unknowns_are_answered_in_their_own_order():
    matrix, q = bowl_on_triangles(70)
    order = np.random.default_rng(0).permutation(q.size)
    plain, scattered = cq.solve(cq.ContactQP(matrix, q)), cq.solve(cq.ContactQP(matrix[order][:, order], q[order]))
    np.testing.assert_allclose(scattered.gap, plain.gap[order], atol=1e-9)
    assert scattered.status == cq.Status.CERTIFIED


def test_the_steps_hardly_grow_with_the_mesh():
    steps = [cq.solve(cq.ContactQP(*bowl_on_triangles(nodes))).iterations for nodes in (70, 210)]
    assert max(steps) <= 12
