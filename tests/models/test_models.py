from fractions import Fraction

import numpy as np
import pytest
import xarray as xr
from springs import springs

import contactqp as cq
import contactqp.testing
from contactqp import profiles
from contactqp.gallery import bowl

LATTICE = cq.Frame.rectangle(5, 4, center=(0.5, 0.0)).lattice(1.0)


def test_q_is_load_less_shape_and_reactions_follow():
    """Eq. (2.9): R = P + G ω - G f."""
    rng = np.random.default_rng(1)
    f, p = rng.uniform(0.5, 1.0, 12), rng.uniform(0, 2, 12)
    membrane = cq.Membrane(LATTICE, tension=2.0, load=p, support=f)
    gap = rng.uniform(0, 1, 12)
    matrix = membrane.problem.G.toarray()
    np.testing.assert_allclose(membrane.problem.reaction(gap), p + matrix @ gap - matrix @ f, atol=1e-14)
    np.testing.assert_allclose(membrane.deflection(gap), f - gap)


def test_the_objective_is_the_potential_energy_less_that_of_the_gap_zero():
    rng = np.random.default_rng(2)
    f = rng.uniform(0.5, 1.0, 12)
    membrane = cq.Membrane(LATTICE, tension=2.0, load=0.7, support=f)
    matrix, P = membrane.problem.G.toarray(), membrane.nodal_load

    def energy(w):
        return 0.5 * w @ matrix @ w - P @ w

    gap = rng.uniform(0, 1, 12)
    assert membrane.problem.objective(gap) == pytest.approx(energy(f - gap) - energy(f))


def test_every_way_to_give_a_field_gives_the_same_model():
    def function(x, y):
        return 1.0 + 0.1 * x + 0.2 * y**2

    grid = function(LATTICE.x[None, :], LATTICE.y[:, None])
    array = xr.DataArray(grid, dims=("y", "x"), coords={"y": LATTICE.y, "x": LATTICE.x})
    larger = np.arange(-4.0, 5.0)
    covering = xr.DataArray(
        function(larger[:, None], larger[None, :]), dims=("x", "y"), coords={"x": larger, "y": larger}
    )
    reference = cq.Membrane(LATTICE, 1.0, load=0.3, support=function).support
    for given in (grid, LATTICE.gather(grid), array, array.T, covering, grid.tolist()):
        shifted = cq.Frame.rectangle(5, 4, center=(0.5, 0.0)).lattice(1.0) if given is not covering else LATTICE
        np.testing.assert_allclose(cq.Membrane(shifted, 1.0, load=0.3, support=given).support, reference)


def test_a_lattice_shifted_by_half_covers_a_shifted_dataarray_only():
    array = xr.DataArray(np.ones((3, 3)), dims=("y", "x"), coords={"y": [0.0, 1, 2], "x": [0.0, 1, 2]})
    with pytest.raises(ValueError, match="support does not cover the lattice"):
        cq.Membrane(LATTICE, 1.0, load=0.3, support=array)
    descending = xr.DataArray(LATTICE.y[::-1, None] + 0 * LATTICE.x, dims=("y", "x"), coords={"y": LATTICE.y[::-1]})
    membrane = cq.Membrane(LATTICE, 1.0, load=0.3, support=9.0, frame_height=descending)
    by_function = cq.Membrane(LATTICE, 1.0, load=0.3, support=9.0, frame_height=lambda x, y: y)
    np.testing.assert_allclose(membrane.problem.q, by_function.problem.q)
    twice = xr.DataArray(np.ones((6, 3)), dims=("y", "x"), coords={"y": [0, 0, 1, 1, 2, 2]})
    with pytest.raises(ValueError, match="support has repeated coordinates along y"):
        cq.Membrane(LATTICE, 1.0, load=0.3, support=twice)
    with pytest.raises(ValueError, match=r"dims \('y', 'x'\), got \('u', 'v'\)"):
        cq.Membrane(LATTICE, 1.0, load=0.3, support=xr.DataArray(np.ones((3, 3)), dims=("u", "v")))


def test_inputs_are_never_modified_nor_aliased():
    f = np.full(12, 1.0)
    membrane = cq.Membrane(LATTICE, 1.0, load=0.3, support=f)
    f[:] = 7.0
    assert membrane.support.max() == 1.0
    with pytest.raises(ValueError, match="read-only"):
        membrane.support[0] = 2.0


