"""Widgets and plots of the explorer's page, by Bokeh; the page's scripts fill them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from bokeh.document import Document
from bokeh.events import Tap
from bokeh.layouts import column
from bokeh.models import (
    ColumnDataSource,
    CustomJS,
    CustomJSHover,
    DataRange1d,
    HoverTool,
    LinearColorMapper,
    PrintfTickFormatter,
    Range1d,
)
from bokeh.models.annotations.geometry import Span
from bokeh.models.annotations.legends import ColorBar, Legend
from bokeh.models.widgets.buttons import Toggle
from bokeh.models.widgets.groups import RadioButtonGroup
from bokeh.models.widgets.inputs import Select
from bokeh.models.widgets.sliders import Slider
from bokeh.palettes import Blues256, Oranges256
from bokeh.plotting import figure

from ..plotting.style import BLUE, CLEAR, CONTACT, GROUND, INK, UNDECIDED

_NOWHERE = "#ffffff00"
"""The colour of points that are no nodes: none."""

_CELLS = "state", "gap", "lower", "upper", "pressure", "deflection", "support"
_PLACES = "x", "deflection", "support", "foot", "gap", "lower", "upper", "pressure", "state"

_STATES = "return ['', 'clear', 'undecided', 'in contact'][value] ?? '';"
_NUMBER = "return Number.isFinite(value) ? String(Number(value.toPrecision(6))) : '–';"
_BOUND = "return Number.isFinite(value) ? String(Number(value.toPrecision(13))) : '–';"


def document_of(scenes: Sequence[str]) -> Document:
    """Return the page's widgets and plots, as roots by name.

    Parameters
    ----------
    scenes : sequence of str
        Names; the page opens with the first.

    Returns
    -------
    Document
        Its roots are called controls, more, quantity, map, section, reactions, beta and race.
    """
    controls, more, others = _controls(scenes), _more(), _beside_plots()
    models: dict[str, Any] = {**controls, **more, **others, **_map(), **_section(), **_race()}
    _connect(models)
    document = Document()
    for name, widgets in (("controls", controls), ("more", more)):
        document.add_root(column(*widgets.values(), name=name, spacing=8, **_WIDE))
    for name in ("quantity", "map", "section", "reactions", "beta", "race"):
        document.add_root(models[name])
    names = ", ".join(models)
    document.js_on_event("document_ready", CustomJS(args=models, code=f"contactqp.start({{{names}}})"))
    return document


_WIDE: dict[str, Any] = {"sizing_mode": "stretch_width"}


def _slider(title: str, name: str, **options: Any) -> Slider:
    numbers = {"start": 0.0, "end": 1.0, "value": 0.0, "step": 0.1, "format": PrintfTickFormatter(format="%.4g")}
    return Slider(title=title, name=name, **{**numbers, **options}, **_WIDE)


def _controls(scenes: Sequence[str]) -> dict[str, Any]:
    """Return what most readers move; the page's scripts set ranges, titles and values."""
    return {
        "scene": Select(title="problem", name="scene", options=list(scenes), value=scenes[0], **_WIDE),
        "support": Select(title="support", name="support", options=[""], value="", **_WIDE),
        "load": _slider("load p", "load"),
        "play": Toggle(label=_PLAY, name="play", **_WIDE),
    }


_PLAY, _STOP = "▶ touchdown: let the load grow", "■ stop"


def _more() -> dict[str, Any]:
    return {
        "tension": _slider("tension T", "tension"),
        "lift": _slider("lift of the support", "lift"),
        "relief": _slider("relief of the support", "relief", end=2.0, value=1.0, step=0.02, format="0.00"),
        "row": _slider("section through row", "row", step=1, format="0"),
    }


def _beside_plots() -> dict[str, Any]:
    beta = {"start": 1.0, "end": 1.98, "value": 1.7, "step": 0.02, "format": "0.00"}
    return {
        "quantity": RadioButtonGroup(labels=["contact", "gap", "pressure"], active=0, name="quantity", **_WIDE),
        "beta": _slider("factor of over-relaxation", "beta", **beta),
    }


