"""Pictures of models before anything is solved: frame, support and load, with their directions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.checks import Vector
from ..foundation.pictures import Wanted, drawn
from ..foundation.text import span_of
from ..models.base import ContactModel
from ..models.cable_net import CableNet
from ..models.mesh_membrane import MeshMembrane
from ..models.on_lattice import LatticeModel
from ..models.on_line import LineModel
from .geometry import axes_for, figure_of, finish, mark_rows
from .on_lattice import draw_frame_outline, mark_section, section_row, title_of_section
from .on_line import ALONG_X, Line, cut_along, line_of
from .on_mesh import draw_of_nodes, draw_outline
from .on_net import draw_net
from .section import Cut, cut_of_row, draw_ceiling, draw_ground
from .states import mark_unsupported
from .style import BLUE, GROUND, INK, bar_of_heights, head, map_height, new_figure, tidy, two_halves

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

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


@drawn.register(MeshMembrane)
def _mesh(model: MeshMembrane, wanted: Wanted) -> Figure:
    axes = axes_for(wanted, model.extent)
    if model.supported.any():
        heights = np.where(model.supported, model.support, np.nan)
        _tell_heights(axes, draw_of_nodes(axes, model, heights, cmap=_depths(model)), model, wanted)
    draw_outline(axes, model)
    _tell_unsupported(axes, model)
    finish(axes, wanted, _headline(model, wanted))
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
    cut = cut_of_row(model, model.reference, row)
    section = _sections(right, model, cut, wanted)
    mark_section(axes, model, row)
    draw_before(section, model, cut, wanted)
    section.set_title(title_of_section(model, row, wanted.section), fontsize="medium")
    head(figure, _headline(model, wanted) if wanted.title is None else wanted.title)
    return figure


@drawn.register(LineModel)
def _along_x(model: LineModel, wanted: Wanted) -> Figure:
    return _along(model, ALONG_X, wanted)


def _along(model: ContactModel, line: Line, wanted: Wanted) -> Figure:
    cut = cut_along(model, line, model.reference)
    if wanted.ax is None:
        axes = _sections(new_figure(9, 4 + 1.2 * len(_varying(model))), model, cut, wanted, line.label)
    else:
        axes = wanted.ax
    draw_before(axes, model, cut, wanted, line.label)
    axes.set_title(_headline(model, wanted) if wanted.title is None else wanted.title, fontsize="medium")
    return figure_of(axes)


def _varying(model: ContactModel) -> dict[str, dict[str, Vector]]:
    """Return what else varies from node to node, by quantity and by name: tension and foundation."""
    found: dict[str, dict[str, Vector]] = {}
    for name, (values, _, _) in model.fields.items():
        if name != "ceiling" and np.ptp(values):
            found.setdefault(name.split("_")[0], {})[name] = values
    return found


def _sections(part: Figure | SubFigure, model: ContactModel, cut: Cut, wanted: Wanted, xlabel: str = "x") -> Axes:
    """Return the axes of a section, with what else varies drawn along it in panels below."""
    varying = _varying(model)
    if not varying:
        only: Axes = part.subplots()
        return only
    axes: Any = part.subplots(1 + len(varying), 1, height_ratios=[3] + [1] * len(varying))
    for panel, (quantity, lines) in zip(axes[1:], varying.items(), strict=True):
        for (name, values), style in zip(lines.items(), ("-", "--"), strict=False):
            panel.plot(cut.node_x, values[cut.number], color=BLUE, lw=1.2, ls=style, label=f"along {name[-1]}")
        if len(lines) > 1:
            panel.legend(loc="best", frameon=False, fontsize="small")
        panel.set_ylim(0.0, 1.1 * max(float(values.max()) for values in lines.values()))
        panel.set(xlabel=wanted.label(xlabel), ylabel=quantity if len(lines) > 1 else "".join(lines))
        tidy(panel)
    first: Axes = axes[0]
    return first


def draw_before(axes: Axes, model: ContactModel, cut: Cut, wanted: Wanted, xlabel: str = "x") -> None:
    """Draw frame level, support and load along a section; down is down, whichever way heights are positive."""
    # Where nothing is known of the frame, it is at height zero.
    frame = cut.frame_heights if cut.frame_heights.size else np.zeros(1)
    known = np.concatenate([*(line[np.isfinite(line)] for line in (cut.ground, cut.ceiling)), frame])
    depth = float(np.ptp(known)) or 1.0
    down = -1.0 if model.upwards else 1.0
    highest, lowest = down * float((down * known).min()), down * float((down * known).max())
    bottom = lowest + down * 0.15 * depth
    draw_ground(axes, cut, bottom)
    axes.plot(cut.ground_x, cut.ground, color=GROUND, lw=1.2)
    draw_ceiling(axes, cut, highest - down * 0.05 * depth)
    if cut.frame_x.size:
        axes.plot(cut.frame_x, cut.frame_heights, "s", color=INK, ms=5, label="frame")
    _draw_frame_line(axes, cut)
    _draw_load(axes, cut.node_x, model.load[cut.number], highest - down * 0.08 * depth, down * 0.3 * depth)
    axes.set_ylim(bottom, highest - down * 0.45 * depth)
    axes.set(xlabel=wanted.label(xlabel), ylabel=wanted.label(f"height, {model.sense}"))
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=3, frameon=False, fontsize="small")
    tidy(axes)


def _draw_frame_line(axes: Axes, cut: Cut) -> None:
    """Draw a line from frame point to frame point; height zero where none is known."""
    order = np.argsort(cut.frame_x, kind="stable")
    x, heights = cut.frame_x[order], cut.frame_heights[order]
    if x.size < 2:
        x, heights = np.array([np.nanmin(cut.x), np.nanmax(cut.x)]), np.full(2, heights[0] if x.size else 0.0)
    axes.plot(x, heights, color=INK, lw=0.7, ls=":")


def _draw_load(axes: Axes, x: Vector, load: Vector, base: float, length: float) -> None:
    """Draw arrows above the frame, downwards for a positive load; the longest takes ``length``, which goes down."""
    largest = float(np.abs(load).max(initial=0.0))
    if not largest:
        return
    step = -(-x.size // _ARROWS)
    chosen = np.arange((x.size - 1) % step // 2, x.size, step)
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
        _tell_heights(axes, cells, model, wanted)
    _tell_unsupported(axes, model)
    draw_frame_outline(axes, model)
    mark_rows(axes, lattice, model.rows)


def _scatter_support(axes: Axes, model: ContactModel, wanted: Wanted) -> None:
    known = model.supported
    x, y = model.node_x, model.node_y
    if known.any():
        dots = axes.scatter(
            x[known], y[known], s=26, c=model.support[known], cmap=_depths(model), edgecolors=INK, lw=0.4
        )
        dots.set_zorder(3)
        _tell_heights(axes, dots, model, wanted)
    _tell_unsupported(axes, model)


def _tell_unsupported(axes: Axes, model: ContactModel) -> None:
    marks = mark_unsupported(axes, model)
    if marks:
        place: Any = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.14), "frameon": False, "fontsize": "small"}
        axes.legend(handles=marks, **place)


def _depths(model: ContactModel) -> str:
    """Return the name of a map of colours in which what lies deeper is darker."""
    return "YlGnBu_r" if model.upwards else "YlGnBu"


def _tell_heights(axes: Axes, picture: Any, model: ContactModel, wanted: Wanted) -> None:
    """Draw the scale of the support's heights."""
    label = wanted.label(f"support f, {model.sense}")
    bar_of_heights(axes, picture, model.support[model.supported], label, upwards=model.upwards, pad=0.09)


def _headline(model: ContactModel, wanted: Wanted) -> str:
    quantity = model.units["load"]
    unit = wanted.unit(quantity) or quantity
    low = float(model.load.min(initial=0.0))
    way = "upwards" if model.load.max(initial=0.0) <= 0 and low < 0 else "downwards"
    load = span_of(np.abs(model.load)) if way == "upwards" else span_of(model.load)
    more = "".join(f", {name} {span_of(values)}" for name, values in _told_beside(model).items())
    return f"{type(model).__name__}, {model.size} nodes, load {load} ({unit}) {way}{more}"


def _told_beside(model: ContactModel) -> dict[str, Vector]:
    """Return what a headline tells beside the load: a tension that varies or goes by direction, and a foundation."""
    fields = {name: values for name, (values, _, _) in model.fields.items() if name != "ceiling"}
    by_direction = {
        name: np.array([number]) for name, number in model.parameters.items() if name.startswith("tension_")
    }
    found = by_direction | fields
    return {name: found[name] for name in ("tension", "tension_x", "tension_y", "foundation") if name in found}
