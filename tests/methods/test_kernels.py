"""Compiled sweeps against hand-computed steps and against plain-numpy twins."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import lattice_masks

import contactqp as cq
from contactqp.algebra.sparse import SparseStiffness
from contactqp.algebra.stencil import Stencil
from contactqp.geometry.numbering import Layout
from contactqp.methods.sor import spectral_kernels
from contactqp.methods.sor.relaxation import AdaptiveRelaxation, FreeSetRelaxation, best_factor, young
from contactqp.methods.sor.spectral import MOST_WORK, NodeGrid, jacobi_radius, largest_eigenpair
from contactqp.methods.sor.sweepers import FreeNodes, LatticeSweeper, SparseSweeper


def twin_sweep(matrix, q, supported, omega, beta, order):
    """Cryer's sweep, node by node in the given order; returns the largest step."""
    step = 0.0
    for i in order:
        old = omega[i]
        new = old - beta * (matrix[i] @ omega + q[i]) / matrix[i, i]
        omega[i] = max(0.0, new) if supported[i] else new
        step = max(step, abs(omega[i] - old))
    return step


def test_one_sweep_by_hand():
    """Two nodes, G = [[4, -1], [-1, 4]], q = (-4, -7), β = 1: ω_1 = 1, then ω_2 = (7 + 1)/4 = 2."""
    sweeper = LatticeSweeper(
        Stencil(np.ones((1, 2), dtype=bool), 1.0, 1.0), np.array([-4.0, -7.0]), np.ones(2, dtype=bool)
    )
    assert sweeper.sweep(1.0, 1) == (1, 2.0)
    np.testing.assert_array_equal(sweeper.gap(), [1.0, 2.0])
    assert sweeper.residual(1.0) == 0.5  # R_1/G_11 = 1 - 1 - 2/4
    assert sweeper.sweep(1.0, 1) == (1, 0.5)
    np.testing.assert_array_equal(sweeper.gap(), [1.5, 2.125])


def test_the_clip_by_hand():
    """A positive q holds the gap shut; without a support the node goes on to minus q/G."""
    stencil = Stencil(np.ones((1, 2), dtype=bool), 1.0, 1.0)
    sweeper = LatticeSweeper(stencil, np.array([4.0, 4.0]), np.array([True, False]))
    sweeper.sweep(1.0, 1)
    np.testing.assert_array_equal(sweeper.gap(), [0.0, -1.0])
    assert sweeper.residual(1.0) == 0.0


def test_red_black_order_by_hand():
    """Points of even row + column first, on the padded net: of three nodes at (1, 1), (1, 2), (1, 3) the outer two."""
    stencil = Stencil(np.ones((1, 3), dtype=bool), 1.0, 1.0)
    sweeper = LatticeSweeper(stencil, np.array([-4.0, -4.0, -4.0]), np.ones(3, dtype=bool), red_black=True)
    sweeper.sweep(1.0, 1)
    np.testing.assert_array_equal(sweeper.gap(), [1.0, 1.5, 1.0])


def test_runs_by_hand():
    mask = np.array([[True, False, True, True], [False, False, False, False], [True, True, True, True]])
    np.testing.assert_array_equal(Layout(mask).runs, [[1, 1, 2, 0, 1], [1, 3, 5, 1, 1], [3, 1, 5, 3, 1]])
    supported = np.array([[True, False, True, False], [False] * 4, [True, False, False, True]])
    kinds = [[1, 1, 2, 0, 1], [1, 3, 4, 1, 1], [1, 4, 5, 2, 0], [3, 1, 2, 3, 1], [3, 2, 4, 4, 0], [3, 4, 5, 6, 1]]
    np.testing.assert_array_equal(Layout(mask, supported.astype(np.uint8)).runs, kinds)
    np.testing.assert_array_equal(Layout(mask).row_start, [0, 0, 2, 2, 3, 3])


