"""An object in a process of another interpreter, or in several ranks of one MPI program: it is asked through files.

Arrays stand in a temporary folder, where each rank reads and writes its share of them, and what is asked and answered
beside them as JSON. The interpreter may have other releases of Python and of numpy than this one, and nothing of this
package: it runs one file, which is told the folder (see `contactqp.backends.petsc_worker`).
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import tempfile
import time
import weakref
from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import MissingBackendError
from ..foundation.checks import Vector
from ..foundation.interrupts import run_interruptibly
from ..foundation.loading import apart
from .interpreters import Interpreter
from .processes import LostProcessError, ended

_PROGRAM = """
import runpy, sys
sys.path[:] = [path for path in sys.path if path]  # nothing of the folder that we happen to be in
runpy.run_path(sys.argv.pop(1), run_name="__main__")
"""

_LONGEST = 400
"""Characters of a process's last words that are told."""

_OFTEN, _SELDOM, _SOON = 0.001, 0.01, 0.5
"""Seconds between two looks for an answer, at first and later, and what is later."""

_LAUNCHED = ("OMPI_COMM_WORLD_SIZE", "PMI_RANK", "PMIX_RANK")
_LAUNCHERS = ("OMPI_", "PMI_", "PMIX_", "PRTE_", "HYDI_", "HYDRA_", "MPI_")
_FOR_RANKS = {
    "OMP_NUM_THREADS": "1",
    # Open MPI refuses root, and more ranks than cores, unless it is told; the ranks are the user's own processes.
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",  # others may have work for the core on which a rank waits
    "OMPI_MCA_ess_singleton_isolated": "1",  # a single process needs no daemon, whose start takes a second
    "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
}
_FOR_ONE = {"OMPI_MCA_pml": "ob1", "OMPI_MCA_btl": "self"}
"""A single process talks to nobody: that Open MPI looks for networks would be nearly half of its start."""


