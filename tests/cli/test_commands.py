"""The command line: what each command prints, writes and ends with."""

import json
import os
import re
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import jsonschema
import meshio
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from strategies import BACKENDS
from triangulations import rings
from typer.testing import CliRunner

import contactqp as cq
from contactqp.cli.application import PICTURES
from contactqp.cli.commands import app
from contactqp.io.case_sections import schema
from contactqp.io.cases import load_case
from contactqp.io.templates import template, template_names
from contactqp.paper import reproduction

EXAMPLES = Path(__file__).parents[2] / "examples"
HEXAGON, CABLE, DOME = (EXAMPLES / f"{name}.toml" for name in ("hexagon", "cable", "dome"))


def run(*arguments, columns=None):
    environment = {} if columns is None else {"COLUMNS": str(columns)}
    return CliRunner().invoke(app, [str(argument) for argument in arguments], env=environment)


# Files that are written.


@pytest.mark.parametrize(
    ("command", "option", "name", "known"),
    [
        ("solve", "--out", "x.vtk", ".nc"),
        ("solve", "--out", "-", ".nc"),
        ("solve", "--out", "x", ".nc"),
        ("solve", "--out", "x.NC.txt", ".nc"),
        ("solve", "--plot", "x.gif", ".png .pdf .svg"),
        ("solve", "--plot", "-", ".png .pdf .svg"),
        ("compare", "--plot", "x.vtk", ".png .pdf .svg"),
        ("compare", "--json", "x.yaml", ".json"),
        ("compare", "--json", "-", ".json"),
        ("compare", "--report", "x.pdf", ".html .htm"),
        ("certify", "--out", "x.vtk", ".json .nc .csv"),
    ],
)
def test_unknown_suffixes_are_refused_before_anything_is_solved(tmp_path, monkeypatch, command, option, name, known):
    monkeypatch.chdir(tmp_path)
    answer = ["answer.npy"] if command == "certify" else []
    result = run(command, tmp_path / "no-case-is-read.toml", *answer, option, name)
    assert result.exit_code == 2
    assert result.stderr.startswith(f"contactqp: {option}: cannot write the file {name}: ")
    assert f"; known: {known}" in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_places_that_cannot_be_written_to(tmp_path):
    (tmp_path / "folder.nc").mkdir()
    result = run("solve", CABLE, "--out", tmp_path / "folder.nc")
    assert (result.exit_code, "there is a folder of that name" in result.stderr) == (2, True)
    result = run("solve", CABLE, "--out", tmp_path / "no" / "x.nc")
    assert (result.exit_code, "there is no folder" in result.stderr) == (2, True)


def test_a_report_is_a_page(tmp_path):
    comparison = cq.compare(cq.Cable(nodes=3, spacing=1.0, tension=1.0, load=1.0, support=1.0), ["psor"])
    with pytest.raises(ValueError, match=r"cannot write the report .*page\.pdf: unknown suffix '\.pdf'; known: \.html"):
        comparison.report(tmp_path / "page.pdf")


@pytest.mark.parametrize("suffix", PICTURES)
def test_every_known_picture_can_be_written(tmp_path, suffix):
    assert run("solve", CABLE, "--plot", tmp_path / f"x{suffix.upper()}").exit_code == 0
    assert (tmp_path / f"x{suffix.upper()}").stat().st_size > 1000


# Exit codes.


def test_exit_codes_are_told():
    text = " ".join(run("--help", columns=200).output.split())
    assert "Exit codes: 0 ok; 1 not certified, or no agreement; 2 bad input; 130 interrupted by Ctrl-C." in text
    page = " ".join((EXAMPLES.parent / "docs" / "command-line.md").read_text(encoding="utf-8").split())
    assert "0 ok, 1 not certified or no agreement, 2 bad input, 130 interrupted by Ctrl-C" in page


