"""What lies beside the interpolant of a support with kinks, told by parts of cells: against values in between."""

import numpy as np
import pytest

import contactqp as cq
from contactqp.continuum.data import Data
from contactqp.continuum.kinks import cells_with_kinks, told_by_parts
from contactqp.continuum.relatives import prolonged
from contactqp.profiles import Cone, HillAndFloor, Plane, Uppermost

SURFACES = {
    "hill": (HillAndFloor(), 1.0),
    "roof": (Uppermost(Plane(1.0, 0.3, 0.1), Plane(1.1, -0.2, 0.05), Plane(1.3)), 1.0),
    "cone": (Cone(0.2, 0.4, center=(0.3, -0.7)), 1.0),
}


@pytest.mark.parametrize("name", sorted(SURFACES))
@pytest.mark.parametrize("spacing", [1.0, 0.7])
def test_no_value_between_the_points_lies_farther_beside_the_interpolant(name, spacing):
    surface, sign = SURFACES[name]
    lattice = cq.Lattice.from_mask(np.ones((17, 33), dtype=bool), spacing, (-16 * spacing, -8 * spacing))
    data = Data.of(cq.Membrane(lattice, 1.0, load=1.0, support=surface, frame_height=-100.0))
    field = told_by_parts(data.plan, data.support, surface, sign)
    assert (field.below <= data.support.below).all()
    kinks = cells_with_kinks(data.plan, data.support)
    assert kinks.any()
    fine = field.values
    for _ in range(4):
        fine = prolonged(fine)
    x, y = data.plan.places
    steps = spacing / 16
    there = surface(x[0, 0] + steps * np.arange(fine.shape[1]), (y[0, 0] + steps * np.arange(fine.shape[0]))[:, None])
    for row, column in np.argwhere(data.plan.squares):
        part = np.s_[16 * row : 16 * row + 17, 16 * column : 16 * column + 17]
        away = there[part] - fine[part]
        assert -away.min() <= field.below[row, column] + 1e-13
        assert away.max() <= field.above[row, column] + 1e-13
    # It is a good deal nearer where there are kinks.
    assert np.median((field.below + field.above)[kinks]) < 0.7 * np.median(
        (data.support.below + data.support.above)[kinks]
    )


def test_smooth_surfaces_are_left_as_they_are():
    lattice = cq.Frame.rectangle(1, 1).lattice(0.25)
    plane = Plane(1.0, 0.1)
    data = Data.of(cq.Membrane(lattice, 1.0, load=1.0, support=plane))
    assert told_by_parts(data.plan, data.support, plane, 1.0) is data.support
