import numpy as np
import pytest
from hypothesis import given
from strategies import lattice_masks

import contactqp as cq
from contactqp.algebra.stencil import Stencil

MASK = np.array([[True, False, True], [True, True, True]])


def test_nodes_are_numbered_row_by_row_with_x_ascending():
    lattice = cq.Lattice.from_mask(MASK, spacing=2.0, origin=(10.0, 20.0))
    assert lattice.size == 5
    np.testing.assert_array_equal(lattice.node_x, [10, 14, 10, 12, 14])
    np.testing.assert_array_equal(lattice.node_y, [20, 20, 22, 22, 22])
    assert lattice.describe(3) == "node 3 (x=12, y=22)"
    assert repr(lattice) == "Lattice(5 nodes in 2 x 3, spacing=2)"


def test_scatter_and_gather_are_inverse():
    lattice = cq.Lattice.from_mask(MASK, spacing=1.0)
    grid = lattice.scatter([1.0, 2.0, 3.0, 4.0, 5.0])
    assert np.isnan(grid[0, 1])
    np.testing.assert_array_equal(lattice.gather(grid), [1, 2, 3, 4, 5])


def test_the_mask_is_copied_and_frozen():
    mask = MASK.copy()
    lattice = cq.Lattice.from_mask(mask, spacing=1.0)
    mask[:] = False
    assert lattice.mask.sum() == 5
    with pytest.raises(ValueError, match="read-only"):
        lattice.mask[0, 0] = False


def test_bad_lattices_say_what_is_wrong():
    with pytest.raises(ValueError, match="holds no node"):
        cq.Lattice.from_mask(np.zeros((2, 2), dtype=bool), spacing=1.0)
    with pytest.raises(TypeError, match="mask must be boolean"):
        cq.Lattice.from_mask(np.ones((2, 2)), spacing=1.0)
    with pytest.raises(ValueError, match="two-dimensional"):
        cq.Lattice.from_mask(np.ones(3, dtype=bool), spacing=1.0)
    with pytest.raises(ValueError, match="spacing must be > 0, got -1"):
        cq.Lattice.from_mask(MASK, spacing=-1.0)
    with pytest.raises(ValueError, match=r"shape \(5,\), got \(4,\)"):
        cq.Lattice.from_mask(MASK, 1.0).scatter(np.ones(4))
    with pytest.raises(ValueError, match="lattice's shape"):
        cq.Lattice.from_mask(MASK, 1.0).gather(np.ones((3, 2)))


def dense_stencil(mask, horizontal, vertical):
    """G arm by arm: the twin of `Stencil`, one node at a time."""
    number = {(i, j): k for k, (i, j) in enumerate(zip(*np.nonzero(mask), strict=True))}
    matrix = np.zeros((len(number), len(number)))
    for (i, j), k in number.items():
        arms = [
            ((i, j - 1), horizontal[i, j]),
            ((i, j + 1), horizontal[i, j + 1]),
            ((i - 1, j), vertical[i, j]),
            ((i + 1, j), vertical[i + 1, j]),
        ]
        matrix[k, k] = sum(weight for _, weight in arms)
        for neighbour, weight in arms:
            if neighbour in number:
                matrix[k, number[neighbour]] -= weight
    return matrix


@given(mask=lattice_masks())
def test_stencil_matches_the_arm_by_arm_matrix(mask):
    rng = np.random.default_rng(mask.size)
    rows, columns = mask.shape
    horizontal = rng.integers(1, 9, (rows, columns + 1)).astype(float)
    vertical = rng.integers(1, 9, (rows + 1, columns)).astype(float)
    stencil = Stencil(mask, horizontal, vertical)
    expected = dense_stencil(mask, horizontal, vertical)
    matrix = stencil.tocsr()
    np.testing.assert_array_equal(matrix.toarray(), expected)
    assert matrix.has_sorted_indices
    assert stencil.nonzeros == matrix.nnz
    vector = rng.integers(-5, 5, stencil.size).astype(float)
    np.testing.assert_array_equal(stencil.matvec(vector), expected @ vector)
    np.testing.assert_array_equal(stencil.diagonal(), np.diag(expected))
    np.testing.assert_array_equal(stencil.scaled(2.0).tocsr().toarray(), 2 * expected)


