"""Other interpreters of this machine, which have packages that this one has not: a system's own, or one of conda's."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

_PATIENCE = 60.0
"""Seconds that an interpreter has to import a package: the first time may be slow."""


@dataclass(frozen=True)
class Interpreter:
    """An interpreter that can import a package.

    Attributes
    ----------
    path : str
        Of its program.
    version : str
        The package's.
    environment : mapping of str to str
        Variables that it needs for that, beside those that there are.
    """

    path: str
    version: str
    environment: Mapping[str, str] = field(default_factory=dict)

    @property
    def mpiexec(self) -> str | None:
        """The program that starts ranks of the interpreter's MPI: the one beside it, or what is found; None if none."""
        beside = Path(self.path).with_name("mpiexec")
        return str(beside) if beside.exists() else shutil.which("mpiexec")


def interpreter_with(module: str, variable: str, environments: Iterable[Mapping[str, str]] = ()) -> Interpreter | None:
    """Return the interpreter that can import a module, or None.

    Parameters
    ----------
    module : str
        Full name; its package tells its version.
    variable : str
        The environment variable that may name the interpreter. Where it is not set, this interpreter is tried, then the
        system's own, then ``python3`` as it is found.
    environments : iterable of mapping of str to str
        Variables to try another interpreter with, where it cannot import the module without.

    Examples
    --------
    >>> interpreter_with("numpy.linalg", "NO_SUCH_VARIABLE").path == sys.executable
    True
    >>> interpreter_with("no_such_module", "NO_SUCH_VARIABLE")
    """
    named = os.environ.get(variable)
    usual = [sys.executable, "/usr/bin/python3", shutil.which("python3") or ""]
    for path in [named] if named else dict.fromkeys(usual):
        for environment in ({}, *(environments if path != sys.executable else ())):
            version = _version(path, module, tuple(environment.items()))
            if version:
                return Interpreter(path, version, environment)
    return None


@cache
def _version(path: str, module: str, environment: tuple[tuple[str, str], ...]) -> str | None:
    """Return the version of a module's package, None where an interpreter cannot import the module, or is none."""
    package = module.partition(".")[0]
    if not Path(path).name.lower().startswith(("python", "pypy")):
        return None
    program = f"import {module}, {package}; print({package}.__version__)"
    try:
        run = subprocess.run(
            [path, "-c", program],
            capture_output=True,
            text=True,
            timeout=_PATIENCE,
            stdin=subprocess.DEVNULL,
            env={**os.environ, **dict(environment)},
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return run.stdout.split()[-1] if run.returncode == 0 and run.stdout.split() else None
