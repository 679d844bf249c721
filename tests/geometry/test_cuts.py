"""Where contours cut the arms of a lattice."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import contactqp as cq
from contactqp.geometry.cuts import LEAST


def on_disk(lattice, radius=1.0, center=(0.0, 0.0)):
    x, y = lattice.frame_places
    return np.hypot(x - center[0], y - center[1]) - radius


def test_a_diamond_by_hand():
    """|x| + |y| < 1.25 with spacing 1 has five nodes, and all arms to the frame are a quarter long."""
    diamond = cq.Frame.polygon([(1.25, 0), (0, 1.25), (-1.25, 0), (0, -1.25)])
    lattice = diamond.lattice(1.0, (0.0, 0.0), fitted=True)
    assert lattice.size == 5
    np.testing.assert_allclose(lattice.frame_arms.length, 0.25, atol=1e-12)
    x, y = lattice.frame_places
    np.testing.assert_allclose(np.abs(x) + np.abs(y), 1.25, atol=1e-12)
    assert lattice.overshoot == 0.0
    assert lattice.caution == ""
    assert "fitted to its contour" in repr(lattice)


@given(st.floats(0.05, 0.4), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_arms_end_on_a_circle(spacing, x, y):
    lattice = cq.Frame.disk(1.0, center=(x, y)).lattice(spacing, (0.0, 0.0), fitted=True)
    lengths = lattice.frame_arms.length
    cut = lengths < 1
    assert (lengths >= LEAST).all()
    # Where a node next to the circle has come to the frame, its neighbours' arms end there.
    assert np.abs(on_disk(lattice, center=(x, y))[cut]).max() < 1e-11
    assert (on_disk(lattice, center=(x, y))[~cut] > -LEAST * spacing).all()


def test_a_frame_that_lies_on_the_lattice_cuts_nothing():
    hexagon = cq.Frame.polygon([(0, 0), (4, 0), (4, 2), (2, 4), (0, 4)])
    for frame in (cq.Frame.rectangle(2, 1), cq.Frame.rectangle(3, 3) - cq.Frame.rectangle(1, 1), hexagon):
        fitted, plain = frame.lattice(0.5, fitted=True), frame.lattice(0.5)
        np.testing.assert_array_equal(fitted.mask, plain.mask)
        assert (fitted.frame_arms.length == 1).all()


def test_the_hexagons_diagonal_sides():
    """Side 1, spacing 1/4: 60° sides leave along x at whole and half spacings, the flat ones at √3/2."""
    lattice = cq.Frame.hexagon(1.0).lattice(0.25, (0.0, 0.0), fitted=True)
    x, y = lattice.frame_places
    along = lattice.frame_arms.along_x
    np.testing.assert_allclose(np.abs(x[along]) + np.abs(y[along]) / np.sqrt(3), 1.0, atol=1e-12)
    flat = ~along & (np.abs(x) <= 0.5)
    np.testing.assert_allclose(np.abs(y[flat]), np.sqrt(3) / 2, atol=1e-12)


def test_holes_and_several_parts():
    ring = cq.Frame.disk(1.0) - cq.Frame.disk(0.35)
    lattice = (ring | cq.Frame.disk(0.5, center=(3.0, 0.2))).lattice(0.1, (0.0, 0.0), fitted=True)
    assert lattice.parts == 2
    x, y = lattice.frame_places
    distance = np.minimum(
        np.minimum(np.abs(np.hypot(x, y) - 1), np.abs(np.hypot(x, y) - 0.35)), np.abs(np.hypot(x - 3, y - 0.2) - 0.5)
    )
    # The parts of a joined frame are polygons of 256 sides each, as shapely has them.
    assert distance.max() < 1e-4


def test_a_node_next_to_the_contour_belongs_to_the_frame():
    """Of half the width 1.0005 the outermost node lies 0.0005 from the contour; of 1.01 it has an arm of 0.01."""
    near = cq.Frame.rectangle(2.001, 2.001).lattice(1.0, (0.0, 0.0), fitted=True)
    assert near.size == 1
    assert (near.frame_arms.length == 1).all()
    far = cq.Frame.rectangle(2.02, 2.02).lattice(1.0, (0.0, 0.0), fitted=True)
    assert far.size == 9
    np.testing.assert_allclose(far.frame_arms.length, 0.01, atol=1e-9)


def test_nothing_left_is_refused():
    with pytest.raises(ValueError, match="next to the contour"):
        cq.Frame.rectangle(0.0015, 0.0015).lattice(1.0, (0.0, 0.0), fitted=True)


def test_a_fitted_lattice_warns_of_no_growth(recwarn):
    cq.Frame.disk(1.0).lattice(0.3, fitted=True)
    assert not recwarn.list


def test_a_net_does_not_take_it():
    with pytest.raises(ValueError, match="without fitted=True"):
        cq.CableNet.orthogonal(cq.Frame.disk(1.0).lattice(0.3, fitted=True), 1.0, load=1.0, support=1.0)


def test_arguments():
    with pytest.raises(TypeError, match="fitted"):
        cq.Frame.disk(1.0).lattice(0.3, fitted="yes")
