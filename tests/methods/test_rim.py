"""What holds coarse lattices beside a frame that cuts their arms, against hand-computed arms and a plain-numpy twin."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import lattice_masks

from contactqp.methods.multigrid.rim_kernels import hold_coarse_rim

SIDES = (0, -1), (0, 1), (-1, 0), (1, 0)


def held_by(mask, ground, coarse, across, along, down, right):
    held = np.zeros(coarse.shape)
    hold_coarse_rim(mask, ground, coarse, held, across, along, down, right)
    return held


def test_three_nodes_in_a_row_by_hand():
    """The middle one stays: its arms are 1 and 1 + 3/3 in series, 1 and 1 + 1/3 in series, each less 1/2."""
    mask, coarse = np.ones((1, 3), dtype=bool), np.ones((1, 1), dtype=bool)
    held = held_by(mask, np.array([[3.0, 0.0, 1.0]]), coarse, 1.0, 1.0, 1, 2)
    np.testing.assert_allclose(held, [[(2 / 3 - 1 / 2) + (4 / 7 - 1 / 2)]], rtol=1e-15)


def test_arms_that_end_beside_a_coarse_node_by_hand():
    """A node alone: each of its four arms is 1 + 2/4, and stands for two; what is equal between two nodes is 1."""
    mask = np.zeros((3, 3), dtype=bool)
    mask[1, 1] = True
    held = held_by(mask, np.where(mask, 2.0, 0.0), np.ones((1, 1), dtype=bool), 1.0, 1.0, 2, 2)
    np.testing.assert_allclose(held, [[4 * (2 * 1.5 - 1)]], rtol=1e-15)


@settings(max_examples=50)
@given(
    mask=lattice_masks(9, 9), seed=st.integers(0, 999), factors=st.sampled_from([(2, 2), (2, 1), (1, 2)]),
    arms=st.sampled_from([(1.0, 1.0), (1.0, 0.25), (0.0, 1.0)]),
)  # fmt: skip
def test_the_pass_over_the_rim_matches_its_twin(mask, seed, factors, arms):
    (down, right), (along_rows, along_columns) = factors, arms
    rows, columns = mask.shape[0] // down, mask.shape[1] // right
    coarse = np.ascontiguousarray(mask[down - 1 :: down, right - 1 :: right][:rows, :columns])
    beside = mask & ~np.logical_and.reduce([shifted(mask, *side) for side in SIDES])
    ground = np.where(beside, np.random.default_rng(seed).uniform(0, 3, mask.shape), 0.0)
    each = ground / np.maximum(1, sum((~shifted(mask, *side)).astype(int) for side in SIDES))
    expected = np.zeros(coarse.shape)
    own = np.ix_(down * np.arange(1, rows + 1) - 1, right * np.arange(1, columns + 1) - 1)
    for up, beside_it in SIDES:
        arm, joined, lines = (along_rows, right, down) if beside_it else (along_columns, down, right)
        first = arm + each
        both = (
            first
            if joined == 1
            else np.where(shifted(mask, up, beside_it), series(arm, shifted(first, up, beside_it)), first)
        )
        ends = coarse & ~shifted(coarse, up, beside_it)
        expected += np.where(ends, np.maximum(lines * (both[own] - arm / joined), 0.0), 0.0)
    np.testing.assert_allclose(
        held_by(mask, ground, coarse, along_rows, along_columns, down, right), expected, rtol=1e-13, atol=1e-15
    )


def series(arm, beyond):
    return arm * (beyond / (arm + beyond)) if arm > 0 else beyond


def shifted(grid, up, right):
    """What each point's neighbour has; nothing outside the array."""
    rows, columns = grid.shape
    return np.pad(grid, 1)[1 + up : 1 + up + rows, 1 + right : 1 + right + columns]
