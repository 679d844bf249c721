"""Ctrl-C is answered at once, at whatever moment, and what was interrupted can be done again."""

import os
import random
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import typer
from ctrl_c import PROMPTLY

import contactqp as cq
import contactqp_command
from contactqp.backends.base import Stop
from contactqp.cli.application import bad_input
from contactqp.foundation import interrupts, loading
from contactqp.foundation.deadline import Deadline
from contactqp.foundation.interrupts import INTERRUPTED, OutOfTime, ended_by_interrupts, run_interruptibly

ROOT = Path(__file__).parents[2]
PROGRAM = ROOT / "tests" / "interrupted.py"
WORKS = (
    *("osqp", "clarabel", "mangasarian", "psor", "multigrid", "active-set"),
    *("matrix", "compare", "trace", "march", "events", "certify"),
)
COMMANDS = {
    "compare": ["compare", "examples/hexagon.toml", "--plot", "{0}/a.png", "--report", "{0}/a.html"],
    "solve": ["solve", "examples/dome.toml", "--backend", "clarabel", "--out", "{0}/a.nc", "--plot", "{0}/a.png"],
    "paper": ["paper", "--out", "{0}/paper"],
}
STARTED = "import contactqp.cli.commands; from contactqp_command import main; print('ready', flush=True); main()"
BEGUN = "print('ready', flush=True); from contactqp_command import main; main()"
posix = pytest.mark.skipif(os.name != "posix", reason="sends a signal of POSIX")


@pytest.fixture
def nothing_left(monkeypatch):
    monkeypatch.setattr(interrupts, "_left_behind", [])


def interrupted_soon():
    threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()


@posix
def test_an_interrupt_leaves_the_work_behind_and_asks_it_to_stop(nothing_left):
    asked, ended = threading.Event(), threading.Event()

    def work():
        asked.wait(10)
        ended.set()

    interrupted_soon()
    with pytest.raises(KeyboardInterrupt):
        run_interruptibly(work, abandon=asked.set)
    assert ended.wait(5)


@posix
@pytest.mark.parametrize("seconds", [None, 60.0])
def test_work_within_work_that_is_left_behind_is_asked_to_stop_too(nothing_left, seconds):
    """As a backend's library is, which is called within the thread that a time limit takes."""
    asked, ended = threading.Event(), threading.Event()

    def library():
        asked.wait(10)
        ended.set()

    def backend():
        return run_interruptibly(library, abandon=asked.set, seconds=seconds)

    interrupted_soon()
    with pytest.raises(KeyboardInterrupt):
        run_interruptibly(backend, seconds=60.0)
    assert ended.wait(5)


def test_work_that_begins_after_the_call_around_it_was_left_behind_is_asked_to_stop_at_once(nothing_left):
    asked, go_on, ended = threading.Event(), threading.Event(), threading.Event()

    def backend():
        go_on.wait(10)
        run_interruptibly(ended.set, abandon=asked.set)

    with pytest.raises(interrupts.OutOfTime):
        run_interruptibly(backend, seconds=0.1)
    go_on.set()
    assert ended.wait(5)
    assert asked.is_set()


@posix
def test_clarabel_is_told_of_an_interrupt_although_it_has_a_time_limit(nothing_left, monkeypatch):
    told = []

    class Told(threading.Event):
        def __init__(self):
            super().__init__()
            told.append(self)

    monkeypatch.setattr("contactqp.foundation.deadline.Event", Told)
    lattice = cq.Frame.rectangle(1.0, 1.0).lattice(spacing=1 / 200)
    membrane = cq.Membrane(lattice, tension=1.0, load=4.0, support=0.1)
    cq.solve(cq.gallery.bowl(9), "clarabel")  # loads the library
    interrupted_soon()
    with pytest.raises(KeyboardInterrupt):
        cq.solve(membrane, "clarabel", tol=1e-9, time_limit=120.0)
    assert told[-1].is_set()
    (thread,) = interrupts._left_behind
    thread.join(60)  # what is at work while the interpreter goes down would end the process