@pytest.mark.parametrize("command", ["solve", "compare"])
def test_ctrl_c_is_130(monkeypatch, command):
    def interrupted(path):
        raise KeyboardInterrupt

    monkeypatch.setattr("contactqp.io.cases.read_case", interrupted)
    assert run(command, CABLE).exit_code == 130


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals are others there")
def test_ctrl_c_while_it_solves_is_130(tmp_path):
    case = tmp_path / "large.toml"
    case.write_text(template("membrane").replace("spacing = 0.05", "spacing = 0.008"))
    command = [sys.executable, "-c", "from contactqp.cli.commands import main; main()", "solve", str(case)]
    with subprocess.Popen([*command, "--backend", "osqp", "--tol", "1e-12"], stderr=subprocess.PIPE) as process:
        time.sleep(4)
        process.send_signal(signal.SIGINT)
        _, complained = process.communicate(timeout=60)
    assert process.returncode == 130
    assert b"Traceback" not in complained


def test_a_reader_that_has_enough_is_no_bad_input():
    """As `contactqp schema | head -1`: the pipe is closed before all is written."""
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-c", "from contactqp.cli.commands import main; main()", "schema"]
    result = subprocess.run(command, stdout=write, stderr=subprocess.PIPE, check=False)
    os.close(write)
    assert result.returncode == 1
    assert b"contactqp:" not in result.stderr


def test_python_runs_the_package_as_a_command():
    result = subprocess.run(
        [sys.executable, "-m", "contactqp", "--version"], capture_output=True, text=True, check=False
    )
    assert (result.returncode, result.stdout.split()[0]) == (0, "contactqp")


# Certify.


@pytest.fixture(scope="module")
def hexagon():
    model = load_case(HEXAGON)
    return model, cq.solve(model, tol=1e-9)


def written(path, array):
    if path.suffix == ".npy":
        np.save(path, array)
    else:
        np.savetxt(path, np.atleast_2d(array), delimiter=",")
    return path


@pytest.mark.parametrize("suffix", [".npy", ".csv"])
@pytest.mark.parametrize("layout", ["vector", "column", "grid"])
@pytest.mark.parametrize("quantity", ["gap", "deflection"])
def test_anybodys_answer_is_certified(tmp_path, hexagon, suffix, layout, quantity):
    model, solution = hexagon
    values = getattr(solution, quantity)
    laid = {"vector": values, "column": values[:, None], "grid": model.lattice.scatter(values)}[layout]
    result = run("certify", HEXAGON, written(tmp_path / f"a{suffix}", laid), "--quantity", quantity, "--tol", "1e-6")
    assert result.exit_code == 0, result.output
    output = " ".join(result.output.split())
    assert f"a{suffix}: certified" in output
    assert "303 of 1857 nodes certainly in contact, 1554 clear, 0 undecided" in output
    bound = float(re.search(r"gap error <= (\S+) of", output)[1])
    assert bound <= 1e-8
    assert "caution largest slope 0.23: the theory assumes small slopes" in output


def test_a_wrong_answer_is_enclosed_and_not_certified(tmp_path, hexagon):
    model, solution = hexagon
    answer = written(tmp_path / "a.npy", solution.gap + 0.01)
    result = run("certify", HEXAGON, answer, "--out", tmp_path / "a.json")
    assert result.exit_code == 1
    assert "a.npy: inaccurate" in " ".join(result.output.split())
    record = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    certificate = cq.certify(model, solution.gap + 0.01)
    assert record["status"] == "inaccurate"
    assert 0.01 * (1 - 1e-6) <= record["gap_bound"] <= 0.0102
    assert record["gap_bound"] == certificate.gap_bound
    assert record["relative_bound"] == pytest.approx(certificate.gap_bound / record["gap_scale"])
    assert record["contact"]["certain"] == certificate.contact.sum()
    assert record["total_reaction"][0] <= solution.reaction.sum() <= record["total_reaction"][1]
    assert run("certify", HEXAGON, answer, "--tol", "0.5").exit_code == 0


