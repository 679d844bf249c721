"""Pictures of cable nets: the plan, and the net in space."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Vector
from .states import draw_legend_of_states, seen
from .style import BLUE, CLEAR, CONTACT, GROUND, INK, UNDECIDED, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import SubFigure

    from ..models.cable_net import CableNet
    from ..models.records import Answered

_STATE_COLOURS = (CLEAR, CONTACT, UNDECIDED)
_SEGMENT_COLOURS = (BLUE, CONTACT, UNDECIDED)
"""A line in the colour of clear nodes would not be seen on white."""
_WIDTHS = (0.9, 1.5, 1.5)


def draw_plan(axes: Axes, net: CableNet, state: NDArray[np.int64], proven: str) -> None:
    """Draw the net in plan: nodes and segments in the colours of their states, and the fixed points."""
    kind = _segment_states(net, state)
    for k, colour in enumerate(_SEGMENT_COLOURS):
        _draw_lines(axes, net.positions[net.segments[kind == k]], colour, _WIDTHS[k])
    size = float(np.clip(2500 / net.size, 3, 22))
    for k, colour in enumerate(_STATE_COLOURS):
        x, y = net.node_x[state == k], net.node_y[state == k]
        axes.scatter(x, y, s=size, color=colour, edgecolors=INK, linewidths=0.4, zorder=2.5)
    fixed = draw_fixed(axes, net)
    draw_legend_of_states(axes, state, proven, more=[fixed])
    axes.set(aspect="equal", xlabel="x", ylabel="y", title="Contact map")
    tidy(axes)


def draw_in_space(part: SubFigure, solution: Answered, net: CableNet) -> None:
    """Draw the net in space, heights exaggerated to fit, with the gaps as lines down to the support.

    A support that lies deeper below the net than the net is high is left out.
    """
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    axes: Any = part.add_subplot(projection="3d")
    state, _ = seen(solution)
    points = np.column_stack([net.positions, net.point_heights(solution.deflection)])
    top, bottom = points[:, 2].min(), points[:, 2].max()
    near = net.support <= bottom + (bottom - top or 1.0)
    foot = np.column_stack([net.positions[net.free], net.support])[near]
    gaps = np.stack([points[net.free][near], foot], axis=1)
    drawn = np.concatenate([points[:, 2], net.support[near]])
    room = 0.05 * (np.ptp(drawn) or 1.0)
    axes.add_collection3d(Line3DCollection(gaps, colors=GROUND, linewidths=0.8, linestyles="dotted"), autolim=False)
    axes.scatter(*foot.T, s=5, color=GROUND, depthshade=False, label="support f at nodes")
    kind = _segment_states(net, state)
    for k, colour in enumerate(_SEGMENT_COLOURS):
        lines = Line3DCollection(points[net.segments[kind == k]], colors=colour, linewidths=_WIDTHS[k])
        axes.add_collection3d(lines, autolim=False)
    axes.scatter(*points[net.fixed].T, s=12, marker="s", color=INK, depthshade=False)
    for k, colour in enumerate(_STATE_COLOURS[1:], start=1):
        axes.scatter(*points[net.free][state == k].T, s=9, color=colour, depthshade=False)
    low, high = net.positions.min(axis=0), net.positions.max(axis=0)
    middle, half = (low + high) / 2, (high - low).max() / 2
    axes.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half))
    axes.set(zlim=(drawn.max() + room, drawn.min() - room))
    axes.set(xlabel="x", ylabel="y", title="Net and support, ordinates not to scale")
    axes.set_box_aspect((1, 1, 0.5), zoom=0.98)
    axes.view_init(elev=32, azim=-60)
    axes.tick_params(labelsize="small")
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.pane.set_visible(False)
        axis.line.set_color(INK)
    axes.grid(visible=False)
    if near.any():
        axes.legend(loc="upper left", frameon=False, fontsize="small")


def draw_net_spread(axes: Axes, net: CableNet, spread: Vector, norm: Any) -> Any:
    """Draw a number at each node in plan by colour, and return what a colour bar needs."""
    _draw_lines(axes, net.positions[net.segments], GROUND, 0.8)
    return axes.scatter(net.node_x, net.node_y, c=spread, s=26, cmap="viridis", norm=norm, zorder=3)


def draw_fixed(axes: Axes, net: CableNet) -> Any:
    """Mark the fixed points in plan, and return what a legend needs."""
    x, y = net.positions[net.fixed].T
    squares = axes.scatter(x, y, marker="s", s=16, color=INK, zorder=3)
    squares.set_label(f"fixed ({net.fixed.size})")
    # Points on a line get some room beside it.
    low, high = net.positions.min(axis=0), net.positions.max(axis=0)
    middle, room = (low + high) / 2, 0.1 * (high - low).max()
    axes.update_datalim([middle - room, middle + room])
    axes.autoscale_view()
    return squares


def _segment_states(net: CableNet, state: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return 2 (undecided) for segments with such an end, 1 (in contact) if both ends are, else 0 (clear)."""
    everywhere = np.zeros(len(net.positions), dtype=np.int64)
    everywhere[net.free] = state
    ends = everywhere[net.segments]
    return np.where((ends == 2).any(axis=1), 2, np.where((ends == 1).all(axis=1), 1, 0))


def _draw_lines(axes: Axes, lines: NDArray[np.float64], colour: str, width: float) -> None:
    from matplotlib.collections import LineCollection

    axes.add_collection(LineCollection(list(lines), colors=colour, linewidths=width, capstyle="round", zorder=1.5))
