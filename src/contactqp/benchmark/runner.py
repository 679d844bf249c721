"""run(): a suite of problems by several solvers, each in a process of its own; a run that was stopped goes on."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Literal

from ..backends import get_backend
from ..backends.base import Backend
from ..foundation.checks import names_in, nearest
from ..foundation.progress import Progress
from ..foundation.text import counted
from ..gallery.families import FAMILIES
from ..solving.tolerances import tolerance_of
from .about import measured_with
from .record import REFERENCE, Ask, Listed, Record
from .results import Results
from .suites import Suite, suite_of

_GRACE, _MARGIN = 180.0, 1.5
"""Seconds beyond the limits of its solves after which a process is ended, and the factor upon these limits: a library
may look at the clock between its steps only, and a process has to start, to compile, to make its problem, and to
judge."""

_LONGEST = 300
"""Characters of a process's last words that are kept."""


def run(
    suite: str | Suite = "quick",
    folder: str | Path = "benchmark",
    *,
    backends: Sequence[str | Backend] | Literal["all"] | None = None,
    levels: Sequence[str] | None = None,
    families: Sequence[str] | None = None,
) -> Results:
    """Measure solvers on a suite of problems, each in a process of its own with limits of time and memory.

    Every answer is judged by the package, and compared with an enclosure of the true solution: a solver that says that
    it has solved a problem, and is proven wrong, is counted. What is found is written line by line, so that a run that
    was stopped goes on where it was.

    Parameters
    ----------
    suite : str or Suite
        "quick" (some minutes), "standard" or "large".
    folder : str or Path
        Where results are written: ``records.jsonl`` and ``about.json``, see `Results`. It is made if need be.
    backends : sequence of str or Backend, or "all", optional
        Names, or backends whose classes can be imported and called without arguments. By default those that are usual
        for a problem's kind and size; with "all" the solvers that qpsolvers and CVXPY find, too.
    levels : sequence of str, optional
        "low", "mid", "high", "default"; by default those of the suite.
    families : sequence of str, optional
        Some of the suite's; by default all.

    Returns
    -------
    Results

    Raises
    ------
    UnknownBackendError
        If there is no backend of a given name.
    ValueError
        If another name is not known, or the folder holds results of something else.
    KeyboardInterrupt
        With a note of how many answers the folder keeps.
    """
    whole = suite_of(suite)
    chosen = _narrowed(whole, levels, families)
    if backends is not None and backends != "all":
        for backend in names_in(backends, "backends"):
            get_backend(backend)
    results = Results.begun(Path(folder), replace(chosen, problems=whole.problems), *measured_with())
    try:
        _measure(results, chosen, backends)
    except KeyboardInterrupt as stop:
        kept = counted(len(results.records), "answer is", "answers are")
        stop.add_note(f"{kept} kept in {results.folder}; started again, the same command goes on from there")
        raise
    return results


def _measure(results: Results, chosen: Suite, backends: Sequence[str | Backend] | Literal["all"] | None) -> None:
    """Add what is still missing of a suite to results."""
    done = {record.key for record in results.records}
    named = None if backends is None or isinstance(backends, str) else backends
    with Progress(f"benchmark {chosen.name}") as progress, tempfile.TemporaryDirectory() as scratch:
        for family, number in _problems(chosen):
            if named is not None and not _open(chosen, family, number, named, done):
                continue
            progress.update(f"{family} {number}: the truth")
            truth = Path(scratch, f"{family}-{number}.npz")
            wanted: Listed = "none" if named is not None else "usual" if backends is None else "all"
            listed = _reference(chosen, family, number, truth, Path(scratch), wanted)
            for ask in _asks(chosen, family, number, listed if named is None else named):
                if ask.key not in done:
                    progress.update(f"{ask.problem}: {ask.backend}, {ask.level}")
                    results.add(_measured(ask, truth, Path(scratch)))


