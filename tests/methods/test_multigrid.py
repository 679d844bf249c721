"""The contact multigrid: its passes against plain numpy, what it promises, and published problems."""

import os
import signal
import subprocess
import sys
import time
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import linalg
from strategies import bounds, lattice_masks

import contactqp as cq
from contactqp.algebra.stencil import Stencil
from contactqp.foundation.loading import once
from contactqp.foundation.threads import Team
from contactqp.geometry.numbering import Layout
from contactqp.methods.multigrid import contact
from contactqp.methods.multigrid.arms import Arms, arms_of, coarsening
from contactqp.methods.multigrid.contact import NO_LIMITS, ContactMultigrid
from contactqp.methods.multigrid.lattice_kernels import exchange_kernels, lattice_kernels, start_from_coarse
from contactqp.methods.multigrid.level_kernels import level_kernels, transfer_kernels
from contactqp.methods.multigrid.linear import LatticeSolver
from contactqp.methods.multigrid.nested import nested_start
from contactqp.methods.multigrid.weighted_hierarchy import hierarchy_of
from contactqp.methods.multigrid.weighted_kernels import weighted_kernels


def hat_matrix(fine, coarse, factor):
    """Linear interpolation along a line: coarse point J sits on fine point factor J, all counted from the ring."""
    matrix = np.zeros((fine + 2, coarse + 2))
    for i in range(fine + 2):
        for j in range(coarse + 2):
            matrix[i, j] = max(0.0, 1 - abs(i - factor * j) / factor)
    return matrix[1:-1, 1:-1]


def interpolation(level, rows, columns):
    """Interpolation as a matrix, from the rectangle of a coarse level to the finer one's."""
    plan = level.plan
    if plan.weighted:
        return weighted_interpolation(level, rows, columns)
    down = hat_matrix(rows, plan.rows, plan.row_coarsening)
    return np.kron(down, hat_matrix(columns, plan.columns, plan.column_coarsening))


def weighted_interpolation(level, rows, columns):
    """Interpolation by a level's weights as a matrix: each fine point from the corners of the cell that it lies in."""
    plan, weights = level.plan, level.weights
    matrix = np.zeros((rows, columns, plan.rows + 2, plan.columns + 2))
    for i, j in np.ndindex(rows, columns):
        (cell, up), (step, right) = divmod(i + 1, plan.row_coarsening), divmod(j + 1, plan.column_coarsening)
        if not (up or right):
            matrix[i, j, cell, step] = 1.0
        elif up and right:
            matrix[i, j, cell : cell + 2, step : step + 2] = weights[4:8, cell, step].reshape(2, 2)
        elif up:
            matrix[i, j, cell : cell + 2, step] = weights[2:4, cell, step]
        else:
            matrix[i, j, cell, step : step + 2] = weights[0:2, cell, step]
    return matrix[:, :, 1:-1, 1:-1].reshape(rows * columns, plan.rows * plan.columns)


def stencil_matrix(level):
    """A level's operator as a matrix on its rectangle."""
    rows, columns = level.plan.rows, level.plan.columns
    matrix = np.zeros((rows, columns, rows, columns))
    for i in range(rows):
        for j in range(columns):
            matrix[i, j, i, j] = level.stencil[0, i + 1, j + 1]
            for k, (a, b) in enumerate(((0, 1), (1, 0), (1, 1), (1, -1)), start=1):
                if 0 <= i + a < rows and 0 <= j + b < columns:
                    value = level.stencil[k, i + 1, j + 1]
                    matrix[i, j, i + a, j + b] = matrix[i + a, j + b, i, j] = value
    return matrix.reshape(rows * columns, rows * columns)


@st.composite
def lattices(draw, max_side=11):
    """A lattice with equal or varying arms, its stencil, and a random generator."""
    mask = draw(lattice_masks(max_side, max_side))
    rng = np.random.default_rng(draw(st.integers(0, 9999)))
    kind = draw(st.sampled_from(["equal", "anisotropic", "varying", "on springs"]))
    if kind == "varying":
        arms: Any = (
            rng.uniform(0.5, 1.5, (mask.shape[0], mask.shape[1] + 1)),
            rng.uniform(0.5, 1.5, (mask.shape[0] + 1, mask.shape[1])),
        )
    elif kind == "on springs":
        arms = (0.25, 0.25, rng.uniform(0.0, 0.5, mask.shape) * (rng.uniform(size=mask.shape) < 0.7))
    else:
        arms = (0.25, 0.25) if kind == "equal" else (0.01, 0.49)
    stencil = Stencil(mask, *arms)
    supported = rng.uniform(size=stencil.size) < draw(st.sampled_from([1.0, 0.7]))
    lower, upper = (0.0, np.inf) if draw(st.booleans()) else draw(bounds(stencil.size))
    problem = cq.ContactQP(stencil, rng.normal(size=stencil.size), lower, upper, supported=supported)
    return arms_of(stencil, problem.layout), problem, rng