def test_the_enclosure_as_netcdf_and_from_netcdf(tmp_path, hexagon):
    model, solution = hexagon
    assert run("solve", HEXAGON, "--out", tmp_path / "own.nc").exit_code == 0
    result = run("certify", HEXAGON, tmp_path / "own.nc", "--out", tmp_path / "e.nc")
    assert result.exit_code == 0, result.output
    with xr.open_dataset(tmp_path / "e.nc", engine="netcdf4") as data:
        assert data.attrs["status"] == "certified"
        assert (data["gap_lower"] <= data["gap_upper"]).where(data["gap"].notnull(), True).all()
        lower, upper = (model.lattice.gather(data[name].to_numpy()) for name in ("gap_lower", "gap_upper"))
    assert (lower <= solution.gap + 1e-8).all()
    assert (solution.gap - 1e-8 <= upper).all()


@pytest.mark.parametrize("case", [DOME, CABLE])
def test_fields_of_every_model_come_back(tmp_path, case):
    """Beside the dome there is no support: there the file's gap is infinite, and its deflection tells."""
    assert run("solve", case, "--out", tmp_path / "own.nc").exit_code == 0
    for quantity in ("gap", "deflection"):
        result = run("certify", case, tmp_path / "own.nc", "--quantity", quantity)
        assert result.exit_code == 0, result.output


@pytest.mark.parametrize(
    ("name", "make", "message"),
    [
        ("a.npy", lambda path: np.save(path, np.zeros(7)), "it holds 7 numbers, and the case has 99 nodes"),
        ("b.npy", lambda path: np.save(path, np.full(99, np.nan)), "gap must be finite"),
        ("c.npy", lambda path: np.save(path, np.full(99, np.inf)), "where there is no support, hand over deflections"),
        ("d.csv", lambda path: path.write_text("a,b\n"), "d.csv: cannot read it"),
        ("e.txt", lambda path: path.write_text("1\n"), "unknown kind '.txt'; known: .npy .csv .nc"),
        ("f.npy", lambda path: None, "there is no file"),
        ("g.nc", lambda path: path.write_bytes(b"nothing"), "g.nc: "),
        ("h.nc", lambda path: xr.Dataset({"gapp": ("x", np.zeros(99))}).to_netcdf(path, engine="netcdf4"),
         "it has no variable gap, but gapp; did you mean 'gapp'?"),
    ],
)  # fmt: skip
def test_answers_that_are_none(tmp_path, name, make, message):
    make(tmp_path / name)
    result = run("certify", CABLE, tmp_path / name)
    assert result.exit_code == 2
    assert message in result.stderr
    assert result.stderr.count("\n") == 1


# New case files, schema, version, completion.


@pytest.mark.parametrize("name", template_names())
def test_every_new_case_file_solves_as_it_is(tmp_path, name):
    """That of a mesh membrane does with the mesh that it tells of."""
    result = run("new", name)
    assert result.exit_code == 0
    assert result.output == template(name)
    assert result.output.count("#") >= 5
    (tmp_path / "case.toml").write_text(result.output, encoding="utf-8")
    if "drum.msh" in result.output:
        points, triangles = rings(10)
        mesh = meshio.Mesh(np.pad(points, ((0, 0), (0, 1))), [("triangle", triangles)])
        meshio.write(tmp_path / "drum.msh", mesh, file_format="gmsh22", binary=False)
    solved = run("solve", tmp_path / "case.toml")
    assert solved.exit_code == 0, solved.output
    contact = int(re.search(r"nodes +(\d+) in contact", solved.output)[1])
    assert contact > 0
    # The paper's own load makes slopes that the theory has doubts about.
    assert ("theory assumes small slopes" in solved.output) is (name == "hexagon")


