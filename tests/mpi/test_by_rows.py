"""Rows divided among processes: the same bits for any number of them, one store, and errors that end all."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from membranes_by_rows import CASES, SIZES

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


def start(processes, *arguments, folder):
    """Start a program of so many processes."""
    paths = os.pathsep.join([*sys.path, str(HERE.parent)])
    environment = {**os.environ, "PYTHONPATH": paths, "OMP_NUM_THREADS": "1"}
    command = [MPIEXEC, "-n", str(processes), sys.executable, *map(str, arguments)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen(command, env=environment, cwd=folder, **pipes)


def ended(program):
    """Return exit code, output and errors of a program."""
    try:
        output, errors = program.communicate(timeout=300)
    except subprocess.TimeoutExpired:
        program.kill()
        raise
    return program.returncode, output, errors


def command(processes, *arguments, folder):
    """Return what the command line, in so many processes, ended with."""
    call = "from contactqp_command import main; main()"
    return ended(start(processes, "-c", call, *arguments, folder=folder))


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """What `by_rows.py` has found, by case and number of processes."""
    folder = tmp_path_factory.mktemp("found")
    code, _, errors = ended(start(9, HERE / "by_rows.py", folder / "found.json", folder=folder))
    assert code == 0, errors
    return json.loads((folder / "found.json").read_text())


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_answers_are_the_same_to_the_bit_for_any_number_of_processes(found, case):
    alone = found[case]["1"]
    assert alone["ended"].startswith("certified")
    for size in SIZES[case][1:]:
        told = found[case][str(size)]
        assert told == {name: alone[name] for name in told}


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_from_an_earlier_answer_fewer_cycles_suffice(found, case):
    """Whether it is in memory or in a store; that they are the same to the bit is asked above."""
    alone = found[case]["1"]
    from_answer, from_store, *_ = alone["warm cycles"]
    assert from_answer == from_store < alone["cycles"]
    assert alone["warm"][0] == alone["warm"][1]
    assert all(facts["ended"].startswith("certified") for facts in alone["warm facts"])


@pytest.mark.slow
def test_a_start_that_is_no_good_is_refused_by_all_in_the_same_words(found):
    first, second = found["refused"]["2"]["words"]
    assert first == second
    for words, start in zip(
        ("151 x 120, but the store", "is no Zarr store", "process 1 the", "must be"), first, strict=True
    ):
        assert words in start


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_the_answer_is_that_of_the_multigrid_in_one_process(found, case):
    """But for the last digit of the gap scale, which is summed in another order."""
    apart, outside = found[case]["1"]["apart"], found[case]["1"]["outside"]
    assert apart < 1e-15
    assert outside == 0.0


@pytest.mark.slow
def test_a_trace_goes_on_after_the_stores_that_are_there(found):
    told = {name: value for part in found["trace"].values() for name, value in part.items()}
    assert told["resumed"] == [False, False, True, False, False]
    assert told["same"] == [True, True]
    assert told["status"] == ["certified"] * 3
    assert told["areas"] == sorted(told["areas"])


@pytest.mark.slow
def test_the_command_writes_one_store_and_prints_once(tmp_path):
    (tmp_path / "case.toml").write_text(CASE)
    code, output, errors = command(2, "solve", "case.toml", "--out", "result.zarr", folder=tmp_path)
    assert (code, errors) == (0, "")
    assert output.count("certified, multigrid of 2 processes") == 1
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
def test_the_command_starts_from_a_store_of_any_number_of_processes(tmp_path):
    (tmp_path / "case.toml").write_text(CASE)
    for processes in (2, 1):
        out = "--out", f"{processes}.zarr"
        code, _, errors = command(processes, "solve", "case.toml", "--tol", "1e-4", *out, folder=tmp_path)
        assert (code, errors) == (0, "")
    for store in ("1.zarr", "2.zarr"):
        start = "--warm-start", store, "--tol", "1e-4", "--out", "result.zarr"
        for processes in (3, 1):
            code, output, errors = command(processes, "solve", "case.toml", *start, folder=tmp_path)
            assert (code, errors) == (0, "")
            assert "1 cycle, " in output if processes == 3 else "certified" in output
    (tmp_path / "case.toml").write_text(CASE.replace("radius = 1.0", "radius = 0.9"))
    code, _, errors = command(2, "solve", "case.toml", "--warm-start", "1.zarr", folder=tmp_path)
    assert code == 2
    assert errors.count("must be of the membrane's lattice") == 1


@pytest.mark.slow
def test_an_error_is_told_once(tmp_path):
    (tmp_path / "case.toml").write_text(CASE.replace("spacing = 0.02", "spacing = 0.2"))
    code, _, errors = command(2, "solve", "case.toml", folder=tmp_path)
    assert code == 2
    assert errors.count("9 rows of nodes are too few for 2 processes") == 1


def test_each_process_alone_by_its_mpi_is_told(tmp_path, monkeypatch):
    """As where mpiexec belongs to another MPI than mpi4py: each would write the same store."""
    from mpi4py import MPI  # noqa: F401  (it warns of the variable, too, if it is loaded later)

    from contactqp.cli.distributed import processes_started, solve_together

    assert processes_started() == 1
    monkeypatch.setenv("OMPI_COMM_WORLD_SIZE", "4")
    assert processes_started() == 4
    with pytest.raises(ValueError, match="4 processes were started, but each is alone by its MPI"):
        solve_together(tmp_path / "case.toml", "auto", 1e-6, None, None, None)


@pytest.mark.slow
@pytest.mark.parametrize("signal_number", [signal.SIGKILL, signal.SIGINT])
def test_what_ends_one_process_ends_all(tmp_path, signal_number):
    """A process that is killed, and Ctrl-C to mpiexec, while others wait for it within MPI."""
    program = start(2, HERE / "waiting.py", folder=tmp_path)
    places = [tmp_path / "0", tmp_path / "1"]
    deadline = time.monotonic() + 120
    while not all(place.exists() and place.read_text() for place in places):
        assert program.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.05)
    pids = [int(place.read_text()) for place in places]
    began = time.monotonic()
    os.kill(pids[1] if signal_number == signal.SIGKILL else program.pid, signal_number)
    code, output, errors = ended(program)
    assert time.monotonic() - began < 60
    assert not any(alive(pid) for pid in pids)
    if signal_number == signal.SIGKILL:
        assert code != 0
        assert "Killed" in output + errors
    else:
        assert code == 130
        assert "contactqp: interrupted" in errors


def alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def test_importing_the_package_does_not_import_mpi4py():
    code = "import sys, contactqp; assert 'mpi4py' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
