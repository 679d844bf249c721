"""Objects in other interpreters' processes: asked through files, ended at any time, and gone without a trace."""

import os
import sys
import tempfile
import threading
from pathlib import Path

import numpy as np
import pytest

import contactqp as cq
from contactqp.backends import in_files
from contactqp.backends.in_files import InFiles
from contactqp.backends.interpreters import Interpreter, interpreter_with
from contactqp.backends.processes import Lost, LostProcessError
from contactqp.foundation.interrupts import OutOfTime

HERE = Interpreter(sys.executable, "1.0")
WORKER = str(Path(__file__).parents[1] / "worker.py")

pytestmark = pytest.mark.skipif(os.name != "posix", reason="other systems have no PETSc, and groups of their own")


@pytest.fixture(autouse=True)
def scratch(tmp_path, monkeypatch):
    """The folder that temporary ones stand in."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def made(settings=None, ranks=1):
    return InFiles(HERE, WORKER, ranks, {"matrix": np.eye(2)}, settings or {})


def gone(placed, scratch):
    return placed._process.poll() is not None and not list(scratch.iterdir())


def test_an_object_is_asked_with_arrays_and_settings_and_ends_without_a_trace(scratch):
    placed = made()
    gap = np.linspace(0.0, 1.0, 1000)
    for steps in (3, 4):
        vector, facts = placed.call("twice", {"gap": gap}, {"steps": steps})
        np.testing.assert_array_equal(vector, 2.0 * gap)
        assert facts == {"told": {"steps": steps}}
    assert placed.call("nothing", {}, {}) == (None, {"told": {}})
    assert len(list(next(scratch.iterdir()).iterdir())) == 2  # its number, and what it has printed: no vector stays
    placed.end()
    assert gone(placed, scratch)
    with pytest.raises(LostProcessError):
        placed.call("twice", {"gap": gap}, {})


def test_a_process_that_ends_tells_its_last_words(scratch):
    with pytest.raises(LostProcessError, match="its process ended with code 7: no such matrix, nowhere"):
        made({"words": "no such matrix,\n nowhere"})
    placed = made()
    with pytest.raises(LostProcessError, match=r"code 7: \.\.\. x*$"):
        placed.call("die", {}, {"words": 2000 * "x"})
    assert gone(placed, scratch)


@pytest.mark.parametrize("method", ["time", "thread"])
def test_a_call_is_ended_from_outside(scratch, method):
    placed = made()
    if method == "time":
        with pytest.raises(OutOfTime):
            placed.call("wait", {}, {}, seconds=0.05)
    else:
        timer = threading.Timer(0.05, placed.end)
        timer.start()
        with pytest.raises(LostProcessError, match="ended"):
            placed.call("wait", {}, {})
        timer.join()
    assert gone(placed, scratch)


def test_what_cannot_be_started_is_told(scratch, monkeypatch):
    with pytest.raises(LostProcessError, match="/no/such/python3"):
        InFiles(Interpreter("/no/such/python3", "1.0"), WORKER, 1, {}, {})
    monkeypatch.setattr("shutil.which", lambda name: None)
    with pytest.raises(cq.MissingBackendError, match=r"ranks=2 needs mpiexec.*openmpi-bin.*or take ranks=1"):
        InFiles(Interpreter(str(scratch / "python3"), "1.0"), WORKER, 2, {}, {})


def test_what_could_not_be_made_tells_why_at_each_call():
    lost = Lost(LostProcessError("no matrix"))
    for _ in range(2):
        with pytest.raises(LostProcessError, match="no matrix"):
            lost.call("solve")
    lost.end()


def test_within_an_mpi_program_the_processes_are_none_of_it(monkeypatch):
    monkeypatch.setenv("OMPI_MCA_btl", "self")
    assert in_files._environment(2)["OMPI_MCA_btl"] == "self"  # the user's own wish
    monkeypatch.setenv("PMIX_RANK", "1")
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    found = in_files._environment(2)
    assert "PMIX_RANK" not in found
    assert "OMPI_MCA_btl" not in found
    assert found["OMPI_ALLOW_RUN_AS_ROOT"] == "1"
    assert found["OMP_NUM_THREADS"] == "2"


def test_an_interpreter_is_found_by_what_it_can_import(monkeypatch, tmp_path):
    assert interpreter_with("numpy.linalg", "PYTHON_FOR_TESTS") == Interpreter(sys.executable, np.__version__)
    monkeypatch.setenv("PYTHON_FOR_TESTS", "/usr/bin/env")
    assert interpreter_with("numpy.linalg", "PYTHON_FOR_TESTS") is None
    monkeypatch.setenv("PYTHON_FOR_TESTS", str(tmp_path / "python3"))
    assert interpreter_with("numpy.linalg", "PYTHON_FOR_TESTS") is None


def test_ranks_are_started_by_what_stands_beside_the_interpreter(tmp_path, monkeypatch):
    monkeypatch.setattr("shutil.which", lambda name: f"/elsewhere/{name}")
    assert Interpreter(str(tmp_path / "python3"), "1.0").mpiexec == "/elsewhere/mpiexec"
    (tmp_path / "mpiexec").touch()
    assert Interpreter(str(tmp_path / "python3"), "1.0").mpiexec == str(tmp_path / "mpiexec")