def test_a_raised_frame_is_a_change_of_datum():
    """Frame and support shifted together: the same gap, and deflections shifted by as much."""
    shape = profiles.Paraboloid(depth=0.2, radius=8.0)
    low = cq.Membrane(LATTICE, 1.0, load=0.3, support=shape)
    high = cq.Membrane(LATTICE, 1.0, load=0.3, support=lambda x, y: shape(x, y) + 5.0, frame_height=5.0)
    np.testing.assert_allclose(high.problem.q, low.problem.q, atol=1e-13)
    assert high.problem.gap_scale == pytest.approx(low.problem.gap_scale)
    first, second = cq.solve(low, "clarabel"), cq.solve(high, "clarabel")
    np.testing.assert_allclose(second.deflection, first.deflection + 5.0, atol=1e-9)
    assert abs(second.force_balance.imbalance) < 1e-12
    assert second.max_slope == pytest.approx(first.max_slope)


def test_frame_heights_by_function_and_by_array_agree():
    def height(x, y):
        return 0.1 * x - 0.05 * y

    wide = cq.Lattice.from_mask(np.pad(np.ones((3, 4), dtype=bool), 1), 1.0)
    grid = height(wide.x[None, :], wide.y[:, None])
    by_function = cq.Membrane(wide, 1.0, load=0.0, support=9.0, frame_height=height)
    by_array = cq.Membrane(wide, 1.0, load=0.0, support=9.0, frame_height=grid)
    np.testing.assert_allclose(by_function.problem.q, by_array.problem.q)
    plane = cq.solve(by_function, "clarabel").deflection
    np.testing.assert_allclose(plane, height(wide.node_x, wide.node_y), atol=1e-9)
    tight = cq.Lattice.from_mask(np.ones((3, 4), dtype=bool), 1.0)
    with pytest.raises(ValueError, match="outside the lattice's array"):
        cq.Membrane(tight, 1.0, load=0.0, support=9.0, frame_height=np.zeros((3, 4)))
    with pytest.raises(ValueError, match="frame_height must be a number, a function or have shape"):
        cq.Membrane(wide, 1.0, load=0.0, support=9.0, frame_height=np.zeros((2, 2)))
    with pytest.raises(ValueError, match="frame_height must be finite"):
        cq.Membrane(
            wide, 1.0, load=0.0, support=9.0, frame_height=lambda x, y: x / 0.0 if np.seterr(all="ignore") else x
        )


@pytest.mark.parametrize("datum", [2.0**20, 2.0**30])
def test_a_datum_far_away_costs_no_digits(datum):
    base = np.round(2.0**16 * (0.05 + 0.1 * LATTICE.node_x**2)) / 2.0**16
    near = cq.Membrane(LATTICE, 0.7, load=0.5, support=base)
    far = cq.Membrane(LATTICE, 0.7, load=0.5, support=base + datum, frame_height=datum)
    np.testing.assert_array_equal(far.problem.q, near.problem.q)
    assert far.problem.gap_scale == near.problem.gap_scale


def test_a_support_out_of_reach_does_not_loosen_the_tolerance():
    """A very deep floor beside a hill, in place of no support at all, must not count as the scale of the answer."""
    lattice = cq.Frame.rectangle(2, 2).lattice(0.1)

    def hill(x, y, floor):
        return np.where(np.hypot(x, y) < 0.3, 0.05 + 0.1 * (x * x + y * y), floor)

    without, deep = (
        cq.Membrane(lattice, 1.0, load=1.0, support=lambda x, y, floor=floor: hill(x, y, floor))
        for floor in (np.inf, 1e6)
    )
    assert deep.problem.gap_scale == pytest.approx(without.problem.gap_scale)
    assert without.problem.gap_scale < 0.5
    exact = cq.solve(without, "clarabel", tol=1e-9).deflection
    for backend in ("clarabel", "psor", "osqp"):
        solution = cq.solve(deep, backend, on_failure="ignore")
        if solution.status == "certified":
            np.testing.assert_allclose(solution.deflection, exact, atol=2e-6 * without.problem.gap_scale)
        else:
            assert solution.relative_bound > 1e-6


@pytest.mark.parametrize("backend", ["osqp", "clarabel", "mangasarian", "psor"])
def test_a_peg_under_a_point_load_does_not_loosen_the_tolerance(backend):
    """The unsupported deflection would be millions of times the true one; the answer itself bounds the scale."""
    lattice = cq.Frame.rectangle(40, 40).lattice(1.0)
    middle = (lattice.node_x == 0) & (lattice.node_y == 0)
    peg = cq.Membrane(lattice, 1.0, load=np.where(middle, 1e3, 0.0), support=np.where(middle, 1e-4, np.inf))
    matrix = peg.problem.G.toarray()
    exact = 1e-4 * np.linalg.solve(matrix, middle.astype(float)) / np.linalg.inv(matrix)[middle, middle]
    solution = cq.solve(peg, backend, on_failure="ignore")
    if solution.status == "certified":
        np.testing.assert_allclose(solution.deflection, exact, atol=1e-5 * exact.max())


