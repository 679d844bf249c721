"""Pictures of load paths and of touchdown loads."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ..models.on_lattice import LatticeModel
from ..plotting.on_lattice import draw_frame_outline
from ..plotting.style import BLUE, CLEAR, CONTACT, GROUND, INK, new_figure, tidy

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from ..foundation.checks import Vector
    from ..models.base import ContactModel


_NAMES = {"load": "load factor", "tension": "tension", "lift": "lift of the support"}


class Settling(Protocol):
    """What the picture of touchdown loads reads of a `Touchdown`."""

    @property
    def model(self) -> ContactModel: ...  # noqa: D102
    @property
    def clear(self) -> Vector: ...  # noqa: D102
    @property
    def contact(self) -> Vector: ...  # noqa: D102
    @property
    def load(self) -> Vector: ...  # noqa: D102
    @property
    def loads(self) -> Vector: ...  # noqa: D102
    @property
    def width(self) -> float: ...  # noqa: D102


def plot_path(table: pd.DataFrame, iteration_unit: str, backend: str, verdict: str) -> Figure:
    """Draw contact fraction, total reaction, largest deflection and iterations against the parameter.

    Parameters
    ----------
    table : pandas.DataFrame
        See `LoadPath.to_frame`.
    iteration_unit, backend : str
        Of the solutions.
    verdict : str
        See `LoadPath.verdict`.
    """
    parameter = str(table.index.name)
    table = table.sort_index()
    value = table.index.to_numpy()
    figure = new_figure(10, 6)
    axes = figure.subplots(2, 2, sharex=True)
    middle = 0.5 * (table["total_reaction_lower"] + table["total_reaction_upper"])
    for place, values, label, colour in (
        (axes[0, 0], table["contact_fraction"], "nodes in contact, fraction", CONTACT),
        (axes[0, 1], middle, "total reaction", CONTACT),
        (axes[1, 0], table["max_deflection"], "largest deflection", BLUE),
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
    figure.suptitle(fill(f"{len(table)} {parameter}s: {verdict}", 110), fontsize="medium")
    return figure


def plot_touchdown(touchdown: Settling) -> Figure:
    """Draw at which load each node settles: on a membrane a map, on a cable loads along x."""
    model = touchdown.model
    if not isinstance(model, LatticeModel):
        return _on_a_plan(touchdown)
    if model.is_line:
        return _along_a_cable(touchdown)
    lattice = model.lattice
    height = float(np.clip(6.5 * lattice.shape[0] / lattice.shape[1], 3.5, 7.0))
    figure = new_figure(8.5, height + 1.3)
    axes = figure.subplots()
    early = np.isinf(touchdown.clear) & np.isfinite(touchdown.contact)
    never = np.isinf(touchdown.contact)
    grid = np.ma.masked_invalid(lattice.scatter(touchdown.load))
    picture = axes.pcolormesh(lattice.x, lattice.y, grid, cmap="viridis", shading="nearest", rasterized=True)
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    handles: list[Any] = []
    for chosen, colour, label in (
        (early, CONTACT, f"in contact at {touchdown.loads[0]:g} ({np.count_nonzero(early)})"),
        (never, CLEAR, f"not certainly in contact at {touchdown.loads[-1]:g} ({np.count_nonzero(never)})"),
    ):
        if chosen.any():
            mask = np.ma.masked_equal(lattice.scatter(chosen.astype(float), fill=0.0), 0.0)
            axes.pcolormesh(
                lattice.x, lattice.y, mask, cmap=ListedColormap([colour]), shading="nearest", rasterized=True
            )
            handles.append(Patch(color=colour, label=label))
    draw_frame_outline(axes, model)
    figure.colorbar(picture, ax=axes, label="load factor at which the node settles", shrink=0.85)
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False, fontsize="small")
    known = f", known to {touchdown.width:.2g}" if touchdown.width else ""
    axes.set(aspect="equal", xlabel="x", ylabel="y", title=f"Touchdown loads{known}")
    tidy(axes)
    return figure


def _on_a_plan(touchdown: Settling) -> Figure:
    figure = new_figure(8, 6)
    axes = figure.subplots()
    x, y, closed = touchdown.model.node_x, touchdown.model.node_y, np.isfinite(touchdown.load)
    axes.scatter(x[~closed], y[~closed], s=18, facecolors="none", edgecolors=GROUND, linewidths=0.8)
    picture = axes.scatter(x[closed], y[closed], s=30, c=touchdown.load[closed], cmap="viridis")
    figure.colorbar(picture, ax=axes, label="load factor at which the node settles", shrink=0.85)
    axes.set(aspect="equal", xlabel="x", ylabel="y", title=f"Touchdown loads, known to {touchdown.width:.2g}")
    tidy(axes)
    return figure


def _along_a_cable(touchdown: Settling) -> Figure:
    figure = new_figure(9, 4)
    axes = figure.subplots()
    x = touchdown.model.node_x
    closed = np.isfinite(touchdown.load)
    axes.vlines(x[closed], touchdown.clear[closed], touchdown.contact[closed], color=GROUND, lw=2)
    axes.plot(x[closed], touchdown.load[closed], ".", color=CONTACT, ms=5)
    axes.set(xlabel="x", ylabel="load factor", title=f"Touchdown loads, known to {touchdown.width:.2g}")
    tidy(axes)
    return figure
