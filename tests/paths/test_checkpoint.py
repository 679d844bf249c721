"""Checkpoints: one path at a time, from any thread, and nothing that was kept is lost."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from threading import Barrier, Event
from time import sleep

import numpy as np
import pytest
import xarray as xr

import contactqp as cq
from contactqp.foundation.files import held
from contactqp.foundation.progress import Progress
from contactqp.paths import trace as trace_module

CABLE = cq.Cable(nodes=19, spacing=1.0, tension=1.0, load=1.0, support=1.0)
EIGHT = [0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08]


def kept(file):
    with xr.open_dataset(file, engine="netcdf4") as data:
        return dict(zip(data["value"].to_numpy().tolist(), data["cold_iterations"].to_numpy().tolist(), strict=True))


@pytest.fixture
def finished(tmp_path):
    """A checkpoint of a path of eight loads."""
    file = tmp_path / "path.nc"
    cq.trace(CABLE, loads=EIGHT, backend="psor", checkpoint=file)
    assert list(kept(file)) == EIGHT
    return file


@contextmanager
def killed_after(loads):
    """Interrupt the path that is traced inside after so many loads."""
    asked = []

    class Killed(Progress):
        def update(self, detail=None):
            asked.append(detail)
            if len(asked) > loads:
                raise KeyboardInterrupt

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(trace_module, "Progress", Killed)
        with pytest.raises(KeyboardInterrupt):
            yield


def test_a_finished_checkpoint_that_is_resumed_with_cold_starts_and_killed_keeps_all(finished):
    with killed_after(2):
        cq.trace(CABLE, loads=EIGHT, backend="psor", checkpoint=finished, cold=True)
    found = kept(finished)
    assert list(found) == EIGHT
    assert [count >= 0 for count in found.values()] == [True, True, *[False] * 6]


def test_other_values_are_added_to_those_that_are_kept(finished):
    with killed_after(3):
        cq.trace(CABLE, loads=[0.01, 0.015, 0.025, 0.035], backend="psor", checkpoint=finished)
    assert list(kept(finished)) == [*EIGHT, 0.015, 0.025]
    path = cq.trace(CABLE, loads=[0.08, 0.015, 0.5], backend="psor", checkpoint=finished)
    restored = "restored from path.nc"
    assert [solution.note == restored for solution in path.solutions] == [True, True, False]
    np.testing.assert_allclose(path.solutions[2].gap, cq.solve(path.solutions[2].model).gap, atol=1e-5)
    assert list(kept(finished)) == [*EIGHT, 0.015, 0.025, 0.5]


def test_a_shorter_path_leaves_the_rest(finished):
    cq.trace(CABLE, loads=EIGHT[:2], backend="psor", checkpoint=finished, tol=1e-12)
    assert list(kept(finished)) == EIGHT


def test_a_worse_answer_does_not_replace_a_better_one(finished):
    with xr.open_dataset(finished, engine="netcdf4") as data:
        before = data["gap"].to_numpy()
    path = cq.trace(CABLE, loads=EIGHT, backend="psor", checkpoint=finished, tol=1e-17, max_iter=1, on_failure="ignore")
    assert not any(solution.status.ok for solution in path.solutions)
    fresh = cq.trace(CABLE, loads=EIGHT, backend="psor", checkpoint=finished, tol=1e-6)
    assert {solution.note for solution in fresh.solutions} == {"restored from path.nc"}
    with xr.open_dataset(finished, engine="netcdf4") as data:
        after = data["gap"].to_numpy()
    exact = np.array([cq.solve(solution.model, tol=1e-12).gap for solution in fresh.solutions])
    assert np.abs(after - exact).max() <= np.abs(before - exact).max() * (1 + 1e-9)


def test_a_damaged_checkpoint_is_told_and_left_alone(finished):
    damaged = finished.read_bytes()[:900]
    finished.write_bytes(damaged)
    with pytest.raises(ValueError, match=r"path\.nc is no checkpoint"):
        cq.trace(CABLE, loads=EIGHT, backend="psor", checkpoint=finished)
    assert finished.read_bytes() == damaged


def alone(call, inside, most):
    """Note how many threads are in a call at once."""

    def noting(*args, **kwargs):
        inside.append(None)
        most.append(len(inside))
        sleep(0.002)
        try:
            return call(*args, **kwargs)
        finally:
            inside.pop()

    return noting


def test_threads_with_files_of_their_own(tmp_path, monkeypatch):
    """The library beneath NetCDF is not safe for threads: where two are in it, the interpreter may die."""
    together = Barrier(4)
    inside: list[None] = []
    most: list[int] = []
    monkeypatch.setattr(xr.Dataset, "to_netcdf", alone(xr.Dataset.to_netcdf, inside, most))
    monkeypatch.setattr(xr, "open_dataset", alone(xr.open_dataset, inside, most))

    def path(k):
        together.wait()
        traced = cq.trace(CABLE, loads=EIGHT, backend="psor", checkpoint=tmp_path / f"{k}.nc")
        return traced.to_frame()["contact"].tolist()

    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(path, range(4)))
        list(pool.map(path, range(4)))  # from what is kept
    assert found == [found[0]] * 4
    assert len(most) == 4 * len(EIGHT) + 4
    assert max(most) == 1
    assert sorted(file.name for file in tmp_path.iterdir()) == ["0.nc", "1.nc", "2.nc", "3.nc"]
    assert all(list(kept(tmp_path / f"{k}.nc")) == EIGHT for k in range(4))


def test_a_checkpoint_in_use_by_another_thread_is_refused(tmp_path):
    file = tmp_path / "path.nc"
    inside, done = Event(), Event()

    def hold():
        with held(file, "checkpoint"):
            inside.set()
            assert done.wait(20)

    with ThreadPoolExecutor(1) as pool:
        holding = pool.submit(hold)
        assert inside.wait(20)
        for name in (file, tmp_path / "." / "path.nc"):
            with pytest.raises(
                ValueError, match=r"checkpoint .*path\.nc is in use by another thread; name another file"
            ):
                cq.trace(CABLE, loads=EIGHT, checkpoint=name)
        done.set()
        holding.result()
    cq.trace(CABLE, loads=EIGHT, checkpoint=file)
    assert list(tmp_path.iterdir()) == [file]


HOLDER = """
import sys, pathlib
from contactqp.foundation.files import held
from contactqp.foundation.progress import Progress
with held(pathlib.Path(sys.argv[1]), "checkpoint"):
    print("held", flush=True)
    sys.stdin.read()
"""


def test_a_checkpoint_in_use_by_another_process_is_refused_until_that_dies(tmp_path):
    file = tmp_path / "path.nc"
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(file)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        assert holder.stdout.readline() == "held\n"
        with pytest.raises(ValueError, match=r"checkpoint .*path\.nc is in use by another process"):
            cq.trace(CABLE, loads=EIGHT, checkpoint=file)
        assert not file.exists()
    finally:
        holder.kill()
        holder.communicate()
    cq.trace(CABLE, loads=EIGHT, checkpoint=file)
    assert list(tmp_path.iterdir()) == [file]


def test_an_interrupted_path_lets_go_of_its_checkpoint(tmp_path):
    file = tmp_path / "path.nc"
    with killed_after(2):
        cq.trace(CABLE, loads=EIGHT, checkpoint=file)
    with held(Path(file), "checkpoint"):
        pass
    assert list(tmp_path.iterdir()) == [file]