def admissible(problem, rng):
    """Return a gap between the bounds, at a bound at many nodes."""
    return problem.project(rng.normal(size=problem.size))


def assert_sweeps_are_gauss_seidel(lattice, problem, rng, count):
    layout = lattice.layout
    omega = layout.grid(admissible(problem, rng))
    expected = layout.vector(omega)
    rows, columns = np.nonzero(layout.mask)
    matrix = problem.G.toarray()
    for half in range(count):
        for i in np.flatnonzero((rows + columns) % 2 == half % 2):
            value = expected[i] - (matrix[i] @ expected + problem.q[i]) / matrix[i, i]
            expected[i] = min(problem.upper[i], max(problem.lower[i], value))
    sweep = lattice_kernels(lattice.kind).sweep
    limits = problem.bound_grids()
    arguments = omega, layout.grid(problem.q), *lattice.stiffnesses, *limits, layout.runs, layout.row_start
    middle = 1 + lattice.rows // 2
    strips = (
        [(1, middle), (middle, lattice.rows + 1)]
        if min(middle - 1, lattice.rows + 1 - middle) >= count
        else [(1, lattice.rows + 1)]
    )
    for lo, hi in reversed(strips):
        sweep(*arguments, 0, count, lo, hi)
    for border, _ in strips[1:]:
        for k in range(1, count):
            sweep(*arguments, k, 1, border - k, border + k)
    np.testing.assert_allclose(layout.vector(omega), expected, atol=1e-13)


@given(lattices(), st.integers(1, 6))
def test_sweeps_are_gauss_seidel_in_red_black_order(case, count):
    lattice, problem, rng = case
    assert_sweeps_are_gauss_seidel(lattice, problem, rng, count)


@pytest.mark.parametrize("upper", [np.inf, 0.2])
def test_long_runs_on_springs_are_swept_as_short_ones(upper):
    """Short ones are visited node by node, long ones in vectors."""
    rng = np.random.default_rng(4)
    mask = np.ones((3, 40), dtype=bool)
    mask[1, 20], mask[2, 3:9] = False, False
    stencil = Stencil(mask, 0.25, 0.25, rng.uniform(0.1, 0.5, mask.shape))
    problem = cq.ContactQP(stencil, rng.normal(size=stencil.size), 0.0, upper)
    assert_sweeps_are_gauss_seidel(arms_of(stencil, problem.layout), problem, rng, 4)


