"""What profiles tell of whole rectangles holds at every point of them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contactqp.foundation.intervals import Interval
from contactqp.foundation.surfaces import Ranged
from contactqp.profiles import (
    Along,
    Cone,
    Cylinder,
    Hemisphere,
    HillAndFloor,
    Paraboloid,
    Plane,
    Profile,
    Sampled,
    Uppermost,
)

PROFILES = [
    Plane(0.3, 0.2, -0.1),
    Paraboloid(0.1, 2.0, (0.3, -0.2)),
    Paraboloid(0.1, -0.7),
    Cone(0.2, 0.5, (0.1, 0.1)),
    Cone(0.2, -0.5),
    Cylinder(0.1, 1.5, axis="x"),
    Cylinder(0.1, 0.6, (0.2, 0.0)),
    Hemisphere(0.1, 1.5, (0.1, 0.2)),
    Hemisphere(0.0, 0.5),
    HillAndFloor(scale=1 / 24),
    HillAndFloor(floor=0.3, scale=1 / 30),
    Uppermost(Plane(0.4), Hemisphere(0.1, 0.7)),
    Uppermost(Plane(0.3, 0.2), Plane(0.3, -0.2), Paraboloid(0.2, 1.0)),
    Sampled([-1.0, -0.3, 0.1, 0.2, 0.9], [0.3, 0.1, 0.4, 0.35, 0.2], outside="hold"),
    Sampled(np.linspace(-1, 1, 33), np.sin(5 * np.linspace(-1, 1, 33)), outside="hold"),
    Along(Paraboloid(0.1, 2.0, (0.3, -0.2)), (0.0, 0.1), (3.0, 4.1)),
    Along(Cone(0.2, 0.5, (0.1, 0.1)), (0.0, 0.0), (-2.0, 0.0), abscissa=0.2),
]
CUBIC = Sampled([-1.0, -0.3, 0.1, 0.2, 0.9], [0.3, 0.1, 0.4, 0.35, 0.2], interpolation="pchip", outside="hold")
places = st.floats(-1.0, 1.0)


def rectangle(x, y, width, height):
    return Interval.between([x], [x + width]), Interval.between([y], [y + height])


@pytest.mark.parametrize("profile", [*PROFILES, CUBIC], ids=repr)
@settings(max_examples=15)
@given(x=places, y=places, width=st.floats(0, 0.7), height=st.floats(0, 0.7), seed=st.integers(0, 2**16))
def test_ranges_hold_all_depths(profile, x, y, width, height, seed):
    found = profile.range(*rectangle(x, y, width, height))
    at = np.random.default_rng(seed).uniform(size=(2, 40))
    depths = profile(np.append(x + width * at[0], [x, x + width]), np.append(y + height * at[1], [y, y + height]))
    # Depths are rounded themselves; ranges are not wider than that.
    room = 1e-13
    assert (found.lower - room <= depths).all()
    assert (depths <= found.upper + room).all()


@pytest.mark.parametrize("profile", PROFILES, ids=repr)
@settings(max_examples=15)
@given(x=places, y=places, width=st.floats(0.01, 0.7), height=st.floats(0.01, 0.7), seed=st.integers(0, 2**16))
def test_curvatures_hold_all_second_differences(profile, x, y, width, height, seed):
    """A second difference is a weighted mean of second derivatives, kinks included."""
    sides = rectangle(x, y, width, height)
    found, laplacian = profile.curvature(*sides), profile.laplacian_range(*sides)
    at = np.random.default_rng(seed).uniform(0.25, 0.75, size=(2, 40))
    points, steps = (x + width * at[0], y + height * at[1]), (width / 4, height / 4)
    middle = profile(*points)
    with np.errstate(invalid="ignore"):
        for part, (right, up) in ((found.xx, (1, 0)), (found.yy, (0, 1))):
            ends = [profile(points[0] + s * right * steps[0], points[1] + s * up * steps[1]) for s in (-1, 1)]
            differences = (ends[0] - 2 * middle + ends[1]) / (right * steps[0] + up * steps[1]) ** 2
            known = np.isfinite(differences)
            room = 1e-14 / min(steps) ** 2
            assert (part.lower - room <= differences[known]).all()
            assert (differences[known] <= part.upper + room).all()
    total = found.xx + found.yy
    assert (laplacian.upper <= total.upper + 1e-12 * np.abs(total.upper)).all()


def test_ranges_of_single_points_are_as_narrow_as_rounding():
    at = Interval.of([0.4]), Interval.of([0.3])
    for profile in PROFILES:
        found = profile.range(*at)
        if np.isfinite(found.upper[0]):
            assert found.upper - found.lower < 3e-13


def test_the_laplacian_is_that_of_the_formula():
    sides = Interval.of([0.6]), Interval.of([0.8])
    assert Cone(0.0, 2.0).laplacian_range(*sides).upper == pytest.approx(2.0)
    assert Paraboloid(0.0, 4.0).laplacian_range(*sides).lower == pytest.approx(0.5)
    z = np.sqrt(3.0)
    assert Hemisphere(0.0, 2.0).laplacian_range(*sides).upper == pytest.approx(2 / z + 1 / z**3)


def test_kinks_are_told_by_their_sense():
    """The top of a cone bends downwards in a kink: depths grow on all sides of it."""
    sides = Interval.between([-0.1], [0.1]), Interval.between([-0.1], [0.1])
    tip = Cone(0.0, 1.0).curvature(*sides)
    assert tip.xx.upper[0] == np.inf
    assert tip.xx.lower[0] >= -1e-300
    valley = Uppermost(Plane(0.0, 1.0), Plane(0.0, -1.0)).curvature(*sides)
    assert (valley.xx.lower[0], valley.xx.upper[0]) == (-np.inf, 0.0)


def test_a_profile_of_ones_own_tells_nothing():
    class Dent(Profile):
        def __call__(self, x, y):
            return np.asarray(x) ** 2

    sides = Interval.of([0.0]), Interval.of([0.0])
    assert Dent().range(*sides) is None
    assert Dent().laplacian_range(*sides) is None
    assert Uppermost(Plane(1.0), Dent()).range(*sides) is None
    assert Uppermost(Plane(1.0), Dent()).curvature(*sides) is None
    assert Uppermost(Plane(1.0), lambda x, y: x).range(*sides) is None
    assert isinstance(Plane(1.0), Ranged)
    assert Along(lambda x, y: x, (0.0, 0.0), (1.0, 0.0)).range(*sides) is None
    assert CUBIC.curvature(*sides) is None


def test_beyond_its_samples_a_profile_may_be_absent():
    bed = Sampled([0.0, 1.0], [0.2, 0.3], outside="none")
    sides = Interval.between([-0.5, 0.2], [0.5, 0.4]), Interval.of([0.0, 0.0])
    assert bed.range(*sides).upper.tolist() == [np.inf, pytest.approx(0.24)]
    assert bed.curvature(*sides).xx.upper.tolist() == [np.inf, 0.0]
