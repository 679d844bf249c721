"""A terminal may be narrow, closed or missing."""

import io
import subprocess
import sys

import pytest
from strategies import BACKENDS

import contactqp as cq
from contactqp.foundation.loading import _announcing
from contactqp.foundation.progress import Progress
from contactqp.foundation.terminal import on_terminal, table_console


def closed():
    stream = io.StringIO()
    stream.close()
    return stream


@pytest.mark.parametrize("stream", [None, closed(), io.StringIO()])
def test_progress_without_a_terminal(monkeypatch, stream):
    monkeypatch.setattr(sys, "stderr", stream)
    assert not on_terminal()
    with Progress("loads") as progress, _announcing("psor"):
        progress.update("load 1 of 2")


@pytest.mark.parametrize("stream", [None, closed()])
@pytest.mark.parametrize("backend", BACKENDS)
def test_every_backend_solves_without_standard_error(monkeypatch, stream, backend):
    cable = cq.Cable(span=10.0, spacing=1.0, tension=1.0, load=1.0, support=2.0)
    monkeypatch.setattr(sys, "stderr", stream)
    assert cq.solve(cable, backend).status.ok


def test_the_command_line_without_any_streams(tmp_path):
    """A service has none: the operating system's are closed before the interpreter starts."""
    case = tmp_path / "case.toml"
    case.write_text('model = "cable"\nspan = 10\nspacing = 1\ntension = 1\nload = 1\nsupport = 2\n')
    command = f"exec {sys.executable} -c 'from contactqp.cli.commands import main; main()' solve"
    for name, code in ((case, 0), (tmp_path / "nothing.toml", 2)):
        found = subprocess.run(f"{command} '{name}' <&- >&- 2>&-", shell=True, check=False)
        assert found.returncode == code


def test_tables_are_as_wide_as_told(monkeypatch):
    monkeypatch.setenv("COLUMNS", "90")
    assert table_console().width == 90
    monkeypatch.delenv("COLUMNS")
    assert table_console().width == 160
