"""Beams in case files, and in the files of their answers."""

from pathlib import Path

import numpy as np
import pytest

import contactqp as cq
from contactqp.errors import CaseFileError
from contactqp.io.case_sections import schema
from contactqp.io.cases import load_case

EXAMPLES = Path(__file__).parents[2] / "examples"

CASE = """
model = "beam"
span = 5.0
spacing = 0.5
start = -1.0
bending_stiffness = 2.0
tension = 3.0
load = 1.5
ends = ["clamped", "free"]
support = 0.25
ceiling = -0.5
foundation = 0.1
frame_height = 0.05
"""


def written(folder, text):
    file = folder / "case.toml"
    file.write_text(text, encoding="utf-8")
    return file


def beam_in(folder, text):
    beam = load_case(written(folder, text))
    assert isinstance(beam, cq.Beam)
    return beam


def test_a_case_file_is_the_beam_that_it_describes(tmp_path):
    beam = beam_in(tmp_path, CASE)
    same = cq.Beam(
        5.0,
        spacing=0.5,
        start=-1.0,
        bending_stiffness=2.0,
        tension=3.0,
        load=1.5,
        ends=("clamped", "free"),
        support=0.25,
        ceiling=-0.5,
        foundation=0.1,
        frame_height=0.05,
    )
    assert repr(beam) == repr(same)
    assert (beam.problem.G != same.problem.G).nnz == 0
    np.testing.assert_array_equal(beam.problem.q, same.problem.q)


def test_one_word_for_both_ends_and_no_tension(tmp_path):
    text = "\n".join(line for line in CASE.splitlines() if not line.startswith(("tension", "ends", "foundation")))
    beam = beam_in(tmp_path, text + '\nends = "clamped"\n')
    assert beam.ends == ("clamped", "clamped")
    assert beam.tension == 0.0
    assert beam_in(tmp_path, text).ends == ("pinned", "pinned")


def test_stiffness_and_load_from_files(tmp_path):
    stiffness, load = np.linspace(1.0, 2.0, 9), np.linspace(0.5, 1.0, 10)
    np.save(tmp_path / "stiffness.npy", stiffness[None])
    np.save(tmp_path / "load.npy", load[None])
    text = CASE.replace("bending_stiffness = 2.0", 'bending_stiffness = {file = "stiffness.npy"}')
    beam = beam_in(tmp_path, text.replace("load = 1.5", 'load = {file = "load.npy"}'))
    np.testing.assert_allclose(beam.bending_stiffness, [*stiffness, stiffness[-1]])
    np.testing.assert_allclose(beam.load, load)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('["clamped", "free"]', '["clamped", "loose"]', "ends"),
        ("bending_stiffness = 2.0", "", "bending_stiffness"),
        ("bending_stiffness = 2.0", "bending_stiffness = 0.0", "bending_stiffness"),
        ("tension = 3.0", "tension = -3.0", "tension"),
        ("tension = 3.0", "tension = 3.0\nrigidity = 1.0", "rigidity"),
        ("ceiling = -0.5", "ceiling = 0.5", "ceiling must not lie below the support"),
    ],
)
def test_a_bad_case_names_its_key(tmp_path, old, new, message):
    assert old in CASE
    with pytest.raises(CaseFileError, match=message):
        load_case(written(tmp_path, CASE.replace(old, new)))


def test_what_nothing_holds_is_refused_with_the_file(tmp_path):
    text = CASE.replace('["clamped", "free"]', '"free"').replace("foundation = 0.1", "")
    with pytest.raises(CaseFileError, match="let the beam fall"):
        load_case(written(tmp_path, text))


def test_the_schema_knows_beams():
    assert "BeamCase" in schema()["$defs"]


def test_a_stiff_pipeline_bridges_what_a_cable_hangs_into():
    beam, cable = load_case(EXAMPLES / "pipeline_bending.toml"), load_case(EXAMPLES / "pipeline.toml")
    assert isinstance(beam, cq.Beam)
    stiff, slack = cq.solve(beam), cq.solve(cable)
    assert stiff.status == cq.Status.CERTIFIED
    assert stiff.contact.sum() < slack.contact.sum()
    spans = beam.spans(stiff)
    longest = spans.loc[spans["length"].where(spans["kind"] == "free").idxmax()]
    assert 1270 <= longest["start"] < 1310 < longest["end"] <= 1360  # the plough mark
    touching = spans[spans["kind"] == "contact"]
    assert touching["reaction"].max() > 3 * 0.7 * 5
    forces = touching[["force_at_start", "force_at_end"]].to_numpy()
    assert not (forces < 0).any()  # the ground only pushes


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
@pytest.mark.parametrize("ends", ["pinned", ("clamped", "free")])
@pytest.mark.parametrize("varies", [False, True])
def test_a_solution_comes_back_with_its_beam(tmp_path, ends, varies, suffix):
    pytest.importorskip("zarr" if suffix == ".zarr" else "xarray")
    beam = cq.Beam(
        4.0,
        spacing=0.5,
        bending_stiffness=(lambda x: 3 + x) if varies else 2.0,
        tension=(lambda x: 1 + x**2) if varies else 0.0,
        load=lambda x: 1 + x,
        support=0.3,
        ceiling=-0.2,
        foundation=0.1 if varies else None,
        frame_height=lambda x: 0.02 * x,
        ends=ends,
        start=-1.0,
        upwards=False,
        units={"length": "m", "force": "kN"},
    )
    solution = cq.solve(beam)
    file = tmp_path / f"answer{suffix}"
    solution.save(file)
    again = cq.load_solution(file)
    assert repr(again.model) == repr(beam)
    assert isinstance(again.model, cq.Beam)
    assert again.model.ends == beam.ends
    assert (again.model.problem.G != beam.problem.G).nnz == 0
    np.testing.assert_array_equal(again.model.problem.q, beam.problem.q)
    np.testing.assert_array_equal(again.gap, solution.gap)
    assert again.model.unit_names == beam.unit_names


@pytest.mark.parametrize("suffix", [".vtu", ".csv"])
def test_other_formats_have_moment_and_shear(tmp_path, suffix):
    beam = cq.Beam(4.0, spacing=0.5, bending_stiffness=1.0, load=1.0, support=0.3, ends=("clamped", "free"))
    solution = cq.solve(beam)
    file = tmp_path / f"answer{suffix}"
    solution.save(file)
    if suffix == ".csv":
        text = file.read_text(encoding="utf-8")
        assert "bending_moment" in text
        assert "shear" in text
    assert file.stat().st_size > 0
