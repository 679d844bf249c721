"""Rows divided among processes: the same bits for any number of them, one store, and errors that end all."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import contactqp as cq

pytest.importorskip("mpi4py")
HERE = Path(__file__).parent
MPIEXEC = shutil.which("mpiexec", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
if MPIEXEC is None:
    pytest.skip("needs the command mpiexec, as of pip install mpich", allow_module_level=True)

CASE = """
spacing = 0.02
tension = 1.0
load = 2.0
support = {profile = "paraboloid", depth = 0.05, radius = 10.0}
frame = {shape = "disk", radius = 1.0}
"""


def started(processes, *arguments, folder):
    """Return what a program, of so many processes, ended with."""
    paths = os.pathsep.join([*sys.path, str(HERE.parent)])
    environment = {**os.environ, "PYTHONPATH": paths, "OMP_NUM_THREADS": "1"}
    command = [MPIEXEC, "-n", str(processes), sys.executable, *map(str, arguments)]
    return subprocess.run(
        command, env=environment, cwd=folder, capture_output=True, text=True, timeout=300, check=False
    )


def contactqp(processes, *arguments, folder):
    call = "from contactqp_command import main; main()"
    return started(processes, "-c", call, *arguments, folder=folder)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """What `by_rows.py` has found, by case and number of processes."""
    folder = tmp_path_factory.mktemp("found")
    ended = started(5, HERE / "by_rows.py", folder / "found.json", folder=folder)
    assert ended.returncode == 0, ended.stderr
    return json.loads((folder / "found.json").read_text())


@pytest.mark.slow
@pytest.mark.parametrize("case", ["plain", "masked", "between", "upwards"])
def test_answers_are_the_same_to_the_bit_for_any_number_of_processes(found, case):
    alone = found[case]["1"]
    assert alone["ended"].startswith("certified")
    for size in ("2", "3", "5"):
        told = found[case][size]
        assert told == {name: alone[name] for name in told}


@pytest.mark.slow
@pytest.mark.parametrize("case", ["plain", "masked", "between", "upwards"])
def test_the_answer_is_that_of_the_multigrid_in_one_process(found, case):
    """But for the last digit of the gap scale, which is summed in another order."""
    apart, outside = found[case]["1"]["apart"], found[case]["1"]["outside"]
    assert apart < 1e-15
    assert outside == 0.0


@pytest.mark.slow
def test_the_command_writes_one_store_and_prints_once(tmp_path):
    (tmp_path / "case.toml").write_text(CASE)
    ended = contactqp(2, "solve", "case.toml", "--out", "result.zarr", folder=tmp_path)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout.count("certified, multigrid of 2 processes") == 1
    import xarray as xr

    from contactqp.io.cases import load_case

    model = load_case(tmp_path / "case.toml")
    solution = cq.solve(model, "multigrid")
    with xr.open_zarr(tmp_path / "result.zarr", consolidated=False) as data:
        assert data.attrs["status"] == "certified"
        np.testing.assert_array_equal(data["x"], model.lattice.x)
        np.testing.assert_array_equal(data["y"], model.lattice.y)
        mask = model.lattice.mask
        assert np.isnan(data["gap"].values[~mask]).all()
        np.testing.assert_allclose(data["gap"].values[mask], solution.gap, atol=1e-15)
        np.testing.assert_allclose(data["deflection"].values[mask], solution.deflection, atol=1e-15)
        assert (data["gap_lower"].values[mask] <= solution.certificate.upper).all()
        assert (data["gap_upper"].values[mask] >= solution.certificate.lower).all()
    assert [each.name for each in tmp_path.iterdir() if each.name.startswith(".")] == []


@pytest.mark.slow
def test_an_error_is_told_once(tmp_path):
    (tmp_path / "case.toml").write_text(CASE.replace("spacing = 0.02", "spacing = 0.2"))
    ended = contactqp(2, "solve", "case.toml", folder=tmp_path)
    assert ended.returncode == 2
    assert ended.stderr.count("9 rows of nodes are too few for 2 processes") == 1


def test_importing_the_package_does_not_import_mpi4py():
    code = "import sys, contactqp; assert 'mpi4py' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
