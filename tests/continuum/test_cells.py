"""Regions along lattice lines and diagonals: rectangles, corners that point inwards, holes; and what is refused."""

import numpy as np
import pytest

import contactqp as cq
from contactqp.continuum.cells import Cells, largest_at_corners


def test_a_rectangle():
    cells = Cells(np.ones((2, 4), dtype=bool), 0.5)
    assert cells.inside.all()
    assert cells.convex
    assert cells.strip == (0, 0, 3)
    level, upright, *slanted = cells.rim
    assert (level.step, upright.step) == ((0, 1), (1, 0))
    np.testing.assert_array_equal(level[:2], [[0] * 5 + [3] * 5, [*range(5)] * 2])
    np.testing.assert_array_equal(upright[:2], [[0, 0, 1, 1, 2, 2], [0, 5] * 3])
    assert not any(edges.row.size for edges in slanted)


def test_a_corner_that_points_inwards():
    mask = np.ones((4, 5), dtype=bool)
    mask[:2, :2] = False
    cells = Cells(mask, 0.5)
    assert not cells.convex
    assert cells.inside.sum() == 5 * 6 - 4
    assert np.transpose(cells.inward_corners).tolist() == [[2, 2]]
    assert cells.closure.sum() == 6 * 7 - 4
    assert sum(edges.row.size for edges in cells.rim) == 22


def test_a_hole():
    mask = np.ones((7, 7), dtype=bool)
    mask[2:5, 2:5] = False
    cells = Cells(mask, 1.0)
    assert cells.inside.sum() == 64 - 4
    assert cells.rim[0].row.size == 8 + 8 + 2 + 2


def laid(corners, spacing=1.0):
    lattice = cq.Frame.polygon(corners).lattice(spacing)
    return Cells(lattice.mask, spacing, lattice.halved)


def test_a_square_on_its_corner():
    cells = laid([(3, 0), (0, 3), (-3, 0), (0, -3)])
    assert cells.nodes.sum() == 13
    assert cells.whole.sum() == 12
    assert cells.shares.sum() == 18.0
    assert cells.closure.sum() == 25
    assert cells.corners.sum() == 25 + 12
    assert [edges.row.size for edges in cells.rim] == [0, 0, 6, 6]
    for edges in cells.rim:
        for end in edges.ends:
            assert (cells.closure & ~cells.nodes)[end].all()
    assert cells.convex
    assert cells.strip == (0, 1, 6)


def test_slanted_and_straight_sides_with_an_inward_corner_between():
    cells = laid([(0, 0), (4, 0), (4, 4), (3, 4), (2, 3), (1, 4), (0, 4)])
    assert cells.shares.sum() == 15.0
    assert not cells.convex
    assert cells.inward_corners[0].size == 1
    assert [edges.row.size for edges in cells.rim] == [4 + 2, 8, 1, 1]


def test_half_cells_have_one_node():
    halved = np.zeros((3, 3), dtype=bool)
    halved[1, 1] = True
    with pytest.raises(ValueError, match="have one node each"):
        Cells(np.ones((2, 2), dtype=bool), 1.0, halved)


@pytest.mark.parametrize(
    ("rows", "where"),
    [
        (["111", "101", "111"], "at row 1, column 1"),  # a pin
        (["11111", "10001", "11111"], "at row 1, column 1"),  # a slit
        (["111", "000", "111"], ""),  # a wall without thickness
        (["101"], ""),
    ],
)
def test_frames_within_the_region_are_refused(rows, where):
    mask = np.array([[mark == "1" for mark in row] for row in rows])
    with pytest.raises(ValueError, match=f"has a pin, a slit or a passage without nodes {where}".strip()):
        Cells(mask, 1.0)


def test_the_largest_about_a_point():
    found = largest_at_corners(np.array([[1.0, 2.0], [0.0, 5.0]]))
    np.testing.assert_array_equal(found, [[1, 2, 2], [1, 5, 5], [0, 5, 5]])