def test_a_new_case_file_without_a_name_and_of_an_unknown_one():
    assert run("new").output == template("membrane")
    result = run("new", "hexagn")
    assert result.exit_code == 2
    known = "'beam', 'cable', 'dome', 'hexagon', 'membrane', 'mesh membrane', 'plate'"
    assert f"kind must be one of {known}, got 'hexagn'; did you mean 'hexagon'?" in result.stderr
    told = " ".join(run("new", "--help", columns=200).output.split())
    assert all(name in told for name in template_names())


def test_the_schema_takes_what_the_program_takes():
    printed = json.loads(run("schema").output)
    assert printed == schema()
    jsonschema.Draft202012Validator.check_schema(printed)
    validator = jsonschema.Draft202012Validator(printed)
    texts = [file.read_text(encoding="utf-8") for file in EXAMPLES.glob("*.toml")]
    texts += [template(name) for name in template_names()]
    assert len(texts) >= 9
    for text in texts:
        data = tomllib.loads(text)
        validator.validate(data)
        assert not validator.is_valid(data | {"sapcing": 1.0})
        assert not validator.is_valid(data | {"tension": -1.0})
        assert not validator.is_valid(data | {"support": {"profile": "conne"}})
    assert "Distance of neighbouring nodes" in json.dumps(printed)


def test_the_version():
    result = run("--version")
    assert (result.exit_code, result.output) == (0, f"contactqp {cq.__version__}\n")


def test_completion_is_offered():
    text = run("--help", columns=120).output
    assert "--install-completion" in text
    assert "--show-completion" in text


# Tables.


@pytest.mark.parametrize("columns", [80, 100, 160])
def test_the_comparison_is_readable_however_wide_the_terminal(columns):
    result = run("compare", CABLE, columns=columns)
    assert result.exit_code == 0, result.output
    lines = result.output.splitlines()
    assert max(map(len, lines)) <= columns
    assert "…" not in result.output
    heading = next(line for line in lines if line.startswith("backend"))
    for name in ("status", "seconds", "bound/scale", "contact"):
        assert name in heading
    assert ("min gap" in heading) == (columns == 160)
    assert ("--wide shows all" in result.output) == (columns < 160)
    for backend in BACKENDS:
        row = next(line for line in lines if line.startswith(f"{backend} "))
        assert "certified" in row
        assert re.search(r"\b41\b", row)


def test_wide_shows_all_columns_in_a_narrow_terminal():
    result = run("compare", CABLE, "--backends", "psor,osqp", "--wide", columns=60)
    heading = next(line for line in result.output.splitlines() if line.startswith("backend"))
    for name in ("status", "iterations", "true error", "min gap", "min R", "gap·R", "contact", "undecided"):
        assert name in heading
    assert "…" not in result.output


@pytest.mark.parametrize("columns", [80, 240])
def test_the_list_of_backends_is_readable(columns):
    output = run("backends", columns=columns).output
    assert max(map(len, output.splitlines())) <= columns
    assert "…" not in output
    assert "single linear program (HiGHS" in output
    assert "through scipy.optimize.linprog)" in output
    for kind in ("own", "library", "qpsolvers family", "cvxpy family"):
        assert f"\n{kind}:" in output
    assert "BSD-3-Clause" in output
    assert "Z-matrix, no upper bound" in output
    assert output.count("mangasarian") == (1 if columns == 240 else 2)


def test_the_papers_table_is_readable(tmp_path, monkeypatch):
    rows = reproduction.reproduce([0.03, 0.10])  # what it says of the load of the misprint, and of one more
    monkeypatch.setattr(reproduction, "reproduce", lambda: rows)
    monkeypatch.setattr("contactqp.paper.folder.write_folder", lambda _, folder: [folder / "README.txt"])
    output = run("paper", "--out", tmp_path / "p", columns=80).output
    table = output[: output.index("README.txt")]
    assert max(map(len, table.splitlines()[:-1])) <= 80
    assert "…" not in table.replace("1.05, …, 1.95", "")


