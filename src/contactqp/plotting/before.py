"""Pictures of models before anything is solved: frame, support and load, with their directions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.checks import Vector
from ..foundation.pictures import Wanted, drawn
from ..foundation.text import span_of
from ..models.base import ContactModel
from ..models.cable import Cable
from ..models.cable_net import CableNet
from ..models.on_lattice import LatticeModel
from .geometry import axes_for, figure_of, finish, mark_rows
from .on_lattice import draw_frame_outline, section_row
from .on_line import ALONG_X, Line, cut_along, line_of
from .on_net import draw_net
from .section import Cut, cut_of_row
from .style import BLUE, CONTACT, GROUND, INK, head, map_height, new_figure, tidy, two_halves

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ARROWS = 25
"""Arrows of the load along a section, at most."""


@drawn.register(ContactModel)
def _in_plan(model: ContactModel, wanted: Wanted) -> Figure:
    line = line_of(model)
    if line is not None:
        return _along(model, line, wanted)
    axes = axes_for(wanted, model.extent)
    _scatter_support(axes, model, wanted)
    finish(axes, wanted, _headline(model, wanted))
    return figure_of(axes)


@drawn.register(CableNet)
def _net(net: CableNet, wanted: Wanted) -> Figure:
    line = line_of(net)
    if line is not None:
        return _along(net, line, wanted)
    axes = axes_for(wanted, net.extent)
    draw_net(axes, net)
    _scatter_support(axes, net, wanted)
    finish(axes, wanted, _headline(net, wanted))
    return figure_of(axes)


@drawn.register(LatticeModel)
def _map_and_section(model: LatticeModel, wanted: Wanted) -> Figure:
    if wanted.ax is not None:
        _draw_support(wanted.ax, model, wanted)
        finish(wanted.ax, wanted, f"{type(model).__name__}, {model.size} nodes")
        return figure_of(wanted.ax)
    figure = new_figure(12.5, map_height(model.extent) + 1.0)
    left, right = two_halves(figure)
    axes = left.subplots()
    _draw_support(axes, model, wanted)
    finish(axes, Wanted(title="Frame and support", units=wanted.units), "")
    row = section_row(model, wanted.section)
    section = right.subplots()
    axes.axhline(model.lattice.y[row], color=CONTACT, lw=1, ls="--")
    draw_before(section, model, cut_of_row(model, model.reference, row), wanted)
    section.set_title(f"Section at y = {model.lattice.y[row]:g}", fontsize="medium")
    head(figure, _headline(model, wanted) if wanted.title is None else wanted.title)
    return figure


@drawn.register(Cable)
def _cable(cable: Cable, wanted: Wanted) -> Figure:
    return _along(cable, ALONG_X, wanted)


def _along(model: ContactModel, line: Line, wanted: Wanted) -> Figure:
    axes = new_figure(9, 4).subplots() if wanted.ax is None else wanted.ax
    draw_before(axes, model, cut_along(model, line, model.reference), wanted, line.label)
    axes.set_title(_headline(model, wanted) if wanted.title is None else wanted.title, fontsize="medium")
    return figure_of(axes)


def draw_before(axes: Axes, model: ContactModel, cut: Cut, wanted: Wanted, xlabel: str = "x") -> None:
    """Draw frame level, support and load along a section; down is down, whichever way heights are positive."""
    level = float(cut.frame_heights.mean()) if cut.frame_heights.size else 0.0
    known = np.concatenate([cut.ground[np.isfinite(cut.ground)], cut.frame_heights, [level]])
    depth = float(np.ptp(known)) or 1.0
    down = -1.0 if model.upwards else 1.0
    highest, lowest = down * float((down * known).min()), down * float((down * known).max())
    bottom = lowest + down * 0.15 * depth
    axes.fill_between(cut.ground_x, cut.ground, bottom, color=GROUND, alpha=0.55, lw=0, label="support f")
    axes.plot(cut.ground_x, cut.ground, color=GROUND, lw=1.2)
    if cut.frame_x.size:
        axes.plot(cut.frame_x, cut.frame_heights, "s", color=INK, ms=5, label="frame")
    axes.hlines(level, np.nanmin(cut.x), np.nanmax(cut.x), color=INK, lw=0.7, ls=":")
    _draw_load(axes, cut.node_x, model.load[cut.number], highest - down * 0.08 * depth, down * 0.3 * depth)
    axes.set_ylim(bottom, highest - down * 0.45 * depth)
    axes.set(xlabel=wanted.label(xlabel), ylabel=wanted.label(f"height, {model.sense}"))
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=3, frameon=False, fontsize="small")
    tidy(axes)


def _draw_load(axes: Axes, x: Vector, load: Vector, base: float, length: float) -> None:
    """Draw arrows above the frame, downwards for a positive load; the longest takes ``length``, which goes down."""
    largest = float(np.abs(load).max(initial=0.0))
    if not largest:
        return
    chosen = np.unique(np.linspace(0, x.size - 1, min(x.size, _ARROWS)).astype(int))
    place, size = x[chosen], length * load[chosen] / largest
    begin = np.where(load[chosen] >= 0, base - size, base)
    some = size != 0
    arrows: Any = axes.quiver(
        *(place[some], begin[some], np.zeros(some.sum()), size[some]),
        angles="xy",
        scale_units="xy",
        scale=1,
        width=0.0035,
        color=BLUE,
        label="load p",
    )
    arrows.set_zorder(3)


def _draw_support(axes: Axes, model: LatticeModel, wanted: Wanted) -> None:
    lattice = model.lattice
    grid = np.ma.masked_invalid(lattice.scatter(np.where(model.supported, model.support, np.nan)))
    if grid.count():
        cells = axes.pcolormesh(lattice.x, lattice.y, grid, cmap=_depths(model), shading="nearest", rasterized=True)
        _colour_bar(axes, cells, model, wanted)
    row, column = np.nonzero(lattice.scatter(~model.supported, fill=0.0) == 1.0)
    if row.size:
        size = float(np.clip(4000 / lattice.size, 1, 20))
        axes.scatter(lattice.x[column], lattice.y[row], s=size, marker="x", lw=0.6, color=CONTACT, label="no support")
        axes.legend(loc="upper right", fontsize="small")
    draw_frame_outline(axes, model)
    mark_rows(axes, lattice)


def _scatter_support(axes: Axes, model: ContactModel, wanted: Wanted) -> None:
    known = model.supported
    x, y = model.node_x, model.node_y
    axes.scatter(x[~known], y[~known], s=18, marker="x", lw=0.8, color=CONTACT, label="no support")
    if known.any():
        dots = axes.scatter(
            x[known], y[known], s=26, c=model.support[known], cmap=_depths(model), edgecolors=INK, lw=0.4
        )
        dots.set_zorder(3)
        _colour_bar(axes, dots, model, wanted)
    if not known.all():
        axes.legend(loc="upper right", fontsize="small")


def _depths(model: ContactModel) -> str:
    """Return the name of a map of colours in which what lies deeper is darker."""
    return "YlGnBu_r" if model.upwards else "YlGnBu"


def _colour_bar(axes: Axes, picture: Any, model: ContactModel, wanted: Wanted) -> None:
    figure: Any = axes.get_figure(root=False)
    bar = figure.colorbar(picture, ax=axes, shrink=0.85, pad=0.09, label=wanted.label(f"support f, {model.sense}"))
    if not model.upwards:
        bar.ax.invert_yaxis()
    bar.ax.tick_params(labelsize="small")


def _headline(model: ContactModel, wanted: Wanted) -> str:
    quantity = model.units["load"]
    unit = wanted.unit(quantity) or quantity
    low = float(model.load.min(initial=0.0))
    way = "upwards" if model.load.max(initial=0.0) <= 0 and low < 0 else "downwards"
    load = span_of(np.abs(model.load)) if way == "upwards" else span_of(model.load)
    return f"{type(model).__name__}, {model.size} nodes, load {load} ({unit}) {way}"
