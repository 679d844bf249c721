"""Surfaces through soundings that lie anywhere, and surfaces along a line."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import contactqp as cq
from contactqp.profiles import Along, Gridded, Plane, Profile, Scattered, Uppermost

SQUARE = ([0.0, 4.0, 0.0, 4.0], [0.0, 0.0, 2.0, 2.0], [80.0, 82.0, 81.0, 83.0])
COORDINATE = st.floats(-100, 100, allow_subnormal=False).map(lambda value: round(value, 3))


def scatter(count, seed=0):
    """Points in the unit square, whose corners are among them."""
    inner = np.random.default_rng(seed).uniform(size=(count, 2))
    return np.vstack([inner, [[0, 0], [1, 0], [0, 1], [1, 1]]]).T


def hill(x, y):
    return 80 + np.sin(3 * x) * np.cos(2 * y)


def test_it_is_a_profile_that_tells_what_it_holds():
    bed = Scattered(*SQUARE, outside="hold")
    assert isinstance(bed, Profile)
    assert repr(bed) == "Scattered(4 soundings, x from 0 to 4, y from 0 to 2, linear, outside='hold')"
    np.testing.assert_array_equal(bed.depth, SQUARE[2])
    assert bed([1.0, 2.0], [[1.0], [0.5]]).shape == (2, 2)
    assert bed(1.0, 1.0).shape == ()
    with pytest.raises(ValueError, match="read-only"):
        bed.depth[0] = 2.0
    np.testing.assert_allclose(Uppermost(bed, Plane(81.0))([1.0, 4.0], 1.0), [81.0, 81.0])


@settings(max_examples=60, deadline=None)
@given(
    points=st.lists(st.tuples(COORDINATE, COORDINATE), min_size=3, max_size=25, unique=True),
    plane=st.tuples(*[st.floats(-5, 5)] * 3),
    shift=st.sampled_from([0.0, 5.6e6]),
    weights=st.lists(st.floats(0.01, 1.0), min_size=25, max_size=25),
)
def test_planes_are_reproduced_within_the_hull(points, plane, shift, weights):
    x, y = np.array(points).T + shift
    values = plane[0] + plane[1] * (x - shift) + plane[2] * (y - shift)
    across = np.linalg.svd(np.column_stack([x - x.mean(), y - y.mean()]), compute_uv=False)
    if across[1] < 1e-3 * across[0]:
        return
    share = np.array(weights[: x.size]) / sum(weights[: x.size])
    inside = share @ x, share @ y
    bed = Scattered(x, y, values)
    expected = plane[0] + plane[1] * (inside[0] - shift) + plane[2] * (inside[1] - shift)
    assert bed(*inside) == pytest.approx(expected, abs=1e-6 if shift else 1e-9)
    np.testing.assert_allclose(bed(x, y), values, atol=1e-6 if shift else 1e-8)


@pytest.mark.parametrize("interpolation", ["linear", "nearest", "cubic"])
def test_soundings_are_met(interpolation):
    x, y = scatter(40)
    np.testing.assert_allclose(Scattered(x, y, hill(x, y), interpolation=interpolation)(x, y), hill(x, y), rtol=1e-12)


def test_elevations_are_depths_below_zero():
    x, y, depth = map(np.array, SQUARE)
    assert Scattered(x, y, -depth, upwards=True)(1.0, 1.0) == Scattered(x, y, depth)(1.0, 1.0) > 0


def test_the_order_of_the_error():
    """Points of a lattice that are moved by a third of its spacing, so that their distance is about that.

    The cubic's error is of second order, too, where its gradients are estimated from irregular points, but smaller.
    """
    counts, kinds = (11, 21, 41), ("nearest", "linear", "cubic")
    errors = np.empty((len(counts), len(kinds)))
    inner = np.random.default_rng(3).uniform(0.25, 0.75, (2, 2000))
    for at, count in enumerate(counts):
        x, y = map(np.ravel, np.meshgrid(*[np.linspace(0, 1, count)] * 2))
        away = np.random.default_rng(count).uniform(-1 / 3, 1 / 3, (2, x.size)) / (count - 1)
        x, y = x + away[0], y + away[1]
        for k, kind in enumerate(kinds):
            errors[at, k] = np.abs(Scattered(x, y, hill(x, y), interpolation=kind)(*inner) - hill(*inner)).mean()
    orders = np.log2(errors[0] / errors[-1]) / (len(counts) - 1)
    assert (orders > [0.9, 1.8, 1.8]).all()
    assert (errors[:, 2] < errors[:, 1] / 8).all()


def test_the_nearest_sounding():
    assert Scattered(*SQUARE, interpolation="nearest")(3.0, 0.5) == 82.0


def test_what_happens_outside_the_hull_is_chosen():
    triangle = ([0.0, 4.0, 0.0], [0.0, 0.0, 4.0], [1.0, 5.0, 1.0])
    with pytest.raises(ValueError, match=r"x = 3, y = 3 lies outside the soundings' hull.*outside='hold'.*'none'"):
        Scattered(*triangle)([1.0, 3.0], [1.0, 3.0])
    np.testing.assert_array_equal(
        Scattered(*triangle, outside="none")([[1.0, 3.0]], [[1.0, 3.0]]).round(12), [[2.0, np.inf]]
    )
    held = Scattered(*triangle, outside="hold")([3.0, -1.0, 9.0, 2.0, 1.0], [3.0, -2.0, 0.0, -1.0, 1.0])
    np.testing.assert_allclose(held, [3.0, 1.0, 5.0, 3.0, 2.0], rtol=1e-7)


@pytest.mark.parametrize("interpolation", ["linear", "nearest", "cubic"])
def test_points_on_the_hull_are_not_missed_by_rounding(interpolation):
    turn = np.exp(0.3j)
    corners = turn * np.array([0, 7, 7 + 3j, 3j]) + 5e5 + 5.6e6j
    bed = Scattered(corners.real, corners.imag, [1.0, 2.0, 3.0, 4.0], interpolation=interpolation)
    on_edges = np.concatenate(
        [a + (b - a) * np.linspace(0, 1, 101) for a, b in zip(corners, np.roll(corners, 1), strict=True)]
    )
    assert np.isfinite(bed(on_edges.real, on_edges.imag)).all()


def test_several_soundings_at_one_place():
    x, y, depth = [0.0, 4.0, 0.0, 4.0, 0.0], [0.0, 0.0, 2.0, 0.0, 0.0], [1.0, 2.0, 3.0, 6.0, 5.0]
    with pytest.raises(ValueError, match=r"two soundings or more at x = 0, y = 0, and at 1 other places: keep one by"):
        Scattered(x, y, depth)
    with pytest.raises(ValueError, match=r"two soundings at x = 4, y = 0: keep one by duplicates = 'mean', 'first'"):
        Scattered(x[:4], y[:4], depth[:4])
    for kept, at_origin, at_four in [
        ("mean", 3, 4), ("first", 1, 2), ("last", 5, 6), ("shallowest", 1, 2), ("deepest", 5, 6)
    ]:  # fmt: skip
        bed = Scattered(x, y, depth, duplicates=kept)
        np.testing.assert_allclose(bed([0.0, 4.0], 0.0), [at_origin, at_four])
    raised = Scattered(x, y, np.negative(depth), duplicates="shallowest", upwards=True)
    np.testing.assert_allclose(raised([0.0, 4.0], 0.0), [1, 2])


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"x": [0.0, 1.0], "y": [0.0, 1.0], "depth": [1.0, 1.0]}, ValueError, "at three places or more, got 2"),
        (
            {"x": [5e5, 5e5 + 1, 5e5 + 3], "y": [7, 9, 13], "depth": [1, 1, 2]},
            ValueError,
            "lie on a line, which makes no surface; profiles.Sampled takes",
        ),
        ({"x": [0.0, 1.0, 2.0, 0.3], "y": [0.0, 0.1, 0.2, 0.03]}, ValueError, "the 4 soundings lie on a line"),
        ({"x": [0.0, np.nan, 0.0, 4.0]}, ValueError, "x must be finite, but entry 1 is nan"),
        ({"depth": [0.0, 1.0, np.inf, 4.0]}, ValueError, "depth must be finite, but entry 2 is inf"),
        ({"y": [0.0, 1.0]}, ValueError, r"y must have shape \(4,\), got \(2,\)"),
        ({"x": [[0.0, 1.0]]}, ValueError, r"x must have one dimension, got shape \(1, 2\)"),
        ({"depth": ["a", "b", "c", "d"]}, TypeError, "depth must hold real numbers"),
        ({"interpolation": "pchip"}, ValueError, "interpolation must be one of 'linear', 'nearest', 'cubic'"),
        ({"outside": "extend"}, ValueError, "outside must be one of 'error', 'hold', 'none', got 'extend'"),
        ({"duplicates": "any"}, ValueError, "duplicates must be one of 'error', 'mean'"),
    ],
)
def test_bad_soundings_say_what_is_wrong(arguments, error, message):
    with pytest.raises(error, match=message):
        Scattered(**dict(zip(("x", "y", "depth"), SQUARE, strict=True)) | arguments)


def test_places_asked_for_must_be_finite():
    with pytest.raises(ValueError, match="x must be finite, but entry 1 is nan"):
        Scattered(*SQUARE)([0.0, np.nan], 0.0)


def test_it_can_be_sent_to_another_process():
    bed = pickle.loads(pickle.dumps(Scattered(*SQUARE, interpolation="cubic")))
    assert bed(1.0, 1.0) == pytest.approx(81.0)


TEXTS = {
    "blanks": "# soundings of a made-up bed\n0   0 80\n 4\t0  82\n\n0 2 81\n4 2 83 \n",
    "commas": "0,0,80\n4, 0,82\n# a comment\n0,2,81\n4,2,83\n",
    "semicolons": "X;Y;Z\n0;0;80\n4;0;82\n0;2;81\n4;2;83\n",
    "tabulators": "y\tx\tdepth\n0\t0\t80\n0\t4\t82\n2\t0\t81\n2\t4\t83\n",
    "a byte order mark": "\ufeffx y z\n0 0 80\n4 0 82\n0 2 81\n4 2 83\n",
}


@pytest.mark.parametrize("name", TEXTS)
def test_soundings_from_text(tmp_path, name):
    (tmp_path / "bed.xyz").write_text(TEXTS[name], encoding="utf-8")
    bed = Scattered.from_file(tmp_path / "bed.xyz", outside="none")
    assert repr(bed) == "Scattered(4 soundings, x from 0 to 4, y from 0 to 2, linear, outside='none')"
    np.testing.assert_allclose(bed([1.0, 4.0, 5.0], 1.0), [81.0, 82.5, np.inf])


def test_columns_and_decimals_are_chosen(tmp_path):
    (tmp_path / "bed.csv").write_text("no;easting;northing;z;sd\n1;0,5;0;80,5;1\n2;4;0;82;1\n3;0;2;81;1\n4;4;0;84;1\n")
    columns = {"x": "easting", "y": 2, "depth": "Z", "decimal": ","}
    bed = Scattered.from_file(tmp_path / "bed.csv", **columns, duplicates="mean")
    np.testing.assert_array_equal(bed.x, [0.0, 0.5, 4.0])
    np.testing.assert_array_equal(bed.depth, [81.0, 80.5, 83.0])


@pytest.mark.parametrize(
    ("text", "columns", "message"),
    [
        ("x y z w\n0 0 1 2\n", {}, r"bed.xyz: choose one of its columns by depth: z, w"),
        ("e n z\n0 0 1\n", {"depth": "z"}, r"bed.xyz: no column 'x'; it has e, n, z"),
        ("0 0 1\n1 0 one\n", {}, r"bed.xyz, line 2: depth \(column 2\) is 'one', which is no number"),
        ("0 0 1\n1 0\n", {}, r"bed.xyz, line 2: no column 2, it has 2 columns"),
        ("0 0 1\n1 0 nan\n", {}, r"bed.xyz, line 2: depth \(column 2\) must be finite, got nan"),
        ("0;0;1,5\n1;0;2,5\n", {}, r"line 1: depth \(column 2\) is '1,5', which is no number; decimal=',' reads it"),
        ("0 0 1\n1 0 1\n", {}, r"bed.xyz: a surface needs soundings at three places or more, got 2"),
        ("# nothing\n", {}, r"bed.xyz: it has no rows"),
        ("0 0 1\n", {"x": 0, "y": 0}, r"x, y and depth must be different columns, got 0 for several"),
    ],
)
def test_bad_text_names_file_line_and_value(tmp_path, text, columns, message):
    (tmp_path / "bed.xyz").write_text(text)
    with pytest.raises(ValueError, match=message):
        Scattered.from_file(tmp_path / "bed.xyz", **columns)


def test_a_surface_along_a_line_is_that_surface():
    line = Along(hill, (1.0, 2.0), (4.0, 6.0), abscissa=10.0)
    assert line.span == 5.0
    np.testing.assert_allclose(line([10.0, 12.5, 15.0]), hill(np.array([1.0, 2.5, 4.0]), np.array([2.0, 4.0, 6.0])))
    np.testing.assert_allclose(line(10.0, 5.0), hill(1.0 - 4.0, 2.0 + 3.0))
    assert repr(Along(Plane(1.0), (0, 0), (3, 4))) == (
        "Along(Plane(depth=1.0, slope_x=0.0, slope_y=0.0), from (0, 0) to (3, 4), span=5)"
    )


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (([[1.0]], (0, 0), (1, 0)), TypeError, "surface must be a profile or a function of .x, y., got list"),
        ((hill, (0, 0, 1), (1, 0)), ValueError, r"start must be a pair \(x, y\), got \(0, 0, 1\)"),
        ((hill, (0, np.nan), (1, 0)), ValueError, r"start\[1\] must be .*finite"),
        ((hill, (1, 0), (1, 0)), ValueError, "start and end must be different points"),
    ],
)
def test_bad_lines_say_what_is_wrong(arguments, error, message):
    with pytest.raises(error, match=message):
        Along(*arguments)


def test_cables_and_beams_lie_over_a_map_as_over_its_profile():
    """The map holds a surface that is bilinear, so that the profile along a line is known: a parabola."""
    x, y = np.linspace(0, 300, 31), np.linspace(0, 400, 11)

    def bed(across, along):
        return 30 + 5e-4 * (across - 150) * (along - 200)

    surface = Gridded(x, y, bed(*np.meshgrid(x, y)))
    points = np.random.default_rng(1).uniform(size=(300, 2)) * (300, 400)
    corners = [(0, 0), (300, 0), (0, 400), (300, 400)]
    soundings = Scattered(*np.vstack([points, corners]).T, bed(*np.vstack([points, corners]).T), interpolation="cubic")

    def profile(distance, y):
        return bed(0.6 * distance, 0.8 * distance)

    for model, more in ((cq.Cable, {}), (cq.Beam, {"bending_stiffness": 1e4})):
        line = {"spacing": 5.0, "tension": 800.0, "load": 0.4, "frame_height": 20.0} | more
        expected, found, close = (
            cq.solve(model(500.0, support=ground, **line))
            for ground in (profile, *(Along(each, (0, 0), (300, 400)) for each in (surface, soundings)))
        )
        assert expected.status == found.status == "certified"
        assert 0 < expected.contact.sum() < expected.contact.size
        np.testing.assert_allclose(found.deflection, expected.deflection, atol=1e-7)
        np.testing.assert_allclose(close.deflection, expected.deflection, atol=0.02)
