"""Pictures of models whose nodes lie in a line, where a map would be a strip: everything along that line."""

from __future__ import annotations

from functools import singledispatch
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..foundation.checks import Vector
from ..models.base import ContactModel
from ..models.cable_net import CableNet
from ..models.on_lattice import LatticeModel
from ..models.on_line import LineModel
from ..models.records import states_of
from .section import Cut, ceiling_at, cut_of_row, draw_section, draw_shape, ground_at, section_axes
from .states import STATE_COLOURS, labels_of_states
from .style import BLUE, CONTACT, GROUND, INK, new_figure, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

    from ..models.records import Answered, Enclosed, Settling

ALONG_THE_LINE = "distance along the line"

_STRAIGHT = 1e-9
"""Points count as in a line that leave it by no more than this part of their extent."""


class Line(NamedTuple):
    """A straight line in plan, and what a place on it is called.

    Attributes
    ----------
    start, direction : (float, float)
        The point that places are counted from (length), and a unit vector.
    label : str
        Label of the axis.
    """

    start: tuple[float, float]
    direction: tuple[float, float]
    label: str

    def along(self, x: Vector, y: Vector) -> Vector:
        """Return the places of points on the line (length)."""
        return np.asarray((x - self.start[0]) * self.direction[0] + (y - self.start[1]) * self.direction[1])


ALONG_X, ALONG_Y = Line((0.0, 0.0), (1.0, 0.0), "x"), Line((0.0, 0.0), (0.0, 1.0), "y")


def line_through(x: Vector, y: Vector) -> Line | None:
    """Return the line in which points lie, None if they lie in none; a single point lies on one along x.

    Examples
    --------
    >>> line_through(np.array([0.0, 3.0, 6.0]), np.array([1.0, 5.0, 9.0])).along(np.array([3.0]), np.array([5.0]))
    array([5.])
    >>> line_through(np.array([0.0, 3.0, 6.0]), np.array([1.0, 5.0, 7.0])) is None
    True
    """
    width, height = float(np.ptp(x)), float(np.ptp(y))
    slack = _STRAIGHT * max(width, height)
    if height <= slack:
        return ALONG_X
    if width <= slack:
        return ALONG_Y
    one, other = int(np.argmin(x)), int(np.argmax(x))
    start, run = (float(x[one]), float(y[one])), (float(x[other] - x[one]), float(y[other] - y[one]))
    length = float(np.hypot(*run))
    line = Line(start, (run[0] / length, run[1] / length), ALONG_THE_LINE)
    off = (x - start[0]) * line.direction[1] - (y - start[1]) * line.direction[0]
    return line if float(np.abs(off).max()) <= slack else None


@singledispatch
def line_of(model: ContactModel) -> Line | None:
    """Return the line in which all nodes of a model, and what is known of its frame, lie; None if they do not."""
    return line_through(model.node_x, model.node_y)


@line_of.register(LatticeModel)
def _no_line(model: LatticeModel) -> Line | None:
    return None


@line_of.register(LineModel)
def _along_x(model: LineModel) -> Line | None:
    return ALONG_X


@line_of.register(CableNet)
def _line_of_points(net: CableNet) -> Line | None:
    return line_through(*net.positions.T)


@singledispatch
def cut_along(model: ContactModel, line: Line, gap: Vector) -> Cut:
    """Return the section along the line in which a model's nodes lie, with the gap at them."""
    place, none = line.along(model.node_x, model.node_y), np.zeros(0)
    number = np.argsort(place, kind="stable")
    x = place[number]
    ground, ceiling = ground_at(model, number), ceiling_at(model, number)
    return Cut(x, model.deflection(gap)[number], x, ground, ceiling, none, none, x, number, "deflection")


@cut_along.register(LineModel)
def _cut_of_row(model: LineModel, line: Line, gap: Vector) -> Cut:
    return cut_of_row(model, gap, 0)


