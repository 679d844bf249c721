"""Nets of tensioned segments: any graph, membranes and cables as special cases, and what is said of answers."""

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from strategies import BACKENDS, altered, lattice_masks

import contactqp as cq
from contactqp.models.base import ContactModel
from contactqp.models.varied import with_load
from contactqp.testing import assert_backends_agree, assert_complementary, assert_same_contact

ON_MATRICES = [name for name in BACKENDS if name != "multigrid"]

STAR = {
    "positions": [[3.0, 0.0], [0.0, 4.0], [0.0, 0.0], [-5.0, 0.0]],
    "segments": [[0, 2], [2, 1], [3, 2]],
    "tension": [6.0, 8.0, 5.0],
    "load": 4.0,
    "support": np.inf,
    "fixed": [0, 1, 3],
}


def star(**changes):
    return cq.CableNet(**(STAR | changes))


def net_over_a_dome(seed=3, count=60):
    """A random triangulation of points in the unit disk, the outermost ones fixed, in balance in plan, over a dome."""
    from scipy.spatial import Delaunay

    rng = np.random.default_rng(seed)
    inner = np.sqrt(rng.uniform(0, 0.9, count))[:, None] * unit(rng.uniform(0, 2 * np.pi, count))
    positions = np.concatenate([unit(np.linspace(0, 2 * np.pi, 25)[:-1]), inner])
    triangles = Delaunay(positions).simplices
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    segments = np.unique(np.sort(pairs, axis=1), axis=0)
    dome = cq.profiles.Paraboloid(depth=0.02, radius=5.0)
    rim = np.arange(24)
    positions = cq.CableNet.plan_in_equilibrium(positions, segments, 2.0, fixed=rim)
    return cq.CableNet(positions, segments, force_density=2.0, load=0.05, support=dome, fixed=rim)


def unit(angle):
    return np.column_stack([np.cos(angle), np.sin(angle)])


DOME = net_over_a_dome()


def test_stiffness_is_tension_over_length():
    """Force densities 6/3, 8/4 and 5/5 hold the star's middle: w = P / 5."""
    net = star()
    np.testing.assert_array_equal(net.force_density, [2.0, 2.0, 1.0])
    np.testing.assert_array_equal(net.problem.G.toarray(), [[5.0]])
    np.testing.assert_array_equal(net.problem.q, [4.0])
    solution = cq.solve(net)
    np.testing.assert_allclose(solution.deflection, [0.8], rtol=1e-12)
    assert solution.max_slope == pytest.approx(0.8 / 3)
    assert repr(net) == "CableNet(1 node, 3 segments, 3 fixed points, load=4, support=none, 1 unsupported)"
    assert net.describe(0) == "node 0 (point 2, x=0, y=0)"


def test_by_force_densities_it_is_the_same_net():
    net = star(tension=None, force_density=[2.0, 2.0, 1.0])
    np.testing.assert_array_equal(net.tension, [6.0, 8.0, 5.0])
    np.testing.assert_array_equal(net.problem.G.toarray(), star().problem.G.toarray())


def test_stiffness_and_forces_are_those_of_the_branch_node_matrix():
    """Schek 1974: G = Cᵀ Q C with a row of C for each segment, +1 and -1 at its ends."""
    rng = np.random.default_rng(1)
    heights = -np.abs(rng.normal(size=len(DOME.positions)))  # above the support
    net = cq.CableNet(
        DOME.positions,
        DOME.segments,
        rng.uniform(1, 3, len(DOME.segments)),
        load=rng.uniform(0, 0.1, DOME.size),
        support=rng.uniform(0.1, 0.2, DOME.size),
        fixed=DOME.fixed,
        fixed_height=heights[DOME.fixed],
    )
    branch = np.zeros((len(net.segments), len(net.positions)))
    rows = np.arange(len(net.segments))
    branch[rows, net.segments[:, 0]], branch[rows, net.segments[:, 1]] = 1.0, -1.0
    lengths = np.linalg.norm(branch @ net.positions, axis=1)
    whole = branch.T @ np.diag(net.tension / lengths) @ branch
    free = net.free
    np.testing.assert_allclose(net.problem.G.toarray(), whole[np.ix_(free, free)], rtol=1e-12, atol=1e-12)
    pulled = whole[np.ix_(free, free)] @ net.support + whole[np.ix_(free, net.fixed)] @ heights[net.fixed]
    np.testing.assert_allclose(net.problem.q, net.load - pulled, atol=1e-11)
    solution = cq.solve(net, "active-set")
    w = np.array(heights)
    w[free] = solution.deflection
    np.testing.assert_allclose((whole @ w)[free], net.load - solution.reaction, atol=1e-11)
    balance = solution.force_balance
    assert balance.frame == pytest.approx(-(whole @ w)[net.fixed].sum(), abs=1e-11)
    assert abs(balance.imbalance) < 1e-11
    slopes = np.abs(branch @ w) / lengths
    assert solution.max_slope == pytest.approx(slopes[~np.isin(net.segments, net.fixed).all(axis=1)].max())


