"""Between the points of a lattice fields lie within what is told of them, with kinks as well; dense samples try it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import contactqp as cq
from contactqp.continuum.cell_fields import function_field
from contactqp.continuum.line import Line
from contactqp.continuum.plan import Plan
from contactqp.profiles import Cone, Hemisphere, Paraboloid, Plane, Uppermost

FIELDS = [
    Paraboloid(0.1, 0.5, (0.3, 0.2)),
    Cone(0.2, 0.7, (0.41, 0.53)),
    Hemisphere(0.0, 2.0, (0.4, 0.5)),
    Uppermost(Plane(0.3, 0.5), Plane(0.4, -0.7, 0.2), Paraboloid(0.25, 1.0, (0.5, 0.5))),
    cq.Smooth(lambda x, y: np.sin(3 * x) * y, second_derivative=10.0),
    cq.Smooth(lambda x, y: np.abs(x - 0.37), lipschitz=1.0),
]


def field_on(plan, function):
    x, y = (np.broadcast_to(place, plan.nodes.shape) for place in plan.places)
    return function_field(plan, function, np.where(plan.points, function(x, y), np.nan))


@pytest.mark.parametrize("function", FIELDS, ids=repr)
@pytest.mark.parametrize("squares", [5, 16])
def test_fields_lie_within_what_is_told(function, squares):
    plan = Plan(cq.Frame.rectangle(1, 1, center=(0.5, 0.5)).lattice(1 / squares))
    field, h = field_on(plan, function), plan.spacing
    x, y = plan.places
    parts = (np.arange(32) + 0.5) / 32
    for i, j in np.argwhere(plan.squares):
        s, t = np.meshgrid(parts, parts)
        corner = field.values[i : i + 2, j : j + 2]
        between = (1 - t) * ((1 - s) * corner[0, 0] + s * corner[0, 1]) + t * (
            (1 - s) * corner[1, 0] + s * corner[1, 1]
        )
        beyond = function(x[0, j] + s * h, y[i, 0] + t * h) - between
        room = 1e-12
        assert -field.below[i, j] - room <= beyond.min()
        assert beyond.max() <= field.above[i, j] + room
        means = beyond.reshape(2, 16, 2, 16).mean(axis=(1, 3))
        # The midpoint rule is off by a 256th of what second derivatives, or a slope, make within a part.
        off = 2e-3 * (field.below[i, j] + field.above[i, j]) + room
        assert -field.mean_below[i, j] - off <= means.min()
        assert means.max() <= field.mean_above[i, j] + off


def test_squares_with_kinks_are_known_by_their_parts():
    """A roof over a lattice: in squares that it crosses it lies above its interpolant by what its slopes make of h."""
    plan = Plan(cq.Frame.rectangle(1, 1, center=(0.5, 0.5)).lattice(1 / 16))
    roof = Uppermost(Plane(0.3, 0.5), Plane(0.8, -0.5))
    shifted = Uppermost(Plane(0.3, 0.5), Plane(0.83, -0.5))
    for function, most in ((roof, 1.2e-2), (shifted, 2.5e-2)):
        field = field_on(plan, function)
        assert float(field.below.max()) < most
        assert float(field.mean_below.max()) < most


@settings(max_examples=20)
@given(place=st.floats(0.1, 0.9), slope=st.floats(0.1, 5))
def test_kinks_of_a_line(place, slope):
    """A tension with a kink on a cable is no more than it is; the interpolant cuts the kink off."""
    function = Uppermost(Plane(1.0, slope), Plane(1.0 + 2 * slope * place, -slope))
    line = Line(cq.Cable(1.0, spacing=1 / 8, tension=1.0, load=1.0, support=1.0))
    field = function_field(line, function, function(line.x, 0 * line.x))
    along = np.linspace(0, 1, 801)
    beyond = function(along, 0 * along) - np.interp(along, line.x, field.values)
    stretch = np.minimum((along * 8).astype(int), 7)
    assert (beyond <= field.above[stretch] + 1e-12).all()
    assert (-field.below[stretch] - 1e-12 <= beyond).all()
