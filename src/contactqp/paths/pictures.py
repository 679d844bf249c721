"""Pictures of load paths and of touchdown loads."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from ..foundation.checks import Vector
from ..foundation.loading import load_modules
from ..foundation.pictures import PLAIN, Wanted
from ..plotting.geometry import figure_of
from ..plotting.style import BLUE, CONTACT, GROUND, INK, new_figure, tidy
from ..plotting.views import settling_figure

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..models.records import Settling


_NAMES = {"load": "load factor", "tension": "tension", "lift": "lift of the support", "time": "time"}


def plot_path(table: pd.DataFrame, iteration_unit: str, backend: str, verdict: str, wanted: Wanted = PLAIN) -> Figure:
    """Draw contact fraction, total reaction, largest deflection and iterations against the parameter.

    Parameters
    ----------
    table : pandas.DataFrame
        See `LoadPath.to_frame`.
    iteration_unit, backend : str
        Of the solutions.
    verdict : str
        See `LoadPath.verdict`.
    wanted : Wanted
        With axes given, the contact fraction alone is drawn.
    """
    parameter = str(table.index.name)
    table = table.sort_index()
    value = table.index.to_numpy()
    text = f"{len(table)} {parameter}s: {verdict}" if wanted.title is None else wanted.title
    if wanted.ax is not None:
        wanted.ax.plot(value, table["contact_fraction"].to_numpy(), "o-", ms=4, lw=1.4, color=CONTACT)
        wanted.ax.set(xlabel=_NAMES[parameter], ylabel="nodes in contact, fraction")
        wanted.ax.set_title(fill(text, 60), fontsize="medium")
        _from_zero(wanted.ax, table["contact_fraction"].to_numpy())
        tidy(wanted.ax)
        return figure_of(wanted.ax)
    figure = new_figure(10, 6)
    axes = figure.subplots(2, 2, sharex=True)
    middle = 0.5 * (table["total_reaction_lower"] + table["total_reaction_upper"])
    for place, values, label, colour in (
        (axes[0, 0], table["contact_fraction"], "nodes in contact, fraction", CONTACT),
        (axes[0, 1], middle, wanted.label("total reaction", "force"), CONTACT),
        (axes[1, 0], table["max_deflection"], wanted.label("deflection of the lowest node"), BLUE),
    ):
        place.plot(value, values.to_numpy(), "o-", ms=4, lw=1.4, color=colour)
        place.set(ylabel=label)
        _from_zero(place, values.to_numpy())
    work = axes[1, 1]
    work.plot(value, table["iterations"].to_numpy(), "o-", ms=4, lw=1.4, color=INK, label="from the answer before")
    if "cold_iterations" in table:
        cold = table["cold_iterations"].to_numpy()
        work.plot(value, cold, "o--", ms=4, lw=1.2, color=GROUND, label="from a cold start")
        work.legend(frameon=False, fontsize="small")
    work.set(ylabel=f"{iteration_unit}s of {backend}")
    _from_zero(work, np.concatenate([line.get_ydata() for line in work.lines]))
    load_modules("matplotlib.ticker")
    from matplotlib.ticker import MaxNLocator

    work.yaxis.set_major_locator(MaxNLocator(integer=True))
    for place in axes[1]:
        place.set_xlabel(_NAMES[parameter])
    for place in axes.flat:
        tidy(place)
    # Findings are long sentences, and the title must not be wider than the figure.
    figure.suptitle(fill(text, 110), fontsize="medium")
    return figure


def _from_zero(axes: Axes, values: Vector) -> None:
    """Let an axis begin at zero, or where values are negative below them, with room for the marks at both ends."""
    known = values[np.isfinite(values)]
    low, high = min(0.0, float(known.min(initial=0.0))), max(0.0, float(known.max(initial=0.0)))
    room = 0.06 * (high - low or 1.0)
    axes.set_ylim(low - room if low else 0.0, high + room)


def plot_touchdown(touchdown: Settling) -> Figure:
    """Draw at which load each node settles: on a membrane a map, on a cable loads along x."""
    return settling_figure(touchdown.model, touchdown)
