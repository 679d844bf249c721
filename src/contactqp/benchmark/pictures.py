"""Pictures of a benchmark: performance profiles, and time against size."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..foundation.loading import load_modules
from ..plotting.style import INK, new_figure
from .record import Record
from .specs import Timing
from .statistics import exponent, growths, profile

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = (
    *("#2f6690", "#c8553d", "#3f7d58", "#7a4e9c", "#f2c14e", "#22333b", "#81a4cd", "#b9a88f"),
    *("#d6336c", "#0f9d9d", "#8d6b1f", "#9aa5ab", "#5b8c00", "#b07cc6", "#e08f62", "#3d4fd1"),
)
_LINES = ("-", "--", ":", "-.")
_LEAST_DISTANCE = 0.035
"""Between two numbers, as a part of the axes' height."""


def _look(rank: int, level: int = 0) -> dict[str, Any]:
    """Return the colour of a solver and the line of a level, by their ranks."""
    return {"color": _COLOURS[rank % len(_COLOURS)], "linestyle": _LINES[level % len(_LINES)]}


def plot_profiles(records: Sequence[Record]) -> Figure:
    """Return a performance profile for each level."""
    levels = list(dict.fromkeys(record.level for record in records))
    backends = _names(records)
    figure = new_figure(max(7.5, 5.5 * len(levels)), 4.8)
    for place, level in enumerate(levels, start=1):
        axes = figure.add_subplot(1, len(levels), place)
        factors, parts = profile(records, level)
        last = max(factors[-1] * 1.2, 2.0)
        for backend, part in parts.items():
            look = _look(backends.index(backend))
            axes.step([*factors, last], [*part, part[-1]], where="post", lw=1.8, label=backend, **look)
        axes.set(
            xscale="log",
            xlim=(1.0, last),
            ylim=(0.0, 1.03),
            title=f"level {level}",
            xlabel="time over the fastest solver's",
            ylabel="part of the problems proven within it" if place == 1 else "",
        )
        axes.grid(color="#dfe7ec")
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper", frameon=False, fontsize="small")
    return figure


def plot_growth(records: Sequence[Record]) -> Figure | None:
    """Return time against size for each family, of those solvers that prove three sizes; None if there are none."""
    load_modules("matplotlib.lines")
    from matplotlib.lines import Line2D

    found = growths(records)
    families = list(dict.fromkeys(growth.family for growth in found))
    if not families:
        return None
    backends = _names(records)
    levels = list(dict.fromkeys(growth.level for growth in found))
    columns = min(3, len(families))
    rows = -(-len(families) // columns)
    figure = new_figure(max(7.5, 4.2 * columns + 2), 3.8 * rows)
    for place, family in enumerate(families, start=1):
        axes = figure.add_subplot(rows, columns, place)
        shown = [growth for growth in found if growth.family == family]
        for growth in shown:
            look = _look(backends.index(growth.backend), levels.index(growth.level))
            axes.plot(growth.sizes, growth.seconds, marker="o", ms=4, lw=1.5, **look)
        lowest, leftmost = place > len(families) - columns, (place - 1) % columns == 0
        axes.set(xscale="log", yscale="log", title=family)
        axes.set(xlabel="unknowns" if lowest else "", ylabel="seconds" if leftmost else "")
        axes.grid(color="#dfe7ec")
        _tell_exponents(axes, [_End(float(one.sizes[-1]), float(one.seconds[-1]), one.exponent) for one in shown])
    drawn = [name for name in backends if any(growth.backend == name for growth in found)]
    solvers = [Line2D([], [], marker="o", ms=4, **_look(backends.index(name))) for name in drawn]
    lines = [Line2D([], [], **{**_look(0, rank), "color": INK}) for rank in range(len(levels))]
    words = [*drawn, *(f"level {level}" for level in levels)]
    figure.legend([*solvers, *lines], words, loc="outside right upper", frameon=False, fontsize="small")
    return figure


def plot_timings(timings: Sequence[Timing], title: str, sizes: str) -> Figure | None:
    """Return time against size for each phase of a spec; None without a time at a size.

    Parameters
    ----------
    timings : sequence of Timing
    title : str
    sizes : str
        What the sizes are.
    """
    known = [timing for timing in timings if timing.timed and math.isfinite(timing.size)]
    if not known:
        return None
    figure = new_figure(7.5, 4.8)
    axes = figure.add_subplot()
    ends = []
    for rank, phase in enumerate(dict.fromkeys(timing.phase for timing in known)):
        own = sorted((timing for timing in known if timing.phase == phase), key=lambda timing: timing.size)
        size, seconds = (np.array([getattr(timing, what) for timing in own]) for what in ("size", "seconds"))
        axes.plot(size, seconds, marker="o", ms=4, lw=1.5, label=phase, **_look(rank))
        power = exponent(size, seconds)
        if power is not None:
            ends.append(_End(float(size[-1]), float(seconds[-1]), power))
    axes.set(xscale="log", yscale="log", xlabel=sizes, ylabel="seconds")
    axes.set_title(title, fontsize="medium")
    sizes_known = [timing.size for timing in known]
    # Within a decade matplotlib labels the ticks in between, which run into each other as soon as there are more.
    axes.tick_params(axis="x", which="minor", labelbottom=max(sizes_known) < 10 * min(sizes_known))
    axes.grid(color="#dfe7ec")
    _tell_exponents(axes, ends)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside right upper", frameon=False, fontsize="small")
    return figure


def _names(records: Sequence[Record]) -> list[str]:
    return list(dict.fromkeys(record.backend for record in records))


class _End(NamedTuple):
    """Where a line ends, and the exponent of its growth."""

    size: float
    seconds: float
    exponent: float


def _tell_exponents(axes: Axes, ends: Sequence[_End]) -> None:
    """Write each exponent at the end of its line, above that of a line that ends as low."""
    low, high = np.log10(axes.get_ylim())
    apart = 10 ** ((high - low) * _LEAST_DISTANCE)
    below = 0.0
    for end in sorted(ends, key=lambda end: end.seconds):
        height = max(end.seconds, below)
        place, told = (end.size, height), f"{end.exponent:.1f}"
        axes.annotate(told, place, xytext=(5, -3), textcoords="offset points", fontsize="x-small", color=INK)
        below = height * apart