@settings(max_examples=100)
@given(lattices(), st.sampled_from(["float32", "float64"]))
def test_the_residual_is_restricted_by_the_transpose_of_interpolation(case, precision):
    lattice, problem, rng = case
    layout = lattice.layout
    gap = admissible(problem, rng)
    hierarchy = hierarchy_of(lattice, Team(1))
    first = hierarchy.levels[0]
    plan = first.plan
    coarse = np.zeros((plan.rows + 2, plan.columns + 2), dtype=precision)
    slope = 0.3
    changes, worst = exchange_kernels(lattice.kind, precision).restrict_residual(
        layout.grid(gap), layout.grid(problem.q), *lattice.stiffnesses, *problem.bound_grids(), layout.runs,
        layout.row_start, hierarchy.free, hierarchy.changed, coarse, *first.factors, first.exchange_weights, slope,
        1, plan.rows + 1,
    )  # fmt: skip
    reaction = problem.reaction(gap)
    free = (gap > problem.lower) & (gap < problem.upper)
    marks = lattice.marks()[layout.mask]
    grid = np.zeros(layout.mask.shape)
    grid[layout.mask] = np.where(free & (marks > 0), -reaction, 0.0)
    expected = interpolation(hierarchy.levels[0], lattice.rows, lattice.columns).T @ grid.ravel()
    np.testing.assert_allclose(coarse[1:-1, 1:-1].ravel(), expected, atol=1e-5 if precision == "float32" else 1e-12)
    assert changes == np.count_nonzero(~free & (marks > 0))
    np.testing.assert_array_equal(hierarchy.free[1:-1, 1:-1][layout.mask], free * marks)
    hierarchy.changed[:] = 0
    again = gap.copy()
    flip = int(rng.integers(0, problem.size))
    low, high = problem.lower[flip], problem.upper[flip]
    bound = low if np.isfinite(low) else high
    again[flip] = bound if free[flip] and np.isfinite(bound) else low + min(1.0, (high - low) / 2)
    if not np.isfinite(low):
        again[flip] = bound if free[flip] and np.isfinite(bound) else min(high, 0.0) - 1.0
    now_free = low < again[flip] < high
    changes, _ = exchange_kernels(lattice.kind, precision).restrict_residual(
        layout.grid(again), layout.grid(problem.q), *lattice.stiffnesses, *problem.bound_grids(), layout.runs,
        layout.row_start, hierarchy.free, hierarchy.changed, coarse, *first.factors, first.exchange_weights, slope,
        1, plan.rows + 1,
    )  # fmt: skip
    assert changes == (now_free != free[flip] and marks[flip] > 0)
    assert np.flatnonzero(hierarchy.changed).tolist() == [np.nonzero(layout.mask)[0][flip] + 1] * changes
    upwards = np.minimum(-reaction, slope * (problem.upper - gap))
    violation = np.maximum(upwards, np.minimum(reaction, slope * (gap - problem.lower)))
    assert worst == pytest.approx(max(0.0, violation.max()), abs=1e-12)


@settings(max_examples=100)
@given(lattices(13))
def test_coarse_operators_are_galerkin_products_of_the_truncated_operator(case):
    lattice, problem, rng = case
    hierarchy = hierarchy_of(lattice, Team(1))
    marks = lattice.marks()[lattice.layout.mask]
    active = (rng.uniform(size=problem.size) < 0.8) & (marks > 0)
    hierarchy.free[1:-1, 1:-1][lattice.layout.mask] = active * marks
    hierarchy.changed[:] = 1
    hierarchy.update()
    # Then in one row, so that only what depends on it is computed anew.
    rows = np.nonzero(lattice.layout.mask)[0]
    row = rng.integers(0, lattice.rows)
    active = np.where(rows == row, (rng.uniform(size=problem.size) < 0.5) & (marks > 0), active)
    hierarchy.free[1:-1, 1:-1][lattice.layout.mask] = active * marks
    hierarchy.changed[row + 1] = 1
    hierarchy.update()
    truncated = np.zeros((lattice.rows * lattice.columns,) * 2)
    place = np.flatnonzero(lattice.layout.mask.ravel())[active]
    truncated[np.ix_(place, place)] = problem.G.toarray()[np.ix_(active, active)]
    operator = truncated
    size: Any = lattice.rows, lattice.columns
    for level in hierarchy.levels:
        interpolate = interpolation(level, *size)
        operator = interpolate.T @ operator @ interpolate
        np.testing.assert_allclose(stencil_matrix(level), operator, atol=2e-6)
        diagonal, factor = np.diag(operator), level.stencil[5, 1:-1, 1:-1].ravel()
        assert ((factor > 0) == (diagonal > 1e-9)).all()
        used = factor > 0
        root = np.sqrt(factor[used])
        scaled = root[:, None] * operator[np.ix_(used, used)] * root
        assert not used.any() or np.linalg.eigvalsh(scaled).max() < 16 / 9 + 1e-4
        size = level.plan.rows, level.plan.columns


def test_the_coarse_operator_of_the_five_point_one_is_that_of_bilinear_elements():
    """By hand: Pᵀ A P for A = 4 u - (four neighbours) is (1/4)[-1 -1 -1; -1 8 -1; -1 -1 -1] + ... = 3 at the centre."""
    lattice = Arms(Layout(np.ones((15, 15), dtype=bool)), 1.0, 1.0)
    hierarchy = hierarchy_of(lattice, Team(1))
    hierarchy.free[1:-1, 1:-1] = 1
    hierarchy.update()
    centre, east, north, north_east, north_west, factor = hierarchy.levels[0].stencil[:, 4, 4]
    assert (centre, east, north, north_east, north_west) == (3.0, -0.5, -0.5, -0.25, -0.25)
    assert factor == pytest.approx(8 / 9 / 3)
    assert hierarchy.levels[0].kind[4, 4] == 1


