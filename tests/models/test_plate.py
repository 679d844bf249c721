"""Plates against series and tables, their matrix, and what edges they may have."""

import numpy as np
import pytest
from scipy import sparse

import contactqp as cq
from contactqp.models.varied import with_load, with_tension

SQUARE = cq.Frame.rectangle(1.0, 1.0).lattice(0.125)

CORNER = np.ones((9, 9), dtype=bool)
CORNER[4:, 4:] = False

HOLE = np.ones((11, 12), dtype=bool)
HOLE[4:7, 3:8] = False


@pytest.mark.parametrize("tension", [0.0, 20.0])
def test_a_simply_supported_square_converges_to_naviers_series(tension):
    found = []
    for nodes in (9, 19, 39):
        plate, exact = cq.gallery.plate_under_load(nodes, tension)
        solution = cq.solve(plate)
        assert solution.status == cq.Status.CERTIFIED
        found.append(np.abs(solution.deflection - exact).max())
    assert (np.log2(np.array(found[:-1]) / found[1:]) >= 1.9).all()


def test_the_series_has_the_deflection_and_the_moments_of_the_table():
    """Timoshenko and Woinowsky-Krieger 1959, table 8: 0.00406 pL⁴/D and 0.0479 pL² in the middle, ν = 0.3."""
    plate, exact = cq.gallery.plate_under_load(39)
    assert exact.max() == pytest.approx(0.00406, abs=5e-6)
    data = cq.solve(plate).to_dataset()
    middle = {"x": 0.5, "y": 0.5}
    for name in ("moment_x", "moment_y"):
        assert float(data[name].sel(middle, method="nearest")) == pytest.approx(0.0479, abs=1e-4)
    # The corners are held down by R = 2 M_xy = 0.065 pL²; the node nearest to one lies beside it.
    twist = np.abs(data["moment_xy"].to_numpy())
    assert np.nanmax(twist) == pytest.approx(0.065 / 2, rel=0.02)
    assert data["moment_x"].attrs["units"] == "force"


def test_a_clamped_square_sags_as_in_the_table():
    """Timoshenko and Woinowsky-Krieger 1959, table 35: 0.00126 pL⁴/D and 0.0231 pL² in the middle, ν = 0.3."""
    plate = cq.Plate(cq.Frame.rectangle(1.0, 1.0).lattice(0.025), 1.0, load=1.0, support=np.inf)
    data = cq.solve(plate).to_dataset()
    assert float(data["deflection"].max()) == pytest.approx(0.00126, rel=0.02)
    assert float(data["moment_x"].sel(x=0.0, y=0.0, method="nearest")) == pytest.approx(0.0231, rel=0.02)


def test_a_clamped_plate_converges_with_second_order():
    """Of w = sin²πx sin²πy the load is ∇⁴w."""
    found = []
    for nodes in (9, 19, 39):
        lattice = cq.Frame.rectangle(1.0, 1.0, (0.5, 0.5)).lattice(1 / (nodes + 1))

        def load(x, y):
            waves = np.cos(2 * np.pi * x), np.cos(2 * np.pi * y)
            return 8 * np.pi**4 * np.prod(waves, axis=0) - 4 * np.pi**4 * (
                waves[0] * (1 - waves[1]) + waves[1] * (1 - waves[0])
            )

        plate = cq.Plate(lattice, 1.0, load=load, support=np.inf)
        exact = (np.sin(np.pi * lattice.node_x) * np.sin(np.pi * lattice.node_y)) ** 2
        found.append(np.abs(cq.solve(plate).deflection - exact).max())
    assert (np.log2(np.array(found[:-1]) / found[1:]) >= 1.9).all()


@pytest.mark.parametrize("edge", ["clamped", "simply supported"])
@pytest.mark.parametrize("mask", [np.ones((6, 8), dtype=bool), CORNER, HOLE])
@pytest.mark.parametrize("tension", [0.0, 2.0, (1.0, 3.0)])
def test_the_matrix_is_symmetric_definite_and_what_pull_says(edge, mask, tension):
    rng = np.random.default_rng(3)
    lattice = cq.Lattice.from_mask(mask, spacing=0.5)
    plate = cq.Plate(
        lattice,
        2.0,
        tension=tension,
        load=1.0,
        support=1.0,
        edge=edge,
        foundation=rng.uniform(0.0, 1.0, lattice.size),
    )
    matrix = plate.problem.G.toarray()
    assert (matrix == matrix.T).all()
    assert np.linalg.eigvalsh(matrix).min() > 0
    for _ in range(3):
        depths = rng.normal(size=plate.size)
        np.testing.assert_allclose(matrix @ depths, plate.pull(depths), rtol=0, atol=1e-12 * np.abs(matrix).max())


