"""What speaks against an answer is said wherever a verdict is."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import contactqp as cq
from contactqp.cli.commands import app

STEEP = cq.Membrane(cq.Frame.rectangle(4, 4).lattice(1.0), 1.0, load=2000.0, support=880.0)
SAID = "largest slope 880: the theory assumes small slopes"
CASE = """
spacing = 1.0
tension = 1.0
load = 2000.0
support = 880.0
frame = {shape = "rectangle", width = 4, height = 4}
"""


@pytest.fixture(scope="module")
def comparison():
    return cq.compare(STEEP, ["clarabel", "active-set"])


def test_a_slope_of_880_is_a_caution_beside_every_verdict(comparison, tmp_path):
    assert comparison.agree
    assert comparison.cautions == (SAID,)
    assert f"Caution: {SAID}." in str(comparison).splitlines()
    assert f"<p>Caution: {SAID}.</p>" in comparison._repr_html_()
    record = json.loads(comparison.to_json())
    assert record["cautions"] == [SAID]
    assert record["backends"][0]["max_slope"] == pytest.approx(880.0)
    assert comparison.to_frame()["max_slope"].tolist() == pytest.approx([880.0, 880.0])
    page = comparison.report(tmp_path / "page.html").read_text(encoding="utf-8")
    assert page.index("All 2 backends agree") < page.index(f"Caution: {SAID}.") < page.index("<h2>")
    solution = comparison.best
    assert f"caution     {SAID}" in repr(solution)
    assert solution.to_dataset().attrs["cautions"] == SAID
    path = cq.trace(STEEP, loads=[0.5, 1.0])
    assert path.cautions == (SAID,)
    assert f"caution: {SAID}" in repr(path)


def test_cautions_on_the_command_line(tmp_path):
    case = tmp_path / "case.toml"
    case.write_text(CASE)
    for command in (["solve", case], ["compare", case, "--backends", "psor,active-set"]):
        result = CliRunner().invoke(app, [str(part) for part in command])
        assert result.exit_code == 0, result.output
        assert SAID in result.output.replace("\n", " ")
    case.write_text(CASE.replace("880.0", "-0.3").replace("2000.0", "0.001"))
    result = CliRunner().invoke(app, ["solve", str(case), "--backend", "active-set"])
    assert result.stderr.startswith(f"contactqp: warning: {case}: support stands above the frame")
    assert "caution     support stands above the frame at 12 of the 12 places" in result.stdout


def test_certify_tells_all_cautions_and_the_warnings_of_its_case(tmp_path):
    case = tmp_path / "case.toml"
    case.write_text(CASE.replace("880.0", "-880.0").replace("2000.0", "0.001"))
    model = cq.Membrane(STEEP.lattice, 1.0, load=0.001, support=880.0)
    np.save(tmp_path / "gap.npy", np.full(model.size, 0.0))
    arguments = ["certify", str(case), str(tmp_path / "gap.npy"), "--out", str(tmp_path / "e.json")]
    result = CliRunner().invoke(app, arguments, env={"COLUMNS": "300"})
    assert result.stderr.startswith(f"contactqp: warning: {case}: support stands above the frame")
    assert result.stdout.count("caution     ") == 2
    assert f"caution     {SAID}" in result.stdout
    assert "caution     support stands above the frame at 12 of the 12 places" in result.stdout
    assert len(json.loads((tmp_path / "e.json").read_text())["cautions"]) == 2


def test_gentle_answers_and_bare_problems_have_none():
    assert cq.compare(cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0]), ["psor"]).cautions == ()
    gentle = cq.compare(cq.Membrane(STEEP.lattice, 1.0, load=0.01, support=1.0), ["psor"])
    assert gentle.cautions == ()
    assert "Caution" not in str(gentle)
    assert json.loads(gentle.to_json())["cautions"] == []
