import json
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
import xarray as xr
from strategies import BACKENDS
from typer.testing import CliRunner

import contactqp as cq
from contactqp.cli.commands import app
from contactqp.io.cases import load_case

EXAMPLES = Path(__file__).parents[2] / "examples"
GOOD = """
spacing = 0.5
tension = 1.0
load = 2.0
support = 0.3
frame = {shape = "rectangle", width = 2.0, height = 2.0}
"""


@pytest.fixture
def case(tmp_path):
    def write(text=GOOD, **changes):
        for old, new in changes.items():
            lines = [line for line in text.splitlines() if not line.startswith(old)]
            text = "\n".join([f"{old} = {new}" if new is not None else "", *lines])
        path = tmp_path / "case.toml"
        path.write_text(text)
        return path

    return write


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_the_hexagon_example_is_the_gallerys():
    model = load_case(EXAMPLES / "hexagon.toml")
    np.testing.assert_array_equal(model.problem.q, cq.gallery.paper_hexagon().problem.q)


@pytest.mark.parametrize(
    ("name", "nodes", "kind"),
    [
        ("rectangle", 79 * 39, cq.Membrane),
        ("dome", 1941, cq.Membrane),
        ("cable", 99, cq.Cable),
        ("pipeline", 399, cq.Cable),
    ],
)
def test_the_other_examples(name, nodes, kind):
    model = load_case(EXAMPLES / f"{name}.toml")
    assert isinstance(model, kind)
    assert model.lattice.size == nodes


@pytest.mark.parametrize(
    "frame",
    [
        '{shape = "disk", radius = 1.0}',
        '{shape = "hexagon", side = 2.88}',
        '{shape = "polygon", corners = [[0, 0], [2, 0], [0, 2]], holes = []}',
    ],
)
def test_every_frame_can_be_described(case, frame):
    assert load_case(case(frame=frame)).lattice.size > 0


@pytest.mark.parametrize(
    ("support", "profile"),
    [
        ('{profile = "plane", depth = 0.2, slope_x = 0.1}', cq.profiles.Plane(0.2, 0.1)),
        ('{profile = "paraboloid", depth = 0.2, radius = 3.0}', cq.profiles.Paraboloid(0.2, 3.0)),
        ('{profile = "cone", depth = 0.2, slope = 0.1, center = [0.5, 0.0]}', cq.profiles.Cone(0.2, 0.1, (0.5, 0.0))),
        ('{profile = "cylinder", depth = 0.2, radius = 0.6}', cq.profiles.Cylinder(0.2, 0.6)),
        ('{profile = "hemisphere", depth = 0.2, radius = 0.6}', cq.profiles.Hemisphere(0.2, 0.6)),
        ('{profile = "hill-and-floor", scale = 0.02}', cq.profiles.HillAndFloor(scale=0.02)),
        ("inf", lambda x, y: np.inf),
    ],
)
def test_every_profile_can_be_described(case, support, profile):
    model = load_case(case(support=support))
    np.testing.assert_array_equal(model.support, cq.Membrane(model.lattice, 1.0, load=1.0, support=profile).support)


def test_supports_from_files(case, tmp_path):
    shape = load_case(case()).lattice.shape
    grid = np.linspace(0.1, 0.6, shape[0] * shape[1]).reshape(shape)
    np.save(tmp_path / "f.npy", grid)
    np.savetxt(tmp_path / "f.csv", grid, delimiter=",")
    np.savez(tmp_path / "f.npz", other=grid + 1, depth=grid)
    matplotlib.image.imsave(tmp_path / "f.png", grid[::-1], cmap="gray", vmin=0, vmax=1)
    expected = cq.Membrane(load_case(case()).lattice, 1.0, load=1.0, support=grid).support
    for support, tolerance in (
        ('{file = "f.npy"}', 0.0),
        ('{file = "f.csv"}', 1e-12),
        ('{file = "f.npz", key = "depth"}', 0.0),
        ('{file = "f.png"}', 8e-3),
        ('{file = "f.npy", factor = 2.0, offset = 1.0}', None),
    ):
        found = load_case(case(support=support)).support
        reference = 2 * expected + 1 if tolerance is None else expected
        np.testing.assert_allclose(found, reference, atol=tolerance or 1e-12)


