"""Ceilings, foundations and tension that varies in case files, on the command line and in files of answers."""

import json
import tomllib

import jsonschema
import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import contactqp as cq
from contactqp.cli.commands import app
from contactqp.io.case_sections import schema
from contactqp.io.cases import load_case
from contactqp.solving.loaded import load_solution

GOOD = """
spacing = 0.5
tension = [2.0, 1.0]
load = 2.0
support = 0.3
foundation = 0.5
frame = {shape = "rectangle", width = 3.0, height = 2.0}

[ceiling]
profile = "plane"
depth = -0.1
slope_x = 0.01
"""
CABLE = """
model = "cable"
span = 10.0
spacing = 0.5
tension = {file = "tension.csv"}
load = -2.0
support = 1.0
ceiling = -0.5
foundation = 0.2
"""


@pytest.fixture
def case(tmp_path):
    def write(text, **changes):
        for name, value in changes.items():
            text = "\n".join([f"{name} = {value}", *(line for line in text.splitlines() if not line.startswith(name))])
        path = tmp_path / "case.toml"
        path.write_text(text)
        return path

    return write


def test_a_case_says_what_python_says(case):
    lattice = cq.Frame.rectangle(3.0, 2.0).lattice(0.5)
    ceiling = cq.profiles.Plane(-0.1, 0.01)
    expected = cq.Membrane(lattice, (2.0, 1.0), load=2.0, support=0.3, ceiling=ceiling, foundation=0.5)
    found = load_case(case(GOOD))
    assert repr(found) == repr(expected)
    np.testing.assert_array_equal(found.ceiling, expected.ceiling)
    np.testing.assert_array_equal(found.problem.G.toarray(), expected.problem.G.toarray())
    up = load_case(case(GOOD.replace("support = 0.3", "support = -0.3"), upwards="true"))
    np.testing.assert_array_equal(up.ceiling, -expected.ceiling)  # a profile's depth counts downwards
    jsonschema.validate(tomllib.loads(GOOD), schema())
    jsonschema.validate(tomllib.loads(CABLE), schema())


def test_files_hold_tension_ceilings_and_foundations(case, tmp_path):
    lattice = cq.Frame.rectangle(3.0, 2.0).lattice(0.5)
    rng = np.random.default_rng(0)
    values = {name: rng.uniform(1, 2, lattice.shape) for name in ("tension", "foundation", "ceiling")}
    values["ceiling"] = -values["ceiling"]
    values["ceiling"][2, 2] = np.nan
    for name, array in values.items():
        np.save(tmp_path / f"{name}.npy", array)
    text = "\n".join(line for line in GOOD.split("[ceiling]")[0].splitlines())
    for rows, turn in (("up", 1), ("down", -1)):
        found = load_case(
            case(
                text,
                tension=f'[1.5, {{file = "tension.npy", rows = "{rows}"}}]',
                foundation=f'{{file = "foundation.npy", rows = "{rows}"}}',
                ceiling=f'{{file = "ceiling.npy", rows = "{rows}", missing = "none"}}',
            )
        )
        turned = {name: array[::turn] for name, array in values.items()}
        np.testing.assert_array_equal(found.foundation, lattice.gather(turned["foundation"]))
        along_x, along_y = found.tension  # type: ignore[misc]
        np.testing.assert_array_equal(along_y, lattice.gather(turned["tension"]))
        assert along_x == 1.5
        ceiling = np.where(np.isnan(turned["ceiling"]), -np.inf, turned["ceiling"])
        np.testing.assert_array_equal(found.ceiling, lattice.gather(ceiling))
    np.savetxt(tmp_path / "tension.csv", np.linspace(1, 2, 19)[None, :], delimiter=",")
    cable = load_case(case(CABLE))
    np.testing.assert_allclose(cable.tension, np.linspace(1, 2, 19))
    assert cq.solve(cable).contact_upper.any()