def _connect(models: dict[str, Any]) -> None:
    """Let the page's scripts know what is moved."""
    calls = {
        "scene": "contactqp.chooseScene()",
        "row": "contactqp.showSection()",
        "beta": "contactqp.restartRace()",
        **dict.fromkeys(("support", "load", "tension", "lift", "relief"), "contactqp.changed()"),
    }
    for name, code in calls.items():
        models[name].js_on_change("value", CustomJS(code=code))
    models["quantity"].js_on_change("active", CustomJS(code="contactqp.chooseQuantity(cb_obj.active)"))
    models["play"].js_on_change(
        "active",
        CustomJS(
            args={"labels": [_PLAY, _STOP]},
            code="cb_obj.label = labels[Number(cb_obj.active)]; contactqp.play(cb_obj.active)",
        ),
    )
    models["map"].js_on_event(Tap, CustomJS(code="contactqp.cutAt(cb_obj.y)"))


_BARE: dict[str, Any] = {"sizing_mode": "stretch_width", "toolbar_location": None}


def _plot(height: int, label: str, name: str, **options: Any) -> Any:
    """Return an empty plot as wide as its place."""
    plot = figure(
        name=name,
        height=height,
        **_BARE,
        html_attributes={"role": "img", "aria-label": label},
        **options,
    )
    for axis in plot.axis:
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_color = axis.major_label_text_color = INK
    plot.grid.grid_line_color = "#eef2f4"
    plot.outline_line_color = "#b8c4cb"
    return plot


def _map() -> dict[str, Any]:
    """Return the map of the nodes: a picture of their states, of the gap, and of the pressure, one at a time."""
    nothing = np.full((1, 1), np.nan)
    box = {"x": [0.0], "y": [0.0], "width": [1.0], "height": [1.0]}
    source = ColumnDataSource({**box, **{cell: [nothing] for cell in _CELLS}})
    plot = _plot(360, "Map of the nodes", "map", match_aspect=True, tools="pan,wheel_zoom,reset")
    plot.x_range, plot.y_range = (DataRange1d(range_padding=0.02) for _ in range(2))
    plot.toolbar.active_scroll = None
    mappers = {
        "state": LinearColorMapper(palette=[CLEAR, UNDECIDED, CONTACT], low=0.5, high=3.5, nan_color=_NOWHERE),
        "gap": LinearColorMapper(palette=Blues256[::-1], low=0, high=1, nan_color=_NOWHERE),
        "pressure": LinearColorMapper(palette=Oranges256[::-1], low=0, high=1, nan_color=_NOWHERE),
    }
    places = {"x": "x", "y": "y", "dw": "width", "dh": "height"}
    images = [
        plot.image(image=name, source=source, color_mapper=mapper, visible=name == "state", **places)
        for name, mapper in mappers.items()
    ]
    bar = ColorBar(color_mapper=mappers["gap"], visible=False, width=12)
    plot.add_layout(bar, "right")
    line = Span(location=0, dimension="width", line_color=INK, line_width=1, line_dash="dashed")
    plot.add_layout(line)
    told = [
        ("place", "$x{0.[000]}, $y{0.[000]}"),
        ("state", "@state{custom}"),
        ("gap", "@gap{custom}"),
        ("proven at least", "@lower{custom}"),
        ("proven at most", "@upper{custom}"),
        ("contact pressure", "@pressure{custom}"),
        ("deflection", "@deflection{custom}"),
        ("support", "@support{custom}"),
    ]
    plot.add_tools(HoverTool(tooltips=told, formatters=_formatters(_CELLS, state=_STATES)))
    return {
        "map": plot,
        "map_source": source,
        "images": images,
        "gap_mapper": mappers["gap"],
        "pressure_mapper": mappers["pressure"],
        "bar": bar,
        "line": line,
    }


