"""What a spline is continued by beyond the rim, on squares by hand and on corners that point inwards."""

import numpy as np
import pytest

import contactqp as cq
from contactqp.continuum.cells import Cells
from contactqp.continuum.ghosts import Continuation


def bends(values):
    """Return second differences along rows and columns at the points."""
    return np.diff(values, n=2, axis=1)[1:-1], np.diff(values, n=2, axis=0)[:, 1:-1]


@pytest.mark.parametrize("corner", ["less", "more"])
def test_a_parabola_goes_on_as_one(corner):
    cells = Cells(np.ones((3, 4), dtype=bool), 1.0)
    row, column = np.indices((7, 8))
    parabola = 2.0 * row**2 + column**2 - row * column
    found = Continuation(cells)(parabola[1:-1, 1:-1], np.full((5, 6), 6.0), corner)
    np.testing.assert_allclose(found, parabola, atol=1e-12)


@pytest.mark.parametrize("corner", ["less", "more"])
@pytest.mark.parametrize(
    "corners",
    [
        [(4, 0), (0, 4), (-4, 0), (0, -4)],
        [(0, 0), (6, 0), (6, 4), (4, 6), (0, 6)],
        [(0, 0), (8, 0), (8, 8), (6, 8), (4, 6), (2, 8), (0, 8)],
    ],
    ids=["diamond", "pentagon", "notch"],
)
def test_across_diagonals_too(corners, corner):
    lattice = cq.Frame.polygon(corners).lattice(1.0)
    cells = Cells(lattice.mask, 1.0, lattice.halved)
    row, column = np.indices(np.array(cells.nodes.shape) + 2)
    parabola = 1000.0 + 2.0 * row**2 + column**2 - row * column
    found = Continuation(cells)(parabola[1:-1, 1:-1], np.full(cells.nodes.shape, 6.0), corner)
    reached = found != 0
    np.testing.assert_allclose(found[reached], parabola[reached], atol=1e-9)
    for down in range(4):
        for right in range(4):
            assert reached[down:, right:][: cells.inside.shape[0], : cells.inside.shape[1]][cells.inside].all()


def test_corners_bend_as_little_or_as_much_as_can_be():
    """On a frame at height zero under a load of 1 the second differences along the sides are zero, across them 1."""
    cells = Cells(np.ones((3, 3), dtype=bool), 1.0)
    values = np.pad(-np.ones((3, 3)), 1)
    continuation = Continuation(cells)
    less, more = (continuation(values, np.ones((5, 5)), corner) for corner in ("less", "more"))
    for found, at_corner in ((less, 0.0), (more, 2.0)):
        along, across = bends(found)
        np.testing.assert_allclose(across[0, 1:-1], 1.0)
        np.testing.assert_allclose(along[1:-1, -1], 1.0)
        assert along[0, 0] + across[0, 0] == pytest.approx(at_corner)
        np.testing.assert_allclose(found, found.T)
        np.testing.assert_allclose(found, found[::-1])
    assert less[0, 0] == pytest.approx(-1.0)  # as the value across the corner, but for the load


def test_beyond_a_corner_that_points_inwards_both_sides_have_a_say():
    mask = np.ones((4, 4), dtype=bool)
    mask[:2, :2] = False
    values = np.where(np.pad(mask, 1), -1.0, 0.0)
    found = Continuation(Cells(mask, 1.0))(values, np.zeros((6, 6)), "less")
    assert found[2, 2] == pytest.approx(1.0)  # beyond both sides, mirrored with the other sign
    assert np.isfinite(found).all()
    assert not found[:2, :2].any()  # where no cell reaches


def test_regions_of_one_node_have_nothing_to_go_by():
    found = Continuation(Cells(np.ones((1, 1), dtype=bool), 1.0))(np.pad([[-1.0]], 1), np.ones((3, 3)), "more")
    assert found.shape == (5, 5)
    assert np.isfinite(found).all()