@pytest.mark.parametrize("command", ["solve", "compare"])
@pytest.mark.parametrize("titled", [True, False])
def test_a_picture_has_the_title_of_its_case_above_its_own_headline(tmp_path, monkeypatch, command, titled):
    heads = []
    save = Figure.savefig
    monkeypatch.setattr(
        Figure, "savefig", lambda self, *a, **k: heads.append(self.get_suptitle()) or save(self, *a, **k)
    )
    case = tmp_path / "case.toml"
    text = re.sub("^title.*\n", "", DOME.read_text(encoding="utf-8"), flags=re.MULTILINE)
    case.write_text(('title = "disk over a dome"\n' if titled else "") + text.replace("0.04", "0.1"), encoding="utf-8")
    arguments = ["--plot", tmp_path / "p.png", *(["--report", tmp_path / "p.html"] if command == "compare" else [])]
    assert run(command, case, *arguments).exit_code == 0
    first, *others = heads[0].splitlines()
    assert (first == "disk over a dome") is titled
    assert re.match("active-set: certified|7 backends, ", others[0] if titled else first)
    if command == "compare":
        page = (tmp_path / "p.html").read_text(encoding="utf-8")
        assert f"<h1>{'disk over a dome' if titled else 'case.toml'}</h1>" in page


def test_certify_tells_its_figures_against_what_and_of_what(tmp_path):
    solution = cq.solve(load_case(CABLE))
    np.save(tmp_path / "gap.npy", solution.gap)
    result = run("certify", CABLE, tmp_path / "gap.npy", "--out", tmp_path / "e.json", columns=80)
    record = json.loads((tmp_path / "e.json").read_text())
    assert record["error_scale"] == solution.verdict.scale
    assert f"of the error scale {record['error_scale']:.3g}; tol" in result.output
    assert "against     the exact solution of the discrete problem" in result.output


def test_certify_writes_every_format_of_solutions(tmp_path):
    solution = cq.solve(load_case(CABLE))
    np.save(tmp_path / "gap.npy", solution.gap)
    for suffix in (".csv", ".nc"):
        assert run("certify", CABLE, tmp_path / "gap.npy", "--out", tmp_path / f"e{suffix}").exit_code == 0
    head = (tmp_path / "e.csv").read_text().splitlines()[0]
    assert head.startswith("node,x,y,gap,")
    assert "gap_upper" in head
    assert "gap_upper" in xr.load_dataset(tmp_path / "e.nc")


# Narrow terminals.


@pytest.mark.parametrize("command", ["solve", "certify"])
def test_lines_that_are_too_long_go_on_below_what_they_tell(tmp_path, command):
    case = tmp_path / "case.toml"
    corners = "[[0, 0], [5, 0], [5, 2.5], [2.5, 2.5], [2.5, 5], [0, 5]]"
    case.write_text(
        f'spacing = 0.3\ntension = 1\nload = 0.01\nsupport = 1\nframe = {{shape = "polygon", corners = {corners}}}\n'
    )
    answer = [written(tmp_path / "a.npy", np.zeros(load_case_quietly(case).size))] if command == "certify" else []
    result = run(command, case, *answer, columns=80)
    assert max(map(len, result.stdout.splitlines())) <= 80 + len(str(tmp_path)) * (command == "certify")
    told = result.stdout.splitlines()
    first = next(k for k, line in enumerate(told) if line.strip().startswith("caution"))
    hanging = 14 if command == "solve" else 12
    assert told[first + 1].startswith(" " * hanging)
    assert told[first + 1][hanging] != " "
    assert "sides: x = 2.5 at 2.7" in " ".join(result.stdout.split())


def test_a_reaction_of_nothing_is_told_as_nothing(tmp_path):
    case = tmp_path / "case.toml"
    case.write_text('model = "cable"\nspan = 10\nspacing = 1\ntension = 1\nload = 0.01\nsupport = 2\n')
    assert "  reaction    0 in all (force)" in run("solve", case).stdout.splitlines()


