"""Shared settings of the tests."""

import os
import subprocess
import sys
from pathlib import Path

import matplotlib
import pytest
from hypothesis import HealthCheck, settings
from kernels import HALVES

pytest_plugins = ["pytester"]

for _name in ("COLUMNS", "LINES"):  # a shell exports them, or readline to processes that run tests side by side
    os.environ.pop(_name, None)
matplotlib.use("Agg")
settings.register_profile(
    "contactqp", deadline=None, derandomize=True, max_examples=60, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("thorough", parent=settings.get_profile("contactqp"), max_examples=1000, derandomize=False)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "contactqp"))


class FailuresAtOnce:
    """Tells of a failure when it happens: what ends a run from outside would take the summary along."""

    def __init__(self, terminal):
        self._terminal = terminal

    def pytest_runtest_logreport(self, report):
        if report.failed:
            self._terminal.write_line(f"\n{report.nodeid} ({report.when}):\n{report.longreprtext}")


@pytest.hookimpl(trylast=True)
def pytest_configure(config):
    if config.getoption("numprocesses", None):
        config.pluginmanager.register(FailuresAtOnce(config.pluginmanager.getplugin("terminalreporter")))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes():
    """Compile all kernels, each half in a process of its own, before tests run side by side."""
    program = str(Path(__file__).with_name("kernels.py"))
    running = [subprocess.Popen([sys.executable, program, half]) for half in HALVES]
    assert [process.wait() for process in running] == [0] * len(HALVES)
