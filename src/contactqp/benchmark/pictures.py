"""Pictures of a benchmark: performance profiles, and time against size."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.loading import load_modules
from ..plotting.style import INK, new_figure
from .record import Record
from .statistics import Growth, growths, profile

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
        _tell_exponents(axes, shown)
    drawn = [name for name in backends if any(growth.backend == name for growth in found)]
    solvers = [Line2D([], [], marker="o", ms=4, **_look(backends.index(name))) for name in drawn]
    lines = [Line2D([], [], **{**_look(0, rank), "color": INK}) for rank in range(len(levels))]
    words = [*drawn, *(f"level {level}" for level in levels)]
    figure.legend([*solvers, *lines], words, loc="outside right upper", frameon=False, fontsize="small")
    return figure


def _names(records: Sequence[Record]) -> list[str]:
    return list(dict.fromkeys(record.backend for record in records))


def _tell_exponents(axes: Axes, growths: Sequence[Growth]) -> None:
    """Write each solver's exponent at the end of its line, above that of a line that ends as low."""
    low, high = np.log10(axes.get_ylim())
    apart = 10 ** ((high - low) * _LEAST_DISTANCE)
    below = 0.0
    for growth in sorted(growths, key=lambda growth: float(growth.seconds[-1])):
        height = max(float(growth.seconds[-1]), below)
        end, told = (float(growth.sizes[-1]), height), f"{growth.exponent:.1f}"
        axes.annotate(told, end, xytext=(5, -3), textcoords="offset points", fontsize="x-small", color=INK)
        below = height * apart