def load_case_quietly(case):
    with pytest.warns(cq.ContactWarning):
        return load_case(case)


def test_a_comparison_has_the_columns_that_the_terminal_has_room_for(monkeypatch):
    comparison = cq.compare(cq.Cable(nodes=9, spacing=1.0, tension=1.0, load=1.0, support=2.0), ["psor", "active-set"])
    whole = repr(comparison)
    monkeypatch.setenv("COLUMNS", "80")
    narrow = repr(comparison)
    assert max(map(len, narrow.splitlines())) <= 80 < max(map(len, whole.splitlines()))
    assert "Left out for want of room: " in narrow
    assert "Left out" not in whole


def test_the_least_push_of_no_node_is_none():
    rows = cq.compare(cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0], lower=0.0, upper=1.0), ["psor"])
    assert "inf" not in repr(rows).splitlines()[4]
    free = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0], lower=[0.0, 0.0], upper=[0.1, 2.0])
    assert "1 at lower, 1 at upper, 0 clear, 0 undecided: proven" in repr(cq.solve(free))


def test_what_moves_in_time_is_told_within_the_terminal():
    times = "--times", "0:10:3", "--damping", "1"
    result = run("march", CABLE, *times, columns=80)
    assert result.exit_code == 0, result.output
    assert max(map(len, result.output.splitlines())) <= 80
    assert "Left out for want of room: iterations; to_frame() has all." in result.output
    assert "iterations" in run("march", CABLE, *times, columns=200).output.splitlines()[1]


def test_the_list_of_backends_says_what_each_relies_on():
    lines = {line.split()[0]: line for line in run("backends", columns=300).output.splitlines() if line.strip()}
    for solver in ("highs", "daqp", "quadprog", "ecos"):
        assert "definite" in lines[f"qpsolvers:{solver}"]
    assert "definite" not in lines["qpsolvers:piqp"]
    for method in ("psor", "active-set"):
        assert "definite or M-matrix" in lines[method]
    assert "symmetric" in lines["osqp"]
    assert "symmetric" not in lines["active-set"]


# Slips are told with what was probably meant, and files by their names.


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (
            ("certify", CABLE, "a.npy", "--rows", "upp"),
            "--rows must be one of 'up', 'down', got 'upp'; did you mean 'up'?",
        ),
        (
            ("certify", CABLE, "a.npy", "--quantity", "gaps"),
            "--quantity must be one of 'gap', 'deflection', got 'gaps'",
        ),
        (
            ("march", CABLE, "--times", "0,1", "--damping", "1", "--method", "eulr"),
            "--method must be one of 'crank-nicolson', 'euler', got 'eulr'; did you mean 'euler'?",
        ),
        (("certify", CABLE, "missing.csv"), "there is no file missing.csv"),
        (("solve", "missing.toml"), "missing.toml"),
    ],
)
def test_slips_are_told_in_one_line(tmp_path, monkeypatch, arguments, told):
    monkeypatch.chdir(tmp_path)
    np.save("a.npy", np.zeros(99))
    result = run(*arguments)
    assert result.exit_code == 2
    assert told in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert "Errno" not in result.stderr


def test_an_answer_of_another_size_is_told_by_what_is_wanted(tmp_path):
    for given, told in (
        (np.zeros(98), "98 numbers"),
        (np.zeros((4, 5)), "an array of shape (4, 5)"),
        (1.0, "1 number"),
    ):
        np.save(tmp_path / "a.npy", given)
        result = run("certify", CABLE, tmp_path / "a.npy")
        assert result.exit_code == 2
        assert (
            f"it holds {told}, and the case has 99 nodes: hand over a number for each, in their order" in result.stderr
        )
    result = run("certify", HEXAGON, tmp_path / "a.npy")
    assert "1857 nodes: hand over a number for each, in their order, or an array of shape (49, 65)" in result.stderr


