"""Sides that a lattice moves, and spacings that divide them all."""

import itertools

import numpy as np
import pytest

import contactqp as cq
from contactqp.geometry.sides import is_short

L_SHAPE = [(0, 0), (5, 0), (5, 2.5), (2.5, 2.5), (2.5, 5), (0, 5)]
ANGLE = cq.Frame.polygon(L_SHAPE)


def caution_of(frame, spacing):
    return frame.lattice(spacing).caution


def test_sides_that_are_moved_are_told_with_the_spacings_that_fit():
    with pytest.warns(cq.ContactWarning, match="up to 0.2 outside its contour") as told:
        lattice = ANGLE.lattice(0.3)  # the whole grows by 2 % only, an arm by 8 %
    assert lattice.caution == str(told[0].message)
    assert "it is 5.1 x 5.1 instead of 5 x 5, up to 2% wider" in lattice.caution
    assert "sides: x = 2.5 at 2.7, y = 2.5 at 2.7, x = 5 at 5.1, y = 5 at 5.1" in lattice.caution
    assert lattice.caution.endswith("fitting spacings: 0.25 or 0.3125")
    assert caution_of(ANGLE, 0.2).startswith("with spacing 0.2 the frame lies up to 0.1 outside its contour; sides: x")
    assert caution_of(ANGLE, 0.25) == ""


def test_a_corner_that_is_slightly_wrong_is_told_of_by_its_place():
    wrong = cq.Frame.polygon([(5, 2.47) if corner == (5, 2.5) else corner for corner in L_SHAPE])
    assert "up to 0.027 outside its contour; most at x = 4.75, y = 2.5; no spacing fits" in caution_of(wrong, 0.25)


def test_curves_and_holes_are_told_of():
    assert "up to 0.028 outside its contour; most at x = " in caution_of(cq.Frame.disk(1.0), 0.04)
    hole = cq.Frame.rectangle(6, 6) - cq.Frame.rectangle(2.1, 2)
    assert "sides: x = -1.05 at -1, x = 1.05 at 1; fitting spacings: 0.05" in caution_of(hole, 0.25)


def test_the_caution_stands_beside_every_answer():
    lattice = ANGLE.lattice(0.2)
    for model in (
        cq.Membrane(lattice, 1.0, load=0.01, support=0.1),
        cq.CableNet.orthogonal(lattice, 1.0, load=0.01, support=0.1),
    ):
        assert model.cautions == (lattice.caution,)
        assert "frame up to 0.1 outside its contour" in repr(model)
        assert "up to 0.1 outside its contour" in model._repr_html_()
        solution = cq.solve(model)
        assert solution.cautions == (lattice.caution,)
        assert lattice.caution in repr(solution)
        assert cq.compare(model, ["active-set"]).cautions == (lattice.caution,)
        assert cq.Solver(model).solve(load=0.02).cautions == (lattice.caution,)


@pytest.mark.parametrize(
    "corners",
    [
        L_SHAPE,
        [(0, 0), (10, 0), (10, 10), (0, 10)],
        [(-2, 0), (0, -2), (2, 0), (0, 2)],
        [(1, 0), (4, 0), (4, 3), (3, 4), (0, 4), (0, 1)],
        [(0.1, 0.2), (3.3, 0.2), (3.3, 1.4), (0.1, 1.4)],
    ],
)
@pytest.mark.filterwarnings("ignore::contactqp.ContactWarning")
def test_spacings_that_are_told_fit(corners):
    frame = cq.Frame.polygon(corners)
    for spacing in (0.07, 0.3, 0.41):
        for text, each in itertools.zip_longest(
            caution_of(frame, spacing).split("fitting spacings: ")[1].split(" or "), frame.sides.fitting(spacing)
        ):
            assert float(text) == pytest.approx(each, rel=1e-11)
            assert frame.lattice(float(text)).overshoot == 0
            assert is_short(each)


def test_spacings_that_people_write_come_first():
    assert cq.Frame.rectangle(5, 5).sides.fitting(2.0) == [1.25, 2.5]
    assert cq.Frame.rectangle(7, 7).sides.fitting(0.69) == pytest.approx([0.5, 0.7])
    assert cq.Frame.rectangle(1 / 3, 1).sides.fitting(0.06) == pytest.approx([1 / 18, 1 / 15])


def test_the_width_of_an_arm_is_the_way_to_the_side_that_faces_it():
    steps = [(0, 0), (5, 0), (5, 2.5), (2.6, 2.5), (2.6, 2.51), (2.5, 2.51), (2.5, 5), (0, 5)]
    sides = cq.Frame.polygon(steps).sides
    widths = {(side.axis, side.at): sides.width(side) for side in sides.moved(0.7, (0.0, 0.0))}
    assert widths == pytest.approx({("x", 5): 5, ("y", 2.5): 2.5, ("x", 2.5): 2.5, ("y", 5): 5})


def test_a_frame_of_many_sides_is_looked_at_in_no_time():
    """A coast along pixels, ten thousand of them."""
    rng = np.random.default_rng(0)
    heights = np.repeat(rng.integers(1, 1000, 5000) / 7, 2)
    places = np.concatenate([[0], np.repeat(np.arange(1, 5000), 2), [5000]])
    coast = cq.Frame.polygon([*zip(places, 200 + heights, strict=True), (5000, 0), (0, 0)])
    assert len(coast.sides.moved(0.9, (0.0, 0.0))) > 1000
    assert coast.sides.fitting(0.9) == pytest.approx([1 / 7], rel=1e-9)
