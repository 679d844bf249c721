"""Outlines of frames, as lattices that are fitted to them keep them."""

import numpy as np
import pytest

import contactqp as cq


def test_lattices_that_are_fitted_know_their_contour():
    frame = cq.Frame.hexagon(1.0) - cq.Frame.disk(0.3)
    assert frame.lattice(0.125).outline is None
    outline = frame.lattice(0.125, fitted=True).outline
    assert len(outline.rings) == 2
    assert outline.geometry.area == pytest.approx(frame.area, rel=1e-3)
    x, y = np.array([0.0, 0.5, 0.9]), np.array([0.0, 0.1, 0.8])
    assert outline.holds(x, y).tolist() == [False, True, False]
    assert outline.nearly_holds(np.array([1.0]), np.array([1e-9]), 1e-6).all()


def test_frames_that_are_combined_keep_fine_chords():
    coarse, fine = ((cq.Frame.disk(1.0) | cq.Frame.rectangle(1, 3)).outline(h) for h in (0.2, 0.005))
    assert len(fine.rings[0]) > len(coarse.rings[0])
    assert coarse.sagitta == fine.sagitta == 0.0
    both = cq.Frame.disk(1.0).outline(0.01), (cq.Frame.disk(1.0) - cq.Frame.disk(0.2)).outline(0.01)
    assert 0.0 < both[0].sagitta <= both[1].sagitta < 1e-5


def test_corners_that_point_inwards_are_named():
    frame = cq.Frame.polygon([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)])
    assert frame.outline(0.1).inward_corners == [(1.0, 1.0)]
    hole = cq.Frame.rectangle(3, 3) - cq.Frame.rectangle(1, 1)
    assert len(hole.outline(0.1).inward_corners) == 4
