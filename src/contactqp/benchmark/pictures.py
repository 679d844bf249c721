"""Pictures of a benchmark: performance profiles, and time against size."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.checks import Vector
from ..plotting.style import INK, new_figure
from .record import Record
from .specs import Timing
from .statistics import Growth, exponent, growths, profile

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = ("#2f6690", "#c8553d", "#3f7d58", "#7a4e9c", "#f2c14e", "#22333b", "#81a4cd", "#b9a88f")
_LINES = ("-", "--", ":", "-.")


def _look(rank: int) -> dict[str, Any]:
    """Return a colour and a line that differ from those of other ranks."""
    return {"color": _COLOURS[rank % len(_COLOURS)], "linestyle": _LINES[rank // len(_COLOURS) % len(_LINES)]}


def plot_profiles(records: Sequence[Record]) -> Figure:
    """Return a performance profile for each level."""
    levels = list(dict.fromkeys(record.level for record in records))
    backends = list(dict.fromkeys(record.backend for record in records))
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
    found = growths(records)
    families = list(dict.fromkeys(growth.family for growth in found))
    if not families:
        return None
    names = list(dict.fromkeys(f"{growth.backend}, {growth.level}" for growth in found))
    columns = min(3, len(families))
    rows = -(-len(families) // columns)
    figure = new_figure(max(7.5, 4.2 * columns + 2), 3.8 * rows)
    for place, family in enumerate(families, start=1):
        axes = figure.add_subplot(rows, columns, place)
        for growth in found:
            if growth.family == family:
                _draw_growth(axes, growth, names)
        lowest, leftmost = place > len(families) - columns, (place - 1) % columns == 0
        axes.set(xscale="log", yscale="log", title=family)
        axes.set(xlabel="unknowns" if lowest else "", ylabel="seconds" if leftmost else "")
        axes.grid(color="#dfe7ec")
    drawn = (zip(*axes.get_legend_handles_labels(), strict=True) for axes in figure.axes)
    handles = {label: handle for lines in drawn for handle, label in lines}
    shown = [name for name in names if name in handles]
    figure.legend([handles[name] for name in shown], shown, loc="outside right upper", frameon=False, fontsize="small")
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
    for rank, phase in enumerate(dict.fromkeys(timing.phase for timing in known)):
        own = [timing for timing in known if timing.phase == phase]
        size, seconds = (np.array([getattr(timing, what) for timing in own]) for what in ("size", "seconds"))
        _draw_line(axes, size, seconds, exponent(size, seconds), phase, rank)
    axes.set(xscale="log", yscale="log", xlabel=sizes, ylabel="seconds", title=title)
    axes.grid(color="#dfe7ec")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside right upper", frameon=False, fontsize="small")
    return figure


def _draw_growth(axes: Axes, growth: Growth, names: Sequence[str]) -> None:
    """Draw one solver's times."""
    name = f"{growth.backend}, {growth.level}"
    _draw_line(axes, growth.sizes, growth.seconds, growth.exponent, name, names.index(name))


def _draw_line(axes: Axes, sizes: Vector, seconds: Vector, power: float | None, label: str, rank: int) -> None:
    """Draw times against sizes, with the exponent at their end."""
    order = np.argsort(sizes)
    sizes, seconds = sizes[order], seconds[order]
    axes.plot(sizes, seconds, marker="o", ms=4, lw=1.5, label=label, **_look(rank))
    if power is not None:
        end = (float(sizes[-1]), float(seconds[-1]))
        axes.annotate(f"{power:.1f}", end, xytext=(4, -3), textcoords="offset points", fontsize="x-small", color=INK)
