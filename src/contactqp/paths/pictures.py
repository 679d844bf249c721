"""Pictures of load paths and of touchdown loads."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from ..foundation.pictures import PLAIN, Wanted
from ..plotting.geometry import figure_of
from ..plotting.style import BLUE, CONTACT, GROUND, INK, new_figure, tidy
from ..plotting.views import settling_figure

if TYPE_CHECKING:
    import pandas as pd
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
        wanted.ax.set_ylim(bottom=0.0)
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
        place.set_ylim(bottom=min(0.0, float(np.min(values.to_numpy()))))
    work = axes[1, 1]
    work.plot(value, table["iterations"].to_numpy(), "o-", ms=4, lw=1.4, color=INK, label="from the answer before")
    if "cold_iterations" in table:
        cold = table["cold_iterations"].to_numpy()
        work.plot(value, cold, "o--", ms=4, lw=1.2, color=GROUND, label="from a cold start")
        work.legend(frameon=False, fontsize="small")
    work.set(ylabel=f"{iteration_unit}s of {backend}")
    work.set_ylim(bottom=0)
    for place in axes[1]:
        place.set_xlabel(_NAMES[parameter])
    for place in axes.flat:
        tidy(place)
    # Findings are long sentences, and the title must not be wider than the figure.
    figure.suptitle(fill(text, 110), fontsize="medium")
    return figure


def plot_touchdown(touchdown: Settling) -> Figure:
    """Draw at which load each node settles: on a membrane a map, on a cable loads along x."""
    return settling_figure(touchdown.model, touchdown)