@given(mask=lattice_masks())
def test_a_uniform_stencil_is_the_special_case_of_equal_arms(mask):
    rows, columns = mask.shape
    uniform = Stencil(mask, 3.0, 2.0)
    varying = Stencil(mask, np.full((rows, columns + 1), 3.0), np.full((rows + 1, columns), 2.0))
    assert uniform.uniform
    assert not varying.uniform
    np.testing.assert_array_equal(uniform.tocsr().toarray(), varying.tocsr().toarray())
    vector = np.arange(uniform.size, dtype=float)
    np.testing.assert_array_equal(uniform.matvec(vector), varying.matvec(vector))


def test_the_matrix_of_the_paper():
    """Eqs. (2.7), (2.8): blocks M = tridiag(-1, 4, -1), and -I beside them, times T."""
    lattice = cq.Lattice.from_mask(np.ones((3, 4), dtype=bool), spacing=0.5)
    matrix = cq.Membrane(lattice, tension=7.0, load=0.0, support=1.0).problem.G.toarray() / 7.0
    block = 4 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1)
    np.testing.assert_array_equal(
        matrix, np.kron(np.eye(3), block) - np.kron(np.eye(3, k=1) + np.eye(3, k=-1), np.eye(4))
    )


def test_frame_points_and_pull():
    stencil = Stencil(np.array([[True, True]]), 2.0, 3.0)
    expected = np.array([[0, 1, 1, 0], [1, 0, 0, 1], [0, 1, 1, 0]], dtype=bool)
    np.testing.assert_array_equal(stencil.frame_points(), expected)
    height = np.array([[0, 10, 20, 0], [1, 0, 0, 2], [0, 30, 40, 0.0]])
    np.testing.assert_array_equal(stencil.pull(height), [-(2 * 1 + 3 * 40), -(2 * 2 + 3 * 60)])
    height[1, 1:3] = [5.0, 7.0]
    np.testing.assert_array_equal(
        stencil.pull(height), stencil.matvec(np.array([5.0, 7.0])) - [2 * 1 + 3 * 40, 2 * 2 + 3 * 60]
    )
    np.testing.assert_array_equal(stencil.pull(height + 2.0**40), stencil.pull(height))
    flat = Stencil(np.array([[True, True]]), 2.0, 0.0)
    assert flat.frame_points().sum() == 2


def test_bad_stencils_say_what_is_wrong():
    mask = np.ones((2, 2), dtype=bool)
    with pytest.raises(ValueError, match=r"horizontal must be a number or have shape \(2, 3\)"):
        Stencil(mask, np.ones((2, 2)), 1.0)
    with pytest.raises(ValueError, match="finite and >= 0"):
        Stencil(mask, -1.0, 1.0)
    with pytest.raises(ValueError, match="at least one arm"):
        Stencil(mask, 0.0, 0.0)
    with pytest.raises(ValueError, match="two-dimensional boolean array"):
        Stencil([[1, 0]], 1.0, 1.0)
    with pytest.raises(ValueError, match="two-dimensional boolean array"):
        Stencil(np.zeros((2, 2), dtype=bool), 1.0, 1.0)


def test_parts_that_hang_on_nothing_are_refused():
    with pytest.raises(ValueError, match="no arm to the frame, among them that of node 0"):
        Stencil(np.ones((1, 2), dtype=bool), np.array([[0.0, 1.0, 0.0]]), 0.0)
    with pytest.raises(ValueError, match=r"1 part\(s\) have no arm"):
        Stencil(np.ones((1, 4), dtype=bool), np.array([[0.0, 1.0, 0.0, 1.0, 1.0]]), 0.0)
    held = Stencil(np.ones((1, 4), dtype=bool), np.array([[1.0, 1.0, 0.0, 1.0, 1.0]]), 0.0)
    assert cq.ContactQP(held, -np.ones(4)).is_m_matrix


def test_a_million_nodes_are_assembled_without_a_loop():
    lattice = cq.Lattice.from_mask(np.ones((1000, 1000), dtype=bool), spacing=1.0)
    matrix = Stencil(lattice.mask, 1.0, 1.0).tocsr()
    assert matrix.shape == (10**6, 10**6)
    assert matrix.nnz == 5 * 10**6 - 4 * 1000
    assert matrix.indices.dtype == np.int32
