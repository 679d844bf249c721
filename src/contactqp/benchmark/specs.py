"""Spec: a benchmark of parts, which builds a case for each point of a sweep and times phases on it, in turn."""

from __future__ import annotations

import importlib.util
import math
import re
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..errors import MissingBackendError, UnsuitableProblemError

Point = int | float | str
"""A point of a sweep: a number, or a problem's name."""

Facts = Mapping[str, int | float | str]
"""Numbers and words by their names."""

COLUMNS = ("spec", "phase", "point", "size", "seconds", "ratio", "runs", "words")
"""What every line has; facts have other names."""

_NAME = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")


@dataclass(frozen=True)
class Phase:
    """What is timed on a case.

    Attributes
    ----------
    run : callable
        Of the case. It raises an `UnsuitableProblemError` if the case does not suit it, which is told in its line.
    largest : float
        It is left out at larger numbers of the sweep.
    needs : tuple of str
        Modules or commands without which it is left out.
    once : bool
        Whether it takes so long that it is timed once, without a run before that warms up.
    """

    run: Callable[[Any], object]
    largest: float = math.inf
    needs: tuple[str, ...] = ()
    once: bool = False

    @property
    def lacks(self) -> str:
        """The first of its needs that is not there, or an empty text."""
        return next((need for need in self.needs if not _is_there(need)), "")


@dataclass(frozen=True)
class Spec:
    """A benchmark: what is built, for which numbers, and what is timed.

    Attributes
    ----------
    name : str
        Words in small letters and digits, joined by dashes.
    summary : str
        What is measured, in a line.
    build : callable
        Returns the case of a point of the sweep; it is not timed.
    sweep : tuple of int, float or str
        The points.
    phases : mapping of str to callable or Phase
        What is timed, by name: functions of the case. A mapping that one returns is told in its line, of a `Solution`
        its status, iterations and bound.
    point : str
        What a point stands for.
    size : callable, optional
        What there is to do for a case: its unknowns, or updates of nodes. Then microseconds for each of them are told,
        and growth with them; else with the points.
    tell : callable, optional
        Of the case and of what a phase returned: a mapping that is told in its line. It is not timed.
    beside : tuple of str
        Ratios are of times over that of the fastest of these phases; by default over that of the first phase.
    repeat : int or callable
        Times each phase is timed, of which the least counts; or a function of the point.
    smoke : int, float or str, optional
        A point that takes no time, for a run that only shows that it runs; by default the first of the sweep.
    largest_facts : tuple of str
        Facts of which median and largest over all points are told in the end.
    drawn : bool
        Whether a picture of time against size is made.
    clock : callable
        Returns seconds: those on the wall, or ``time.process_time``.

    Raises
    ------
    ValueError
        If the name is malformed, there is no point or no phase, or none of a name in ``beside``.

    Examples
    --------
    >>> import numpy as np
    >>> spec = Spec("sort", "numpy's sort", np.arange, (10, 100), {"sort": np.sort, "copy": np.copy}, size=np.size)
    >>> [(timing.point, timing.phase) for timing in time_point(spec, 100, repeat=2)]
    [(100, 'sort'), (100, 'copy')]
    """

    name: str
    summary: str
    build: Callable[[Any], Any]
    sweep: tuple[Point, ...]
    phases: Mapping[str, Callable[[Any], object] | Phase]
    point: str = "nodes along a side"
    size: Callable[[Any], float] | None = None
    tell: Callable[[Any, Any], Facts] | None = None
    beside: tuple[str, ...] = ()
    repeat: int | Callable[[Any], int] = 3
    smoke: Point | None = None
    largest_facts: tuple[str, ...] = ()
    drawn: bool = False
    clock: Callable[[], float] = time.perf_counter

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            raise ValueError(f"name must be words in small letters and digits, joined by dashes, got {self.name!r}")
        for what in ("sweep", "phases"):
            if not getattr(self, what):
                raise ValueError(f"{what} of {self.name!r} must not be empty")
        unknown = [name for name in self.beside if name not in self.phases]
        if unknown:
            raise ValueError(f"beside of {self.name!r} has {unknown[0]!r}; its phases are {', '.join(self.phases)}")

    def phase(self, name: str) -> Phase:
        """Return the phase of a name."""
        found = self.phases[name]
        return found if isinstance(found, Phase) else Phase(found)

    @property
    def smallest(self) -> Point:
        """The point of a run that only shows that it runs."""
        return self.sweep[0] if self.smoke is None else self.smoke

    def runs(self, point: Point) -> int:
        """Return how often each phase is timed at a point."""
        return self.repeat(point) if callable(self.repeat) else self.repeat

    def facts(self, case: Any, result: object) -> Facts:
        """Return what is told of what a phase returned.

        Raises
        ------
        ValueError
            If a fact has the name of what every line has.
        """
        from ..solving.solution import Solution

        if self.tell is not None:
            found = self.tell(case, result)
        elif isinstance(result, Solution):
            found = solution_facts(result)
        else:
            found = result if isinstance(result, Mapping) else {}
        taken = next((name for name in found if name in COLUMNS), None)
        if taken is not None:
            raise ValueError(f"{self.name!r} tells a fact {taken!r}; give it another name than {', '.join(COLUMNS)}")
        return found


