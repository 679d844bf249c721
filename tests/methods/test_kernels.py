"""Compiled sweeps against hand-computed steps and against plain-numpy twins."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import bounds, lattice_masks

import contactqp as cq
from contactqp.algebra.stencil import Stencil
from contactqp.geometry.numbering import Layout, Numbering
from contactqp.geometry.runs import HELD, STIFF
from contactqp.methods.sor.relaxation import AdaptiveRelaxation, best_factor
from contactqp.methods.sor.sweepers import LatticeSweeper, SparseSweeper


def lattice_sweeper(stencil, q, lower=0.0, upper=np.inf, start=None, **options):
    problem = cq.ContactQP(stencil, q, lower, upper)
    start = np.zeros(problem.size) if start is None else start
    return LatticeSweeper(stencil, problem.layout, problem.q, start, problem.bound_grids(), **options)


def sparse_sweeper(stencil, q, lower=0.0, upper=np.inf):
    problem = cq.ContactQP(stencil.tocsr(), q, lower, upper)
    above = np.zeros(0) if problem.one_sided else problem.upper
    return SparseSweeper(problem.stiffness, problem.q, np.zeros(problem.size), problem.lower, above)


def twin_sweep(matrix, q, lower, upper, omega, beta, order):
    """Cryer's sweep, node by node in the given order; returns the largest step."""
    step = 0.0
    for i in order:
        old = omega[i]
        new = old - beta * (matrix[i] @ omega + q[i]) / matrix[i, i]
        omega[i] = min(upper[i], max(lower[i], new))
        step = max(step, abs(omega[i] - old))
    return step


def some_bounds(rng, size, two_sided, data):
    """Return bounds of every kind; or zero from below, where there is a support."""
    if two_sided:
        return data.draw(bounds(size))
    return np.where(rng.uniform(size=size) < 0.8, 0.0, -np.inf), np.full(size, np.inf)


def test_one_sweep_by_hand():
    """Two nodes, G = [[4, -1], [-1, 4]], q = (-4, -7), β = 1: ω_1 = 1, then ω_2 = (7 + 1)/4 = 2."""
    sweeper = lattice_sweeper(Stencil(np.ones((1, 2), dtype=bool), 1.0, 1.0), np.array([-4.0, -7.0]))
    assert sweeper.sweep(1.0, 1) == (1, 2.0)
    np.testing.assert_array_equal(sweeper.gap(), [1.0, 2.0])
    assert sweeper.residual(1.0) == 0.5  # R_1/G_11 = 1 - 1 - 2/4
    assert sweeper.sweep(1.0, 1) == (1, 0.5)
    np.testing.assert_array_equal(sweeper.gap(), [1.5, 2.125])


def test_the_clip_by_hand():
    """A positive q holds the gap shut; without a support the node goes on to minus q/G."""
    stencil = Stencil(np.ones((1, 2), dtype=bool), 1.0, 1.0)
    sweeper = lattice_sweeper(stencil, np.array([4.0, 4.0]), [0.0, -np.inf])
    sweeper.sweep(1.0, 1)
    np.testing.assert_array_equal(sweeper.gap(), [0.0, -1.0])
    assert sweeper.residual(1.0) == 0.0


def test_red_black_order_by_hand():
    """Points of even row + column first, on the padded net: of three nodes at (1, 1), (1, 2), (1, 3) the outer two."""
    stencil = Stencil(np.ones((1, 3), dtype=bool), 1.0, 1.0)
    sweeper = lattice_sweeper(stencil, np.array([-4.0, -4.0, -4.0]), red_black=True)
    sweeper.sweep(1.0, 1)
    np.testing.assert_array_equal(sweeper.gap(), [1.0, 1.5, 1.0])


def test_runs_by_hand():
    mask = np.array([[True, False, True, True], [False, False, False, False], [True, True, True, True]])
    np.testing.assert_array_equal(Layout(mask).runs, [[1, 1, 2, 0, 1, 0], [1, 3, 5, 1, 1, 0], [3, 1, 5, 3, 1, 0]])
    supported = np.array([[True, False, True, False], [False] * 4, [True, False, False, True]])
    kinds = [
        *([1, 1, 2, 0, 1, 0], [1, 3, 4, 1, 1, 0], [1, 4, 5, 2, 0, 0]),
        *([3, 1, 2, 3, 1, 0], [3, 2, 4, 4, 0, 0], [3, 4, 5, 6, 1, 0]),
    ]
    np.testing.assert_array_equal(Layout(mask, supported.astype(np.uint8)).runs, kinds)
    np.testing.assert_array_equal(Layout(mask).row_start, [0, 0, 2, 2, 3, 3])
    held = np.zeros((3, 4), dtype=np.uint8)
    held[2, 1:3], held[0, 1] = STIFF, HELD  # a point that is no node is not held
    holds = [[1, 1, 2, 0, 1, 0], [1, 3, 5, 1, 1, 0], [3, 1, 2, 3, 1, 0], [3, 2, 4, 4, 1, 2], [3, 4, 5, 6, 1, 0]]
    np.testing.assert_array_equal(Layout(mask).with_holds(held).runs, holds)