@pytest.mark.parametrize(
    ("changes", "wanted"),
    [
        ({"tension": "0.0"}, "tension: input should be greater than 0, got 0.0"),
        ({"tension": "[1.0, -1.0]"}, r"tension\[1\]: input should be greater than 0, got -1.0"),
        ({"tension": "[1.0]"}, "tension"),
        ({"tension": '{profile = "plane", depth = 1.0}'}, "tension: must be a number or a table with file, not"),
        ({"tension": '[1.0, {file = "a.npy", row = "up"}]'}, r"tension\[1\].row: unknown key; did you mean 'rows'"),
        ({"foundation": "-1.0"}, "foundation must be >= 0, but is -1"),
        ({"foundation": "{depth = 1.0}"}, "foundation: must be a number, or a table with profile or file"),
        ({"support": "-0.5"}, "ceiling must not lie below the support, but at node 4"),
        ({"tension": '{file = "none.npy"}'}, "tension.file"),
        ({"ceilng": "1.0"}, "ceilng: unknown key; did you mean 'ceiling'"),
    ],
)
def test_what_is_wrong_is_told_by_key(case, changes, wanted):
    with pytest.raises(cq.CaseFileError, match=wanted):
        load_case(case(GOOD, **changes))


def test_the_command_line_solves_writes_and_certifies_them(case, tmp_path):
    path = case(GOOD, load="-2.0")
    run = CliRunner().invoke
    solved = run(app, ["solve", str(path), "--out", str(tmp_path / "a.nc"), "--plot", str(tmp_path / "a.png")])
    assert solved.exit_code == 0, solved.output
    assert "at upper" in solved.output
    data = xr.load_dataset(tmp_path / "a.nc")
    assert {"ceiling", "foundation"} <= set(data)
    assert (data.attrs["tension_x"], data.attrs["tension_y"]) == (2.0, 1.0)
    certified = run(app, ["certify", str(path), str(tmp_path / "a.nc")])
    assert certified.exit_code == 0, certified.output
    written = run(app, ["solve", str(path), "--out", str(tmp_path / "a.csv")])
    assert written.exit_code == 0
    assert "ceiling" in (tmp_path / "a.csv").read_text().splitlines()[0]
    compared = run(app, ["compare", str(path), "--json", str(tmp_path / "a.json")])
    assert compared.exit_code == 0, compared.output
    assert json.loads((tmp_path / "a.json").read_text())["agree"]


def models():
    lattice = cq.Frame.disk(2.0).lattice(0.5)
    more = {"load": -2.0, "support": 0.3, "ceiling": lambda x, y: -0.1 - 0.01 * x, "foundation": 0.5}
    yield cq.Membrane(lattice, (lambda x, y: 1 + 0.1 * x, 1.0), **more)
    yield cq.Membrane(lattice, lambda x, y: 1 + 0.1 * y**2, **more, frame_height=lambda x, y: 0.01 * x)
    yield cq.Membrane(lattice, (2.0, 1.0), **more)
    yield cq.Cable(10.0, spacing=0.5, tension=lambda x: 1 + x, load=-2.0, support=0.3, ceiling=-0.1, foundation=0.1)
    yield cq.CableNet.orthogonal(lattice, 1.0, **more)


@pytest.mark.parametrize("model", list(models()), ids=lambda model: f"{type(model).__name__}")
def test_answers_in_files_bring_their_models(model, tmp_path):
    solution = cq.solve(model)
    solution.save(tmp_path / "answer.nc")
    again = load_solution(tmp_path / "answer.nc")
    if not isinstance(model, cq.CableNet):  # which does not tell of the lattice that it was laid on
        assert repr(again.model) == repr(model)
    np.testing.assert_array_equal(again.problem.G.toarray(), solution.problem.G.toarray())
    np.testing.assert_array_equal(again.problem.q, solution.problem.q)
    np.testing.assert_array_equal(again.problem.upper, solution.problem.upper)
    np.testing.assert_array_equal(again.contact_upper, solution.contact_upper)