@given(
    mask=lattice_masks(), beta=st.floats(0.1, 1.9), seed=st.integers(0, 999), red_black=st.booleans(),
    across=st.sampled_from([1.0, 0.25]), sweeps=st.integers(1, 4),
)  # fmt: skip
def test_lattice_sweeps_match_their_twin(mask, beta, seed, red_black, across, sweeps):
    rng = np.random.default_rng(seed)
    stencil = Stencil(mask, across, 1.0)
    q, supported = rng.normal(size=stencil.size), rng.uniform(size=stencil.size) < 0.8
    start = np.abs(rng.normal(size=stencil.size))
    sweeper = LatticeSweeper(stencil, q, supported, start, red_black=red_black)
    matrix, twin = stencil.tocsr().toarray(), start.copy()
    rows, columns = np.nonzero(mask)
    colour = (rows + columns) % 2
    order = np.argsort(colour, kind="stable") if red_black else np.arange(stencil.size)
    count, step = sweeper.sweep(beta, sweeps)
    for _ in range(sweeps):
        twin_step = twin_sweep(matrix, q, supported, twin, beta, order)
    assert count == sweeps
    assert step == pytest.approx(twin_step, abs=1e-12)
    np.testing.assert_allclose(sweeper.gap(), twin, atol=1e-12)
    correction = (matrix @ twin + q) / np.diag(matrix)
    natural = np.where(supported, np.minimum(twin, 2 * correction), 2 * correction)
    assert sweeper.residual(2.0) == pytest.approx(np.abs(natural).max(), abs=1e-12)


@given(mask=lattice_masks(), beta=st.floats(0.1, 1.9), seed=st.integers(0, 999))
def test_sparse_sweeps_match_lattice_sweeps(mask, beta, seed):
    rng = np.random.default_rng(seed)
    stencil = Stencil(mask, 0.5, 1.0)
    q, supported = rng.normal(size=stencil.size), rng.uniform(size=stencil.size) < 0.8
    one = LatticeSweeper(stencil, q, supported)
    other = SparseSweeper(SparseStiffness(stencil.tocsr()), q, supported)
    assert one.sweep(beta, 3)[1] == pytest.approx(other.sweep(beta, 3)[1], abs=1e-12)
    np.testing.assert_allclose(one.gap(), other.gap(), atol=1e-12)
    assert one.residual(1.0) == pytest.approx(other.residual(1.0), abs=1e-12)


def test_sweeps_end_early_once_the_step_is_small():
    stencil = Stencil(np.ones((3, 3), dtype=bool), 1.0, 1.0)
    sweeper = LatticeSweeper(stencil, -np.ones(9), np.ones(9, dtype=bool))
    count, step = sweeper.sweep(1.0, 1000, small=1e-6)
    assert count < 100
    assert step < 1e-6
    other = SparseSweeper(SparseStiffness(stencil.tocsr()), -np.ones(9), np.ones(9, dtype=bool))
    assert other.sweep(1.0, 1000, small=1e-6)[0] == count


@pytest.mark.parametrize("nodes", [15, 31, 63])
def test_the_adaptive_factor_approaches_youngs(nodes):
    """Without contact μ = cos(πh), so the best factor is 2/(1 + sin(πh)) (Young 1971, ch. 6)."""
    lattice = cq.Lattice.from_mask(np.ones((nodes, nodes), dtype=bool), 1 / (nodes + 1))
    solution = cq.solve(cq.Membrane(lattice, 1.0, 1.0, np.inf), "psor", history=True)
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


def dense_jacobi(free, across, along):
    """The assembled Jacobi matrix of the free nodes."""
    number = np.full(np.add(free.shape, 2), -1)
    number[1:-1, 1:-1][free] = np.arange(free.sum())
    matrix = np.zeros((free.sum(), free.sum()))
    for (i, j), weight in (((0, 1), across), ((1, 0), along)):
        one, other = number[1:-1, 1:-1], number[1 + i : number.shape[0] - 1 + i, 1 + j : number.shape[1] - 1 + j]
        both = (one >= 0) & (other >= 0)
        matrix[one[both], other[both]] = matrix[other[both], one[both]] = weight
    return matrix


def dense_radius(free, across, along):
    """The twin: the spectral radius of the assembled matrix."""
    return np.abs(np.linalg.eigvalsh(dense_jacobi(free, across, along))).max()


@given(mask=lattice_masks(), weights=st.sampled_from([(0.25, 0.25), (0.4, 0.1), (0.5, 0.0), (0.0, 0.5)]))
def test_the_jacobi_radius_is_never_overestimated(mask, weights):
    estimate = jacobi_radius(mask, *weights)
    radius = dense_radius(mask, *weights)
    assert estimate.mu <= radius + 1e-12
    assert estimate.products <= MOST_WORK * mask.size