@given(lattice_masks(), st.sampled_from([1.0, 0.1, 1 / 3, 2.5]), st.integers(0, 2**32 - 1))
def test_orthogonal_cables_are_the_membrane_to_the_bit(mask, spacing, seed):
    """The membrane of tension T is the net of orthogonal cables of tension S = TΔ with nodal loads P = pΔ²."""
    rng = np.random.default_rng(seed)
    lattice = cq.Lattice(mask, spacing, origin=(0.3, -0.7))
    force, pressure = rng.uniform(0.5, 2.0), rng.uniform(0.1, 1, lattice.size)
    support = rng.uniform(-0.5, 0.5, lattice.size)
    deep = rng.uniform(size=lattice.size) < 0.2
    support[deep] = 10.0 ** rng.uniform(0, 8, deep.sum())  # some are out of reach

    def height(x, y):
        return 0.1 * x - 0.3 * y**2

    for frame_height in (0.0, height):
        membrane = cq.Membrane(lattice, force / spacing, load=pressure, support=support, frame_height=frame_height)
        net = cq.CableNet.orthogonal(
            lattice, force, load=membrane.nodal_load, support=support, frame_height=frame_height
        )
        for part in ("data", "indices", "indptr"):
            np.testing.assert_array_equal(getattr(net.problem.G, part), getattr(membrane.problem.G, part))
        np.testing.assert_array_equal(net.problem.q, membrane.problem.q)
        np.testing.assert_array_equal(net.problem.lower, membrane.problem.lower)
        np.testing.assert_array_equal(net.node_x, lattice.node_x)
        np.testing.assert_allclose(net.length, spacing)
        gap = rng.uniform(0, 1, lattice.size)
        assert net.max_slope(gap) == pytest.approx(membrane.max_slope(gap), rel=1e-12)
        ours, theirs = net.force_balance(gap), membrane.force_balance(gap)
        assert ours.frame == pytest.approx(theirs.frame, rel=1e-12, abs=1e-12)
        contact = rng.uniform(size=lattice.size) < 0.5
        boundaries = [sorted(map(tuple, np.round(model.free_boundary(contact), 9))) for model in (net, membrane)]
        assert boundaries[0] == boundaries[1]


@pytest.mark.parametrize("depth", [1.0, 1e3, 1e4, 3e4, 1e5, 1e6, 1e8])
@pytest.mark.parametrize("load", [1.0, 0.01])
def test_orthogonal_cables_and_the_membrane_drop_the_same_supports(depth, load):
    lattice = cq.Frame.disk(4.0).lattice(0.5)
    support = np.where(np.arange(lattice.size) % 3, depth, 0.5)
    membrane = cq.Membrane(lattice, 2.0, load=load, support=support)
    net = cq.CableNet.orthogonal(lattice, 1.0, load=load * 0.25, support=support)
    np.testing.assert_array_equal(net.unreachable, membrane.unreachable)
    np.testing.assert_array_equal(net.problem.q, membrane.problem.q)
    heavier = [with_load(model, 100.0) for model in (net, membrane)]
    np.testing.assert_array_equal(heavier[0].unreachable, heavier[1].unreachable)