@given(lattices(), st.sampled_from([("float32", "float32"), ("float64", "float32"), ("float64", "float64")]))
def test_passes_on_a_level_are_those_of_its_matrix(case, precisions):
    lattice, _, rng = case
    hierarchy = hierarchy_of(lattice, Team(1))
    hierarchy.free[1:-1, 1:-1][lattice.layout.mask] = 1
    hierarchy.update()
    level = hierarchy.levels[0]
    next_level = hierarchy.levels[min(1, len(hierarchy.levels) - 1)]
    coarse_plan, weighted = next_level.plan, level.plan.weighted
    own, coarser = ("float64", "float64") if weighted else precisions
    shape, coarse_shape = level.residual.shape, (coarse_plan.rows + 2, coarse_plan.columns + 2)

    def ringed(values, dtype):
        grid = np.zeros((values.shape[0] + 2, values.shape[1] + 2), dtype=dtype)
        grid[1:-1, 1:-1] = values
        return grid

    right, start = (ringed(rng.normal(size=(shape[0] - 2, shape[1] - 2)), own) for _ in range(2))
    matrix, factor = stencil_matrix(level), level.stencil[5, 1:-1, 1:-1].ravel()
    rest = right[1:-1, 1:-1].ravel() - matrix @ start[1:-1, 1:-1].ravel()
    kernels, out = level_kernels(own, level.plan.stencil_precision), np.zeros(shape, dtype=own)
    kernels.smooth_from_zero(level.stencil, right, out, 1, shape[0] - 1)
    np.testing.assert_allclose(out[1:-1, 1:-1].ravel(), factor * right[1:-1, 1:-1].ravel(), rtol=1e-5)
    kernels.smooth(level.stencil, right, start, out, 1, shape[0] - 1)
    np.testing.assert_allclose(out[1:-1, 1:-1].ravel(), start[1:-1, 1:-1].ravel() + factor * rest, atol=2e-5)
    if len(hierarchy.levels) > 1:
        interpolate = interpolation(next_level, level.plan.rows, level.plan.columns)
        given = *next_level.factors, *((next_level.weights,) if weighted else ())
        transfers = weighted_kernels() if weighted else transfer_kernels(own, coarser)
        coarse = np.zeros(coarse_shape, dtype=coarser)
        transfers.restrict(level.stencil, right, start, coarse, *given, 1, coarse_shape[0] - 1)
        np.testing.assert_allclose(coarse[1:-1, 1:-1].ravel(), interpolate.T @ rest, atol=5e-5)
        correction = ringed(rng.normal(size=(coarse_plan.rows, coarse_plan.columns)), coarser)
        added = start.copy()
        transfers.add_interpolated(added, correction, *given, 1, shape[0] - 1)
        expected = interpolate @ correction[1:-1, 1:-1].ravel()
        np.testing.assert_allclose((added - start)[1:-1, 1:-1].ravel(), expected, atol=1e-5)


@given(lattices(9))
def test_corrections_are_projected_and_the_line_search_knows_the_energy(case):
    lattice, problem, rng = case
    layout = lattice.layout
    gap = admissible(problem, rng)
    omega, corrected = layout.grid(gap), layout.zeros()
    hierarchy = hierarchy_of(lattice, Team(1))
    first = hierarchy.levels[0]
    plan = first.plan
    coarse = np.zeros((plan.rows + 2, plan.columns + 2))
    coarse[1:-1, 1:-1] = rng.normal(size=(plan.rows, plan.columns))
    cut = exchange_kernels(lattice.kind, "float64").correct(
        omega, corrected, coarse, *first.factors, first.exchange_weights, *problem.bound_grids(), layout.runs,
        layout.row_start, 1, lattice.rows + 1,
    )  # fmt: skip
    step = (interpolation(hierarchy.levels[0], lattice.rows, lattice.columns) @ coarse[1:-1, 1:-1].ravel()).reshape(
        layout.mask.shape
    )
    free = (gap > problem.lower) & (gap < problem.upper)
    wanted = gap + np.where(free & (lattice.marks()[layout.mask] > 0), step[layout.mask], 0.0)
    expected = problem.project(wanted)
    np.testing.assert_allclose(layout.vector(corrected), expected, atol=1e-13)
    assert cut == np.count_nonzero((wanted < problem.lower) | (wanted > problem.upper))
    slope, curvature = lattice_kernels(lattice.kind).energy_slope(
        omega,
        corrected,
        layout.grid(problem.q),
        *lattice.stiffnesses,
        layout.runs,
        layout.row_start,
        1,
        lattice.rows + 1,
    )
    way = expected - gap
    for length in (0.3, 1.0):
        change = problem.objective(gap + length * way) - problem.objective(gap)
        assert length * slope + 0.5 * length**2 * curvature == pytest.approx(change, abs=1e-11)


