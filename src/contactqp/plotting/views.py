"""Views: pictures of models and their answers, each a function that goes by the class of its first argument.

What stands here serves any model, by the places of its nodes, in plan or, where they lie in a line, along that (see
`on_line`); and a bare problem, which knows no places. A kind of model that is drawn otherwise registers its own
functions in a file of its own (see `on_lattice`, `on_row`, `on_beam`, `on_net` and `on_mesh`), which
`contactqp.plotting` imports. A class without a registration is drawn as the nearest class above it.
"""

from __future__ import annotations

from functools import singledispatch
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..foundation.loading import load_modules
from ..foundation.pictures import PLAIN, Wanted
from ..models.base import ContactModel
from ..models.records import states_of
from .on_line import (
    certificate_on_line,
    draw_answer_on_line,
    draw_shape_on_line,
    line_of,
    settling_on_line,
    values_on_line,
)
from .states import STATE_COLOURS, draw_legend_of_states, mark_unsupported, seen
from .style import BLUE, CONTACT, GROUND, INK, map_height, new_figure, same_scales, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure, SubFigure

    from ..foundation.checks import Mask, Vector
    from ..models.records import Answered, Enclosed, Settling
    from ..problem.contact_problem import ContactProblem


GAP_AND_REACTION = "gap ω, R / G_ii"
"""Label of an axis: both are of the unit that the gap has."""


class NodePlaces(NamedTuple):
    """Where the nodes stand in a picture, for marks beside them.

    Attributes
    ----------
    axes : Axes
    x, y : array, shape (n,)
        Their coordinates in the axes.
    apart : float
        Distance in the axes that keeps two numbers from covering each other.
    ring : float
        Size of a ring about a node (points²).
    """

    axes: Axes
    x: Vector
    y: Vector
    apart: float
    ring: float


@singledispatch
def answer_figure(subject: ContactModel | ContactProblem, solution: Answered, wanted: Wanted = PLAIN) -> Figure:
    """Return a picture of a solution: of a bare problem its gap and reaction, sorted, of a model the map of states."""
    figure = new_figure(7, 4.4)
    draw_answer(subject, figure, solution)
    return figure


@answer_figure.register(ContactModel)
def _answer_figure_in_plan(model: ContactModel, solution: Answered, wanted: Wanted = PLAIN) -> Figure:
    figure = new_figure(9, 6) if line_of(model) else new_figure(7, map_height(model.extent) + 1.2)
    draw_answer(model, figure, solution)
    return figure


@singledispatch
def draw_into(subject: ContactModel | ContactProblem, axes: Axes, solution: Answered, wanted: Wanted) -> None:
    """Draw what tells most of a solution in axes of the user's own: of a bare problem its gap and reaction, sorted."""
    _draw_sorted(axes, solution)


@draw_into.register(ContactModel)
def _draw_map_into(model: ContactModel, axes: Axes, solution: Answered, wanted: Wanted) -> None:
    line = line_of(model)
    if line is not None:
        draw_shape_on_line(model, axes, solution, line)
        return
    state, proven = seen(solution)
    draw_states(model, axes, state, solution.contact, proven)
    # The legend belongs below these axes, not below a figure that may hold others.
    figure: Any = axes.get_figure(root=False)
    legend = figure.legends[-1]
    legend.remove()
    names = [text.get_text() for text in legend.get_texts()]
    place: Any = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.14), "frameon": False, "fontsize": "small"}
    axes.legend(legend.legend_handles, names, ncols=2, **place)


@singledispatch
def draw_answer(
    subject: ContactModel | ContactProblem, part: Figure | SubFigure, solution: Answered
) -> NodePlaces | None:
    """Draw what tells most of a solution in an empty part of a figure: the map of states, or a cable's section.

    Returns
    -------
    NodePlaces or None
        Where the nodes stand; None unless the picture is a map.
    """
    _draw_sorted(part.subplots(), solution)
    return None


def _draw_sorted(axes: Axes, solution: Answered) -> None:
    correction = solution.reaction / solution.problem.stiffness.diagonal()
    order = np.argsort(solution.gap - correction)
    for values, colour, label in ((solution.gap, BLUE, "gap ω"), (correction, CONTACT, "reaction R / G_ii")):
        _plot_sorted(axes, values[order], colour, label)
    axes.set(xlabel="unknowns, sorted", ylabel=GAP_AND_REACTION, title="Gap and reaction")
    axes.legend(frameon=False)
    tidy(axes)


def _plot_sorted(axes: Axes, values: Vector, colour: str, label: str | None = None) -> None:
    """Draw numbers in an order, counted from 1 on, with a dot for each where there are few."""
    load_modules("matplotlib.ticker")
    from matplotlib.ticker import MaxNLocator

    dots = "o" if values.size <= _FEW else ""
    axes.plot(np.arange(1, values.size + 1), values, f"{dots}-", color=colour, lw=1.2, ms=4, label=label)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))


_FEW = 60
"""Unknowns up to which each has a dot of its own."""


@draw_answer.register(ContactModel)
def _draw_answer_in_plan(model: ContactModel, part: Figure | SubFigure, solution: Answered) -> NodePlaces | None:
    line = line_of(model)
    if line is not None:
        draw_answer_on_line(model, part, solution, line)
        return None
    axes = part.subplots()
    state, proven = seen(solution)
    draw_states(model, axes, state, solution.contact, proven)
    return _places_in_plan(axes, model)