def test_a_coarser_file_is_resampled_on_request_only(case, tmp_path):
    np.save(tmp_path / "f.npy", np.array([[0.0, 1.0], [2.0, 3.0]]))
    with pytest.raises(cq.CaseFileError, match=r"support.file = .*has shape \(2, 2\), the lattice .*resample = true"):
        load_case(case(support='{file = "f.npy"}'))
    model = load_case(case(support='{file = "f.npy", resample = true}'))
    grid = model.lattice.scatter(model.support)
    rows, columns = model.lattice.shape
    expected = 2 * np.arange(rows)[:, None] / (rows - 1) + np.arange(columns)[None, :] / (columns - 1)
    np.testing.assert_allclose(grid[model.lattice.mask], expected[model.lattice.mask])


def test_a_frame_from_a_mask_file_and_a_sampled_cable(case, tmp_path):
    np.save(tmp_path / "mask.npy", np.array([[1, 1, 0], [0, 1, 1]]))
    assert load_case(case(frame='{shape = "mask", file = "mask.npy"}')).lattice.size == 4
    moved = load_case(case(frame='{shape = "mask", file = "mask.npy"}', origin="[10.0, 20.0]"))
    assert moved.lattice.origin == (10.0, 20.0)
    np.savetxt(tmp_path / "bed.csv", np.arange(4.0), delimiter=",")
    cable = 'model = "cable"\nspan = 5\nspacing = 1\ntension = 1\nload = 1\nsupport = {file = "bed.csv"}\n'
    np.testing.assert_array_equal(load_case(case(cable)).support, np.arange(4.0))