def test_rows_are_those_of_thirteen_points():
    def diagonal(edge):
        return cq.Plate(SQUARE, 1.0, load=1.0, support=1.0, edge=edge).problem.G.diagonal().reshape(7, 7) * 0.125**2

    np.testing.assert_allclose(diagonal("clamped")[0, :3], [22, 21, 21])
    np.testing.assert_allclose(diagonal("simply supported")[0, :3], [18, 19, 19])
    plate = cq.Plate(SQUARE, 1.0, load=1.0, support=1.0, edge="simply supported")
    # On a rectangle the simply supported plate is the Laplacian's square.
    line = sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(7, 7))
    laplacian = sparse.kronsum(line, line)
    np.testing.assert_allclose((plate.problem.G - laplacian @ laplacian / 0.125**2).toarray(), 0.0, atol=1e-11)
    row = plate.problem.G.toarray()[24].reshape(7, 7)[1:6, 1:6] * 0.125**2
    inner = [[0, 0, 1, 0, 0], [0, 2, -8, 2, 0], [1, -8, 20, -8, 1], [0, 2, -8, 2, 0], [0, 0, 1, 0, 0]]
    np.testing.assert_allclose(row, inner)


def test_a_long_plate_over_a_floor_bends_as_a_beam():
    """In the middle of a strip, five times as long as it is wide, a plate is a beam of stiffness D."""
    spacing, width = 0.05, 1.0
    lattice = cq.Frame.rectangle(width, 5.0).lattice(spacing)
    plate = cq.Plate(lattice, 1.0, load=1500.0, support=1.0, edge="clamped")
    solution = cq.solve(plate)
    beam = cq.Beam(width, spacing=spacing, bending_stiffness=1.0, load=1500.0, support=1.0, ends="clamped")
    middle = solution.to_dataset()["deflection"].sel(y=0.0, method="nearest")
    np.testing.assert_allclose(middle[1:-1], cq.solve(beam).deflection, atol=0.01)
    assert solution.status == cq.Status.CERTIFIED
    assert solution.contact.any()
    assert abs(solution.force_balance.imbalance) < 1e-9


@pytest.mark.parametrize("edge", ["clamped", "simply supported"])
def test_between_floor_and_ceiling_the_balance_has_all_parts(edge):
    plate = cq.Plate(
        cq.Frame.rectangle(2.0, 1.0).lattice(0.0625),
        1.0,
        tension=2.0,
        load=lambda x, y: np.where(x < 0, 3000.0, -3000.0),
        support=0.5,
        ceiling=-0.5,
        foundation=5.0,
        edge=edge,
    )
    solution = cq.solve(plate)
    assert solution.status == cq.Status.CERTIFIED
    assert solution.contact_lower.any()
    assert solution.contact_upper.any()
    balance = solution.force_balance
    assert min(balance.reaction, balance.ceiling) > 1.0
    assert abs(balance.imbalance) < 1e-9
    assert balance.frame != 0.0


def test_an_edge_at_another_height_carries_the_plate_with_it():
    given = {"load": 1000.0, "edge": "clamped"}
    level = cq.solve(cq.Plate(SQUARE, 1.0, support=0.6, **given))
    sunk = cq.solve(cq.Plate(SQUARE, 1.0, support=1.1, frame_height=0.5, **given))
    np.testing.assert_allclose(sunk.deflection, level.deflection + 0.5, atol=1e-9)
    tilted = cq.Plate(SQUARE, 1.0, load=0.0, support=np.inf, edge="simply supported", frame_height=lambda x, y: x - y)
    solution = cq.solve(tilted, on_failure="ignore")
    np.testing.assert_allclose(solution.deflection, SQUARE.node_x - SQUARE.node_y, atol=1e-9)


def test_elevations_are_depths_turned_over():
    given = {"load": 1000.0, "edge": "simply supported"}
    down = cq.solve(cq.Plate(SQUARE, 1.0, support=lambda x, y: 0.5 + x, **given))
    up = cq.solve(cq.Plate(SQUARE, 1.0, support=lambda x, y: -0.5 - x, upwards=True, **given))
    np.testing.assert_allclose(up.deflection, -down.deflection, atol=1e-12)
    for name in ("moment_x", "moment_y", "moment_xy"):
        np.testing.assert_allclose(up.to_dataset()[name], down.to_dataset()[name], atol=1e-9)


def staircase():
    return np.add.outer(np.arange(8), np.arange(8)) < 9


@pytest.mark.parametrize(
    "lattice",
    [cq.Frame.disk(1.0).lattice(0.1), cq.Frame.hexagon(1.0).lattice(0.1), cq.Lattice.from_mask(staircase(), 0.1)],
)
def test_an_edge_aslant_is_refused(lattice):
    with pytest.raises(ValueError, match=r"lattice must have its frame along lattice lines, but .* is another plate"):
        cq.Plate(lattice, 1.0, load=1.0, support=1.0)