def solution_facts(solution: Any) -> Facts:
    """Return an answer's status, iterations and relative bound, as a line tells them."""
    return {
        "status": solution.status.value,
        "iterations": solution.iterations,
        "bound": float(solution.relative_bound),
    }


@dataclass(frozen=True)
class Timing:
    """A line of a benchmark: one phase at one point.

    Attributes
    ----------
    spec, phase : str
    point : int, float or str
    size : float
        What there was to do, see `Spec`; nan for a point that is a word, without a size.
    seconds : float
        The least; nan if it was not timed.
    ratio : float
        Over the seconds of what it is beside; nan if that was not timed.
    runs : int
    facts : mapping of str to int, float or str
    words : str
        Why it was not timed.
    """

    spec: str
    phase: str
    point: Point
    size: float = math.nan
    seconds: float = math.nan
    ratio: float = math.nan
    runs: int = 0
    facts: Facts = field(default_factory=dict)
    words: str = ""

    @property
    def timed(self) -> bool:
        """Whether there is a time."""
        return self.runs > 0


def time_point(
    spec: Spec, point: Point, *, repeat: int | None = None, warm: bool = True, phases: Sequence[str] | None = None
) -> list[Timing]:
    """Build the case of a point, run each phase once to warm up, and time the phases in turn.

    Parameters
    ----------
    spec : Spec
    point : int, float or str
    repeat : int, optional
        Instead of the spec's own.
    warm : bool
        Whether there is a run that is not timed.
    phases : sequence of str, optional
        Some of the spec's; by default all.

    Returns
    -------
    list of Timing
        One for each phase, without those that are left out at so large a number.
    """
    chosen = {name: spec.phase(name) for name in (spec.phases if phases is None else phases)}
    chosen = {name: one for name, one in chosen.items() if isinstance(point, str) or point <= one.largest}
    if not chosen:
        return []
    case = spec.build(point)
    size = _size(spec, case, point)
    refused = {name: f"left out: {one.lacks} is not installed" for name, one in chosen.items() if one.lacks}
    least: dict[str, tuple[float, object]] = {}
    counts = dict.fromkeys(chosen, 0)

    def run(name: str, *, counts_as_run: bool) -> None:
        started = spec.clock()
        try:
            result = chosen[name].run(case)
        except (MissingBackendError, UnsuitableProblemError) as error:
            refused[name] = f"left out: {error}"
            return
        seconds = spec.clock() - started
        if counts_as_run:
            counts[name] += 1
            if name not in least or seconds < least[name][0]:
                least[name] = seconds, result

    if warm:
        for name, one in chosen.items():
            if name not in refused and not one.once:
                run(name, counts_as_run=False)
    for turn in range(spec.runs(point) if repeat is None else repeat):
        for name, one in chosen.items():
            if name not in refused and not (turn and one.once):
                run(name, counts_as_run=True)
    # A first phase that was left out is no reason to compare with another one.
    yardsticks = [least[name][0] for name in spec.beside or list(spec.phases)[:1] if name in least]
    unit = min(yardsticks, default=math.nan)
    found = []
    for name in chosen:
        if name in least:
            seconds, result = least[name]
            ratio = seconds / unit if unit else math.nan
            facts = spec.facts(case, result)
            found.append(Timing(spec.name, name, point, size, seconds, ratio, counts[name], facts))
        else:
            found.append(Timing(spec.name, name, point, size, words=refused[name]))
    return found


def load_specs(path: str | Path) -> tuple[Spec, ...]:
    """Return the ``SPECS`` that a Python file defines.

    Raises
    ------
    ValueError
        If there is no such file, it defines none, or two of one name.
    ImportError
        If it needs a package that is not installed.
    """
    place = Path(path)
    if not place.is_file():
        raise ValueError(f"there is no file {place}")
    name = f"_benchmark_{place.stem}"
    found = importlib.util.spec_from_file_location(name, place)
    if found is None or found.loader is None:
        raise ValueError(f"{place} is no Python file")
    module = importlib.util.module_from_spec(found)
    sys.modules[name] = module  # where classes and compiled functions look for what they were defined in
    found.loader.exec_module(module)
    specs = tuple(getattr(module, "SPECS", ()))
    if not specs or not all(isinstance(spec, Spec) for spec in specs):
        raise ValueError(f"{place} must define SPECS, a sequence of contactqp.benchmark.Spec")
    require_distinct(specs)
    return specs


def require_distinct(specs: Sequence[Spec]) -> None:
    """Raise a ValueError if two specs have one name."""
    names = [spec.name for spec in specs]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ValueError(f"two specs are called {twice!r}; give each a name of its own")


def _is_there(need: str) -> bool:
    """Whether a module can be imported, or a command is found."""
    return importlib.util.find_spec(need) is not None or shutil.which(need) is not None


def _size(spec: Spec, case: Any, point: Point) -> float:
    if spec.size is not None:
        return float(spec.size(case))
    return math.nan if isinstance(point, str) else float(point)


def points_of(spec: Spec, points: Sequence[Point] | None, largest: float | None, *, smoke: bool) -> Iterator[Point]:
    """Yield the points that are to be measured: those given, or the spec's, but numbers above the largest."""
    if smoke:
        yield spec.smallest
        return
    for point in spec.sweep if points is None else points:
        if largest is None or isinstance(point, str) or point <= largest:
            yield point