def test_heavy_load_on_a_shallow_support_is_measured_by_the_support():
    assert cq.Membrane(LATTICE, 1.0, load=1e3, support=0.01).problem.gap_scale == pytest.approx(0.01)
    assert cq.Membrane(LATTICE, 1.0, load=1e6, support=0.0).problem.gap_scale == pytest.approx(1.0, rel=0.4)


def test_a_load_that_closes_gaps_does_not_loosen_the_tolerance():
    matrix = 2 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)
    problem = cq.ContactQP(matrix, [1e12, -1.0, -1.0])
    assert problem.gap_scale < 10
    assert cq.solve(problem, "mangasarian", on_failure="ignore").gap[1:] == pytest.approx([1.0, 1.0], rel=1e-3)
    with pytest.raises(AssertionError, match="certified bound"):
        cq.testing.assert_complementary(problem, [0.0, 0.0, 0.0])


def test_no_support_at_some_nodes():
    support = np.where(LATTICE.node_x < 1, 0.1, np.inf)
    membrane = cq.Membrane(LATTICE, tension=1.0, load=1.0, support=support)
    assert not membrane.problem.supported.all()
    solution = cq.solve(membrane, "clarabel")
    far = support == np.inf
    np.testing.assert_allclose(solution.reaction[far], 0.0, atol=1e-9)
    assert (solution.deflection[far] > 0.1).any()
    data = solution.to_dataset()
    assert np.isinf(data.gap.values[LATTICE.mask][far]).all()
    very_deep = cq.Membrane(LATTICE, 1.0, load=1.0, support=np.where(far, 1e3, support))
    np.testing.assert_allclose(cq.solve(very_deep, "clarabel").deflection, solution.deflection, atol=1e-6)


def test_no_support_at_all_is_the_linear_problem():
    membrane = cq.Membrane(LATTICE, tension=1.0, load=1.0, support=np.inf)
    exact = np.linalg.solve(membrane.problem.G.toarray(), membrane.nodal_load)
    for backend in ("osqp", "clarabel", "mangasarian", "psor"):
        solution = cq.solve(membrane, backend)
        assert solution.status == "certified"
        np.testing.assert_allclose(solution.deflection, exact, atol=1e-6 * exact.max())
        assert not solution.contact.any()


def test_cable_matrix_and_load():
    cable = cq.Cable(nodes=3, spacing=0.5, tension=2.0, load=3.0, support=1.0)
    np.testing.assert_array_equal(cable.problem.G.toarray(), 4.0 * np.array([[2, -1, 0], [-1, 2, -1], [0, -1, 2]]))
    np.testing.assert_array_equal(cable.nodal_load, [1.5, 1.5, 1.5])
    assert cable.span == 2.0
    np.testing.assert_array_equal(cable.lattice.node_x, [0.5, 1.0, 1.5])


def test_cable_functions_of_x_or_of_x_and_y():
    one = cq.Cable(span=4.0, spacing=1.0, tension=1.0, load=np.cos, support=lambda x, rise=1.0, *more: 2 + rise * x)
    two = cq.Cable(span=4.0, spacing=1.0, tension=1.0, load=lambda x, y: np.cos(x), support=profiles.Plane(2.0, 1.0))
    np.testing.assert_array_equal(one.problem.q, two.problem.q)


def test_cable_ends_at_different_heights():
    cable = cq.Cable(span=4.0, spacing=1.0, tension=1.0, load=0.0, support=99.0, frame_height=lambda x: 0.5 * x)
    np.testing.assert_allclose(cq.solve(cable, "clarabel").deflection, [0.5, 1.0, 1.5], atol=1e-9)


def test_force_balance_holds_to_rounding():
    solution = cq.solve(cq.gallery.paper_hexagon(), "psor")
    balance = solution.force_balance
    assert balance.load == pytest.approx(1857 * 0.03)
    assert balance.reaction > 0
    assert abs(balance.imbalance) < 1e-11