@cut_along.register(CableNet)
def _cut_of_net(net: CableNet, line: Line, gap: Vector) -> Cut:
    place, heights = line.along(*net.positions.T), net.point_heights(net.deflection(gap))
    ends = np.column_stack([net.segments, net.segments[:, 0]])
    x, curve = place[ends], heights[ends]
    x[:, 2] = curve[:, 2] = np.nan  # between two segments nothing is drawn
    cut = cut_along.dispatch(ContactModel)(net, line, gap)
    return cut._replace(
        x=x.ravel(), heights=curve.ravel(), frame_x=place[net.fixed], frame_heights=net.fixed_height, noun="net"
    )


def draw_answer_on_line(model: ContactModel, part: Figure | SubFigure, solution: Answered, line: Line) -> None:
    """Draw shape, gap and reaction."""
    draw_section(section_axes(part), cut_along(model, line, solution.gap), model, solution, line.label)


def draw_shape_on_line(model: ContactModel, axes: Axes, solution: Answered, line: Line) -> None:
    """Draw the shape alone."""
    draw_shape(axes, cut_along(model, line, solution.gap), model, solution)
    axes.set_xlabel(line.label)


def certificate_on_line(model: ContactModel, certificate: Enclosed, line: Line) -> Figure:
    """Draw the bounds of the gap, and the states of the nodes."""
    figure = new_figure(9, 3.6)
    axes = figure.subplots()
    place = line.along(model.node_x, model.node_y)
    order = np.argsort(place, kind="stable")
    x, state = place[order], states_of(certificate)[order]
    known = (np.isfinite(certificate.lower) & np.isfinite(certificate.upper) & model.supported)[order]
    lower, upper = (np.where(known, bound[order], np.nan) for bound in (certificate.lower, certificate.upper))
    axes.fill_between(x, lower, upper, color=BLUE, alpha=0.3, lw=0, label="between the bounds of the gap")
    axes.plot(x, upper, color=BLUE, lw=1)
    for k, label in labels_of_states(state, "certainly ").items():
        chosen = state == k
        axes.plot(x[chosen], upper[chosen], "o", ms=4, mec=INK, mew=0.4, color=STATE_COLOURS[k], label=label)
    axes.axhline(0, color=INK, lw=0.6)
    figure.legend(loc="outside lower center", ncols=4, frameon=False, fontsize="small")
    axes.set(xlabel=line.label, ylabel="gap ω")
    tidy(axes)
    return figure


def values_on_line(
    model: ContactModel, values: Vector, floor: float, label: str, line: Line
) -> tuple[Figure, Axes, Vector, Vector]:
    """Draw a number at each node on a logarithmic scale; also returned are the axes and the nodes' places in them."""
    figure = new_figure(9, 4.6)
    axes = figure.subplots()
    x, height = line.along(model.node_x, model.node_y), np.maximum(values, floor)
    order = np.argsort(x, kind="stable")
    axes.plot(x[order], height[order], ".-", color=BLUE, lw=1, ms=4)
    axes.set(yscale="log", xlabel=line.label, ylabel=label)
    tidy(axes)
    return figure, axes, x, height


def settling_on_line(model: ContactModel, touchdown: Settling, line: Line) -> Figure:
    """Draw the loads at which the nodes settle, and between which they are known to do so.

    Nodes that settle beyond the loads solved for, or before them, stand at the last load at which that is certain.
    """
    figure = new_figure(9, 4.4)
    axes = figure.subplots()
    x, known = line.along(model.node_x, model.node_y), np.isfinite(touchdown.load)
    axes.vlines(x[known], touchdown.clear[known], touchdown.contact[known], color=GROUND, lw=2, label="settles between")
    axes.plot(x[known], touchdown.load[known], ".", color=CONTACT, ms=5, label="middle")
    for bound, marker, label in ((touchdown.clear, "^", "settles above"), (touchdown.contact, "v", "settles below")):
        open_end = ~known & np.isfinite(bound)
        if open_end.any():
            axes.plot(x[open_end], bound[open_end], marker, mfc="none", mec=GROUND, ms=5, label=label)
    figure.legend(loc="outside lower center", ncols=4, frameon=False, fontsize="small")
    title = f"Touchdown loads, known to {touchdown.width:.2g}"
    axes.set(xlabel=line.label, ylabel="load factor", title=title)
    tidy(axes)
    return figure