@pytest.mark.parametrize("name", ["square", "disk", "channel", "two parts", "line", "anisotropic"])
def test_the_jacobi_radius_gives_youngs_factor_for_little_work(name):
    """2 - β, by which sweeps are counted, is right to about a tenth, and no estimate takes more than a few sweeps."""
    y, x = np.mgrid[-1:1:50j, -1:1:50j]
    masks = {
        "disk": x**2 + y**2 < 1,
        "channel": np.abs(x - y) < 0.3,
        "two parts": (np.abs(x + 0.5) < 0.3) | (np.abs(x - 0.6) < 0.25),
        "line": np.ones((1, 300), dtype=bool),
    }
    free = masks.get(name, np.ones((50, 50), dtype=bool))
    weights = {"anisotropic": (0.45, 0.05), "line": (0.5, 0.0)}.get(name, (0.25, 0.25))
    estimate = jacobi_radius(free, *weights)
    ratio = (2 - young(estimate.mu)) / (2 - young(dense_radius(free, *weights)))
    assert 1 - 1e-9 <= ratio <= 1.15
    assert estimate.products <= 5 * free.sum()


def interpolation(length, block):
    """The twin, along one axis: the matrix from values in the middles of blocks, zero beyond the ends, to points."""
    if block == 1:
        return np.eye(length)
    blocks = -(-length // 2)
    middles = 2 * np.arange(-1, blocks + 1) + 0.5
    values = [np.interp(np.arange(length), middles, unit) for unit in np.eye(blocks + 2)[1:-1]]
    return np.transpose(values)


@given(mask=lattice_masks(), high=st.integers(1, 2), wide=st.integers(1, 2), seed=st.integers(0, 999))
def test_interpolation_matches_its_twin(mask, high, wide, seed):
    coarse = np.random.default_rng(seed).normal(size=(-(-mask.shape[0] // high), -(-mask.shape[1] // wide)))
    twin = interpolation(mask.shape[0], high) @ coarse @ interpolation(mask.shape[1], wide).T
    net = np.pad(mask, 1)
    fine = np.zeros(net.shape)
    squares = spectral_kernels.prolong(np.pad(coarse, 1), high, wide, net, fine)
    np.testing.assert_allclose(fine, np.pad(np.abs(twin) * mask, 1), atol=1e-14)
    assert squares == pytest.approx(np.sum((twin * mask) ** 2))


@given(mask=lattice_masks(), across=st.booleans(), along=st.booleans())
def test_points_of_coarser_nets_have_three_quarters_of_their_nodes(mask, across, along):
    net = NodeGrid(np.pad(mask, 1))
    coarser = net.coarser(across, along)
    high, wide = net.block
    shape = (-(-mask.shape[0] // high), -(-mask.shape[1] // wide))
    blocks = np.zeros((shape[0] * high, shape[1] * wide))
    blocks[: mask.shape[0], : mask.shape[1]] = mask
    share = blocks.reshape(shape[0], high, shape[1], wide).mean(axis=(1, 3))
    np.testing.assert_array_equal(coarser.mask, np.pad(share >= 0.75, 1))
    assert coarser.nodes == coarser.mask.sum()


@given(mask=lattice_masks(), weights=st.sampled_from([(0.25, 0.25), (0.4, 0.1)]), seed=st.integers(0, 999))
def test_a_lanczos_step_matches_its_twin(mask, weights, seed):
    rng = np.random.default_rng(seed)
    net = np.pad(mask, 1)
    vector, before, product = np.zeros((3, *net.shape))
    vector[net], before[net] = rng.normal(size=(2, mask.sum()))
    scale, back = 1 / np.linalg.norm(vector), rng.uniform()
    unit = scale * vector[net]
    image = dense_jacobi(mask, *weights) @ unit
    lines = (grid.ravel() for grid in (vector, before, product))
    diagonal, length = spectral_kernels.lanczos_step(net.ravel(), net.shape[1], *lines, *weights, scale, back)
    twin = image - (unit @ image) * unit - back * before[net]
    assert diagonal == pytest.approx(unit @ image, abs=1e-14)
    assert length == pytest.approx(np.linalg.norm(twin))
    np.testing.assert_allclose(product[net], twin, atol=1e-14)
    np.testing.assert_array_equal(product[~net], 0)


@given(size=st.integers(1, 40), seed=st.integers(0, 999))
def test_the_largest_eigenpair_matches_its_twin(size, seed):
    rng = np.random.default_rng(seed)
    diagonal, beside = rng.normal(size=size), rng.uniform(0.01, 1, size=size)
    matrix = np.diag(diagonal) + np.diag(beside[:-1], 1) + np.diag(beside[:-1], -1)
    values = np.linalg.eigvalsh(matrix)
    value, vector = largest_eigenpair(diagonal.tolist(), beside[:-1].tolist())
    assert value == pytest.approx(values[-1], abs=1e-13)
    np.testing.assert_allclose(matrix @ vector, value * vector, atol=1e-12)
    assert np.linalg.norm(vector) == pytest.approx(1)
    assert (vector > 0).all()


def twin_lanczos(matrix, start, fewest, most, ratio):
    """Ritz values in a basis that is made orthogonal twice; the number of steps, the last value and its vector."""
    basis = start[:, None] / np.linalg.norm(start)
    while True:
        values, vectors = np.linalg.eigh(basis.T @ matrix @ basis)
        steps, mu = basis.shape[1], values[-1]
        new = matrix @ basis[:, -1]
        for _ in range(2):
            new = new - basis @ (basis.T @ new)
        enough = max(fewest, ratio / np.sqrt(max(1 - mu, 1e-12)))
        if steps >= min(most, enough) or np.linalg.norm(new) <= 1e-10:
            return steps, mu, basis @ vectors[:, -1]
        basis = np.column_stack([basis, new / np.linalg.norm(new)])


@pytest.mark.parametrize("weights", [(0.25, 0.25), (0.4, 0.1), (0.5, 0.0)])
@pytest.mark.parametrize(("fewest", "most"), [(3, 40), (2, 2), (1, 1), (12, 12)])
def test_lanczos_steps_match_their_twin(weights, fewest, most):
    y, x = np.mgrid[-1:1:23j, -1:1:31j]
    for mask in (x**2 + y**2 < 0.9, np.abs(x - y) < 0.4, np.abs(x) > 0.3):
        net = NodeGrid(np.pad(mask, 1))
        start = net.ones()
        start[net.mask] = np.random.default_rng(7).uniform(0.5, 2, size=mask.sum())
        steps, mu, vector = twin_lanczos(dense_jacobi(mask, *weights), start[net.mask], fewest, most, 1.6)
        value = (pytest.approx(mu, abs=1e-13), steps)
        assert net.lanczos(start, *weights, fewest, most, with_vector=False)[:2] == value
        *found, ritz = net.lanczos(start, *weights, fewest, most)
        assert tuple(found) == value
        np.testing.assert_allclose(ritz[net.mask], vector * np.sign(vector.sum()), atol=1e-10)
        np.testing.assert_array_equal(ritz[~net.mask], 0)
        assert net.moment(ritz, *weights) == pytest.approx(mu, abs=1e-13)


def test_lanczos_steps_end_with_the_krylov_space():
    """Ones on a ring of four nodes are an eigenvector: each node has two neighbours."""
    net = NodeGrid(np.pad(np.ones((2, 2), dtype=bool), 1))
    mu, steps, ritz = net.lanczos(3 * net.ones(), 0.25, 0.25, 3, 40)
    assert (mu, steps) == (pytest.approx(0.5, abs=1e-15), 1)
    np.testing.assert_allclose(ritz, 0.5 * net.ones())


def test_no_free_node_or_a_single_one_has_no_coupling():
    single = np.zeros((9, 9), dtype=bool)
    assert jacobi_radius(single, 0.25, 0.25).mu == 0.0
    single[4, 4] = True
    assert jacobi_radius(single, 0.25, 0.25).mu == 0.0


def test_when_an_estimate_is_due():
    relaxation = FreeSetRelaxation()
    for _ in range(8):
        assert not relaxation.due(100)
        relaxation.observe(1.0)
    assert not relaxation.due(0)
    assert relaxation.due(100)
    relaxation.estimate(FreeNodes(np.ones((10, 10), dtype=bool), 0.25, 0.25))
    for _ in range(20):
        relaxation.observe(1.0)
    assert not relaxation.due(119)
    assert relaxation.patient  # and looks again later
    for _ in range(3):
        relaxation.observe(1.0)
    assert relaxation.due(121)  # the free set has grown
    decided = relaxation.beta
    for sweep in range(20):
        relaxation.observe(0.99**sweep)  # as if μ were larger
    assert 2 - relaxation.beta == pytest.approx(0.82 * (2 - decided))
    assert relaxation.due(101)
    assert not relaxation.due(100)  # the same nodes would give the same estimate
    relaxation.observe(0.5, noise=1.0)
    assert not relaxation.due(1000)  # what rounding moves is no free set


def test_the_free_nodes_of_a_sweeper():
    stencil = Stencil(np.array([[True, True, False, True]]), 1.0, 1.0)
    sweeper = LatticeSweeper(stencil, np.array([-4.0, 4.0, 4.0]), np.array([True, True, False]))
    sweeper.sweep(1.0, 1)
    np.testing.assert_array_equal(sweeper.free().mask[1], [False, True, False, False, True, False])
    assert SparseSweeper(SparseStiffness(stencil.tocsr()), np.zeros(3), np.ones(3, dtype=bool)).free() is None