def test_max_slope_is_the_largest_difference_along_an_arm():
    membrane = cq.Membrane(LATTICE, 1.0, load=0.0, support=100.0)
    w = np.arange(12.0) ** 2
    padded = np.zeros((LATTICE.shape[0] + 2, LATTICE.shape[1] + 2))
    padded[1:-1, 1:-1][LATTICE.mask] = w
    touched = np.pad(LATTICE.mask, 1)
    slopes = [
        np.abs(padded[i, j] - padded[row, column])
        for i, j in zip(*np.nonzero(touched), strict=True)
        for row, column in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1))
    ]
    assert membrane.max_slope(100.0 - w) == pytest.approx(max(slopes))


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"tension": 0.0}, ValueError, "tension must be > 0, got 0"),
        ({"tension": -1}, ValueError, "tension must be > 0, got -1"),
        ({"tension": np.inf}, ValueError, "tension must be finite, got inf"),
        ({"tension": "1"}, TypeError, "tension must be a real number, got '1'"),
        ({"tension": 1 + 0j}, TypeError, "tension must be a real number"),
        ({"tension": True}, TypeError, "tension must be a real number, got True"),
        ({"load": np.nan}, ValueError, "load must be finite, but is nan at node 0"),
        ({"load": np.inf}, ValueError, "load must be finite, but is inf at node 0"),
        ({"load": np.ones((12, 1))}, ValueError, r"load must be a number, .* got shape \(12, 1\)"),
        ({"load": np.ones(13)}, ValueError, r"12 nodes, got shape \(13,\)"),
        ({"load": np.ones(12) * 1j}, TypeError, "load must be real, got complex"),
        ({"load": "heavy"}, TypeError, "load must hold real numbers"),
        ({"support": -np.inf}, ValueError, r"support must be finite or \+inf \(no support\), but is -inf at node 0"),
        ({"support": lambda x, y: np.ones(3)}, ValueError, r"support\(x, y\) must return a number or shape \(12,\)"),
        ({"lattice": "hexagon"}, TypeError, "lattice must be a Lattice, got str"),
        ({"frame_height": np.nan}, ValueError, "frame_height must be finite, got nan"),
        ({"frame_height": "high"}, TypeError, "frame_height must be a real number"),
    ],
)
def test_bad_membranes_say_what_is_wrong(arguments, error, message):
    good = {"lattice": LATTICE, "tension": 1.0, "load": 0.1, "support": 1.0}
    with pytest.raises(error, match=message):
        cq.Membrane(**(good | arguments))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"span": 1.0, "nodes": 3}, "give either span or nodes"),
        ({}, "give either span or nodes"),
        ({"span": 2.5}, "whole multiple"),
        ({"span": 1.0}, "whole multiple"),
        ({"nodes": 0}, "nodes must be >= 1, got 0"),
        ({"span": 3.0, "spacing": -1.0}, "spacing must be > 0"),
        ({"span": 3.0, "tension": 0.0}, "tension must be > 0"),
    ],
)
def test_bad_cables_say_what_is_wrong(arguments, message):
    good = {"spacing": 1.0, "tension": 1.0, "load": 0.1, "support": 1.0}
    with pytest.raises(ValueError, match=message):
        cq.Cable(**(good | arguments))


def test_profiles_are_positive_downwards_and_have_reprs():
    x = np.array([-2.0, 0.0, 2.0])
    np.testing.assert_allclose(profiles.Cone(depth=1.0, slope=0.5)(x, 0.0), [2, 1, 2])
    np.testing.assert_allclose(profiles.Hemisphere(depth=1.0, radius=2.0)(x, 0.0), [3, 1, 3])
    np.testing.assert_allclose(profiles.Cylinder(depth=1.0, radius=2.0, axis="x")(x, 0.0), [1, 1, 1])
    np.testing.assert_allclose(profiles.Paraboloid(depth=1.0, radius=-2.0)(x, 0.0), [0, 1, 0])
    np.testing.assert_allclose(profiles.Plane(1.0, slope_y=2.0)(x, 3.0), [7, 7, 7])
    assert repr(profiles.Plane(1.0)) == "Plane(depth=1.0, slope_x=0.0, slope_y=0.0)"
    both = profiles.Uppermost(profiles.Plane(1.5), profiles.Hemisphere(1.0, 2.0))
    np.testing.assert_allclose(both(x, 0.0), [1.5, 1, 1.5])
    for bad in (
        lambda: profiles.Plane(np.nan),
        lambda: profiles.Paraboloid(1.0, 0.0),
        lambda: profiles.Hemisphere(1.0, -1.0),
        lambda: profiles.Cone(1.0, np.inf),
        lambda: profiles.Cone(1.0, 1.0, center=(1.0,)),
        lambda: profiles.Cylinder(1.0, 1.0, axis="z"),
        lambda: profiles.HillAndFloor(scale=0.0),
    ):
        with pytest.raises(ValueError, match="must"):
            bad()
    with pytest.raises(TypeError, match="one or more profiles"):
        profiles.Uppermost()


