"""The region of a membrane, by the squares of its lattice."""

import numpy as np
import pytest

import contactqp as cq
from contactqp.continuum.plan import Plan


def plan_of(*rows):
    return Plan(cq.Lattice.from_mask(np.array([[letter == "o" for letter in row] for row in rows]), spacing=1.0))


def test_a_rectangle_has_four_corners_of_one_quarter_and_sides_of_two():
    plan = plan_of("oo", "oo", "oo")
    lengths = [len(chain.quarters) for chain in plan.chains]
    assert lengths.count(1) == 4
    assert lengths.count(2) == 2 * (2 + 3)
    assert plan.squares.sum() == 3 * 4
    assert plan.sides == (3.0, 4.0)
    assert plan.frame_edges.sum() == 2 * (3 + 4)
    assert plan.frame_corners.max() == 3


def test_about_a_corner_that_goes_inwards_there_are_three_quarters():
    plan = plan_of("ooo.", "ooo.", "oooo")
    assert [len(chain.quarters) for chain in plan.chains].count(3) == 1


def test_a_slit_has_a_tip_of_four_quarters():
    plan = plan_of("oooo", "oo..", "oooo", "oooo")
    found = {(chain.row, chain.column): len(chain.quarters) for chain in plan.chains}
    assert found[2, 3] == 4
    assert sorted(len(c.quarters) for c in plan.chains if (c.row, c.column) == (2, 4)) == [2, 2]


def test_each_quarter_at_the_frame_is_in_one_chain():
    plan = plan_of("oooo.o", "oo..oo", "ooooo.", ".ooooo")
    quarters = [quarter for chain in plan.chains for quarter in chain.quarters]
    assert len(quarters) == len(set(quarters))
    assert len(quarters) == plan.frame_corners.sum()


def test_a_lone_point_holds_no_membrane():
    with pytest.raises(ValueError, match="x=1, y=1 stands alone among nodes"):
        plan_of("ooo", "o.o", "ooo").chains  # noqa: B018


def test_places_are_those_of_the_lattice():
    plan = Plan(cq.Frame.rectangle(2, 1).lattice(0.5))
    x, y = plan.around_points
    assert ((x.lower <= plan.places[0]) & (plan.places[0] <= x.upper)).all()
    assert y.upper.shape == (plan.nodes.shape[0], 1)
    along_x, along_y = plan.around_squares
    assert np.broadcast_shapes(along_x.lower.shape, along_y.lower.shape) == plan.squares.shape
