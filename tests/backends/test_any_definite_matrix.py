"""Active sets on matrices that are no M-matrices: meshes with obtuse angles, beams, plates, any definite matrix."""

import numpy as np
import pytest
from meshes import (
    beam_on_floor,
    beam_over_floor,
    bowl_in_space,
    bowl_on_a_checkerboard,
    bowl_on_triangles,
    plate_over_bowl,
    scattered,
)
from rational import assert_certificate_holds, exact_solution
from scipy import sparse

import contactqp as cq
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


@pytest.mark.parametrize("clamped", [False, True])
@pytest.mark.parametrize(("nodes", "undecided"), [(10_000, 0), pytest.param(100_000, 40, marks=pytest.mark.slow)])
def test_a_long_beam_is_solved_and_proven_in_twice_the_precision(nodes, undecided, clamped):
    """Its condition is that of the fourth power of the number of nodes: up to 10¹⁹."""
    matrix, q, spacing = beam_on_floor(nodes, clamped=clamped)
    solution = cq.solve(cq.ContactQP(matrix, q))
    assert solution.status == cq.Status.CERTIFIED
    assert solution.iterations < 40
    assert solution.certificate.gap_bound < 1e-8
    assert np.count_nonzero(solution.certificate.undecided) <= undecided
    touchdown = ((72 if clamped else 24) * 0.5) ** 0.25
    contact = np.flatnonzero(solution.contact)
    assert abs((contact[0] + 1) * spacing - touchdown) <= spacing
    assert abs((nodes - contact[-1]) * spacing - touchdown) <= spacing
    assert np.abs(solution.gap - beam_over_floor(nodes, clamped=clamped)).max() < 0.3 * spacing**2 + 1e-8
    assert "in twice the precision" in repr(solution.certificate) or solution.certificate.least_eigenvalue.bound > 1e-15


def test_a_long_beam_of_two_bounds_on_springs_and_under_tension_is_proven():
    """Rows of bending, tension and a foundation; a floor below, a ceiling that the middle is pressed against."""
    nodes = 6000
    matrix, _, spacing = beam_on_floor(nodes)
    line = sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(nodes, nodes)) / spacing
    matrix = sparse.csr_array(matrix + 0.1 * line + 0.01 * spacing * sparse.eye_array(nodes))
    x = spacing * np.arange(1, nodes + 1)
    load = np.where(x < 5, 1.0, -1.5) * spacing
    problem = cq.ContactQP(matrix, -load, -0.3, 0.4)
    solution = cq.solve(problem)
    assert solution.status == cq.Status.CERTIFIED
    certificate = solution.certificate
    assert certificate.undecided.sum() == 0
    assert certificate.contact_upper.any()
    assert certificate.contact_lower.any()
    start = cq.solve(problem, warm_start=solution)
    assert start.iterations == 1
    assert np.abs(start.gap - solution.gap).max() < 1e-9


def test_a_long_beam_in_any_order_is_recognised():
    matrix, q, _ = beam_on_floor(5000)
    problem = cq.ContactQP(matrix, q)
    shuffled, forces, order = scattered(problem)
    solution = cq.solve(cq.ContactQP(shuffled, forces))
    assert solution.status == cq.Status.CERTIFIED
    assert np.abs(solution.gap - cq.solve(problem).gap[order]).max() < 1e-8


def test_a_long_beam_whose_rounded_entries_are_indefinite_is_refused():
    """Rows that sum up to less than zero are a foundation that pulls, stiffer than a beam of 50,000 nodes."""
    matrix, q, _ = beam_on_floor(50_000)
    matrix.data[matrix.data > 5.5 * matrix.data.min() * -0.25] *= 1 - 2.0**-50
    with pytest.raises(ValueError, match="G must be positive definite"):
        cq.ContactQP(matrix, q)


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