def test_the_start_interpolates_the_deflection():
    """By hand: five nodes over f = 1, coarse deflections 0.4 and 2 at the second and the fourth."""
    lattice = Arms(Layout(np.ones((1, 5), dtype=bool)), 1.0, 0.0)
    height, omega, coarse = lattice.layout.grid(np.ones(5)), lattice.layout.zeros(), np.zeros((3, 4))
    coarse[1, 1:3] = 0.4, 2.0
    start_from_coarse(omega, height, coarse, 1, 2, 0.0, *NO_LIMITS, lattice.layout.runs, lattice.layout.row_start, 1, 2)
    np.testing.assert_allclose(lattice.layout.vector(omega), [0.8, 0.6, 0.0, 0.0, 0.0])


def test_coarsening_follows_the_stiffer_arms():
    assert coarsening(15, 15, 1.0, 1.0) == (2, 2)
    assert coarsening(15, 15, 10.0, 1.0) == (1, 2)
    assert coarsening(15, 15, 0.0, 1.0) == (2, 1)
    assert coarsening(1, 100, 1.0, 0.0) == (1, 2)
    assert coarsening(100, 1, 10.0, 1.0) == (2, 1)
    assert coarsening(3, 3, 1.0, 1.0) == (1, 1)


@settings(max_examples=150)
@given(lattices(20), st.booleans())
def test_the_energy_never_rises_and_the_answer_is_certified(case, warm):
    _, problem, rng = case
    start = rng.normal(size=problem.size) if warm else None
    solution = cq.solve(problem, "multigrid", tol=1e-8, warm_start=start, history=True)
    assert solution.status == "certified"
    energy = solution.history.get("energy", np.zeros(1))
    assert (np.diff(energy) <= 1e-12 * np.abs(energy).max()).all()


@pytest.mark.parametrize("make", [cq.gallery.bowl, cq.gallery.spiral])
@pytest.mark.parametrize("nodes", [63, 127, 255, pytest.param(511, marks=pytest.mark.slow)])
def test_cycles_hardly_grow_with_the_lattice(make, nodes):
    solution = cq.solve(make(nodes), "multigrid", tol=1e-8, history=True)
    assert solution.iterations <= 14
    assert solution.history["contraction"][-3:].max() < 0.2
    assert solution.history["work"][-1] <= 8 * solution.iterations + 8


# Bueler, PETSc for Partial Differential Equations (2021), ch. 12, the obstacle example: max |u_h - u|.
@pytest.mark.parametrize(("points", "error"), [(33, 5.75e-3), pytest.param(1025, 6.6e-6, marks=pytest.mark.slow)])
def test_the_ball_has_the_published_errors(points, error):
    model, exact = cq.gallery.ball(points - 2)
    solution = cq.solve(model, "multigrid", tol=1e-7)
    assert np.abs(solution.deflection - exact).max() == pytest.approx(error, rel=0.005)


def test_nested_iteration_alone_is_as_accurate_as_the_discretisation():
    model, exact = cq.gallery.ball(127)
    problem, units = model.problem.scaled()
    lattice = arms_of(problem.stencil, problem.layout)
    with Team() as team:
        solver = nested_start(lattice, lattice.layout.grid(problem.q), problem.reference_grid(), team)
        solver.relax()
        solver.correct()
    assert solver.work <= 20
    error = np.abs(model.deflection(lattice.layout.vector(solver.omega) * units.length) - exact).max()
    finished = cq.solve(model, "multigrid", tol=1e-8)
    assert error < 2 * np.abs(finished.deflection - exact).max()


def test_without_a_support_it_solves_the_linear_problem():
    model = cq.gallery.bowl(63)
    free = cq.Membrane(model.lattice, 1.0, load=8.0, support=np.inf)
    solution = cq.solve(free, "multigrid", tol=1e-11)
    np.testing.assert_allclose(solution.deflection, linalg.spsolve(free.problem.G.tocsc(), free.nodal_load), rtol=1e-9)


