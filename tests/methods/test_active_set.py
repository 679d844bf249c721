"""Active sets: the algebraic hierarchy, the iteration's promises, and polishing other answers."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from meshes import bowl_in_space, bowl_on_triangles, scattered
from scipy import sparse
from strategies import m_matrices, problems

import contactqp as cq
from contactqp.algebra.stencil import Stencil
from contactqp.methods.active_set.primal_dual import ActiveSet
from contactqp.methods.amg import sparse_kernels
from contactqp.methods.amg.aggregation import _aggregate, _compiled, aggregate
from contactqp.methods.amg.amg import Amg, Level
from contactqp.methods.factors import DIRECT_SIZE


def disk(spacing=0.02, load=8.0, support=0.3):
    """A lattice that is no rectangle."""
    return cq.Membrane(cq.Frame.disk(1.0).lattice(spacing), 1.0, load=load, support=support)


def test_groups_of_a_path_by_hand():
    """Of seven in a line 0 takes 1, which leaves 2 to 3 with 4; 5's neighbour 4 is taken, so it waits for 6."""
    indptr = np.array([0, 1, 3, 5, 7, 9, 11, 12], dtype=np.int32)
    indices = np.array([1, 0, 2, 1, 3, 2, 4, 3, 5, 4, 6, 5], dtype=np.int32)
    group, count = aggregate(indptr, indices)
    assert group.tolist() == [0, 0, 1, 1, 1, 2, 2]
    assert count == 3


@given(m_matrices(max_size=12))
def test_compiled_groups_are_those_of_plain_python(matrix):
    graph = sparse.csr_array(matrix * (1 - np.eye(len(matrix))))
    graph.eliminate_zeros()
    indptr, indices = graph.indptr.astype(np.int32), graph.indices.astype(np.int32)
    plain, fast = (np.full(len(matrix), -1, dtype=np.int32) for _ in range(2))
    assert _aggregate(indptr, indices, plain) == _compiled()(indptr, indices, fast)
    np.testing.assert_array_equal(plain, fast)
    assert ((plain >= 0) == (np.diff(indptr) > 0)).all()


@given(m_matrices(min_size=2, max_size=9), st.integers(0, 99), st.data())
def test_sweeps_of_blocks_are_triangular_solves(matrix, seed, data):
    rng = np.random.default_rng(seed)
    size = len(matrix)
    rows = sparse.csr_array(matrix)
    arguments = rows.indptr.astype(np.int32), rows.indices.astype(np.int32), rows.data
    inverse, right, x = 1 / np.diag(matrix), rng.normal(size=size), rng.normal(size=size)
    edge = data.draw(st.integers(0, size), label="edge")
    blocks = [(0, edge), (edge, size)]
    apart = np.arange(size) < edge
    lower = np.where(apart[:, None] == apart, np.tril(matrix), 0.0)
    zero, rest, backwards = np.full(size, np.nan), np.empty(size), x.copy()
    for block in blocks:
        sparse_kernels.sweep_from_zero(*arguments, inverse, right, zero, *block)
    for block in reversed(blocks):
        sparse_kernels.residual_after_sweep(*arguments, inverse, zero, rest, *block)
        sparse_kernels.sweep_backwards(*arguments, inverse, right, x, backwards, *block)
    np.testing.assert_allclose(zero, np.linalg.solve(lower, right), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(rest, right - matrix @ zero, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(backwards, x + np.linalg.solve(lower.T, right - matrix @ x), rtol=1e-9, atol=1e-9)


def test_what_is_held_stays_as_it_is():
    """Two unknowns of three, in rows 2, -1 and -1, 2, -1 and -1, 2; the middle one is held."""
    rows = sparse.csr_array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]])
    arguments = rows.indptr.astype(np.int32), rows.indices.astype(np.int32), rows.data
    inverse, right, x, copy = np.array([0.5, 0.0, 0.5]), np.array([2.0, 7.0, 4.0]), np.empty(3), np.empty(3)
    sparse_kernels.sweep_from_zero(*arguments, inverse, right, x, 0, 3)
    assert x.tolist() == [1.0, 0.0, 2.0]
    sparse_kernels.residual_after_sweep(*arguments, inverse, x, copy, 0, 3)
    assert copy.tolist() == [0.0, 0.0, 0.0]
    up = sparse.csr_array([[0.5], [1.0], [0.5]])
    way = up.indptr.astype(np.int32), up.indices.astype(np.int32), up.data
    sparse_kernels.add_prolongation(*way, inverse, np.array([4.0]), x, copy, 0, 3)
    assert x.tolist() == copy.tolist() == [3.0, 0.0, 4.0]
    sparse_kernels.sweep_backwards(*arguments, inverse, right, copy, x, 0, 3)
    assert x.tolist() == [1.0, 0.0, 2.0]