@pytest.mark.parametrize("backend", ["psor", "multigrid", "active-set", "mprgp"])
def test_own_methods_stop_after_an_interrupt_although_they_have_a_time_limit(nothing_left, backend, monkeypatch):
    """What they do once nobody waits for them any more ends at the first look at the clock."""
    bowl, answers, work = cq.gallery.bowl(31), [], Deadline.work
    cq.solve(bowl, backend)  # compiles

    def late(self, call, progress=None):
        def begun_after_the_interrupt():
            assert self.abandoned.wait(20.0)
            answers.append(call()[0])
            return answers[-1], None, None

        return work(self, begun_after_the_interrupt, progress)

    monkeypatch.setattr(Deadline, "work", late)
    interrupted_soon()
    with pytest.raises(KeyboardInterrupt):
        cq.solve(bowl, backend, tol=1e-12, time_limit=300.0)
    (thread,) = interrupts._left_behind
    thread.join(20)
    assert [answer.stop for answer in answers] == [Stop.TIME_LIMIT]


def test_what_the_work_returns_and_raises_is_passed_on():
    assert run_interruptibly(lambda: 7) == 7
    with pytest.raises(ZeroDivisionError):
        run_interruptibly(lambda: 1 / 0)
    with pytest.raises(TimeoutError, match="of the work"):
        run_interruptibly(lambda: (_ for _ in ()).throw(TimeoutError("of the work")))


def test_a_thread_that_no_signal_reaches_does_the_work_itself():
    found = []
    thread = threading.Thread(target=lambda: found.append(run_interruptibly(threading.current_thread)))
    thread.start()
    thread.join()
    assert found == [thread]


@posix
@pytest.mark.parametrize("reaction", ["pass", "raise", "time.sleep(10)", "raise RuntimeError"])
def test_a_command_ends_with_the_code_of_an_interrupt(reaction):
    program = f"""
import os, signal, time
from contactqp.foundation.interrupts import ended_by_interrupts
with ended_by_interrupts():
    try:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(10)
    except KeyboardInterrupt:
        {reaction}
"""
    started = time.monotonic()
    command = [sys.executable, "-c", program]
    result = subprocess.run(command, env=environment(), capture_output=True, text=True, timeout=60, check=False)
    assert (result.returncode, result.stderr) == (INTERRUPTED, "")
    assert time.monotonic() - started < 9


@posix
def test_of_an_interrupt_that_a_destructor_swallows_nothing_is_printed():
    program = """
import os, signal, time
from contactqp.foundation.interrupts import ended_by_interrupts
class Last:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.1)
with ended_by_interrupts():
    last = Last()
    del last
"""
    command = [sys.executable, "-c", program]
    result = subprocess.run(command, env=environment(), capture_output=True, text=True, timeout=60, check=False)
    assert (result.returncode, result.stderr) == (INTERRUPTED, "")


def test_a_command_that_nothing_interrupts_ends_as_it_would():
    with pytest.raises(SystemExit) as error, ended_by_interrupts():
        raise SystemExit(2)
    assert error.value.code == 2


class Clock:
    """A clock whose seconds pass only where a test says so."""

    now = 0.0

    def perf_counter(self):
        return self.now

    def wait(self, seconds):
        self.now += seconds


@pytest.fixture
def clock(monkeypatch):
    """The clock by which loading is timed."""
    made = Clock()
    monkeypatch.setattr(loading, "time", made)
    return made


def test_loading_is_no_work(clock):
    started, loaded = loading.working_seconds(), loading.loading_seconds()
    loading.once(object(), lambda: clock.wait(3.0), "a test")
    assert loading.loading_seconds() - loaded == 3.0
    assert loading.working_seconds() == started


def test_loading_that_was_left_behind_is_no_work_either(clock):
    begun, over = threading.Event(), threading.Event()

    def wait():
        begun.set()
        over.wait()

    started, loaded = loading.working_seconds(), loading.loading_seconds()
    with pytest.raises(OutOfTime):
        run_interruptibly(lambda: loading.once(object(), wait, "a test"), seconds=0.2)
    assert begun.wait(10)
    assert loading.is_loading()
    clock.wait(3.0)
    assert loading.loading_seconds() - loaded == 3.0
    assert loading.working_seconds() == started
    over.set()
    while loading.is_loading():
        time.sleep(0.01)


def test_what_is_done_once_is_not_done_again_but_after_an_error():
    key, calls = object(), []

    def work():
        calls.append(1)
        if len(calls) == 1:
            raise ValueError

    with pytest.raises(ValueError):  # noqa: PT011
        loading.once(key, work, "a test")
    loading.once(key, work, "a test")
    loading.once(key, work, "a test")
    assert len(calls) == 2


def environment(source=ROOT / "src"):
    return dict(os.environ, PYTHONPATH=str(source))


