"""Contours on a lattice: their squares cover the region, however nearly its sides run along lines."""

import math

import numpy as np
import pytest
import shapely

import contactqp as cq
from contactqp.continuum.contour import Contour


@pytest.mark.parametrize("angle", [0.0, 1e-14, 1e-12, 1e-10, 1e-9, 3e-9, 1e-8, 1e-5, 0.3])
def test_squares_cover_regions_whose_sides_nearly_run_along_lines(angle):
    across, up = math.cos(angle), math.sin(angle)
    corners = [(across * x - up * y, up * x + across * y) for x, y in ((-1, -0.6), (1, -0.6), (1, 0.6), (-1, 0.6))]
    lattice = cq.Frame.polygon(corners).lattice(0.1, origin=(0.0, 0.0), fitted=True)
    contour = Contour.of(lattice, lattice.outline)
    # Points just within the sides, by more than places are rounded.
    corner = np.array(corners)
    along = np.linspace(0.0, 1.0, 2001)[1:-1, None]
    for start, end in zip(corner, np.roll(corner, -1, axis=0), strict=True):
        inwards = np.array([start[1] - end[1], end[0] - start[0]]) / np.hypot(*(end - start))
        x, y = (start + along * (end - start) + 1e-14 * inwards).T
        assert shapely.contains_xy(lattice.outline.geometry, x, y).all()
        column, row = ((at - first) / 0.1 for at, first in zip((x, y), contour.first, strict=True))
        # On a line to rounding either square will do.
        found = np.zeros(x.size, dtype=bool)
        for off in np.ndindex(2, 2):
            beside = [
                np.floor(at + (2 * part - 1) * 1e-13).astype(int) for at, part in zip((row, column), off, strict=True)
            ]
            found |= contour.inside[tuple(beside)]
        assert found.all()


def test_sides_along_lines_cut_no_squares():
    for center in ((0.0, 0.0), (0.3, 0.1), (1e5, -1e5)):
        lattice = cq.Frame.rectangle(2.0, 1.2, center=center).lattice(0.1, fitted=True)
        assert not Contour.of(lattice, lattice.outline).cut.any()