def _narrowed(suite: Suite, levels: Sequence[str] | None, families: Sequence[str] | None) -> Suite:
    """Return a suite with some of its levels and families."""
    for family in () if families is None else names_in(families, "families"):
        if family not in suite.problems:
            known = list(suite.problems)
            raise ValueError(
                f"families has {family!r}, which suite {suite.name!r} has not{nearest(family, known)}; "
                f"it has {', '.join(known)}"
            )
    kept = {name: numbers for name, numbers in suite.problems.items() if families is None or name in families}
    for name in kept:
        if name not in FAMILIES:
            raise ValueError(f"suite {suite.name!r} has an unknown family {name!r}; known: {', '.join(FAMILIES)}")
    return replace(suite, problems=kept, levels=suite.levels if levels is None else tuple(names_in(levels, "levels")))


def _problems(suite: Suite) -> Iterator[tuple[str, int]]:
    for family, numbers in suite.problems.items():
        for number in numbers:
            yield family, number


def _open(
    suite: Suite, family: str, number: int, backends: Sequence[str | Backend], done: set[tuple[str, int, str, str]]
) -> bool:
    """Whether somebody who was named has not been asked about a problem yet."""
    named = (_named(backend)[0] for backend in backends)
    return any((family, number, name, level) not in done for name in named for level in suite.levels)


def _named(backend: str | Backend) -> tuple[str, bool]:
    """Return what a backend is called by, and whether it has to be imported."""
    if isinstance(backend, str):
        return backend, False
    return f"{type(backend).__module__}:{type(backend).__qualname__}", True


def _asks(suite: Suite, family: str, number: int, backends: Sequence[str | Backend]) -> Iterator[Ask]:
    """Yield what is to be asked about a problem."""
    for backend in backends:
        name, imported = _named(backend)
        for level in suite.levels:
            yield Ask(family, number, name, level, suite.time_limit, suite.memory, suite.repeats, imported)


def _reference(suite: Suite, family: str, number: int, truth: Path, scratch: Path, wanted: Listed) -> list[str]:
    """Have the truth of a problem found out; return the backends that may be asked about it, as far as wanted."""
    ask = Ask(family, number, REFERENCE, "high", suite.time_limit, suite.memory)
    answer = _in_process(ask, truth, scratch, seconds=10 * _GRACE, listed=wanted)
    if "listed" not in answer:
        raise RuntimeError(f"the problem {ask.problem} cannot be made: {answer['message']}")
    listed: list[str] = answer["listed"]
    return listed


def _measured(ask: Ask, truth: Path, scratch: Path) -> Record:
    seconds = _MARGIN * ask.repeats * ask.time_limit + _GRACE
    return Record.from_dict(_in_process(ask, truth, scratch, seconds=seconds))


def _in_process(ask: Ask, truth: Path, scratch: Path, seconds: float, listed: Listed = "none") -> dict[str, Any]:
    """Return what a process of its own makes of an ask."""
    asked, answer = scratch / "ask.json", scratch / "answer.json"
    answer.unlink(missing_ok=True)
    told = {"ask": asdict(ask), "truth": str(truth), "path": [entry for entry in sys.path if entry], "listed": listed}
    asked.write_text(json.dumps(told), encoding="utf-8")
    command = [sys.executable, "-m", f"{__package__}.child", str(asked), str(answer)]
    started = time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
        try:
            _, words = process.communicate(timeout=seconds)
        except subprocess.TimeoutExpired:
            process.kill()
            said = f"it was at work for {time.perf_counter() - started:.0f} s"
            return Record.of(ask, tol=tolerance_of(ask.level).tol, status="killed", message=said).to_dict()
        except BaseException:
            process.kill()
            raise
    if answer.exists():
        found: dict[str, Any] = json.loads(answer.read_text(encoding="utf-8"))
        return found
    last = (words.strip().splitlines() or ["it said nothing"])[-1][-_LONGEST:]
    status = "out of memory" if "MemoryError" in words or "bad_alloc" in words else "error"
    said = f"its process ended with code {process.returncode}: {last}"
    return Record.of(ask, tol=tolerance_of(ask.level).tol, status=status, message=said).to_dict()