def _section() -> dict[str, Any]:
    """Return the section, heights above and pressures below, of one row of nodes."""
    source = ColumnDataSource({place: [] for place in _PLACES})
    across = Range1d(start=0, end=1)
    downwards, upwards = Range1d(start=1, end=0), DataRange1d(start=0)
    heights = _plot(240, "Section: deflection and support", "section", x_range=across, y_range=downwards, tools="")
    heights.xaxis.visible = False
    bare: dict[str, Any] = {"border_line_color": None, "padding": 0, "margin": 2, "label_text_font_size": "11px"}
    legend = Legend(orientation="horizontal", **bare)
    heights.add_layout(legend, "above")
    heights.varea("x", "deflection", "foot", source=source, fill_color=BLUE, fill_alpha=0.12, legend_label="gap")
    heights.line("x", "support", source=source, line_color=GROUND, line_width=3, legend_label="support")
    stretched = heights.line("x", "deflection", source=source, line_color=BLUE, line_width=2, legend_label="deflection")
    heights.scatter("x", "deflection", source=source, size=3, color=BLUE)
    pressures = _plot(150, "Section: contact pressure", "reactions", x_range=across, y_range=upwards, tools="")
    bars = pressures.vbar("x", 1.0, "pressure", source=source, color=CONTACT)
    told = [
        ("x", "@x{0.[000]}"),
        ("state", "@state"),
        ("deflection", "@deflection{custom}"),
        ("gap", "@gap{custom}"),
        ("proven at least", "@lower{custom}"),
        ("proven at most", "@upper{custom}"),
        ("contact pressure", "@pressure{custom}"),
    ]
    formatters = _formatters(_PLACES)
    heights.add_tools(HoverTool(tooltips=told, formatters=formatters, renderers=[stretched], mode="vline"))
    pressures.add_tools(HoverTool(tooltips=told, formatters=formatters, mode="vline"))
    for plot in (heights, pressures):  # so that both begin at the same place
        plot.min_border_left = 66
    return {"section": heights, "reactions": pressures, "section_source": source, "bars": bars}


def _race() -> dict[str, Any]:
    """Return how the bounds of both methods fall with the work done."""
    empty: dict[str, list[float]] = {"work": [], "bound": [], "steps": []}
    sources = {name: ColumnDataSource(empty) for name in ("multigrid", "relaxation")}
    label = "Proven bound against work, of multigrid and of over-relaxation"
    ranges = {"x_range": Range1d(start=0, end=100), "y_range": Range1d(start=1e-10, end=1e2)}
    plot = _plot(260, label, "race", y_axis_type="log", tools="", **ranges)
    plot.xaxis.axis_label, plot.yaxis.axis_label = "work (sweeps)", "proven bound"
    styles = {"multigrid": (BLUE, "multigrid"), "relaxation": (CONTACT, "over-relaxation")}
    for name, (colour, label) in styles.items():
        plot.line("work", "bound", source=sources[name], line_color=colour, line_width=2, legend_label=label)
        plot.scatter("work", "bound", source=sources[name], color=colour, size=4, legend_label=label)
    plot.legend.background_fill_alpha = 0.7
    plot.legend.border_line_color = None
    told = [("steps", "@steps"), ("work", "@work{0.0}"), ("proven bound", "@bound{0.0e+0}")]
    plot.add_tools(HoverTool(tooltips=told))
    return {"race": plot, **{f"{name}_source": source for name, source in sources.items()}}


def _formatters(names: Sequence[str], **others: str) -> dict[str, Any]:
    """Return what writes numbers in tooltips: proven bounds with more digits, and a dash for what is not there."""
    codes = {name: _BOUND if name in ("lower", "upper") else _NUMBER for name in names} | others
    return {f"@{name}": CustomJSHover(code=code) for name, code in codes.items()}