@given(
    mask=lattice_masks(), beta=st.floats(0.1, 1.9), seed=st.integers(0, 999), red_black=st.booleans(),
    across=st.sampled_from([1.0, 0.25]), sweeps=st.integers(1, 4), two_sided=st.booleans(), data=st.data(),
)  # fmt: skip
def test_lattice_sweeps_match_their_twin(mask, beta, seed, red_black, across, sweeps, two_sided, data):
    rng = np.random.default_rng(seed)
    stencil = Stencil(mask, across, 1.0)
    q = rng.normal(size=stencil.size)
    lower, upper = some_bounds(rng, stencil.size, two_sided, data)
    start = np.clip(np.abs(rng.normal(size=stencil.size)), lower, upper)
    sweeper = lattice_sweeper(stencil, q, lower, upper, start, red_black=red_black)
    matrix, twin = stencil.tocsr().toarray(), start.copy()
    rows, columns = np.nonzero(Numbering(mask).layout.mask)
    colour = (rows + columns) % 2
    order = np.argsort(colour, kind="stable") if red_black else np.arange(stencil.size)
    count, step = sweeper.sweep(beta, sweeps)
    for _ in range(sweeps):
        twin_step = twin_sweep(matrix, q, lower, upper, twin, beta, order)
    assert count == sweeps
    assert step == pytest.approx(twin_step, abs=1e-12)
    np.testing.assert_allclose(sweeper.gap(), twin, atol=1e-12)
    correction = (matrix @ twin + q) / np.diag(matrix)
    natural = np.maximum(np.minimum(twin - lower, 2 * correction), twin - upper)
    assert sweeper.residual(2.0) == pytest.approx(np.abs(natural).max(), abs=1e-12)


@given(
    mask=lattice_masks(), beta=st.floats(0.1, 1.9), seed=st.integers(0, 999), two_sided=st.booleans(), data=st.data()
)
def test_sparse_sweeps_match_lattice_sweeps(mask, beta, seed, two_sided, data):
    rng = np.random.default_rng(seed)
    stencil = Stencil(mask, 0.5, 1.0)
    q = rng.normal(size=stencil.size)
    lower, upper = some_bounds(rng, stencil.size, two_sided, data)
    one, other = lattice_sweeper(stencil, q, lower, upper), sparse_sweeper(stencil, q, lower, upper)
    assert one.sweep(beta, 3)[1] == pytest.approx(other.sweep(beta, 3)[1], abs=1e-12)
    np.testing.assert_allclose(one.gap(), other.gap(), atol=1e-12)
    assert one.residual(1.0) == pytest.approx(other.residual(1.0), abs=1e-12)


def test_sweeps_end_early_once_the_step_is_small():
    stencil = Stencil(np.ones((3, 3), dtype=bool), 1.0, 1.0)
    sweeper = lattice_sweeper(stencil, -np.ones(9))
    count, step = sweeper.sweep(1.0, 1000, small=1e-6)
    assert count < 100
    assert step < 1e-6
    other = sparse_sweeper(stencil, -np.ones(9))
    assert other.sweep(1.0, 1000, small=1e-6)[0] == count


@pytest.mark.parametrize("nodes", [15, 31, 63])
def test_the_adaptive_factor_approaches_youngs(nodes):
    """Without contact μ = cos(πh), so the best factor is 2/(1 + sin(πh)) (Young 1971, ch. 6)."""
    lattice = cq.Lattice.from_mask(np.ones((nodes, nodes), dtype=bool), 1 / (nodes + 1))
    solution = cq.solve(cq.Membrane(lattice, 1.0, load=1.0, support=np.inf), "psor", history=True)
    best = 2 / (1 + np.sin(np.pi / (nodes + 1)))
    assert solution.history["relaxation"][-1] == pytest.approx(best, abs=0.2 * (2 - best))
    scanned = min(
        cq.solve(solution.model, "psor", relaxation=beta, max_iter=1000, on_failure="ignore").iterations
        for beta in (1.7, 1.8, 1.85, 1.9, 1.92, 1.94, 1.96)
    )
    assert solution.iterations <= 1.25 * scanned


def test_best_factor_is_youngs_formula():
    mu = 0.95
    assert best_factor(mu**2, 1.0) == pytest.approx(2 / (1 + np.sqrt(1 - mu**2)))
    adaptive = AdaptiveRelaxation()
    for _ in range(9):
        adaptive.observe(1.0)  # steps that do not decay say nothing
    assert adaptive.beta == 1.35