def test_orthogonal_cables_take_arrays_and_heights_as_a_membrane_does():
    lattice = cq.Frame.rectangle(4, 5).lattice(1.0)
    grid = lattice.y[:, None] + 0 * lattice.x + 3.0
    array = xr.DataArray(grid, dims=("y", "x"), coords={"y": lattice.y, "x": lattice.x})
    for support in (grid, lattice.gather(grid), array, lambda x, y: y + 3.0):
        net = cq.CableNet.orthogonal(lattice, 1.0, load=1.0, support=support, frame_height=grid)
        membrane = cq.Membrane(lattice, 1.0, load=1.0, support=support, frame_height=grid)
        np.testing.assert_array_equal(net.problem.q, membrane.problem.q)
    with pytest.raises(TypeError, match="lattice must be a Lattice, got str"):
        cq.CableNet.orthogonal("net", 1.0, load=1.0, support=1.0)
    with pytest.raises(ValueError, match="tension must be > 0, got 0"):
        cq.CableNet.orthogonal(lattice, 0.0, load=1.0, support=1.0)


def test_a_chain_of_segments_is_the_cable():
    cable, exact = cq.gallery.cable_on_parabola(9, 3, 4.0)
    chain = cq.CableNet(
        np.column_stack([np.arange(11.0), np.zeros(11)]),
        np.column_stack([np.arange(10), np.arange(1, 11)]),
        1.0,
        load=1.0,
        support=cable.support,
        fixed=[0, 10],
    )
    np.testing.assert_array_equal(chain.problem.G.toarray(), cable.problem.G.toarray())
    np.testing.assert_array_equal(chain.problem.q, cable.problem.q)
    np.testing.assert_allclose(cq.solve(chain).deflection, exact, atol=1e-12)


@pytest.mark.parametrize("datum", [2.0**20, 2.0**30])
def test_a_datum_far_away_costs_no_digits(datum):
    base = np.round(2.0**16 * (0.05 + 0.1 * DOME.node_x**2)) / 2.0**16
    near, far = (
        cq.CableNet(
            DOME.positions,
            DOME.segments,
            1.0,
            load=0.01,
            support=base + shift,
            fixed=DOME.fixed,
            fixed_height=shift,
        )
        for shift in (0.0, datum)
    )
    np.testing.assert_array_equal(far.problem.q, near.problem.q)
    assert far.problem.gap_scale == near.problem.gap_scale
    first, second = cq.solve(near), cq.solve(far)
    np.testing.assert_array_equal(second.gap, first.gap)


def test_every_way_to_give_fields_fixed_points_and_heights():
    net = DOME
    everywhere = 0.02 + 0.1 * (net.positions**2).sum(axis=1)
    mask = np.isin(np.arange(len(net.positions)), net.fixed)
    for support, load, fixed in (
        (everywhere, np.full(len(net.positions), 0.05), mask),
        (everywhere[net.free], np.full(net.size, 0.05), net.fixed.tolist()),
        (xr.DataArray(everywhere), lambda x, y: 0.05 + 0 * x, net.fixed[::-1]),
    ):
        other = cq.CableNet(net.positions, net.segments, force_density=2.0, load=load, support=support, fixed=fixed)
        np.testing.assert_allclose(other.problem.q, net.problem.q, atol=1e-15)
    slope = net.positions @ [0.1, 0.2]
    heights = [slope, slope[net.fixed], lambda x, y: 0.1 * x + 0.2 * y]
    tilted = [
        cq.CableNet(
            net.positions, net.segments, net.tension, load=0, support=np.inf, fixed=net.fixed, fixed_height=height
        )
        for height in heights
    ]
    for other in tilted:  # an unloaded net in balance in plan hangs in its frame's plane
        np.testing.assert_allclose(cq.solve(other).deflection, slope[net.free], atol=1e-12)


def test_a_plan_in_equilibrium_is_the_barycentre_of_the_neighbours():
    assert np.abs(DOME.plan_imbalance).max() < 1e-14
    for node, point in enumerate(DOME.free[:5]):
        around = DOME.segments[(DOME.segments == point).any(axis=1)].sum(axis=1) - point
        np.testing.assert_allclose(DOME.positions[around].mean(axis=0), [DOME.node_x[node], DOME.node_y[node]])
    np.testing.assert_allclose(star().plan_imbalance, [[6.0 - 5.0, 8.0]])