def test_a_sampled_profile_as_ground_and_for_the_heights_of_the_ends(case, tmp_path):
    (tmp_path / "bed.csv").write_text("km,z\n0,1.0\n4,3.0\n")
    section = '{profile = "sampled", file = "bed.csv", x = "km", depth = 1, outside = "hold"}'
    cable = f'model = "cable"\nspan = 5\nspacing = 1\ntension = 1\nload = 0\nsupport = {section}\n'
    np.testing.assert_array_equal(load_case(case(cable)).support, [1.5, 2.0, 2.5, 3.0])
    on_ground = load_case(case(cable + f"frame_height = {section}\n"))
    np.testing.assert_array_equal(on_ground.problem.q, [0.0, 0.0, 0.0, -0.5])
    smooth = load_case(case(cable.replace("depth = 1", 'depth = "z", interpolation = "pchip"')))
    np.testing.assert_allclose(smooth.support, [1.5, 2.0, 2.5, 3.0])
    slanted = load_case(case(frame_height='{profile = "plane", depth = 0.0, slope_x = 0.1}'))
    expected = cq.Membrane(slanted.lattice, 1.0, load=2.0, support=0.3, frame_height=cq.profiles.Plane(0.0, 0.1))
    np.testing.assert_array_equal(slanted.problem.q, expected.problem.q)


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ('{profile = "sampled", file = "none.csv"}', r"support.file = 'none.csv': there is no file .*none.csv"),
        ('{profile = "sampled", file = "bed.csv"}', r"support: .*bed.csv, line 3: depth is 'deep', which is no number"),
        ('{profile = "sampled", file = "bed.csv", depth = "z"}', r"no column 'z'; it has x, depth"),
        ('{profile = "sampled", file = "bed.csv", outside = "go on"}', r"support.outside: input should be 'error'"),
        ('{profile = "sampled", file = "good.csv"}', r"x = .* lies outside the samples, which go from 0 to 0.1"),
    ],
)
def test_bad_sampled_profiles_name_file_key_and_value(case, tmp_path, section, message):
    (tmp_path / "bed.csv").write_text("x,depth\n0,1\n1,deep\n")
    (tmp_path / "good.csv").write_text("x,depth\n0,1\n0.1,2\n")
    with pytest.raises(cq.CaseFileError, match=rf"(?s)case.toml:.*{message}"):
        load_case(case(support=section))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"tension": "-1.0"}, r"case.toml: tension: input should be greater than 0, got -1.0"),
        ({"tension": '"high"'}, r"tension: input should be a valid number.*got 'high'"),
        ({"spacing": None}, r"spacing: field required"),
        ({"sapcing": "1"}, r"sapcing: unknown key; did you mean 'spacing'\?"),
        (
            {"frame": '{shape = "circle", radius = 1}'},
            r"frame.shape: must be 'rectangle', .* or 'mask', got 'circle'",
        ),
        ({"frame": '{shape = "disk"}'}, r"frame.radius: field required"),
        ({"frame": '{shape = "disk", radius = 0.01, center = [0.2, 0.2]}'}, r"no lattice point of spacing 0.5"),
        ({"support": '{profile = "cone", depth = 1}'}, r"support.slope: field required"),
        ({"support": '{file = "nowhere.npy"}'}, r"support.file = 'nowhere.npy': there is no file"),
        ({"load": "true"}, r"load: input should be a valid number.*got True"),
        ({"load": '"3"'}, r"load: input should be a valid number.*got '3'; write 3 without quotation marks"),
        ({"load": '"no.csv"'}, r"load: input .*got 'no.csv'; data of a file are load = {file = \"no.csv\"}$"),
        ({"frame_height": '"no.csv"'}, r"frame_height: input .*got 'no.csv'$"),
        ({"load": "nan"}, r"load: input should be a finite number, got nan"),
        ({"support": "nan"}, r"support must be finite or \+inf"),
        ({"support": '{profile = "paraboloid", depth = 1, radius = 0}'}, r"radius must not be 0"),
    ],
)
def test_bad_cases_name_file_key_and_value(case, changes, message):
    with pytest.raises(cq.CaseFileError, match=message):
        load_case(case(**changes))


def test_unreadable_files_are_named(case, tmp_path):
    with pytest.raises(cq.CaseFileError, match=r"nothing.toml: cannot read the case file: No such file"):
        load_case(tmp_path / "nothing.toml")
    with pytest.raises(cq.CaseFileError, match=r"case.toml: not a TOML file"):
        load_case(case("spacing = = 1"))
    (tmp_path / "f.txt").write_text("x")
    with pytest.raises(cq.CaseFileError, match=r"unknown kind '.txt'; known: .npy"):
        load_case(case(support='{file = "f.txt"}'))
    (tmp_path / "f.csv").write_text("a,b\n")
    with pytest.raises(cq.CaseFileError, match=r"support.file = 'f.csv': cannot read it"):
        load_case(case(support='{file = "f.csv"}'))
    np.savez(tmp_path / "f.npz", a=np.ones(2), b=np.ones(2))
    with pytest.raises(cq.CaseFileError, match=r"choose one of its arrays by key: a, b"):
        load_case(case(support='{file = "f.npz"}'))
    with pytest.raises(cq.CaseFileError, match=r"no array 'c' in it"):
        load_case(case(support='{file = "f.npz", key = "c"}'))


def test_compare_on_the_command_line(tmp_path):
    result = run("compare", EXAMPLES / "hexagon.toml", "--plot", tmp_path / "h.png", "--json", tmp_path / "h.json")
    assert result.exit_code == 0, result.output
    assert "All 7 backends agree" in result.output
    for name in BACKENDS:
        assert name in result.output
    assert (tmp_path / "h.png").stat().st_size > 10_000
    assert json.loads((tmp_path / "h.json").read_text())["agree"] is True


