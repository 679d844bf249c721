"""The gallery as a test set of qpbenchmark: by itself where that is installed, and by what it relies on everywhere."""

import subprocess
import sys
import types
from importlib.util import module_from_spec, spec_from_file_location

import numpy as np
import pytest
import qpsolvers
from typer.testing import CliRunner

import contactqp as cq
from contactqp.cli.commands import app
from contactqp.comparison.qpbenchmark import MODULE, PROBLEMS, write_test_set


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sets") / "obstacles"
    names = write_test_set(folder, largest=250)
    assert names == sorted(path.stem for path in (folder / PROBLEMS).iterdir())
    return folder


def test_each_problem_is_one_of_the_gallery_without_dimensions(folder, monkeypatch):
    class Problem(qpsolvers.Problem):
        def __init__(self, *parts, name):
            super().__init__(*parts)
            self.name = name

    monkeypatch.setitem(sys.modules, "qpbenchmark", types.SimpleNamespace(TestSet=object, Problem=Problem))
    spec = spec_from_file_location("contactqp_obstacles", folder / MODULE)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    problems = {problem.name: problem for problem in module.ContactqpObstacles()}
    assert set(problems) == {"bowl_015", "spiral_015", "ball_015", "cable_0099", "channel_0099", "beam_099"}
    for name, model in (
        ("bowl_015", cq.gallery.bowl(15)),
        ("channel_0099", cq.gallery.cable_between_floor_and_ceiling(50, 19)[0]),
        ("beam_099", cq.gallery.beam_on_floor(99, 19)[0]),
    ):
        posed, (problem, units) = problems[name], model.problem.scaled()
        posed.check_constraints()
        assert abs(posed.P - problem.G).max() == 0
        gap = qpsolvers.solve_problem(posed, "clarabel", tol_gap_abs=1e-14, tol_gap_rel=1e-14).x
        exact = cq.solve(model, tol=1e-10).gap / units.length
        np.testing.assert_allclose(gap, exact, atol=1e-4)


def test_the_command_writes_it_anew_and_says_how_it_is_run(tmp_path):
    (tmp_path / PROBLEMS).mkdir()
    (tmp_path / PROBLEMS / "earlier.npz").touch()
    result = CliRunner().invoke(app, ["export-qpbenchmark", str(tmp_path), "--largest", "100"])
    assert result.exit_code == 0
    assert f"qpbenchmark {tmp_path / MODULE} run" in result.output.replace("\n", " ")
    assert {path.name for path in (tmp_path / PROBLEMS).iterdir()} == {
        "beam_099.npz",
        "cable_0099.npz",
        "channel_0099.npz",
    }
    refused = CliRunner().invoke(app, ["export-qpbenchmark", str(tmp_path), "--largest", "5"])
    assert refused.exit_code == 2


@pytest.mark.slow
def test_qpbenchmark_runs_it(folder, tmp_path):
    pytest.importorskip("qpbenchmark")
    import pandas as pd

    code = "from qpbenchmark.benchmark import main; main()"
    results = tmp_path / "results.csv"
    command = [sys.executable, "-c", code, folder / MODULE, "--results-path", results, "run", "--author", "nobody"]
    run = subprocess.run([*command, "--solver", "piqp"], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    table = pd.read_csv(results).query("settings == 'high_accuracy'")
    assert len(table) == len(list((folder / PROBLEMS).iterdir()))
    assert table.found.all()
    assert (table[["primal_residual", "dual_residual", "duality_gap"]].max() < 1e-8).all()
