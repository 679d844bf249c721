"""Progress is one line on a terminal, also of work within work."""

from typing import ClassVar

import pytest

from contactqp.foundation import progress as progress_module
from contactqp.foundation.progress import Progress


class Line:
    """Stands for rich's status line."""

    shown: ClassVar[list[str]] = []
    started = stopped = 0

    def __init__(self, *args, **kwargs):
        pass

    def status(self, text):
        return self

    def start(self):
        Line.started += 1

    def stop(self):
        Line.stopped += 1

    def update(self, text):
        Line.shown.append(text)


@pytest.fixture
def line(monkeypatch):
    monkeypatch.setattr(progress_module, "_PATIENCE", 0.0)
    monkeypatch.setattr("rich.console.Console", Line)
    Line.shown, Line.started, Line.stopped = [], 0, 0
    return Line


def test_work_within_work_shares_a_line(line):
    with Progress("loads", shown=True) as outer:
        outer.update("load 1 of 2")
        with Progress("psor", shown=True) as inner:
            inner.update("20 sweeps")
        outer.update("load 2 of 2")
    assert line.shown == [
        "loads · load 1 of 2 · 0 s",
        "loads · load 1 of 2 · psor · 20 sweeps · 0 s",
        "loads · load 2 of 2 · 0 s",
    ]
    assert (line.started, line.stopped) == (1, 1)
    assert Progress._under_way == []


def interrupted():
    with Progress("loads", shown=True) as outer:
        outer.update("load 1 of 2")
        raise KeyboardInterrupt


def test_an_error_ends_the_line(line):
    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert (line.started, line.stopped) == (1, 1)
    assert Progress._under_way == []


def test_nothing_is_shown_elsewhere_than_on_a_terminal(line):
    with Progress("loads") as outer:
        outer.update("load 1 of 2")
    assert line.shown == []