def test_the_length_in_contact_is_told_as_what_its_nodes_stand_for():
    lines = run("solve", CABLE).stdout.splitlines()
    assert "  contact     41 (length that its nodes stand for)" in lines


# The membrane itself.

BOWL = """
spacing = 0.0625
tension = 1.0
load = 1.0
support = {profile = "plane", depth = 0.03}
frame = {shape = "rectangle", width = 1.0, height = 1.0}
"""


def test_solve_refines_until_the_membrane_is_enclosed(tmp_path):
    case = tmp_path / "case.toml"
    case.write_text(BOWL, encoding="utf-8")
    result = run("solve", case, "--continuum-tol", 0.05)
    assert result.exit_code == 0
    assert "Membrane within 0.0015 (length): tolerance reached" in result.output
    assert [line.split()[0] for line in result.output.splitlines()[2:4]] == ["0.0625", "0.03125"]
    assert "Continuum(pointwise): proven of the continuum itself" in result.output
    assert "certified" in result.output
    assert "discretisation" in result.output


@pytest.mark.parametrize("suffix", [".nc", ".zarr", ".csv"])
def test_solve_starts_from_an_earlier_answer(tmp_path, suffix):
    case, out = tmp_path / "case.toml", tmp_path / f"answer{suffix}"
    case.write_text(BOWL, encoding="utf-8")
    solving = "solve", case, "--backend", "multigrid"
    cold = run(*solving, "--out", out)
    warm = run(*solving, "--warm-start", out)
    assert (cold.exit_code, warm.exit_code) == (0, 0)
    assert "1 cycle" in warm.output
    assert "1 cycle" not in cold.output
    refused = run("solve", case, "--warm-start", out, "--continuum-tol", 0.05)
    assert refused.exit_code == 2
    assert "--warm-start is of one lattice" in refused.stderr
    case.write_text(BOWL.replace("0.0625", "0.05"), encoding="utf-8")
    assert run("solve", case, "--warm-start", out).exit_code == 2


@pytest.mark.parametrize("effort", ["energy", "pointwise"])
def test_what_is_proven_of_the_membrane_goes_along(tmp_path, effort):
    case, out = tmp_path / "case.toml", tmp_path / "answer.nc"
    case.write_text(BOWL, encoding="utf-8")
    result = run("solve", case, "--continuum", effort, "--out", out, "--plot", tmp_path / "bowl.png")
    assert result.exit_code == 0
    assert f"Continuum({effort}): proven of the continuum itself" in result.output
    with xr.open_dataset(out) as stored:
        assert stored.attrs["continuum_effort"] == effort
    report = tmp_path / "report.html"
    compared = run("compare", case, "--backends", "psor", "--continuum", effort, "--report", report)
    assert f"Continuum({effort})" in compared.output
    assert "The membrane itself" in report.read_text(encoding="utf-8")


def test_what_cannot_go_along_is_refused_before_any_work(tmp_path):
    case = tmp_path / "case.toml"
    case.write_text(BOWL, encoding="utf-8")
    result = run("solve", case, "--continuum", "energy", "--out", tmp_path / "answer.csv")
    assert result.exit_code == 2
    assert "a table of nodes takes bounds at the nodes" in " ".join(result.output.split())
    result = run("solve", case, "--continuum", "pointwise", "--out", tmp_path / "answer.geojson")
    assert result.exit_code == 2
    assert "go into .nc .csv .zarr" in " ".join(result.output.split())
    result = run("solve", case, "--continuum", "pointwse")
    assert "did you mean 'pointwise'" in " ".join(result.output.split())


def test_a_frame_beside_the_lattice_cannot_be_enclosed():
    result = run("solve", DOME, "--continuum-tol", 0.05)
    assert result.exit_code == 2
    assert "--continuum-tol" in result.output
