"""run_specs(): benchmarks of parts as tables that are printed line by line, and as files of a folder."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..foundation.checks import integer_at_least, nearest
from ..foundation.files import replaced_as_a_whole
from ..foundation.loading import load_modules
from ..foundation.text import counted, number
from ..foundation.text import seconds as seconds_of
from .about import measured_with, now, write_about
from .pictures import plot_timings
from .specs import COLUMNS, Facts, Point, Spec, Timing, points_of, require_distinct, time_point
from .statistics import exponent

if TYPE_CHECKING:
    import pandas as pd

WIDTH = 80
"""Columns of the tables."""

SMOKE = "smoke: each phase ran once, cold and at a small point; these times mean nothing"
"""What a run that only shows that all runs says of its times."""

_TIMINGS = "timings.csv"
_INDENT = 6
_POINT, _SIZE, _SECONDS, _RATIO, _EACH = 9, 9, 9, 7, 8


def run_specs(
    specs: Sequence[Spec],
    *,
    names: Sequence[str] = (),
    phases: Sequence[str] | None = None,
    points: Sequence[Point] | None = None,
    repeat: int | None = None,
    largest: float | None = None,
    smoke: bool = False,
    out: str | Path | None = None,
    show: Callable[[str], object] = print,
) -> list[Timing]:
    """Measure benchmarks of parts, each as a table that is printed line by line.

    Parameters
    ----------
    specs : sequence of Spec
    names : sequence of str
        Some of them; by default all.
    phases : sequence of str, optional
        Some of theirs; by default all.
    points : sequence of int, float or str, optional
        Instead of their sweeps.
    repeat : int, optional
        Times each phase is timed, instead of their own.
    largest : float, optional
        Numbers of sweeps above it are left out.
    smoke : bool
        Whether each phase runs once only, at a point that takes no time.
    out : str or Path, optional
        A folder, which is made if need be, for ``timings.csv`` (a line for each phase at each point), ``about.json``
        (versions, machine, time) and pictures ``NAME.png`` of those that are drawn.
    show : callable
        What is done with each line.

    Returns
    -------
    list of Timing

    Raises
    ------
    ValueError
        If a name or phase is unknown, two benchmarks have one name, or ``repeat`` is no count.

    Examples
    --------
    >>> spec = Spec("sum", "a sum", range, (9, 99), {"sum": lambda case: {"sum": sum(case)}}, point="addends")
    >>> found = run_specs([spec], repeat=1, show=lambda line: None)
    >>> [(timing.point, timing.facts["sum"]) for timing in found]
    [(9, 36), (99, 4851)]
    """
    require_distinct(specs)
    known = {spec.name: spec for spec in specs}
    _require_known(names, list(known), "benchmark")
    chosen = [known[name] for name in names] if names else list(specs)
    if phases is not None:
        _require_known(phases, list(dict.fromkeys(name for spec in chosen for name in spec.phases)), "phase")
    if repeat is not None:
        integer_at_least(repeat, 1, "repeat")
    folder = None if out is None else Path(out)
    if folder is not None:
        versions, machine = measured_with()
        told = {"specs": [spec.name for spec in chosen], "versions": versions, "machine": machine, "when": now()}
        write_about(folder, told)
    every: list[Timing] = []
    for spec in chosen:
        wanted = [name for name in spec.phases if phases is None or name in phases]
        if not wanted:
            continue
        measured = list(points_of(spec, points, largest, smoke=smoke))
        shown = _Table(spec, wanted, measured)
        for line in shown.head():
            show(line)
        found: list[Timing] = []
        for point in measured:
            timings = time_point(spec, point, repeat=1 if smoke else repeat, warm=not smoke, phases=wanted)
            for line in shown.lines(timings):
                show(line)
            found += timings
        for line in shown.foot(found):
            show(line)
        every += found
        if folder is not None:
            _write(spec, found, every, folder)
    if smoke:
        show(f"\n{SMOKE}")
    return every


def to_frame(timings: Sequence[Timing]) -> pd.DataFrame:
    """Return a line for each phase at each point, with a column for each fact."""
    load_modules("pandas")
    import pandas as pd

    return pd.DataFrame([{name: getattr(one, name) for name in COLUMNS} | dict(one.facts) for one in timings])


def _write(spec: Spec, found: Sequence[Timing], every: Sequence[Timing], folder: Path) -> None:
    """Write all lines so far, so that a run that is stopped keeps them, and a spec's picture."""
    with replaced_as_a_whole(folder / _TIMINGS) as unfinished:
        to_frame(every).to_csv(unfinished, index=False)
    picture = plot_timings(found, spec.summary, "size" if spec.size else spec.point) if spec.drawn else None
    if picture is not None:
        picture.savefig(folder / f"{spec.name}.png", dpi=110)