@pytest.mark.parametrize("mask", [CORNER, HOLE, np.ones((1, 5), dtype=bool), np.ones((1, 1), dtype=bool)])
def test_edges_of_right_angles_are_taken(mask):
    plate = cq.Plate(cq.Lattice.from_mask(mask, 0.5), 1.0, load=1.0, support=0.001)
    assert cq.solve(plate).status == cq.Status.CERTIFIED


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"edge": "pinned"}, "edge must be one of 'clamped', 'simply supported', got 'pinned'"),
        ({"bending_stiffness": -1.0}, "bending_stiffness must be > 0"),
        ({"tension": -1.0}, "tension must be >= 0, got -1"),
        ({"poisson_ratio": 0.7}, "poisson_ratio must lie strictly between -1 and 0.5, got 0.7"),
        ({"ceiling": 2.0}, "ceiling must not lie below the support"),
        ({"stiffness": 1.0}, "Plate has no argument 'stiffness'"),
    ],
)
def test_what_makes_no_plate_is_refused(arguments, message):
    given = {"bending_stiffness": 1.0, "load": 1.0, "support": 1.0} | arguments
    with pytest.raises((ValueError, TypeError), match=message):
        cq.Plate(SQUARE, **given)


def test_no_lattice_is_refused():
    with pytest.raises(TypeError, match="lattice must be a Lattice, got float"):
        cq.Plate(1.0, 1.0, load=1.0, support=1.0)  # type: ignore[arg-type]


def test_other_loads_and_tensions_of_the_same_plate():
    plate = cq.Plate(SQUARE, 1.0, tension=0.5, load=1000.0, support=0.5)
    for varied, given in ((with_load(plate, 2.0), {"load": 2000.0}), (with_tension(plate, 3.0), {"tension": 3.0})):
        again = cq.Plate(SQUARE, 1.0, **({"tension": 0.5, "load": 1000.0, "support": 0.5} | given))
        np.testing.assert_allclose(cq.solve(varied).deflection, cq.solve(again).deflection, atol=1e-9)


def test_derivatives_by_load_and_tension_are_those_of_differences():
    def solved(load, tension):
        return cq.solve(cq.Plate(SQUARE, 1.0, tension=tension, load=load, support=0.5), "active-set", tol=1e-12)

    base, step = solved(1000.0, 2.0), 1e-4
    sensitivity = base.sensitivity()
    for name, after in (("load", solved(1000.0 + step, 2.0)), ("tension", solved(1000.0, 2.0 + step))):
        difference = (after.deflection - base.deflection) / step
        told = sensitivity.forward(**{name: 1.0}).deflection
        np.testing.assert_allclose(told, difference, rtol=1e-3, atol=1e-4 * np.abs(difference).max())


def test_a_plate_is_told_in_words():
    plate = cq.Plate(SQUARE, 2.0, tension=(1.0, 3.0), load=1.0, support=1.0)
    assert repr(plate) == (
        "Plate(49 nodes, spacing=0.125, bending_stiffness=2, tension=(1, 3), clamped, load=1, support=1)"
    )
    assert plate.units["bending_stiffness"] == "force times length"
    assert "bending_stiffness" in plate._repr_html_()


def test_pictures_are_made():
    plate = cq.Plate(cq.Lattice.from_mask(CORNER, 0.125), 1.0, load=2000.0, support=0.1, edge="simply supported")
    solution = cq.solve(plate)
    assert solution.contact.any()
    for figure in (plate.plot(), plate.plot3d(), solution.plot(), solution.plot3d(), solution.certificate.plot()):
        figure.canvas.draw()


def test_a_case_file_and_a_saved_answer_are_that_plate(tmp_path):
    from contactqp.io.cases import load_case

    file = tmp_path / "case.toml"
    file.write_text(
        'model = "plate"\nspacing = 0.125\nbending_stiffness = 2.0\ntension = 1.0\nload = 900.0\nsupport = 0.2\n'
        'ceiling = -0.1\nfoundation = 3.0\nedge = "simply supported"\npoisson_ratio = 0.25\nframe_height = 0.01\n'
        'frame = {shape = "rectangle", width = 1.0, height = 0.75}\n'
    )
    plate = load_case(file)
    assert repr(plate) == (
        "Plate(35 nodes, spacing=0.125, bending_stiffness=2, tension=1, simply supported, load=900, support=0.2, "
        "ceiling=-0.1, foundation=3)"
    )
    assert isinstance(plate, cq.Plate)
    solution = cq.solve(plate)
    solution.save(tmp_path / "answer.nc")
    again = cq.load_solution(tmp_path / "answer.nc")
    assert repr(again.model) == repr(plate)
    assert isinstance(again.model, cq.Plate)
    assert again.model.poisson_ratio == 0.25
    assert (again.model.problem.G != plate.problem.G).nnz == 0
    np.testing.assert_array_equal(again.gap, solution.gap)


def test_a_disk_in_a_case_file_is_refused_with_the_file(tmp_path):
    from contactqp.io.cases import load_case

    file = tmp_path / "case.toml"
    file.write_text(
        'model = "plate"\nspacing = 0.1\nbending_stiffness = 2.0\nload = 1.0\nsupport = 0.2\n'
        'frame = {shape = "disk", radius = 1.0}\n'
    )
    with pytest.raises(cq.CaseFileError, match=r"case\.toml: lattice must have its frame along lattice lines"):
        load_case(file)