@given(m_matrices(min_size=2, max_size=9), st.integers(0, 99))
def test_projected_sweeps(matrix, seed):
    rng = np.random.default_rng(seed)
    size = len(matrix)
    rows = sparse.csr_array(matrix)
    arguments = rows.indptr.astype(np.int32), rows.indices.astype(np.int32), rows.data
    inverse, right, x = 1 / np.diag(matrix), rng.normal(size=size), rng.normal(size=size)
    projected, held = x.clip(0), np.zeros(size)
    sparse_kernels.projected_sweeps(*arguments, inverse, right, held, np.zeros(0), projected, 1)
    twin = x.clip(0)
    for i in range(size):
        twin[i] = max(0.0, twin[i] - (matrix[i] @ twin + right[i]) / matrix[i, i])
    np.testing.assert_allclose(projected, twin, rtol=1e-9, atol=1e-12)


def iterations(matrix, amg):
    """Return how many steps of conjugate gradients take a right-hand side of ones down to 1e-8."""
    x, residual = np.zeros(matrix.shape[0]), np.ones(matrix.shape[0])
    direction, before = np.zeros(matrix.shape[0]), 1.0
    count = 0
    while np.abs(residual).max() > 1e-8:
        count += 1
        preconditioned = amg.cycle(residual)
        product: Any = residual @ preconditioned
        direction = preconditioned + product / before * direction
        before = product
        step = product / (direction @ (matrix @ direction))
        x, residual = x + step * direction, residual - step * (matrix @ direction)
    return count


def test_the_cycle_is_a_symmetric_preconditioner_whose_iterations_hardly_grow():
    counts = []
    for spacing in (0.04, 0.01):
        problem = disk(spacing).problem
        rng = np.random.default_rng(0)
        open_nodes = rng.uniform(size=problem.size) < 0.9
        full = Amg(problem.G)
        amg = full.part(open_nodes)
        first, second = rng.normal(size=(2, problem.size)) * open_nodes
        assert first @ amg.cycle(second) == pytest.approx(second @ amg.cycle(first), rel=1e-8)
        assert first @ amg.cycle(first) > 0
        assert not amg.cycle(first)[~open_nodes].any()
        assert "operator complexity 1." in repr(full)
        counts.append(iterations(problem.G, full))
    assert max(counts) <= 20
    assert counts[1] <= counts[0] + 6


def test_large_matrices_are_swept_in_blocks_and_the_cycle_stays_symmetric():
    matrix = sparse.csr_array(bowl_on_triangles(349)[0])
    amg = Amg(matrix)
    assert len(amg.levels[0].blocks) == 2
    assert amg.levels[0].blocks[-1][1] == matrix.shape[0]
    assert amg.levels[-1].blocks == [(0, amg.levels[-1].matrix.shape[0])]
    rng = np.random.default_rng(0)
    first, second = rng.normal(size=(2, matrix.shape[0]))
    assert first @ amg.cycle(second) == pytest.approx(second @ amg.cycle(first), rel=1e-8)
    assert iterations(matrix, amg) <= 20
    np.testing.assert_array_equal(amg.cycle(first), amg.cycle(first))


