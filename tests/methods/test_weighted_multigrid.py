"""The multigrid where arms differ: its interpolation against plain numpy, and contact where arms jump."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from meshes import bowl_on_a_checkerboard
from strategies import bounds, lattice_masks

import contactqp as cq
from contactqp.algebra.stencil import Stencil
from contactqp.foundation.threads import Team
from contactqp.geometry.numbering import Layout
from contactqp.methods.multigrid.arms import Arms, arms_of
from contactqp.methods.multigrid.lattice_kernels import lattice_kernels
from contactqp.methods.multigrid.weighted_hierarchy import hierarchy_of
from contactqp.methods.multigrid.weighted_kernels import expand_row, spread_row, weighted_kernels


def blocks(rows, columns, block, jump):
    """Return a field that is 1 and ``jump`` in the blocks of a checkerboard."""
    row, column = np.arange(rows)[:, None] // block, np.arange(columns) // block
    return np.where((row + column) % 2 == 0, 1.0, jump)


def over_bowl(tension):
    """Return a membrane of a tension over a bowl, on the unit square."""
    nodes = np.shape(tension[0] if isinstance(tension, tuple) else tension)[0]
    lattice = cq.Frame.rectangle(1, 1).lattice(1 / (nodes + 1))
    support = 0.05 + 0.4 * ((lattice.node_x - 0.5) ** 2 + (lattice.node_y - 0.5) ** 2)
    given = tuple(part.ravel() for part in tension) if isinstance(tension, tuple) else tension.ravel()
    return cq.Membrane(lattice, given, load=8.0, support=support)


def between(neighbours, own):
    """Return the weights of neighbours that pull with such forces at a point that is held by ``own``."""
    pull = np.maximum(neighbours, 0.0)
    return pull / max(own, pull.sum())


def entry(matrix, rows, columns):
    """Return the matrix as a function of two points [i, j], counted from the ring, zero beyond the last."""
    grid = matrix.reshape(rows, columns, rows, columns)

    def at(i, j, a, b):
        inside = 1 <= i <= rows and 1 <= j <= columns and 1 <= a <= rows and 1 <= b <= columns
        return grid[i - 1, j - 1, a - 1, b - 1] if inside else 0.0

    return at


def test_a_point_between_two_is_balanced_by_its_arms():
    """By hand: arms 1 and 3 beside the middle, which a spring of 4 pulls to the ground: 1/8 and 3/8."""
    across, along = np.array([[2.0, 1.0, 3.0, 2.0]]), np.zeros((2, 3))
    lattice = Arms(Layout(np.ones((1, 3), dtype=bool)), across, along, np.array([[0.0, 0.0, 0.0]]))
    weights = np.zeros((8, 3, 3), dtype=np.float32)
    weighted_kernels().weigh_lattice(lattice.layout.mask.copy(), across, along, np.zeros((1, 3)), weights, 1, 2, 0, 3)
    np.testing.assert_allclose(weights[:2, 1, 0], [2 / 3, 1 / 3])
    np.testing.assert_allclose(weights[:2, 1, 1], [3 / 5, 2 / 5])
    springs = np.array([[0.0, 0.0, 5.0]])
    weighted_kernels().weigh_lattice(lattice.layout.mask.copy(), across, along, springs, weights, 1, 2, 0, 3)
    np.testing.assert_allclose(weights[:2, 1, 1], [3 / 10, 2 / 10])


@settings(max_examples=30)
@given(st.integers(8, 13), st.integers(8, 13), st.integers(0, 9999))
def test_weights_are_those_that_balance_each_point(rows, columns, seed):
    rng = np.random.default_rng(seed)
    across, along = 10 ** rng.uniform(-2, 2, (rows, columns + 1)), 10 ** rng.uniform(-2, 2, (rows + 1, columns))
    stencil = Stencil(np.ones((rows, columns), dtype=bool), across, along, rng.uniform(0, 1, (rows, columns)))
    lattice = arms_of(stencil, stencil.layout)
    first = hierarchy_of(lattice, Team(1)).levels[0]
    at = entry(stencil.tocsr().toarray(), rows, columns)
    for cell, step in np.ndindex(first.plan.rows, first.plan.columns):
        if first.factors != (2, 2) or cell == 0 or step == 0:
            continue
        i, j, weights = 2 * cell, 2 * step, first.weights[:, cell, step]
        if j + 2 <= columns:
            own = at(i, j + 1, i, j + 1) + at(i, j + 1, i - 1, j + 1) + at(i, j + 1, i + 1, j + 1)
            if 1 < i < rows:
                pull = np.array([-at(i, j + 1, i, j), -at(i, j + 1, i, j + 2)])
                np.testing.assert_allclose(weights[:2], between(pull, own), rtol=1e-6)
        if i + 2 <= rows and j + 2 <= columns:
            middle = i + 1, j + 1
            side, other = first.weights[:2, cell, step], first.weights[:2, cell + 1, step]
            left, right = first.weights[2:4, cell, step], first.weights[2:4, cell, step + 1]
            west, east = -at(*middle, i + 1, j), -at(*middle, i + 1, j + 2)
            south, north = -at(*middle, i, j + 1), -at(*middle, i + 2, j + 1)
            pull = np.array([
                west * left[0] + south * side[0], east * right[0] + south * side[1],
                west * left[1] + north * other[0], east * right[1] + north * other[1],
            ])  # fmt: skip
            np.testing.assert_allclose(weights[4:], between(pull, at(*middle, *middle)), rtol=1e-6)


def test_without_springs_a_constant_is_interpolated_to_itself():
    rng = np.random.default_rng(5)
    across, along = 10 ** rng.uniform(-3, 3, (31, 32)), 10 ** rng.uniform(-3, 3, (32, 31))
    lattice = Arms(Layout(np.ones((31, 31), dtype=bool)), across, along, np.zeros((31, 31)))
    weights = hierarchy_of(lattice, Team(1)).levels[0].weights
    inner = weights[:, 1:-2, 1:-2]
    np.testing.assert_allclose([inner[:2].sum(axis=0), inner[2:4].sum(axis=0)], 1.0, rtol=1e-6)
    np.testing.assert_allclose(inner[4:].sum(axis=0), 1.0, rtol=1e-6)


def test_a_row_is_spread_and_expanded_by_its_cells():
    """By hand: coarse values 1, 2 below and 3, 4 above, in one cell with weights of its own."""
    weights = np.zeros((8, 4, 4), dtype=np.float32)
    weights[:, 1, 1] = 0.5, 0.25, 0.125, 0.75, 0.1, 0.2, 0.3, 0.4
    coarse, row = np.zeros((4, 4)), np.zeros(6)
    coarse[1, 1:3], coarse[2, 1:3] = (1.0, 2.0), (3.0, 4.0)
    expand_row(coarse, 2, 2, 2, weights, row)
    np.testing.assert_allclose(row[2:5], [1.0, 1.0, 2.0])
    expand_row(coarse, 3, 2, 2, weights, row)
    np.testing.assert_allclose(row[2:4], [2.375, 3.0], rtol=1e-6)
    back = np.zeros((4, 4))
    spread_row(np.array([0.0, 0.0, 1.0, 10.0, 0.0, 0.0]), back, 3, 2, 2, weights, 1, 3)
    np.testing.assert_allclose(back[1:3, 1:3], [[1.125, 2.0], [3.75, 4.0]], rtol=1e-6)


def test_the_coarsest_level_is_solved_exactly_and_what_it_has_no_say_in_is_left_out():
    rng = np.random.default_rng(2)
    arms = 10 ** rng.uniform(-3, 3, (13, 14)), 10 ** rng.uniform(-3, 3, (14, 13)), np.zeros((13, 13))
    hierarchy = hierarchy_of(Arms(Layout(np.ones((13, 13), dtype=bool)), *arms), Team(1))
    hierarchy.free[1:6, 1:6] = 0
    hierarchy.changed[:] = 1
    hierarchy.update()
    last = hierarchy.levels[-1]
    used = last.stencil[0, 1:-1, 1:-1] > 0
    assert not used.all()
    last.residual[1:-1, 1:-1] = np.where(used, rng.normal(size=used.shape), 0.0)
    hierarchy.cycle(len(hierarchy.levels) - 1)
    image = np.zeros_like(last.correction)
    weighted_kernels().apply(last.stencil, last.correction, image, last.residual, 1, last.plan.rows + 1)
    np.testing.assert_allclose(image[1:-1, 1:-1], last.residual[1:-1, 1:-1], atol=1e-9)
    assert (last.correction[1:-1, 1:-1][~used] == 0).all()


@settings(max_examples=40)
@given(lattice_masks(8, 8), st.integers(0, 9999))
def test_the_plane_of_two_steps_has_the_energy_that_it_says(mask, seed):
    rng = np.random.default_rng(seed)
    shapes = (mask.shape[0], mask.shape[1] + 1), (mask.shape[0] + 1, mask.shape[1]), mask.shape
    stencil = Stencil(mask, *(rng.uniform(0.5, 2.0, shape) for shape in shapes))
    size = stencil.size
    lower, upper = np.full(size, -1.0), np.full(size, 1.0)
    problem = cq.ContactQP(stencil, rng.normal(size=size), lower, upper)
    lattice = arms_of(problem.stencil, problem.layout)
    layout = lattice.layout
    vectors = [problem.project(rng.normal(size=size)) for _ in range(3)]
    gap, before, older = (layout.grid(vector) for vector in vectors)
    kernels, place, rows = lattice_kernels(lattice.kind), (layout.runs, layout.row_start), (1, lattice.rows + 1)
    limits = problem.bound_grids()
    kernels.directions(gap, before, older, *limits, *place, *rows)
    free = (vectors[0] > lower) & (vectors[0] < upper)
    first, second = layout.vector(before), layout.vector(older)
    np.testing.assert_allclose(first, np.where(free, vectors[0] - vectors[1], 0.0))
    np.testing.assert_allclose(second, np.where(free, vectors[1] - vectors[2], 0.0))
    sums = kernels.plane(gap, before, older, layout.grid(problem.q), *lattice.stiffnesses, *place, *rows)
    matrix, reaction = problem.G.toarray(), problem.reaction(vectors[0])
    expected = first @ reaction, second @ reaction, first @ matrix @ first, first @ matrix @ second
    np.testing.assert_allclose(sums, [*expected, second @ matrix @ second], atol=1e-10)
    moved = layout.zeros()
    beyond = kernels.advance(gap, moved, before, 0.5, older, -2.0, *limits, *place, *rows)
    wanted = vectors[0] + 0.5 * first - 2.0 * second
    np.testing.assert_allclose(layout.vector(moved), wanted)
    assert beyond == np.count_nonzero((wanted < lower) | (wanted > upper))


@pytest.mark.parametrize(("jump", "most"), [(1e3, 22), (1e6, 34)])
@pytest.mark.parametrize("block", [8, 7])
def test_cycles_stay_few_where_tension_jumps(jump, most, block):
    solution = cq.solve(over_bowl(blocks(96, 96, block, jump)), "multigrid", tol=1e-6)
    assert solution.status == "certified"
    assert not solution.note
    assert solution.iterations <= most


@pytest.mark.parametrize("backend", ["psor", "clarabel"])
def test_others_find_the_same_where_tension_jumps(backend):
    model = over_bowl(blocks(24, 24, 6, 100.0))
    solution = cq.solve(model, "multigrid", tol=1e-8)
    other = cq.solve(model, backend, tol=1e-7)
    assert solution.status == other.status == "certified"
    np.testing.assert_allclose(solution.gap, other.gap, atol=1e-6)


def test_a_tension_a_hundred_times_as_large_along_x_needs_few_cycles():
    field = blocks(96, 96, 8, 10.0)
    solution = cq.solve(over_bowl((100 * field, field)), "multigrid", tol=1e-6)
    assert solution.status == "certified"
    assert not solution.note
    assert solution.iterations <= 25


def test_a_recognised_matrix_starts_so_well_that_few_steps_are_left():
    matrix, q = bowl_on_a_checkerboard(96, 12, 1e3)
    solution = cq.solve(cq.ContactQP(matrix, q), "active-set")
    assert solution.status == "certified"
    assert solution.iterations <= 4


@settings(max_examples=25)
@given(lattice_masks(18, 18), st.floats(0.0, 6.0), st.integers(1, 5), st.booleans(), st.data())
def test_any_jumps_between_blocks_are_solved_and_the_certificate_holds(mask, decades, block, springs, data):
    rng = np.random.default_rng(data.draw(st.integers(0, 9999)))
    rows, columns = mask.shape
    cells = rng.uniform(0, decades, (rows // block + 2, columns // block + 2))
    field = 10 ** np.kron(cells, np.ones((block, block)))[: rows + 2, : columns + 2]
    field = np.pad(field, ((0, max(0, rows + 2 - field.shape[0])), (0, max(0, columns + 2 - field.shape[1]))), "edge")
    across = 2 / (1 / field[1 : rows + 1, :-1] + 1 / field[1 : rows + 1, 1:])[:, : columns + 1]
    along = 2 / (1 / field[:-1, 1 : columns + 1] + 1 / field[1:, 1 : columns + 1])[: rows + 1]
    ground = rng.uniform(0, 1, mask.shape) if springs else np.zeros(mask.shape)
    stencil = Stencil(mask, across, along, ground)
    lower, upper = data.draw(bounds(stencil.size)) if data.draw(st.booleans()) else (0.0, np.inf)
    q: Any = rng.normal(size=stencil.size) * stencil.diagonal()
    problem = cq.ContactQP(stencil, q, lower, upper)
    solution = cq.solve(problem, "multigrid", tol=1e-7)
    assert solution.status == "certified"
    exact = cq.solve(problem, "active-set", tol=1e-12, on_failure="ignore")
    assert solution.certificate is not None
    assert exact.certificate is not None
    error = np.abs(solution.gap - exact.gap).max()
    assert error <= solution.certificate.gap_bound + exact.certificate.gap_bound
