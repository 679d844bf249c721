"""Pictures of cables: everything along x."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..foundation.checks import Vector
from ..foundation.pictures import PLAIN, Wanted
from ..models.cable import Cable
from ..models.records import states_of
from .section import draw_section, draw_shape, section_axes
from .states import STATE_COLOURS, labels_of_states
from .style import BLUE, CONTACT, GROUND, INK, new_figure, tidy
from .views import NodePlaces, answer_figure, certificate_figure, draw_answer, draw_into, settling_figure, values_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

    from ..models.records import Answered, Enclosed, Settling


@answer_figure.register(Cable)
def _answer_figure(cable: Cable, solution: Answered, wanted: Wanted = PLAIN) -> Figure:
    figure = new_figure(9, 6)
    draw_answer(cable, figure, solution)
    return figure


@draw_into.register(Cable)
def _draw_shape_into(cable: Cable, axes: Axes, solution: Answered, wanted: Wanted) -> None:
    draw_shape(axes, cable, solution, row=0, noun="cable")
    axes.set_xlabel("x")


@draw_answer.register(Cable)
def _draw_answer(cable: Cable, part: Figure | SubFigure, solution: Answered) -> None:
    draw_section(section_axes(part), cable, solution, row=0, noun="cable")


@certificate_figure.register(Cable)
def _certificate_figure(cable: Cable, certificate: Enclosed) -> Figure:
    """Draw the bounds of the gap, and the states of the nodes."""
    figure = new_figure(9, 3.6)
    axes = figure.subplots()
    x, state = cable.node_x, states_of(certificate)
    known = np.isfinite(certificate.lower) & np.isfinite(certificate.upper) & cable.supported
    lower, upper = (np.where(known, bound, np.nan) for bound in (certificate.lower, certificate.upper))
    axes.fill_between(x, lower, upper, color=BLUE, alpha=0.3, lw=0, label="between the bounds of the gap")
    axes.plot(x, upper, color=BLUE, lw=1)
    for k, label in labels_of_states(state, "certainly ").items():
        chosen = state == k
        axes.plot(x[chosen], upper[chosen], "o", ms=4, mec=INK, mew=0.4, color=STATE_COLOURS[k], label=label)
    axes.axhline(0, color=INK, lw=0.6)
    figure.legend(loc="outside lower center", ncols=4, frameon=False, fontsize="small")
    axes.set(xlabel="x", ylabel="gap ω")
    tidy(axes)
    return figure


@values_figure.register(Cable)
def _values_figure(cable: Cable, values: Vector, floor: float, label: str) -> tuple[Figure, NodePlaces | None]:
    figure = new_figure(9, 4.6)
    axes = figure.subplots()
    x, height = cable.node_x, np.maximum(values, floor)
    axes.plot(x, height, ".-", color=BLUE, lw=1, ms=4)
    axes.set(yscale="log", xlabel="x", ylabel=label)
    tidy(axes)
    return figure, NodePlaces(axes, x, height, apart=0.03 * float(np.ptp(x)), ring=60)


@settling_figure.register(Cable)
def _settling_figure(cable: Cable, touchdown: Settling) -> Figure:
    figure = new_figure(9, 4)
    axes = figure.subplots()
    x, known = cable.node_x, np.isfinite(touchdown.load)
    axes.vlines(x[known], touchdown.clear[known], touchdown.contact[known], color=GROUND, lw=2)
    axes.plot(x[known], touchdown.load[known], ".", color=CONTACT, ms=5)
    axes.set(xlabel="x", ylabel="load factor", title=f"Touchdown loads, known to {touchdown.width:.2g}")
    tidy(axes)
    return figure