def test_segments_between_fixed_points_and_idle_fixed_points_change_nothing():
    more = star(
        positions=[*STAR["positions"], [9.0, 9.0]],
        segments=[*STAR["segments"], [0, 1]],
        tension=[*STAR["tension"], 7.0],
        fixed=[0, 1, 3, 4],
        fixed_height=[1.0, 1.0, 1.0, 1e6],
    )
    assert more.problem.gap_scale == star(fixed_height=1.0).problem.gap_scale
    np.testing.assert_array_equal(more.problem.G.toarray(), [[5.0]])
    np.testing.assert_allclose(cq.solve(more).deflection, [1.8])
    assert more.max_slope(np.array([1.0 - 1.8])) == pytest.approx(0.8 / 3)
    # The segment from 0 to 10 has the slope 2, but joins fixed points only; w = (4 + 2 x 10) / 5.
    steep = star(segments=[*STAR["segments"], [0, 1]], tension=[*STAR["tension"], 7.0], fixed_height=[0.0, 10.0, 0.0])
    assert cq.solve(steep).max_slope == pytest.approx(4.8 / 3)


def test_an_unloaded_net_is_measured_by_how_far_its_frame_leaves_a_plane():
    assert star(load=0.0, support=100.0, fixed_height=[0.0, 6.0, 0.0]).problem.gap_scale == pytest.approx(4.0)
    lattice = cq.Lattice(np.ones((1, 1), dtype=bool), 1.0)
    membrane = cq.Membrane(lattice, 1.0, load=0.0, support=100.0, frame_height=lambda x, y: 8.0 * (x > 0))
    assert membrane.problem.gap_scale == pytest.approx(6.0)


def test_inputs_are_never_modified_nor_aliased():
    positions, segments = np.array(STAR["positions"]), np.array(STAR["segments"])
    support = np.full(4, 1.0)
    net = star(positions=positions, segments=segments, support=support)
    positions[:], segments[:], support[:] = 0.0, 0, 7.0
    assert net.support.tolist() == [1.0]
    assert net.length.tolist() == [3.0, 4.0, 5.0]
    for array in (net.positions, net.segments, net.support, net.load, net.fixed, net.free, net.tension):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_all_backends_for_matrices_agree():
    comparison = assert_backends_agree(DOME, ON_MATRICES, tol=1e-7)
    assert comparison.decided["contact"] > 3
    assert comparison.decided["undecided"] == 0
    assert set(cq.compare(DOME).solutions) == set(ON_MATRICES)
    with pytest.raises(cq.UnsuitableProblemError, match="needs a problem on a lattice"):
        cq.solve(DOME, "multigrid")


def test_the_assertions_name_points():
    solution = cq.solve(DOME)
    assert_complementary(DOME, solution.gap)
    with pytest.raises(AssertionError, match=r"worst node \d+ \(point \d+, x="):
        assert_complementary(DOME, solution.gap + 0.1)
    assert assert_same_contact(solution, cq.solve(DOME, "clarabel")).all()
    elsewhere = cq.CableNet(
        DOME.positions + np.array([0.1, 0.0]), DOME.segments, 1.0, load=0.05, support=0.5, fixed=DOME.fixed
    )
    with pytest.raises(ValueError, match="first and second must be on the same nodes"):
        assert_same_contact(solution, cq.solve(elsewhere))


def test_what_compare_says_of_nodes_and_boundaries():
    comparison = cq.compare(DOME, ["psor", "active-set"], tol=1e-4)
    worst = comparison.worst_nodes(1).iloc[0]
    node = int(worst["node"])
    assert (worst["x"], worst["y"]) == tuple(DOME.positions[DOME.free[node]])
    assert comparison.to_frame().loc["psor", "boundary_distance"] == 0.0
    contact = cq.solve(DOME).contact
    state = dict(zip(DOME.free.tolist(), contact.tolist(), strict=True))
    expected = {
        tuple(np.round((DOME.positions[one] + DOME.positions[other]) / 2, 9))
        for one, other in DOME.segments.tolist()
        if one in state and other in state and state[one] != state[other]
    }
    assert {tuple(np.round(middle, 9)) for middle in DOME.free_boundary(contact)} == expected
    assert len(expected) > 3


def test_the_fields_of_a_dataset_lie_along_the_nodes(tmp_path):
    solution = cq.solve(DOME)
    data = solution.to_dataset()
    assert data["gap"].dims == data["load"].dims == ("node",)
    np.testing.assert_array_equal(data["point"], DOME.free)
    np.testing.assert_array_equal(data["x"], DOME.node_x)
    np.testing.assert_array_equal(data["gap"], solution.gap)
    assert data["load"].attrs["units"] == data["reaction"].attrs["units"] == "force"
    assert "contact_pressure" not in data
    assert set(np.unique(data["contact_state"])) == {0.0, 1.0}
    data.to_netcdf(tmp_path / "net.nc", engine="netcdf4")
    with xr.open_dataset(tmp_path / "net.nc", engine="netcdf4") as stored:
        xr.testing.assert_identical(stored.load(), data)