def _require_known(wanted: Sequence[str], known: Sequence[str], what: str) -> None:
    for name in wanted:
        if name not in known:
            raise ValueError(f"unknown {what} {name!r}{nearest(name, known)}; known: {', '.join(known)}")


class _Table:
    """How a spec's lines are printed: a line for each phase, what it told beside or below it."""

    def __init__(self, spec: Spec, phases: Sequence[str], points: Sequence[Point]) -> None:
        self.spec, self.sized = spec, spec.size is not None
        self.points = max([_POINT, *(len(str(point)) for point in points)])
        self.names = max(len(name) for name in [*phases, "phase"])

    def head(self) -> list[str]:
        """Return what stands above the table."""
        heading = self._start("point", "size", "phase") + f" {'seconds':>{_SECONDS}} {'ratio':>{_RATIO}}"
        heading += f" {'µs each':>{_EACH}}" if self.sized else ""
        title = f"{self.spec.name}: {self.spec.summary} (point: {self.spec.point})"
        return ["", *textwrap.wrap(title, WIDTH, subsequent_indent=" " * _INDENT), heading]

    def lines(self, timings: Sequence[Timing]) -> list[str]:
        """Return the lines of a point."""
        return [line for place, timing in enumerate(timings) for line in self._lines(timing, first=place == 0)]

    def foot(self, timings: Sequence[Timing]) -> list[str]:
        """Return what follows from all points: how times grow, and median and largest of some facts."""
        timed = [timing for timing in timings if timing.timed]
        found = []
        for name in dict.fromkeys(timing.phase for timing in timed):
            own = [timing for timing in timed if timing.phase == name]
            known = [timing for timing in own if math.isfinite(timing.size)]
            sizes, seconds = (np.array([getattr(timing, what) for timing in known]) for what in ("size", "seconds"))
            power = exponent(sizes, seconds)
            if power is not None:
                found.append(f"  {name}: seconds grow as the {'size' if self.sized else 'number'} to the {power:.2f}")
            found += self._extremes(name, own)
        return found + self._extremes("all", timed)

    def _extremes(self, name: str, timings: Sequence[Timing]) -> list[str]:
        values = {
            fact: [float(timing.facts[fact]) for timing in timings if fact in timing.facts]
            for fact in self.spec.largest_facts
        }
        return [
            f"  {name}: {fact}: median {np.median(own):.4g}, largest {max(own):.4g} ({counted(len(own), 'line')})"
            for fact, own in values.items()
            if own
        ]

    def _start(self, point: str, size: str, phase: str) -> str:
        return f"{point:>{self.points}} " + (f"{size:>{_SIZE}} " if self.sized else "") + f"{phase:{self.names}}"

    def _lines(self, timing: Timing, *, first: bool) -> list[str]:
        point = str(timing.point) if first else ""
        size = f"{timing.size:.0f}" if first and math.isfinite(timing.size) else ""
        line = self._start(point, size, timing.phase)
        if timing.timed:
            line += f" {seconds_of(timing.seconds):>{_SECONDS}} {_finite(timing.ratio):>{_RATIO}}"
            line += f" {1e6 * timing.seconds / timing.size:{_EACH}.3g}" if self.sized else ""
        told = timing.words or told_facts(timing.facts)
        if len(line) + 2 + len(told) <= WIDTH:
            return [f"{line}  {told}".rstrip()]
        return [line.rstrip(), *textwrap.wrap(told, WIDTH, initial_indent=" " * _POINT, subsequent_indent=" " * _POINT)]


def told_facts(facts: Facts) -> str:
    """Return facts as text: a number after its name, a word alone.

    Examples
    --------
    >>> told_facts({"status": "certified", "iterations": 12, "bound": 1.25e-9})
    'certified, iterations 12, bound 1.25e-09'
    """
    return ", ".join(value if isinstance(value, str) else f"{name} {_short(value)}" for name, value in facts.items())


def _short(value: float) -> str:
    return str(value) if isinstance(value, int) else number(value, 3)


def _finite(value: float) -> str:
    return number(value if math.isfinite(value) else None, 3)
