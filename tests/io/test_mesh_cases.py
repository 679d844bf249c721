"""Case files of membranes on meshes, and what the command line does with them."""

import json

import meshio
import numpy as np
import pytest
from jsonschema import Draft202012Validator
from triangulations import rings
from typer.testing import CliRunner

import contactqp as cq
from contactqp.cli.commands import app
from contactqp.io.case_sections import schema
from contactqp.io.cases import load_case
from contactqp.io.toml_files import read_toml

CASE = """
model = "mesh membrane"
title = "A drum"
file = "drum.msh"
tension = 2.0
load = 6.0
support = {profile = "paraboloid", depth = 0.3, radius = -4.0}
"""


@pytest.fixture
def case(tmp_path):
    points, triangles = rings(8)
    on_rim = np.flatnonzero(np.hypot(*points.T) > 1 - 1e-9)
    rim = np.column_stack([on_rim, np.roll(on_rim, -1)])
    left = (points[rim].mean(axis=1)[:, 0] < 0).astype(int)
    cells = [("line", rim), ("triangle", triangles)]
    tags = [1 + left, np.full(len(triangles), 3)]
    names = {"right": np.array([1, 1]), "left": np.array([2, 1]), "sheet": np.array([3, 2])}
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    mesh = meshio.Mesh(np.pad(points, ((0, 0), (0, 1))), cells, cell_data=data, field_data=names)
    meshio.write(tmp_path / "drum.msh", mesh, file_format="gmsh22", binary=False)

    def write(more=""):
        path = tmp_path / "case.toml"
        path.write_text(CASE + more)
        return path

    return write


def test_a_case_on_a_mesh(case):
    path = case('fixed = "left"\nfoundation = 0.5\nceiling = -1\nframe_height = 0.05')
    model = load_case(path)
    assert isinstance(model, cq.MeshMembrane)
    assert (model.positions[model.fixed][:, 0] < 1e-9).all()
    dome = cq.profiles.Paraboloid(depth=0.3, radius=-4.0)
    same = cq.MeshMembrane.from_meshio(
        path.parent / "drum.msh",
        *(2.0,),
        load=6.0,
        support=dome,
        fixed=["left"],
        foundation=0.5,
        ceiling=-1.0,
        frame_height=0.05,
    )
    np.testing.assert_array_equal(model.problem.q, same.problem.q)
    Draft202012Validator(schema()).validate(read_toml(path))


def test_heights_may_be_elevations(case):
    up = load_case(case("upwards = true"))
    assert up.upwards
    np.testing.assert_array_equal(up.problem.q, load_case(case()).problem.q)


def test_the_command_line_solves_it(case, tmp_path):
    run = CliRunner().invoke
    out, picture = tmp_path / "drum.vtu", tmp_path / "drum.png"
    result = run(app, ["solve", str(case()), "--out", str(out), "--plot", str(picture)])
    assert result.exit_code == 0, result.output
    assert "MeshMembrane(169 nodes, 384 triangles, 48 fixed points" in result.output
    assert "contact " in result.output
    assert len(meshio.read(out).cells_dict["triangle"]) == 384
    assert picture.stat().st_size > 1000
    saved = tmp_path / "drum.nc"
    assert run(app, ["solve", str(case()), "--out", str(saved)]).exit_code == 0
    assert cq.load_solution(saved).status == "certified"
    certified = run(app, ["certify", str(case()), str(saved), "--out", str(tmp_path / "enclosure.json")])
    assert certified.exit_code == 0, certified.output
    assert json.loads((tmp_path / "enclosure.json").read_text())["status"] == "certified"


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ('fixed = "lift"', "the mesh has no group 'lift'; did you mean 'left'"),
        ("fixed = 3", "fixed"),
        ('foundation = {file = "k.npy"}', "foundation: "),
        ('frame_height = {file = "k.npy"}', "frame_height: must be a number or a table with profile"),
        ("spacing = 1.0", "spacing: unknown key"),
    ],
)
def test_what_is_wrong_is_told(case, change, told):
    with pytest.raises(cq.CaseFileError, match=told):
        load_case(case(change))


def test_a_mesh_that_is_not_there_is_told(case):
    path = case()
    (path.parent / "drum.msh").unlink()
    with pytest.raises(cq.CaseFileError, match=r"case\.toml: file = 'drum\.msh'"):
        load_case(path)