def test_compare_writes_a_report_and_says_what_was_found(tmp_path):
    page = tmp_path / "cable.html"
    arguments = ("--backends", "osqp,psor", "--tol", "default", "--repeats", "1", "--report", page)
    result = run("compare", EXAMPLES / "cable.toml", *arguments)
    assert result.exit_code == 1, result.output
    assert "tol 1e-06 (default) of the error scale" in result.output
    assert "False claim: osqp said 'solved, eps 1e-03'" in result.output
    assert f"report: {page}" in result.output.replace("\n", "")
    assert "<title>cable over a flat floor</title>" in page.read_text(encoding="utf-8")


def test_a_finding_is_printed_below_the_table(capsys):
    from strategies import touching_softly

    from contactqp.cli.tables import print_comparison

    print_comparison(cq.compare(touching_softly(31, 0.01), ["osqp"], tol="default", options={
        "osqp": {"rho": 0.01, "polishing": True},
    }))  # fmt: skip
    assert "Finding: osqp: polish made the answer worse: bound" in capsys.readouterr().out


def test_the_terminal_table_is_no_wider_than_132_columns():
    result = run("compare", EXAMPLES / "cable.toml", "--tol", "mid")
    assert result.exit_code == 0
    assert max(map(len, result.output.splitlines())) <= 132
    assert "true error" in result.output


def test_compare_exits_with_1_where_there_is_no_agreement(case):
    result = run("compare", case(), "--backends", "psor, clarabel", "--tol", "1e-17")
    assert result.exit_code == 1
    assert "No agreement" in result.output


def test_solve_on_the_command_line(case, tmp_path):
    result = run("solve", case(), "--backend", "psor", "--out", tmp_path / "r.nc", "--plot", tmp_path / "r.png")
    assert result.exit_code == 0, result.output
    assert "Solution by psor: certified" in result.output
    with xr.open_dataset(tmp_path / "r.nc", engine="netcdf4") as data:
        assert data.attrs["backend"] == "psor"
    assert (tmp_path / "r.png").exists()
    assert run("solve", case(), "--backend", "clarabel", "--tol", "1e-17").exit_code == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["compare", "nothing.toml"], "nothing.toml: cannot read the case file"),
        (["compare", EXAMPLES / "hexagon.toml", "--backends", "osq"], "did you mean 'osqp'?"),
        (["compare", EXAMPLES / "hexagon.toml", "--tol", "7"], "tol must lie strictly between 0 and 1, got 7"),
        (["compare", EXAMPLES / "hexagon.toml", "--tol", "midd"], "'default', got 'midd'; did you mean 'mid'?"),
        (["solve", EXAMPLES / "hexagon.toml", "--tol", "nan"], "tol must be finite, got nan"),
        (["compare", EXAMPLES / "hexagon.toml", "--repeats", "-1"], "repeats must be >= 0, got -1"),
        (["compare", EXAMPLES / "hexagon.toml", "--plot", "no/such/p.png"], "there is no folder no/such"),
        (["compare", EXAMPLES / "hexagon.toml", "--report", "no/such/r.html"], "there is no folder no/such"),
        (["solve", EXAMPLES / "hexagon.toml", "--backend", "x"], "unknown backend 'x'"),
        (["solve", EXAMPLES / "hexagon.toml", "--time-limit", "-1"], "time_limit must be > 0"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(arguments, message):
    result = run(*arguments)
    assert result.exit_code == 2
    assert result.stderr.startswith("contactqp: ")
    assert message in result.stderr
    assert "Traceback" not in result.output


def test_the_list_of_backends_and_the_help():
    result = run("backends")
    assert result.exit_code == 0
    assert "mangasarian" in result.output
    assert "Z-matrix" in result.output
    help_text = run("--help").output
    for command in ("compare", "solve", "paper", "backends"):
        assert command in help_text
    assert "Exit code 0" in run("compare", "--help").output
