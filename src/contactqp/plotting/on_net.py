"""Pictures of cable nets: the plan, and the net in space."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..foundation.loading import load_modules
from ..foundation.pictures import PLAIN, Wanted
from ..models.cable_net import CableNet
from ..models.records import NodeState
from .on_line import line_of
from .states import STATE_COLOURS, draw_legend_of_states, mark_unsupported, seen
from .style import BLUE, GROUND, INK, map_height, new_figure, same_scales, tidy, tidy_in_space, two_halves
from .views import answer_figure, draw_answer, draw_states, draw_values, scatter_states, scatter_values

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure, SubFigure

    from ..models.records import Answered

_SEGMENT_COLOURS = STATE_COLOURS | {NodeState.CLEAR: BLUE}
"""A line in the colour of clear nodes would not be seen on white."""


@answer_figure.register(CableNet)
def _plan_and_space(net: CableNet, solution: Answered, wanted: Wanted = PLAIN) -> Figure:
    if line_of(net) is not None:
        figure = new_figure(9, 6)
        draw_answer(net, figure, solution)
        return figure
    figure = new_figure(12.5, map_height(net.extent) + 1.0)
    left, right = two_halves(figure)
    draw_answer(net, left, solution)
    _draw_in_space(right, solution, net)
    return figure


@draw_states.register(CableNet)
def _draw_states(net: CableNet, axes: Axes, state: NDArray[np.int64], contact: Mask, proven: str) -> None:
    """Draw nodes and segments in the colours of their states, and the fixed points."""
    kind = _segment_states(net, state)
    for k, colour in _SEGMENT_COLOURS.items():
        _draw_lines(axes, net.positions[net.segments[kind == k]], colour, _width(k))
    scatter_states(axes, net, state)
    fixed = _draw_fixed(axes, net)
    draw_legend_of_states(axes, state, proven, [fixed, *mark_unsupported(axes, net)])
    axes.set(xlabel="x", ylabel="y", title="Contact map")
    same_scales(axes)
    tidy(axes)


def _draw_in_space(part: SubFigure, solution: Answered, net: CableNet) -> None:
    """Draw the net in space, heights exaggerated to fit, with the gaps as lines down to the support.

    A support that lies deeper below the net than the net is high is left out.
    """
    load_modules("mpl_toolkits.mplot3d.art3d")
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    axes: Any = part.add_subplot(projection="3d")
    state, _ = seen(solution)
    points = np.column_stack([net.positions, net.point_heights(solution.deflection)])
    below = -points[:, 2] if net.upwards else points[:, 2]
    top, bottom = below.min(), below.max()
    near = net.depth <= bottom + (bottom - top or 1.0)
    foot = np.column_stack([net.positions[net.free], net.support])[near]
    gaps = np.stack([points[net.free][near], foot], axis=1)
    drawn = np.concatenate([points[:, 2], net.support[near]])
    if net.ceiling is not None and net.ceiling_depth is not None:
        close = net.ceiling_depth >= top - (bottom - top or 1.0)
        lid = np.column_stack([net.positions[net.free], net.ceiling])[close]
        axes.scatter(*lid.T, s=5, marker="^", color=GROUND, depthshade=False, label="ceiling c at nodes")
        drawn = np.concatenate([drawn, lid[:, 2]])
    room = 0.05 * (np.ptp(drawn) or 1.0)
    axes.add_collection3d(Line3DCollection(gaps, colors=GROUND, linewidths=0.8, linestyles="dotted"), autolim=False)
    axes.scatter(*foot.T, s=5, color=GROUND, depthshade=False, label="support f at nodes")
    kind = _segment_states(net, state)
    for k, colour in _SEGMENT_COLOURS.items():
        lines = Line3DCollection(points[net.segments[kind == k]], colors=colour, linewidths=_width(k))
        axes.add_collection3d(lines, autolim=False)
    axes.scatter(*points[net.fixed].T, s=12, marker="s", color=INK, depthshade=False)
    for k, colour in STATE_COLOURS.items():
        if k != NodeState.CLEAR:
            axes.scatter(*points[net.free][state == k].T, s=9, color=colour, depthshade=False)
    low, high = net.positions.min(axis=0), net.positions.max(axis=0)
    middle, half = (low + high) / 2, (high - low).max() / 2
    axes.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half))
    least, most = drawn.min() - room, drawn.max() + room
    axes.set(zlim=(least, most) if net.upwards else (most, least))
    far = "" if near[net.supported].all() else ", deep support left out"
    axes.set(xlabel="x", ylabel="y", title=f"Net and support, heights not to scale\n({net.sense}{far})")
    axes.set_box_aspect((1, 1, 0.5), zoom=0.98)
    tidy_in_space(axes)
    if near.any():
        axes.legend(loc="upper left", frameon=False, fontsize="small")


def draw_net(axes: Axes, net: CableNet) -> None:
    """Draw segments and fixed points in plan."""
    _draw_lines(axes, net.positions[net.segments], GROUND, 0.8)
    _draw_fixed(axes, net)


@draw_values.register(CableNet)
def _draw_values(net: CableNet, axes: Axes, values: Vector, norm: Normalize) -> ScalarMappable:
    draw_net(axes, net)
    return scatter_values(axes, net, values, norm)


def _draw_fixed(axes: Axes, net: CableNet) -> Any:
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
    """Return the state that both ends have, clear if they differ, and undecided if one end is."""
    everywhere = np.full(len(net.positions), NodeState.CLEAR.value)
    everywhere[net.free] = state
    ends = everywhere[net.segments]
    same = np.where(ends[:, 0] == ends[:, 1], ends[:, 0], NodeState.CLEAR.value)
    return np.where((ends == NodeState.UNDECIDED).any(axis=1), NodeState.UNDECIDED.value, same)


def _width(kind: int) -> float:
    return 0.9 if kind == NodeState.CLEAR else 1.5


def _draw_lines(axes: Axes, lines: NDArray[np.float64], colour: str, width: float) -> None:
    load_modules("matplotlib.collections")
    from matplotlib.collections import LineCollection

    axes.add_collection(LineCollection(list(lines), colors=colour, linewidths=width, capstyle="round", zorder=1.5))
