"""Objects in processes of their own: they answer as they would here, can be ended at any time, and leave nothing."""

import signal
import sys
import threading

import numpy as np
import pytest
from placed import Counter

from contactqp.backends.processes import Elsewhere, Here, LostProcessError
from contactqp.foundation.interrupts import OutOfTime


@pytest.fixture(scope="module")
def counter():
    placed = Elsewhere(Counter, 2)
    yield placed
    placed.end()


def gone(placed):
    return placed._process.poll() is not None


def test_an_object_elsewhere_answers_as_one_here(counter):
    here = Here(Counter, 2)
    for placed in (here, counter):
        assert [placed.call("add", number) for number in (1, 2)] == [3, 5]
        with pytest.raises(KeyError, match="no"):
            placed.call("refuse", "no")
        np.testing.assert_array_equal(placed.call("add", np.ones(100_000)), np.full(100_000, 6.0))


def test_an_error_that_cannot_be_handed_on_is_told(counter):
    with pytest.raises(RuntimeError, match="LocalError: no"):
        counter.call("refuse_in_own_words", "no")


def test_what_is_printed_there_is_no_answer(counter, capfd):
    assert counter.call("say", "solving") == 7
    # The process was started by another test, before this one looked at what is printed.
    assert capfd.readouterr().out == ""


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="systems without masks have groups of processes")
def test_ctrl_c_does_not_reach_it(counter):
    assert counter.call("blocked")


def test_what_cannot_be_made_is_refused_as_here():
    for place in (Here, Elsewhere):
        with pytest.raises(ValueError, match="first must be >= 0, got -1"):
            place(Counter, -1)


def test_a_process_that_ends_by_itself_is_told():
    placed = Elsewhere(Counter, 0)
    with pytest.raises(LostProcessError, match="its process ended with code 7"):
        placed.call("end", 7)
    assert gone(placed)
    with pytest.raises(LostProcessError):
        placed.call("add", 1)


@pytest.mark.slow
def test_a_call_that_takes_too_long_ends_with_its_process():
    placed = Elsewhere(Counter, 0)
    with pytest.raises(OutOfTime):
        placed.call("wait", seconds=0.05)
    assert gone(placed)


@pytest.mark.slow
def test_another_thread_may_end_it_while_a_call_waits():
    placed = Elsewhere(Counter, 0)
    threading.Timer(0.05, placed.end).start()
    with pytest.raises(LostProcessError):
        placed.call("wait")
    assert gone(placed)


def test_an_application_that_is_no_interpreter_is_not_started(monkeypatch):
    monkeypatch.setattr(sys, "executable", "C:/Program Files/QGIS/qgis-bin.exe")
    with pytest.raises(LostProcessError, match="is no interpreter"):
        Elsewhere(Counter, 0)
    monkeypatch.setattr(sys, "executable", "/no/such/python3")
    with pytest.raises(LostProcessError, match="no/such/python3"):
        Elsewhere(Counter, 0)
