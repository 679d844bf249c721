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


DIAMOND = [(2, 0), (0, 2), (-2, 0), (0, -2)]
NOTCHED = [(0, 0), (8, 0), (8, 8), (6, 8), (4, 6), (2, 8), (0, 8)]


def test_a_diamond_has_no_points_beyond_its_frame():
    plan = Plan(cq.Frame.polygon(DIAMOND).lattice(1.0))
    x, y = plan.places
    np.testing.assert_array_equal(plan.points, np.abs(x) + np.abs(y) <= 2)
    assert plan.halved.sum() == 8
    assert plan.whole.sum() == 4
    assert plan.frame.sum() == 8
    assert plan.frame_edges.sum() == 0
    assert plan.sides == (4.0, 4.0)
    assert plan.slanted_sides == pytest.approx((8**0.5, 8**0.5))
    assert (plan.frame_corners[plan.halved] == 2).all()
    assert (plan.frame_corners[plan.whole] == 1).all()
    assert plan.asked.sum() == plan.points.sum() + 8
    lengths = sorted(len(chain.quarters) for chain in plan.chains)
    assert lengths == [2] * 4 + [3] * 4
    for chain in plan.chains:
        assert [quarter.halved for quarter in chain.quarters][:: len(chain.quarters) - 1] == [True, True]


def test_half_squares_know_their_corners():
    plan = Plan(cq.Frame.polygon(NOTCHED).lattice(1.0))
    x, y = (np.broadcast_to(part, plan.nodes.shape) for part in plan.places)
    seen = 0
    for halves in plan.halves:
        (a_x, b_x, c_x), (a_y, b_y, c_y) = halves.of(x), halves.of(y)
        np.testing.assert_array_equal(b_x - a_x, halves.outwards[0])
        np.testing.assert_array_equal(c_y - a_y, halves.outwards[1])
        np.testing.assert_array_equal(b_y, a_y)
        np.testing.assert_array_equal(c_x, a_x)
        assert halves.of(plan.nodes)[0].all()
        assert all(at.all() for at in halves.of(plan.frame)[1:])
        seen += halves.row.size
    assert seen == plan.halved.sum() == 4


def test_each_part_of_a_half_at_the_frame_is_in_one_chain():
    plan = Plan(cq.Frame.polygon(NOTCHED).lattice(1.0))
    quarters = [quarter for chain in plan.chains for quarter in chain.quarters]
    assert len(quarters) == len(set(quarters)) == plan.frame_corners.sum()
    assert sum(quarter.halved for quarter in quarters) == 2 * plan.halved.sum()
    # About the corner that points inwards two triangles are at the ends of three quarters.
    (inner,) = (chain for chain in plan.chains if plan.places[0][0, chain.column] == 4 and chain.row > 4)
    assert [quarter.halved for quarter in inner.quarters] == [True, False, False, True]
