"""Functions about corners on a lattice: what is claimed of them in squares and along a contour, by dense samples."""

import numpy as np
import pytest
import shapely

import contactqp as cq
from contactqp.continuum.contour import Contour
from contactqp.continuum.corner_functions import corner_functions
from contactqp.continuum.corner_on_lattice import CornerOnLattice

SQUARE = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
FRAMES = {
    "hole at a corner": cq.Frame.polygon(SQUARE, [[(1.0, 1.0), (0.1, 0.5), (0.5, 0.1)]]),
    "parts at a corner": cq.Frame.from_shapely(
        shapely.MultiPolygon(
            [shapely.Polygon([(0, 0), (1, -0.5), (1.2, 0.6)]), shapely.Polygon([(0, 0), (-1, 0.5), (-1.1, -0.6)])]
        )
    ),
    "inward": cq.Frame.polygon([(-1, -1), (1, -1.1), (1.1, 0.03), (0.05, 0.03), (0.05, 1), (-1, 1)]),
}


def functions_on_lattice(frame, spacing):
    lattice = frame.lattice(spacing, fitted=True)
    contour = Contour.of(lattice, lattice.outline)
    return [CornerOnLattice(contour, function) for function in corner_functions(lattice.outline, spacing)]


@pytest.mark.parametrize("frame", FRAMES.values(), ids=FRAMES)
def test_functions_lie_beside_their_parabolas_by_no_more_than_is_claimed(frame):
    found = functions_on_lattice(frame, 0.11)
    assert found
    for one in found:
        contour, (parabola, off) = one.contour, one.along
        for t in np.concatenate([np.linspace(0.0, 1.0, 17), [1e-9, 1e-5, 1e-3]]):
            values = one.function(*contour.places((1.0 - t) * contour.start + t * contour.end))
            claimed = (1.0 - t) ** 2 * parabola[0] + 2.0 * t * (1.0 - t) * parabola[1] + t**2 * parabola[2]
            assert (np.abs(values - claimed) <= off).all()
        # Wherever other sides are, a function is known to be no larger than it is.
        assert off.max() <= 5.0 * one.function.size(0, np.array(0.0), np.array(4.0)).max()


@pytest.mark.parametrize("frame", FRAMES.values(), ids=FRAMES)
def test_functions_lie_beside_their_splines_by_no_more_than_is_claimed(frame):
    for one in functions_on_lattice(frame, 0.11):
        contour = one.contour
        row, column = np.nonzero(contour.inside & ~one.hidden)
        block = np.stack([[one.spline[row + i, column + j] for j in range(4)] for i in range(4)])
        for x in np.linspace(0.0, 1.0, 5):
            for y in np.linspace(0.0, 1.0, 5):
                value = np.einsum("i,j,ijk->k", cubic(y), cubic(x), block)
                place = (
                    contour.first[0] + contour.spacing * (column + x),
                    contour.first[1] + contour.spacing * (row + y),
                )
                assert (np.abs(one.function(*place) - value) <= one.beside[row, column]).all()


def cubic(t):
    """Weights of four coefficients in a cubic spline."""
    return np.array([(1 - t) ** 3, 4 - 6 * t**2 + 3 * t**3, 1 + 3 * t + 3 * t**2 - 3 * t**3, t**3]) / 6.0


def test_a_hole_that_touches_a_corner_is_no_reason_to_overflow():
    support = cq.Smooth(lambda x, y: 0.15 + 0.03 * np.cos(3 * x) * np.sin(4 * y), second_derivative=0.8)
    model = cq.Membrane(FRAMES["hole at a corner"].lattice(0.11, fitted=True), tension=1.3, load=1.7, support=support)
    found = cq.solve(model, tol=1e-9).continuum("pointwise")
    assert found.proven
    assert (found.lower <= found.upper).all()


def test_holes_with_corners_leave_the_bounds_that_need_no_answer():
    """No function is known of corners that point inwards at a hole, where splines follow little of a membrane."""
    hole = [(0.3, 0.1), (-0.1, 0.3), (-0.3, -0.1), (0.1, -0.3)]
    lattice = (cq.Frame.disk(1.1) - cq.Frame.polygon(hole)).lattice(0.07, fitted=True)
    found = cq.solve(cq.Membrane(lattice, tension=1.0, load=1.5, support=0.1), tol=1e-9).continuum("pointwise")
    assert found.proven
    assert found.lower.min() > -1e-9
    assert found.upper.max() < 0.1 + 1e-9
    free = cq.solve(cq.Membrane(lattice, tension=1.0, load=1.5, support=5.0), tol=1e-9).continuum("pointwise")
    assert free.lower.min() > -1e-9
    assert free.upper.max() < 1.5 * 2.3**2 / 8.0  # a strip across the frame bends so far