def run(what, *moments, uncaught=False, env):
    more = ["uncaught"] * uncaught
    command = [sys.executable, str(PROGRAM), what, *(f"{moment:.3f}" for moment in moments), *more]
    return subprocess.run(command, env=env, capture_output=True, text=True, timeout=240, cwd=ROOT, check=False)


def uncompiled(folder, but):
    """Copy the package with no compiled kernels but those of one method; return an environment that takes the copy."""

    def left_out(path, names):  # others, that run at the same time, write and remove files of further kinds
        kinds = ("", ".py", ".toml", *([".nbi", ".nbc"] if Path(path).parent.name == but else []))
        return [name for name in names if Path(name).suffix not in kinds]

    shutil.copytree(ROOT / "src", folder, ignore=left_out)
    return {name: value for name, value in environment(folder).items() if name != "NUMBA_CACHE_DIR"}


def check(result, times):
    # OSQP prints a line of its own when it is interrupted.
    lines = [line for line in result.stdout.splitlines() if line != "Solver interrupted"]
    assert len(lines) == times
    for line in lines:
        late, *after = line.split()
        assert float(late) < PROMPTLY
        assert after == ["certified"] * 4


@posix
@pytest.mark.slow
@pytest.mark.parametrize("what", WORKS)
def test_work_interrupted_at_any_moment_can_be_done_again(what):
    chance = random.Random(what)
    for at_first in ((0.0, 0.5), (0.5, 1.5)):
        result = run(what, chance.uniform(*at_first), *(chance.uniform(0.0, 0.7) for _ in range(3)), env=environment())
        assert (result.returncode, result.stderr) == (0, "")
        check(result, times=4)


@posix
@pytest.mark.slow
@pytest.mark.parametrize(("what", "but"), [("multigrid", None), ("psor", "multigrid"), ("matrix", "multigrid")])
def test_compiling_interrupted_at_any_moment_can_be_done_again(what, but, tmp_path):
    """Kernels that the work does not call are found compiled, where others have compiled them: they take longest."""
    chance = random.Random(what)
    result = run(what, chance.uniform(0.0, 8.0), env=uncompiled(tmp_path / "copy", but))
    assert (result.returncode, result.stderr) == (0, "")
    check(result, times=1)


@posix
@pytest.mark.slow
@pytest.mark.parametrize("what", ["osqp", "clarabel", "mangasarian"])
def test_an_interrupt_that_nobody_catches_ends_the_program_in_good_order(what):
    chance = random.Random(what)
    for _ in range(2):
        result = run(what, chance.uniform(0.0, 1.0), uncaught=True, env=environment())
        # 1 where the library's thread ran a string of code before the end: the interpreter forgets the signal then.
        assert result.returncode in (-signal.SIGINT, 1)
        assert result.stderr.endswith("KeyboardInterrupt\n")
        assert "panicked" not in result.stderr
        check(result, times=1)


def test_the_entry_point_ends_as_the_commands_do():
    assert contactqp_command.INTERRUPTED == INTERRUPTED
    with pytest.raises(typer.Exit) as found, bad_input():
        raise KeyboardInterrupt
    assert found.value.exit_code == INTERRUPTED


@posix
@pytest.mark.parametrize("command", [["--version"], ["compare", "no-such-case.toml"]])
def test_a_command_interrupted_while_it_starts_says_so_and_no_more(command):
    chance = random.Random(" ".join(command))
    outcomes = []
    for _ in range(6):
        process = subprocess.Popen(
            [sys.executable, "-c", BEGUN, *command],
            env=environment(),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        time.sleep(chance.uniform(0.02, 0.5))
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        outcomes.append(process.returncode)
        if process.returncode == INTERRUPTED:
            assert errors == contactqp_command.WORDS
        else:  # it was done before the signal came
            assert "Traceback" not in errors
            assert process.returncode in (0, 2)
    assert INTERRUPTED in outcomes


@posix
@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_interrupted_at_any_moment_ends_promptly(name, tmp_path):
    chance = random.Random(name)
    arguments = [argument.format(tmp_path) for argument in COMMANDS[name]]
    for _ in range(4):
        process = subprocess.Popen(
            [sys.executable, "-c", STARTED, *arguments],
            env=environment(),
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        time.sleep(chance.uniform(0.0, 1.5))
        sent = time.monotonic()
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        assert time.monotonic() - sent < PROMPTLY
        if process.returncode != 0:  # else it was done before the signal came
            assert process.returncode == INTERRUPTED
            assert "Traceback" not in errors