def test_nodes_that_stand_for_no_area_have_no_pressure():
    solution = cq.solve(DOME)
    for attribute in ("contact_pressure", "contact_area"):
        with pytest.raises(AttributeError, match=f"{attribute} needs a Membrane or a Cable; .* stand for no area"):
            getattr(solution, attribute)
    assert solution.total_reaction.lower == pytest.approx(solution.reaction.sum())
    assert solution.polish().status == "certified"


def test_a_net_is_certified_and_drawn_by_what_is_certain():
    answer = cq.solve(DOME, "osqp", tol=1e-2).gap
    certificate = cq.certify(DOME, answer + 1e-3, effort="fast")
    assert certificate.gap_bound == cq.certify(DOME.problem, answer + 1e-3, effort="fast").gap_bound
    assert certificate.undecided.any()
    assert f"undecided ({certificate.undecided.sum()})" in texts(certificate.plot())
    with pytest.raises(AttributeError, match="contact_area needs a Membrane or a Cable"):
        _ = certificate.contact_area


def test_every_model_is_a_contact_model():
    lattice = cq.Frame.rectangle(4, 4).lattice(1.0)
    models = [DOME, cq.Membrane(lattice, 1.0, load=1.0, support=1.0), cq.gallery.cable_on_floor(9, 2)[0]]
    assert all(isinstance(model, ContactModel) for model in models)
    with pytest.raises(TypeError, match="abstract"):
        ContactModel()


def texts(figure):
    parts = [figure, *figure.subfigs]
    legends = [legend for part in parts for legend in part.legends] + [a.get_legend() for a in figure.axes]
    found = {text.get_text() for axes in figure.axes for text in [axes.title, *axes.texts]}
    return found | {text.get_text() for legend in legends if legend for text in legend.get_texts()}


def test_the_picture_shows_each_state():
    solution = cq.solve(DOME)
    touching = int(solution.certificate.contact.sum())
    assert {
        "Contact map",
        f"certainly in contact ({touching})",
        f"certainly clear ({DOME.size - touching})",
        "fixed (24)",
    } <= texts(solution.plot())
    bare = altered(solution, certificate=None)
    assert f"in contact ({touching})" in texts(bare.plot())
    flat = cq.CableNet(DOME.positions, DOME.segments, 1.0, load=0.0, support=0.0, fixed=DOME.fixed)
    assert f"undecided ({flat.size})" in texts(cq.solve(flat).plot())