def test_the_surrogate_surface():
    """f = min(5/4, 5 (m/96)²): touches the frame's plane at the summit, reaches the floor at half scale."""
    surface = profiles.HillAndFloor()
    assert surface(0.0, 0.0) == 0.0
    assert surface(16.0, 0.0) == 1.25
    assert surface(0.0, 12.0) == 1.25
    assert surface(4.0, 4.0) == pytest.approx(5 * (24 / 96) ** 2)


def test_gap_scale_does_not_depend_on_the_spacing():
    scales = [bowl(nodes).problem.gap_scale for nodes in (31, 63, 127, 255)]
    assert max(scales) < 1.05 * min(scales)


def test_nodes_of_a_lattice_stand_for_equal_areas():
    membrane = cq.Membrane(cq.Frame.rectangle(5, 4).lattice(0.5), 1.0, load=0.3, support=9.0)
    cable = cq.Cable(nodes=3, spacing=0.5, tension=2.0, load=3.0, support=1.0)
    for model, area in ((membrane, 0.25), (cable, 0.5)):
        np.testing.assert_array_equal(model.node_area, np.full(model.size, area))
        assert model.node_area.strides == (0,), "one number repeated takes no memory"
        with pytest.raises(ValueError, match="read-only"):
            model.node_area[0] = 1.0
    assert membrane.nodal_load.strides == cable.nodal_load.strides == (0,)


def test_areas_of_nodes_in_contact_are_added_and_rounded_outwards():
    model = springs()
    solution = cq.solve(model)
    contact = model.exact == model.support
    assert 10 < contact.sum() < 30
    exact = sum(map(Fraction, model.node_area[contact]))
    area = solution.contact_area
    assert Fraction(area.lower) < exact < Fraction(area.upper)
    assert area.upper - area.lower < 1e-14
    held = np.where(contact, solution.reaction, 0.0)
    np.testing.assert_array_equal(solution.contact_pressure, held / model.node_area)
    rough = cq.certify(model, model.support - model.exact + 10.0, effort="fast")
    assert 0 < rough.contact.sum() < (rough.contact | rough.undecided).sum()
    assert Fraction(rough.contact_area.lower) < sum(map(Fraction, model.node_area[rough.contact]))
    assert Fraction(rough.contact_area.upper) > sum(map(Fraction, model.node_area[rough.contact | rough.undecided]))
    free = springs(support=np.full(40, 9.0))
    assert cq.solve(free).contact_area == (0.0, 0.0)


def test_the_lattice_of_a_cable_is_known_before_its_load_and_support():
    lattice = cq.Cable.lattice_of(4.0, spacing=0.5, start=-2.0)
    cable = cq.Cable(4.0, spacing=0.5, tension=1.0, load=1.0, support=lattice.x**2, start=-2.0)
    np.testing.assert_array_equal(cable.lattice.x, lattice.x)
    np.testing.assert_array_equal(cable.support, cable.node_x**2)
    assert cq.Cable.lattice_of(nodes=3, spacing=1.0).shape == (1, 3)
    with pytest.raises(ValueError, match="whole multiple"):
        cq.Cable.lattice_of(4.0, spacing=0.7)
    with pytest.raises(ValueError, match="start must be finite, got nan"):
        cq.Cable.lattice_of(4.0, spacing=0.5, start=np.nan)


@pytest.mark.parametrize(
    "model",
    [
        cq.Membrane(LATTICE, 1.0, load=0.3, support=9.0),
        cq.Cable(nodes=3, spacing=0.5, tension=2.0, load=3.0, support=1.0),
        cq.CableNet.orthogonal(LATTICE, 1.0, load=1.0, support=1.0),
    ],
    ids=repr,
)
def test_fields_are_taken_at_the_nodes_as_when_the_model_was_made(model):
    expected = 2.0 * model.node_x
    for field in (lambda x, y: 2 * x, expected, expected.tolist()):
        values = model.at_nodes(field, "depth")
        np.testing.assert_array_equal(values, expected)
        assert not values.flags.writeable
    assert model.at_nodes(np.inf, "depth", allow_inf=True).min() == np.inf
    with pytest.raises(ValueError, match=r"depth must be finite, but is inf at node 0 \("):
        model.at_nodes(np.inf, "depth")
    with pytest.raises(ValueError, match=r"depth must be finite or \+inf \(no support\), but is -inf at node 0 \("):
        model.at_nodes(-np.inf, "depth", allow_inf=True)
    with pytest.raises(ValueError, match=r"depth\(x, y\) must return a number or shape"):
        model.at_nodes(lambda x, y: np.ones((2, 2)), "depth")
    with pytest.raises(ValueError, match="depth must be a number"):
        model.at_nodes(np.ones(99), "depth")