class InFiles:
    """An object that a file of Python makes in another interpreter; see `contactqp.backends.processes.Placed`.

    Its methods are given arrays by their names and settings by theirs, and return a vector, or None, and facts. The
    processes end with this one, after Ctrl-C, and when the time of a call is over.

    Parameters
    ----------
    interpreter : Interpreter
    file : str
        What it runs.
    ranks : int
        Processes that share the object; more than one are started by ``mpiexec``.
    arrays : mapping of str to array
    settings : mapping of str to object
        What the object is made of; what is no array must be such that JSON can tell it.

    Raises
    ------
    LostProcessError
        If the object cannot be made; the message ends with the process's own words.
    MissingBackendError
        If there is no ``mpiexec`` for several ranks.
    """

    def __init__(
        self,
        interpreter: Interpreter,
        file: str,
        ranks: int,
        arrays: Mapping[str, Vector],
        settings: Mapping[str, Any],
    ) -> None:
        command = [interpreter.path, "-c", _PROGRAM, file]
        if ranks > 1:
            if interpreter.mpiexec is None:
                raise MissingBackendError(
                    f"ranks={ranks} needs mpiexec, which is not installed; type: apt install openmpi-bin, or what "
                    f"brings the MPI of {interpreter.path}, or take ranks=1"
                )
            command = [interpreter.mpiexec, "-n", str(ranks), *command]
        self._asked_so_far, self._interpreter = 0, interpreter
        apart(partial(self._start, command, arrays, {**settings, "ranks": ranks}))

    def call(self, method: str, *given: Any, seconds: float | None = None) -> Any:
        """See `Placed.call`; what is given are arrays and settings."""
        return run_interruptibly(partial(self._asked, method, *given), abandon=self.end, seconds=seconds)

    def end(self) -> None:
        """See `Placed.end`."""
        self._end()

    def _start(self, command: list[str], arrays: Mapping[str, Vector], settings: Mapping[str, Any]) -> None:
        self._folder = Path(tempfile.mkdtemp(prefix="contactqp-"))
        with (self._folder / "errors").open("wb") as errors:
            try:
                self._process = subprocess.Popen(
                    [*command, str(self._folder), str(os.getpid())],
                    stdin=subprocess.DEVNULL,
                    stdout=_standard_error(),
                    stderr=errors,
                    env={**_environment(settings["ranks"]), **self._interpreter.environment},
                    start_new_session=True,  # Ctrl-C at a terminal does not reach it
                )
            except OSError as error:
                shutil.rmtree(self._folder, ignore_errors=True)
                raise LostProcessError(str(error)) from error
        self._end = weakref.finalize(self, _all_ended, self._process, os.getpid(), self._folder)
        run_interruptibly(partial(self._asked, "", arrays, settings), abandon=self.end)

    def _asked(
        self, method: str, arrays: Mapping[str, Vector], settings: Mapping[str, Any]
    ) -> tuple[Vector | None, dict[str, Any]]:
        number, self._asked_so_far = self._asked_so_far, self._asked_so_far + 1
        folder = self._folder / str(number)
        try:
            folder.mkdir()
            for name, values in arrays.items():
                np.save(folder / f"{name}.npy", values)
            written = folder / "asked"
            written.write_text(json.dumps({"method": method, "settings": settings}), encoding="utf-8")
            written.replace(self._folder / f"{number}.json")
            answer = self._awaited(self._folder / f"{number}.done")
            vector = np.load(self._folder / f"{number}.npy") if answer["vector"] else None
        except FileNotFoundError as error:  # it was ended, and its folder is gone
            raise LostProcessError("its process was ended") from error
        shutil.rmtree(folder, ignore_errors=True)
        for file in self._folder.glob(f"{number}.*"):
            file.unlink(missing_ok=True)
        return vector, answer["facts"]

    def _awaited(self, file: Path) -> Any:
        since = time.monotonic()
        while not file.exists():
            code = self._process.poll()
            failed = list(self._folder.glob("*.failed"))  # written before a process ends
            if code is not None or failed:
                words = self._last_words(failed)
                self.end()
                how = "failed" if failed or code is None else f"ended with code {code}"
                raise LostProcessError(f"its process {how}{words}")
            time.sleep(_OFTEN if time.monotonic() - since < _SOON else _SELDOM)
        return json.loads(file.read_text(encoding="utf-8"))

    def _last_words(self, failed: list[Path]) -> str:
        """Return what a process told of its end, or else the last that it, or what started it, has printed."""
        told = failed or [self._folder / "errors"]
        words = ""
        with suppress(OSError):
            words = " ".join(told[0].read_text(encoding="utf-8", errors="replace").split())
        words = words if len(words) <= _LONGEST else f"... {words[-_LONGEST:]}"
        return f": {words}" if words else ""


def _environment(ranks: int) -> dict[str, str]:
    """Return the environment of so many processes: where this one is a rank of an MPI program, they are none of it."""
    found = dict(os.environ)
    if any(name in found for name in _LAUNCHED):
        found = {name: value for name, value in found.items() if not name.startswith(_LAUNCHERS)}
    return {**_FOR_RANKS, **(_FOR_ONE if ranks == 1 else {}), **found}


def _standard_error() -> int:
    """Return where a library's own words go that the user asks for: standard error, or nowhere if there is none."""
    try:
        os.fstat(2)
    except OSError:
        return subprocess.DEVNULL
    return 2


def _all_ended(process: subprocess.Popen[bytes], owner: int, folder: Path) -> None:
    """End a process and its ranks, which may be in groups of their own, and wait for it."""
    if os.getpid() == owner:
        for rank in folder.glob("*.pid"):
            with suppress(OSError):
                if process.poll() is None:
                    os.kill(int(rank.stem), signal.SIGKILL)
        with suppress(OSError):
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
        ended(process, owner)
        shutil.rmtree(folder, ignore_errors=True)