@pytest.mark.parametrize(
    "net",
    [
        DOME,
        star(),
        star(support=0.1, fixed_height=[0.0, 0.1, 0.2]),
        cq.CableNet([[0, 0], [1, 0], [2, 0]], [[0, 1], [1, 2]], 1.0, load=1.0, support=0.2, fixed=[0, 2]),
        cq.CableNet.orthogonal(cq.Frame.disk(1).lattice(0.2), 1.0, load=0.1, support=0.1),
    ],
    ids=repr,
)
def test_every_net_can_be_drawn(net, tmp_path):
    cq.solve(net).plot().savefig(tmp_path / "net.png", dpi=40)
    comparison = cq.compare(net, ["clarabel", "psor"], tol=1e-3)
    comparison.plot().savefig(tmp_path / "comparison.png", dpi=40)
    comparison.plot_disagreement().savefig(tmp_path / "disagreement.png", dpi=40)
    page = comparison.report(tmp_path / "report.html")
    assert page.stat().st_size > 10_000


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"positions": [0.0, 1.0]}, ValueError, r"positions must have shape \(points, 2\), got \(2,\)"),
        ({"positions": [[0.0, 1, 2]] * 4}, ValueError, r"positions must have shape \(points, 2\), got \(4, 3\)"),
        ({"positions": [[3, 0], [0, np.nan], [0, 0], [-5, 0]]}, ValueError, r"positions .* point 1 is \(0, nan\)"),
        ({"segments": [0, 2]}, ValueError, r"segments must have shape \(segments, 2\), got \(2,\)"),
        ({"segments": np.zeros((0, 2), int)}, ValueError, r"segments must hold one or more, got shape \(0, 2\)"),
        ({"segments": [[0.0, 2.0]]}, TypeError, "segments must hold point numbers, integers, got dtype float64"),
        (
            {"segments": [[0, 2], [2, 1], [4, 2]]},
            ValueError,
            r"segments\[2\] = \(4, 2\): there are 4 points, .* 0 to 3",
        ),
        ({"segments": [[0, 2], [2, 1], [-1, 2]]}, ValueError, r"segments\[2\] = \(-1, 2\): there are 4 points"),
        ({"segments": [[0, 2], [2, 2], [3, 2]]}, ValueError, r"segments\[1\] = \(2, 2\) joins a point to itself"),
        ({"segments": [[0, 2], [2, 1], [2, 0]]}, ValueError, r"segments\[2\] = \(2, 0\) repeats segments\[0\].*one of"),
        (
            {"positions": [[0.0, 0.0], [0.0, 4.0], [0.0, 0.0], [-5.0, 0.0]]},
            ValueError,
            r"segments\[0\] = \(0, 2\) has no length: both points lie at \(0, 0\)",
        ),
        ({"tension": 0.0}, ValueError, "tension must be > 0, got 0"),
        ({"tension": [1.0, -2.0, 3.0]}, ValueError, r"tension must be > 0, but tension\[1\] is -2"),
        ({"tension": [1.0, np.inf, 3.0]}, ValueError, "tension must be finite, but entry 1 is inf"),
        ({"tension": [1.0, 2.0]}, ValueError, r"tension must be a number or have shape \(3,\), got \(2,\)"),
        ({"tension": "high"}, TypeError, "tension must be a real number, got 'high'"),
        ({"tension": None}, ValueError, "give either tension or force_density"),
        ({"force_density": 1.0}, ValueError, "give either tension or force_density"),
        ({"fixed": []}, ValueError, "fixed must name one point or more"),
        ({"fixed": [0, 4]}, ValueError, "fixed names point 4, but there are 4 points, numbered 0 to 3"),
        ({"fixed": [0, -1]}, ValueError, "fixed names point -1"),
        ({"fixed": [0.0, 1.0]}, TypeError, "fixed must hold point numbers or be a mask, got dtype float64"),
        ({"fixed": [[0], [1]]}, ValueError, r"fixed must have one dimension, got shape \(2, 1\)"),
        ({"fixed": [True, False]}, ValueError, r"fixed as a mask must have shape \(4,\), got \(2,\)"),
        ({"fixed": [False] * 4}, ValueError, "fixed must name one point or more"),
        ({"fixed": [0, 1, 2, 3]}, ValueError, "all 4 points are fixed"),
        (
            {"fixed": [0, 1], "segments": [[0, 2], [2, 1]], "tension": 1.0},
            ValueError,
            r"no fixed point, among them that of point 3 ",
        ),
        (
            {
                "positions": [*STAR["positions"], [1, 1], [2, 2]],
                "segments": [*STAR["segments"], [4, 5]],
                "tension": 1.0,
            },
            ValueError,
            r"1 part\(s\) of the net have no fixed point, among them that of point 4 \(x=1, y=1\); fix a point of each",
        ),
        ({"load": np.nan}, ValueError, r"load must be finite, but is nan at node 0 \(point 2, x=0, y=0\)"),
        ({"load": [1.0, 2.0]}, ValueError, r"load must be a number or have shape \(1,\) or \(4,\), got \(2,\)"),
        ({"load": 1j}, TypeError, "load must be real"),
        ({"support": -np.inf}, ValueError, r"support must be finite or \+inf \(no support\), but is -inf at node 0"),
        ({"support": lambda x, y: np.ones(3)}, ValueError, r"support\(x, y\) must return a number or shape \(1,\)"),
        ({"fixed_height": np.nan}, ValueError, "fixed_height must be finite, but is nan at point 0"),
        ({"fixed_height": [1.0, 2.0]}, ValueError, r"fixed_height must be .* shape \(3,\) or \(4,\), got \(2,\)"),
        (
            {"fixed_height": lambda x, y: x[:1]},
            ValueError,
            r"fixed_height\(x, y\) must return a number or shape \(3,\)",
        ),
        ({"tension": 1e308, "positions": np.array(STAR["positions"]) * 1e-5}, ValueError, "too large"),
    ],
)
def test_bad_nets_say_what_is_wrong(changes, error, message):
    with pytest.raises(error, match=message):
        star(**changes)