@settings(max_examples=40)
@given(lattices(15))
def test_the_linear_problem_is_solved_by_the_same_cycle(case):
    _, problem, rng = case
    force = rng.normal(size=problem.size)
    solver = LatticeSolver(problem.stencil)
    for right in (force, force[::-1].copy()):  # the second with what the first has left
        np.testing.assert_allclose(solver.solve(right, 1e-12), np.linalg.solve(problem.G.toarray(), right), atol=1e-9)


def test_varying_arms_get_their_barrier_from_it(monkeypatch):
    rng = np.random.default_rng(0)
    stencil = Stencil(np.ones((70, 80), dtype=bool), rng.uniform(0.1, 3, (70, 81)), rng.uniform(0.1, 3, (71, 80)))
    monkeypatch.setattr(Stencil, "tocsr", lambda self: pytest.fail("the matrix was assembled"))
    barrier = cq.ContactQP(stencil, np.ones(5600)).barrier
    assert barrier.kind == "linear solve"
    assert barrier.s.min() > 0.9
    assert barrier.s.max() < 1.1


def test_it_never_assembles_the_matrix(monkeypatch):
    monkeypatch.setattr(Stencil, "tocsr", lambda self: pytest.fail("the matrix was assembled"))
    assert cq.solve(cq.gallery.bowl(63), "multigrid").status == "certified"


def test_any_number_of_threads_gives_the_same_answer():
    model = cq.gallery.bowl(401)
    first, second = (cq.solve(model, "multigrid", threads=count) for count in (1, 3))
    np.testing.assert_allclose(first.gap, second.gap, atol=1e-12)
    assert first.iterations == second.iterations


