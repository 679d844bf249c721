"""Signs of heights, rows of arrays, and numbers in place of 'no support'."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

import contactqp as cq
from contactqp.models.varied import reachable, with_load

LATTICE = cq.Frame.rectangle(8, 6).lattice(1.0)


def hill(x, y):
    return 0.3 + 0.1 * (x - 1) ** 2 + 0.05 * (y + 1) ** 2


def ends(x, y):
    return 0.05 * x + 0.01 * y


def both(kind, **changes):
    """Return a model with heights downwards, and the same one with heights upwards."""
    at = {"support": hill, "height": ends} | changes

    def up(height):
        return (lambda x, y: -height(x, y)) if callable(height) else -np.asarray(height)

    made = []
    for upwards in (False, True):
        support, height = (up(at["support"]), up(at["height"])) if upwards else (at["support"], at["height"])
        if kind == "membrane":
            made.append(cq.Membrane(LATTICE, 1.0, load=0.2, support=support, frame_height=height, upwards=upwards))
        elif kind == "cable":
            made.append(
                cq.Cable(10, spacing=1.0, tension=2.0, load=0.4, support=support, frame_height=height, upwards=upwards)
            )
        else:
            made.append(
                cq.CableNet.orthogonal(LATTICE, 1.0, load=0.2, support=support, frame_height=height, upwards=upwards)
            )
    return made


@pytest.mark.parametrize("kind", ["membrane", "cable", "net"])
def test_elevations_are_the_same_problem_with_other_signs(kind):
    down, up = (cq.solve(model) for model in both(kind))
    assert 0 < down.contact.sum() < down.problem.size
    np.testing.assert_array_equal(down.problem.q, up.problem.q)
    np.testing.assert_array_equal(down.gap, up.gap)
    np.testing.assert_array_equal(down.reaction, up.reaction)
    np.testing.assert_array_equal(down.deflection, -up.deflection)
    np.testing.assert_array_equal(down.model.support, -up.model.support)
    assert down.max_slope == up.max_slope
    assert abs(up.force_balance.imbalance) < 1e-12
    assert "heights upwards" in repr(up)
    assert "upwards" not in repr(down.model)
    fields = up.to_dataset()
    assert fields["deflection"].attrs["long_name"] == "deflection, positive upwards"
    np.testing.assert_array_equal(fields["support"], -down.to_dataset()["support"])
    np.testing.assert_array_equal(fields["gap"], down.to_dataset()["gap"])


def test_spans_and_lifts_do_not_depend_on_the_sign_of_heights():
    down, up = both("cable")
    pd = pytest.importorskip("pandas")
    pd.testing.assert_frame_equal(down.spans(cq.solve(down)), up.spans(cq.solve(up)))
    lifted = [cq.trace(model, lifts=[0.0, 0.1, 0.2]) for model in (down, up)]
    np.testing.assert_array_equal(lifted[0].max_deflection, -lifted[1].max_deflection)
    assert lifted[1].monotone
    assert lifted[1].max_deflection[0] < 0
    solved = cq.Solver(up).solve(support=-0.4, lift=0.1)
    np.testing.assert_allclose(solved.gap, cq.Solver(down).solve(support=0.4, lift=0.1).gap, atol=1e-12)


def test_a_profile_has_depths_whichever_way_heights_are_positive():
    dome = cq.profiles.Hemisphere(depth=0.2, radius=3.0)
    down = cq.Membrane(LATTICE, 1.0, load=0.2, support=dome)
    up = cq.Membrane(LATTICE, 1.0, load=0.2, support=dome, upwards=True)
    np.testing.assert_array_equal(down.problem.q, up.problem.q)
    assert up.support.max() == pytest.approx(-0.2)
    assert up.support.min() == -np.inf
    net = cq.CableNet.orthogonal(LATTICE, 1.0, load=0.2, support=dome, upwards=True)
    np.testing.assert_array_equal(net.support, up.support)
    bed = cq.profiles.Sampled([0.0, 10.0], [-1.0, -2.0], upwards=True)
    sunk = cq.Cable(10, spacing=1.0, tension=1.0, load=0.1, support=bed, frame_height=bed, upwards=True)
    np.testing.assert_allclose(sunk.problem.q, np.full(9, 0.1))
    np.testing.assert_allclose(sunk.support, -1 - np.arange(1, 10) / 10)


def test_no_support_is_as_deep_as_can_be():
    support = np.full(LATTICE.size, -0.3)
    support[:5] = -np.inf
    up = cq.Membrane(LATTICE, 1.0, load=0.2, support=support, upwards=True)
    assert np.count_nonzero(~up.supported) == 5
    with pytest.raises(ValueError, match=r"support must be finite or -inf \(no support\), but is inf at node 0"):
        cq.Membrane(LATTICE, 1.0, load=0.2, support=np.inf, upwards=True)
    with pytest.raises(TypeError, match="upwards must be True or False, got 'yes'"):
        cq.Membrane(LATTICE, 1.0, load=0.2, support=-1.0, upwards="yes")


def test_pictures_say_which_way_heights_are_positive():
    down, up = (cq.solve(model).plot() for model in both("cable"))
    assert down.axes[0].get_ylabel() == "height,\npositive downwards"
    assert up.axes[0].get_ylabel() == "height,\npositive upwards"
    assert np.diff(down.axes[0].get_ylim()) < 0 < np.diff(up.axes[0].get_ylim())
    spaces: list[Any] = [cq.solve(model).plot().axes[-1] for model in both("net")]
    assert ["positive upwards" in axes.get_title() for axes in spaces] == [False, True]
    assert np.diff(spaces[0].get_zlim()) < 0 < np.diff(spaces[1].get_zlim())


@pytest.mark.parametrize("rows", ["up", "down"])
def test_the_rows_of_arrays_go_where_it_is_told(rows):
    rank = np.arange(LATTICE.shape[0])[:, None] * np.ones(LATTICE.shape[1])
    support = 0.1 + (rank if rows == "up" else rank[::-1]) / 10
    membrane = cq.Membrane(LATTICE, 1.0, load=0.4, support=support, rows=rows)
    solution = cq.solve(membrane)
    assert solution.contact.any()
    assert LATTICE.node_y[solution.contact].mean() < -0.5
    np.testing.assert_array_equal(
        membrane.support, cq.Membrane(LATTICE, 1.0, load=0.4, support=rank / 10 + 0.1).support
    )
    again = cq.Solver(membrane).solve(support=support, rows=rows)
    np.testing.assert_array_equal(again.gap, solution.gap)
    net = cq.CableNet.orthogonal(LATTICE, 1.0, load=0.4, support=support, frame_height=0 * support, rows=rows)
    np.testing.assert_array_equal(net.support, membrane.support)
    frame = np.broadcast_to(LATTICE.y[:, None] / 10, LATTICE.shape)
    tilted = cq.Membrane(
        LATTICE, 1.0, load=0.4, support=2.0, frame_height=frame if rows == "up" else frame[::-1], rows=rows
    )
    expected = cq.Membrane(LATTICE, 1.0, load=0.4, support=2.0, frame_height=lambda x, y: y / 10)
    np.testing.assert_allclose(tilted.problem.q, expected.problem.q, atol=1e-12)
    mask = np.array([[True, False], [True, True]])
    np.testing.assert_array_equal(cq.Lattice.from_mask(mask, 1.0, rows=rows).mask, mask if rows == "up" else mask[::-1])


def test_coordinates_tell_where_rows_go_if_there_are_any():
    grid = np.arange(float(np.prod(LATTICE.shape))).reshape(LATTICE.shape)
    placed = xr.DataArray(grid, dims=("y", "x"), coords={"y": LATTICE.y, "x": LATTICE.x})
    up, down = (cq.Membrane(LATTICE, 1.0, load=1.0, support=placed, rows=rows).support for rows in ("up", "down"))
    np.testing.assert_array_equal(up, down)
    unplaced = cq.Membrane(LATTICE, 1.0, load=1.0, support=placed.drop_vars("y"), rows="down").support
    np.testing.assert_array_equal(unplaced, LATTICE.gather(grid[::-1]))
    with pytest.raises(ValueError, match="rows must be one of 'up', 'down', got 'north'"):
        cq.Membrane(LATTICE, 1.0, load=1.0, support=grid, rows="north")


@pytest.mark.parametrize("upwards", [False, True])
def test_a_support_that_stands_above_the_frame_all_around_is_warned_of(upwards):
    height = 0.3 if upwards else -0.3
    with pytest.warns(cq.ContactWarning, match=r"above the frame at 20 of the 20 .* by 0.3 .*heights are positive"):
        cq.Membrane(cq.Frame.rectangle(6, 6).lattice(1.0), 1.0, load=0.03, support=height, upwards=upwards)
    with pytest.warns(cq.ContactWarning, match="above the frame at 2 of the 2"):
        cq.Cable(100, spacing=1.0, tension=1.0, load=1.0, support=height, upwards=upwards)
    with pytest.warns(cq.ContactWarning, match="above the frame") as found:
        cq.CableNet.orthogonal(LATTICE, 1.0, load=1.0, support=height, upwards=upwards)
    assert found[0].filename == __file__


def test_hills_within_the_frame_and_ground_that_goes_on_from_it_are_not_warned_of():
    cq.Membrane(LATTICE, 1.0, load=1.0, support=lambda x, y: 0.1 * (x**2 + y**2) - 0.5)
    cq.Cable(100, spacing=1.0, tension=1.0, load=1.0, support=lambda x: 0.01 * (x - 50) ** 2, frame_height=25.0)
    cq.Cable(100, spacing=1.0, tension=1.0, load=-0.0001, support=0.0)


@pytest.mark.parametrize("upwards", [False, True])
@pytest.mark.parametrize("kind", ["membrane", "net"])
def test_a_support_above_a_part_of_the_frame_is_told_of_by_its_place(kind, upwards):
    """A floor at an elevation of 0.1, over which the frame falls from 0.3 to -0.1."""
    sign = 1.0 if upwards else -1.0
    given = {"load": 0.1, "support": sign * 0.1, "frame_height": lambda x, y: sign * (0.1 - 0.05 * x)}
    told = r"at 11 of the 24 .*, by 0.2 at most, first at node 4 .*x=1, y=-2\).*check the heights of support and frame"
    make = {"membrane": cq.Membrane, "net": cq.CableNet.orthogonal}[kind]
    with pytest.warns(cq.ContactWarning, match=told):
        model = make(LATTICE, 1.0, **given, upwards=upwards)
    assert any("above the frame" in caution for caution in cq.solve(model).cautions)


def test_a_sloping_support_above_a_part_of_the_frame_is_told_of():
    with pytest.warns(cq.ContactWarning, match="above the frame at 11 of the 24 .*, by 0.7 at most"):
        cq.Membrane(LATTICE, 1.0, load=0.1, support=lambda x, y: 0.1 * x, frame_height=lambda x, y: -0.1 * x)
    with pytest.warns(cq.ContactWarning, match="above the frame at 1 of the 2 places .*first at node 98"):
        cq.Cable(100, spacing=1.0, tension=1.0, load=1.0, support=lambda x: 1 - 0.011 * x)


def test_a_support_that_falls_steeply_beside_the_frame_is_not_above_it():
    def cliff(x, y):
        return np.where(np.abs(x) > 2.5, 0.2, 1e3)

    assert not cq.Membrane(LATTICE, 1.0, load=0.1, support=cliff).cautions


def test_ground_that_goes_on_from_the_frame_is_not_above_it():
    def ground(x, y):
        return 0.05 * x**2 + 0.3 * y

    rough = np.random.default_rng(0).normal(size=(7, 9))
    for height in (ground, rough):
        cq.Membrane(LATTICE, 1.0, load=0.1, support=height, frame_height=height)
    bed = cq.profiles.Sampled(np.arange(11.0), rough.ravel()[:11], interpolation="pchip")
    cq.Cable(10, spacing=0.1, tension=1.0, load=1.0, support=bed, frame_height=bed)


@pytest.mark.parametrize("upwards", [False, True])
def test_loads_and_supports_that_exclude_contact_are_warned_of(upwards):
    with pytest.warns(cq.ContactWarning, match="nowhere presses downwards and the support lies below the frame"):
        model = cq.Membrane(LATTICE, 1.0, load=-0.03, support=-0.3 if upwards else 0.3, upwards=upwards)
    assert not cq.solve(model).contact.any()
    assert "nothing can touch" in model.cautions[0]


@pytest.mark.parametrize("value", [-9999.0, -1e30, -3.4e38])
def test_a_number_for_missing_data_is_warned_of_by_its_node(value):
    support = np.full(LATTICE.size, 40.0) + np.arange(LATTICE.size) / 10
    support[[7, 9]] = value
    match = rf"support is {value:g} at node 7 \(x=-3, y=-1\) and 1 more node, and 40 to 43.4 elsewhere"
    with pytest.warns(cq.ContactWarning, match=match.replace("+", r"\+")):
        cq.Membrane(LATTICE, 1.0, load=1.0, support=support)


@pytest.mark.parametrize("upwards", [False, True])
@pytest.mark.parametrize("value", [1e30, 1e20, 1e300, 99999.0])
def test_a_support_beyond_reach_is_none_exactly(value, upwards):
    sign = -1.0 if upwards else 1.0
    there = LATTICE.node_x < 0
    models = [
        cq.Membrane(LATTICE, 1.0, load=0.2, support=sign * np.where(there, 0.5, absent), upwards=upwards)
        for absent in (value, np.inf)
    ]
    huge, none = (cq.solve(model, tol=1e-10) for model in models)
    np.testing.assert_array_equal(huge.gap, none.gap)
    np.testing.assert_array_equal(huge.deflection, none.deflection)
    assert huge.status == "certified"
    assert f"{value:g} deep or deeper, is out of reach and counts as none" in huge.note
    assert none.note == cq.solve(none.model, tol=1e-10).note
    assert "out of reach" not in none.note
    clearance = huge.to_dataset()["gap"].values[~np.isnan(huge.to_dataset()["gap"].values)]
    np.testing.assert_allclose(clearance, sign * (huge.model.support - huge.deflection))


def test_nothing_but_numbers_for_none_is_no_support_at_all():
    for model in (
        cq.Membrane(LATTICE, 1.0, load=0.2, support=1e30),
        cq.Cable(10, spacing=1.0, tension=1.0, load=1.0, support=1e20),
        cq.CableNet.orthogonal(LATTICE, 1.0, load=0.2, support=1e20),
    ):
        assert not model.supported.any()
        solution = cq.solve(model)
        assert solution.status == "certified"
        assert solution.certificate.gap_bound < 1e-6
    deep = cq.Membrane(LATTICE, 1.0, load=0.2, support=9.0)  # never touched, but no more than a deep support
    assert deep.supported.all()


def test_reach_bounds_the_deflection_without_a_support():
    rng = np.random.default_rng(1)
    for kind in ("membrane", "cable", "net"):
        for model in both(kind, support=lambda x, y: np.full(np.shape(x), 1e9)):
            lowest = np.abs(cq.solve(with_load(model, rng.uniform(0.1, 2))).model._reach())
            free = cq.solve(with_load(model, 1.0)).deflection
            below = -free if model.upwards else free
            assert below.max() - model._datum <= model._reach() + model._frame_relief()
            assert lowest > 0


def test_a_support_that_a_larger_load_reaches_is_there_along_the_whole_path():
    """Free, the cable hangs by 1250 loads; a floor at 2e7 is beyond the reach of one, and within that of 20000."""
    cable = cq.Cable(100, spacing=1.0, tension=1.0, load=1.0, support=2e7)
    assert not cable.supported.any()
    path = cq.trace(cable, loads=[1.0, 10000.0, 20000.0], on_failure="ignore")
    assert path.monotone
    assert path.solutions[-1].contact.any()
    assert path.model.supported.all()
    assert cq.events(cable, stop=20000.0).first_touch == pytest.approx(16000.0)
    assert with_load(cable, 20000.0).supported.all()
    assert reachable(cable, [with_load(cable, 2.0)]).unreachable.all()


def test_depths_of_a_profile_where_elevations_were_meant_are_told():
    """A slab at an elevation of 4.55 below a frame at 5 is a profile of depth -4.55."""
    with pytest.warns(cq.ContactWarning, match="on the other side of height zero.*the depth of a profile"):
        cq.Membrane(LATTICE, 1.0, load=0.2, support=cq.profiles.Plane(4.55), frame_height=5.0, upwards=True)
    right = cq.Membrane(LATTICE, 1.0, load=0.2, support=cq.profiles.Plane(-4.55), frame_height=5.0, upwards=True)
    assert not right.cautions


def test_ground_on_the_other_side_of_height_zero_than_the_frame_is_natural():
    for lattice_model in (cq.Membrane, cq.CableNet.orthogonal):
        assert not lattice_model(LATTICE, 1.0, load=0.2, support=-0.3, frame_height=0.2, upwards=True).cautions
    profile = cq.profiles.Plane(0.3)
    with pytest.warns(cq.ContactWarning, match="support lies at -0.3 and the frame at 0.25, on the other side"):
        cq.Membrane(LATTICE, 1.0, load=0.2, support=profile, frame_height=0.25, upwards=True)
    net = cq.CableNet.orthogonal(LATTICE, 1.0, load=0.2, support=profile, frame_height=0.25, upwards=True)
    assert "support lies at -0.3 and the frame" in net.cautions[0]


def test_of_a_segment_too_weak_for_double_precision_no_bound_is_known_and_nothing_is_dropped():
    """The softness 1/s of a force density s below 1e-308 or so overflows; warnings are errors here."""
    points, segments = [[0, 0], [1, 0], [2, 0]], [[0, 1], [1, 2]]
    for load in (0.0, 1.0):
        net = cq.CableNet(points, segments, force_density=[1.0, 1e-320], load=load, support=[1.0, 1e30], fixed=[0])
        assert net._reach() == np.inf
        assert not net.unreachable.any()