@singledispatch
def certificate_figure(model: ContactModel, certificate: Enclosed) -> Figure:
    """Return a picture of what a certificate proves: the map of states, or of nodes in a line the bounds of the gap."""
    line = line_of(model)
    if line is not None:
        return certificate_on_line(model, certificate, line)
    figure = new_figure(7, map_height(model.extent, least=3.0) + 1.2)
    draw_states(model, figure.subplots(), states_of(certificate), certificate.contact, "certainly ")
    return figure


@singledispatch
def draw_states(model: ContactModel, axes: Axes, state: NDArray[np.int64], contact: Mask, proven: str) -> None:
    """Draw the map of the nodes' states in plan, and a legend below it.

    Parameters
    ----------
    model : Membrane, Cable, CableNet or another model
    axes : Axes
    state : array of int, shape (n,)
        Numbers of `NodeState`.
    contact : array of bool, shape (n,)
        Nodes whose boundary is drawn, where the picture has one.
    proven : str
        What the legend writes before a state.
    """
    scatter_states(axes, model, state)
    draw_legend_of_states(axes, state, proven, mark_unsupported(axes, model))
    axes.set(xlabel="x", ylabel="y", title="Contact map")
    same_scales(axes)
    tidy(axes)


def scatter_states(axes: Axes, model: ContactModel, state: NDArray[np.int64]) -> None:
    """Draw the nodes as dots in the colours of their states."""
    size = float(np.clip(2500 / model.size, 3, 22))
    for k, colour in STATE_COLOURS.items():
        x, y = model.node_x[state == k], model.node_y[state == k]
        axes.scatter(x, y, s=size, color=colour, edgecolors=INK, linewidths=0.4, zorder=2.5)


@singledispatch
def draw_values(model: ContactModel, axes: Axes, values: Vector, norm: Normalize) -> ScalarMappable:
    """Draw a number at each node in plan by colour, and return what a colour bar needs."""
    return scatter_values(axes, model, values, norm)


def scatter_values(axes: Axes, model: ContactModel, values: Vector, norm: Normalize) -> ScalarMappable:
    """Draw the nodes as dots, each with a number by its colour, and return what a colour bar needs."""
    return axes.scatter(model.node_x, model.node_y, c=values, s=26, cmap="viridis", norm=norm, zorder=3)


@singledispatch
def values_figure(
    subject: ContactModel | ContactProblem, values: Vector, floor: float, label: str
) -> tuple[Figure, NodePlaces | None]:
    """Return a picture of a number at each node on a logarithmic scale: in plan, or sorted for a bare problem.

    Parameters
    ----------
    subject : Membrane, Cable, CableNet, another model, or ContactQP
    values : array, shape (n,)
        Each >= 0.
    floor : float
        Values below it are drawn alike, > 0.
    label : str
        What the values are, with their unit.

    Returns
    -------
    figure : Figure
    places : NodePlaces or None
        None where the picture shows no node of its own.
    """
    figure = new_figure(8, 4.6)
    axes = figure.subplots()
    _plot_sorted(axes, np.maximum(np.sort(values)[::-1], floor), BLUE)
    axes.set(yscale="log", xlabel="unknowns, sorted", ylabel=label)
    tidy(axes)
    return figure, None


@values_figure.register(ContactModel)
def _values_figure_in_plan(
    model: ContactModel, values: Vector, floor: float, label: str
) -> tuple[Figure, NodePlaces | None]:
    line = line_of(model)
    if line is not None:
        figure, axes, x, y = values_on_line(model, values, floor, label, line)
        return figure, NodePlaces(axes, x, y, apart=0.03 * float(np.ptp(x)), ring=60)
    load_modules("matplotlib.colors")
    from matplotlib.colors import LogNorm

    figure = new_figure(8.5, map_height(model.extent, 6.8, least=2.2, most=7.5) + 1.0)
    axes = figure.subplots()
    shown = np.maximum(values, floor)
    picture = draw_values(model, axes, shown, LogNorm(floor, max(float(shown.max()), 10 * floor)))
    width, depth = model.extent
    place = "bottom" if width > 2 * depth else "right"
    figure.colorbar(picture, ax=axes, extend="min", label=label, shrink=0.85, location=place)
    axes.set(xlabel="x", ylabel="y")
    same_scales(axes)
    tidy(axes)
    return figure, _places_in_plan(axes, model)


def _places_in_plan(axes: Axes, model: ContactModel) -> NodePlaces:
    x, y = model.node_x, model.node_y
    return NodePlaces(axes, x, y, apart=0.05 * float(max(np.ptp(x), np.ptp(y))), ring=34)


@singledispatch
def settling_figure(model: ContactModel, touchdown: Settling) -> Figure:
    """Return a picture of the loads at which the nodes settle: in plan, rings for those that settle at none of them."""
    line = line_of(model)
    if line is not None:
        return settling_on_line(model, touchdown, line)
    figure = new_figure(8, 6)
    axes = figure.subplots()
    x, y, known = model.node_x, model.node_y, np.isfinite(touchdown.load)
    axes.scatter(x[~known], y[~known], s=18, facecolors="none", edgecolors=GROUND, linewidths=0.8)
    picture: Any = axes.scatter(x[known], y[known], s=30, c=touchdown.load[known], cmap="viridis")
    figure.colorbar(picture, ax=axes, label="load factor at which the node settles", shrink=0.85)
    axes.set(xlabel="x", ylabel="y", title=f"Touchdown loads, known to {touchdown.width:.2g}")
    same_scales(axes)
    tidy(axes)
    return figure