@pytest.mark.parametrize("rows", [24, 29, 36, 40])
def test_low_strips_leave_the_sweeps_as_they_are(rows):
    """A low and wide lattice, divided among as many threads as its strips allow."""
    rng = np.random.default_rng(rows)
    lattice = Arms(Layout(np.ones((rows, 400), dtype=bool)), 0.25, 0.25)
    q, start = lattice.layout.grid(rng.normal(size=lattice.layout.size)), rng.uniform(0, 1, lattice.layout.size)
    answers = []
    for threads in (1, 3):
        team = Team(threads)
        solver = ContactMultigrid(lattice, q, team)
        solver._strips = [(1 + rows * k // threads, 1 + rows * (k + 1) // threads) for k in range(threads)]
        if rows // threads < contact._LEAST_STRIP:
            solver._strips = [(1, rows // 2 + 1), (rows // 2 + 1, rows + 1)]
        solver.omega[...] = lattice.layout.grid(start)
        solver._sweep(6)
        answers.append(solver.omega.copy())
    np.testing.assert_array_equal(*answers)
    wide = Team(4).strips(1, rows + 1, 10**6, contact._LEAST_STRIP)
    assert all(hi - lo >= contact._LEAST_STRIP for lo, hi in wide)


def test_an_update_without_changes_marks_no_row():
    lattice = Arms(Layout(np.ones((40, 50), dtype=bool)), 0.25, 0.25)
    hierarchy = hierarchy_of(lattice, Team(1))
    hierarchy.update()
    hierarchy.update()
    assert not any(level.changed.any() for level in hierarchy.levels)


def test_arms_that_jump_by_orders_of_magnitude_are_handed_over():
    rng = np.random.default_rng(3)
    stencil = Stencil(
        np.ones((25, 25), dtype=bool), 10 ** rng.uniform(-4, 4, (25, 26)), 10 ** rng.uniform(-4, 4, (26, 25))
    )
    problem = cq.ContactQP(stencil, rng.normal(size=625) * stencil.diagonal())
    solution = cq.solve(problem, "multigrid", history=True)
    assert solution.status == "certified"
    assert "active sets went on" in solution.note
    cycles = len(solution.history["bound"])
    assert 0 < cycles < solution.iterations
    limited = cq.solve(problem, "multigrid", max_iter=cycles + 1, on_failure="ignore")
    assert limited.iterations == cycles + 1


def test_soft_parts_are_no_rounding_errors_of_stiff_ones():
    across, along = np.ones((20, 21)), np.ones((21, 20))
    across[:, 10:] = along[:, 10:] = 1e-39
    q = np.random.default_rng(0).normal(size=400)
    problem = cq.ContactQP(Stencil(np.ones((20, 20), dtype=bool), across, along), q)
    assert cq.solve(problem, "multigrid").status == "certified"


def test_arms_that_hold_no_node_do_not_count():
    mask = np.hypot(*np.mgrid[-15:16, -15:16]) < 14
    across, along = np.full((31, 32), 1e300), np.full((32, 31), 1e300)
    point = np.pad(mask, 1)
    across[point[1:-1, :-1] | point[1:-1, 1:]] = along[point[:-1, 1:-1] | point[1:, 1:-1]] = 1.0
    problem = cq.ContactQP(Stencil(mask, across, along), np.full(mask.sum(), -1.0))
    assert cq.solve(problem, "multigrid").iterations <= 10


@pytest.mark.parametrize("backend", ["multigrid", "active-set"])
@pytest.mark.parametrize("height", [1e60, -1e60, 1e300])
def test_an_absurd_start_is_not_used(backend, height):
    model = cq.gallery.bowl(31)
    supported = np.random.default_rng(0).uniform(size=961) < 0.1
    problem = cq.ContactQP(model.stencil, model.problem.q, supported=supported)
    usual = cq.solve(problem, backend)
    assert cq.solve(problem, backend, warm_start=np.full(961, height)).iterations == usual.iterations


def test_history_and_limits():
    model = cq.gallery.spiral(127)
    with pytest.warns(cq.ContactWarning, match="stopped at its iteration limit"):
        stopped = cq.solve(model, "multigrid", max_iter=2, history=True)
    assert stopped.iterations == 2
    lengths = {name: len(column) for name, column in stopped.history.items()}
    names = ["bound", "contraction", "changes", "cut", "damping", "energy", "work"]
    assert lengths == dict.fromkeys(names, 2)
    assert (np.diff(stopped.history["work"]) > 0).all()
    with pytest.raises(ValueError, match="threads must be >= 1, got 0"):
        cq.solve(model, "multigrid", threads=0)
    with pytest.raises(cq.UnsuitableProblemError, match="needs a problem on a lattice"):
        cq.solve(cq.ContactQP(np.eye(2), [1.0, 1.0]), "multigrid")


def test_a_warm_start_saves_cycles():
    model = cq.gallery.bowl(127)
    solution = cq.solve(model, "multigrid", tol=1e-8)
    again = cq.solve(model, "multigrid", tol=1e-8, warm_start=solution, history=True)
    assert again.history["changes"][0] == solution.contact.sum()
    assert again.iterations <= 2 < solution.iterations


def test_compiling_is_announced_on_a_terminal_alone(monkeypatch, capsys):
    monkeypatch.setattr("contactqp.foundation.loading._PATIENCE", 0.01)
    once(object(), lambda: time.sleep(0.1), "nothing")
    assert capsys.readouterr() == ("", "")
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    once(object(), lambda: time.sleep(0.5), "nothing")
    assert capsys.readouterr().err == "contactqp: compiling the kernels of nothing, once on this machine\n"


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="sends a POSIX signal")
def test_an_interrupt_ends_it_within_a_second():
    # A shell that starts the tests in the background has children that ignore the signal.
    code = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "import contactqp as cq; m = cq.gallery.bowl(1500); m.problem.gap_scale; cq.solve(m, 'multigrid')\n"
        "print('ready', flush=True)\n"
        "while True: cq.solve(m, 'multigrid', tol=1e-8)"
    )
    run = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert run.stdout is not None
    assert run.stdout.readline() == "ready\n"
    time.sleep(0.4)
    sent = time.perf_counter()
    run.send_signal(signal.SIGINT)
    _, error = run.communicate(timeout=20)
    assert time.perf_counter() - sent < 10  # within a second, but for a busy machine and the end of the interpreter
    assert "KeyboardInterrupt" in error


def test_the_state_says_what_a_step_did():
    """By hand: one node, G = 4, q = -2, started at 0: a sweep sets ω = 1/2 and nothing is left."""
    lattice = Arms(Layout(np.ones((1, 1), dtype=bool)), 1.0, 1.0)
    solver = ContactMultigrid(lattice, lattice.layout.grid(np.array([-2.0])), Team(1))
    solver.relax()
    assert solver.omega[1, 1] == 0.5
    assert (solver.changes, solver.estimate) == (0, 0.0)
    solver.correct()
    assert solver.omega[1, 1] == 0.5
    assert solver.energy() == -0.5