def test_blocks_that_hang_together_too_much_are_one():
    """Each row of the first half has an entry of the diagonal's size in the second."""
    size = 200_000
    beside = sparse.diags_array([np.full(size // 2, -1.0), np.full(size // 2, -1.0)], offsets=[-size // 2, size // 2])
    near = sparse.diags_array([np.full(size - 1, -0.001), np.full(size - 1, -0.001)], offsets=[-1, 1])
    for diagonal, blocks in ((0.5, 1), (1.5, 2)):
        matrix = (sparse.diags_array(np.full(size, diagonal)) + near + beside).tocsr()
        assert len(Level(matrix, np.ones(size)).blocks) == blocks


def test_cycles_in_space_are_as_few_as_in_the_plane():
    """The entries of the coarser matrices are weak, thirty in a row; aggregates cover them all the same."""
    matrix, _ = bowl_in_space(32)
    assert iterations(sparse.csr_array(matrix), Amg(sparse.csr_array(matrix))) <= 14


def test_a_step_by_hand():
    """G = [[2, -1], [-1, 2]], q = (-1, 3): node 0 opens by ½, node 1 stays shut with R = 2.5."""
    solver = ActiveSet(sparse.csr_array([[2.0, -1.0], [-1.0, 2.0]]), np.array([-1.0, 3.0]), np.zeros(2))
    assert solver.step().exchanged == 1
    assert solver.step().finished
    np.testing.assert_array_equal(solver.omega, [0.5, 0.0])


@given(problems(max_size=40, spread=4.0))
def test_the_energy_falls_and_the_end_is_exact(problem):
    solution = cq.solve(problem, "active-set", tol=1e-10, history=True)
    assert solution.status == "certified"
    energy = solution.history["energy"]
    assert (np.diff(energy) <= 1e-11 * np.abs(energy).max()).all()
    assert solution.history["exchanged"][-1] == 0


@pytest.mark.parametrize("seed", range(5))
def test_nodes_where_gap_and_reaction_vanish_do_not_keep_it_going(seed):
    rng = np.random.default_rng(seed)
    model = disk(0.05)
    gap = rng.uniform(0, 1, model.lattice.size) * (rng.uniform(size=model.lattice.size) < 0.3)
    problem = cq.ContactQP(model.problem.G, -(model.problem.G @ gap))
    solution = cq.solve(problem, "active-set", tol=1e-9)
    assert solution.status == "certified"
    assert solution.iterations < 30
    np.testing.assert_allclose(solution.gap, gap, atol=1e-12)


@pytest.mark.parametrize("spacing", [0.02, pytest.param(0.005, marks=pytest.mark.slow)])
def test_large_matrices_need_few_steps(spacing):
    model = disk(spacing)
    assert model.lattice.size > DIRECT_SIZE
    matrix, q, order = scattered(model.problem)
    solution = cq.solve(cq.ContactQP(matrix, q), "active-set")
    assert solution.status == "certified"
    assert solution.iterations <= 20
    own = cq.solve(model, "multigrid").certificate
    assert (solution.certificate.lower <= own.upper[order]).all()
    assert (own.lower[order] <= solution.certificate.upper).all()


def test_a_long_line_is_factorised():
    cable, exact = cq.gallery.cable_on_floor(20001, 2500)
    solution = cq.solve(cq.ContactQP(cable.problem.G, cable.problem.q), "active-set")
    np.testing.assert_allclose(cable.deflection(solution.gap), exact, rtol=1e-8)
    assert solution.iterations < 60


@pytest.mark.parametrize("model", [cq.gallery.spiral(95), cq.gallery.l_shape_with_hole(0.02), disk(0.02)])
def test_the_matrix_of_a_lattice_starts_from_multigrid(model):
    problem = cq.ContactQP(model.problem.G, model.problem.q)
    solution = cq.solve(problem, "active-set", tol=1e-9)
    assert solution.status == "certified"
    assert solution.iterations <= 3
    # Of another unit of length for each unknown it is the same, when these are undone.
    scale = 10.0 ** np.random.default_rng(0).uniform(-1, 1, problem.size)
    other = cq.ContactQP(sparse.diags_array(scale) @ problem.G @ sparse.diags_array(scale), scale * problem.q)
    np.testing.assert_allclose(cq.solve(other, "active-set", tol=1e-9).gap * scale, solution.gap, atol=1e-7)


@pytest.mark.parametrize("backend", ["osqp", "clarabel", "psor", "mangasarian"])
def test_any_answer_can_be_polished(backend):
    model = cq.gallery.bowl(31)
    rough = cq.solve(model, backend, tol=1e-2)
    exact = rough.polish(tol=1e-11)
    assert (exact.backend, exact.status, exact.tol) == ("active-set", "certified", 1e-11)
    assert exact.residuals.natural_residual < 1e-14
    assert rough.certificate.intersects(exact.certificate)
    assert rough.polish().tol == 1e-2
    assert exact.model is model


def test_what_is_no_m_matrix_can_be_polished():
    other = cq.solve(cq.ContactQP([[1.0, 0.5], [0.5, 1.0]], [-1.0, 1.0]), "osqp")
    assert other.polish().certificate.gap_bound < 1e-14


@settings(max_examples=30)
@given(problems(max_size=25), st.integers(0, 99))
def test_any_start_leads_to_the_same_answer(problem, seed):
    start = 10 * np.random.default_rng(seed).normal(size=problem.size) * problem.gap_scale
    first, second = (
        cq.solve(problem, "active-set", tol=1e-9),
        cq.solve(problem, "active-set", tol=1e-9, warm_start=start),
    )
    np.testing.assert_allclose(first.gap, second.gap, atol=1e-8 * problem.gap_scale)


def test_limits_are_kept():
    with pytest.warns(cq.ContactWarning, match="stopped at its iteration limit"):
        stopped = cq.solve(cq.gallery.spiral(31), "active-set", max_iter=1)
    assert stopped.iterations == 1
    with pytest.warns(cq.ContactWarning, match="stopped at its time limit"):
        cq.solve(cq.gallery.spiral(31), "active-set", time_limit=1e-6)


@pytest.mark.parametrize("seed", range(40))
def test_a_net_on_two_pegs_does_not_rest_too_early(seed):
    """The set can be unchanged by relaxing while the solution that follows pulls a shut node open."""
    rng = np.random.default_rng(seed)
    size = 4 if seed == 0 else int(rng.integers(20, 300))
    load = np.array([1.1, -0.9, -0.7, -0.4]) if seed == 0 else np.cumsum(rng.normal(size=size)) / np.sqrt(size)
    supported = np.zeros(size, dtype=bool)
    supported[0 if seed == 0 else rng.integers(0, size, 2)] = True
    problem = cq.ContactQP(Stencil(np.ones((1, size), dtype=bool), 1.0, 0.0), load, supported=supported)
    for start in (None, np.full(size, -1e10)):
        assert cq.solve(problem, "active-set", tol=1e-7, warm_start=start).status == "certified"


def test_many_lone_unknowns_do_not_make_a_line():
    """Fewer than three entries a row on average, but one part with many."""
    core = disk(0.04).problem
    matrix = sparse.csr_array(sparse.block_diag([core.G, sparse.eye_array(9000)]))
    problem = cq.ContactQP(matrix, np.concatenate([core.q, np.full(9000, -1.0)]))
    solver = ActiveSet(problem.G, problem.q, problem.lower)
    assert not solver.direct
    assert cq.solve(problem, "active-set").status == "certified"


def test_free_nodes_whose_matrix_is_singular_in_rounding_are_a_failure_in_words(monkeypatch):
    def singular(self):
        raise np.linalg.LinAlgError("Singular matrix")

    monkeypatch.setattr("contactqp.methods.active_set.primal_dual.ActiveSet.step", singular)
    solution = cq.solve(cq.gallery.bowl(7), "active-set", on_failure="ignore")
    assert solution.status == "failed"
    assert solution.termination.startswith("Singular matrix")
