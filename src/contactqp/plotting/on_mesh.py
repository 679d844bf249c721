"""Pictures of membranes on meshes of triangles: the map of states, the deflection, and a section across the mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector, finite_number
from ..foundation.loading import load_modules
from ..foundation.pictures import PLAIN, Wanted
from ..models.mesh_membrane import MeshMembrane
from ..models.records import NodeState, held_reaction
from .on_line import Line, line_of
from .section import Cut, draw_shape
from .states import STATE_COLOURS, colours_by_number, draw_legend_of_states, mark_unsupported
from .style import GROUND, INK, bar_of_heights, map_height, new_figure, same_scales, tidy, two_halves
from .views import answer_figure, draw_answer, draw_states, draw_values, settling_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    from ..models.records import Answered, Settling

_ROUNDING = 1e-12
"""Part of the gap scale that deflections may differ by where there are none."""

_TICKS = 5
"""Numbers along an axis of the small map, which more would not fit beside each other."""

_FEW = 4000
"""Triangles up to which their sides are drawn."""


@answer_figure.register(MeshMembrane)
def _map_and_section(model: MeshMembrane, solution: Answered, wanted: Wanted = PLAIN) -> Figure:
    place = _place_of_section(model, solution, wanted.section)
    figure = new_figure(12.5, map_height(model.extent) + 1.0)
    left, right = two_halves(figure)
    draw_answer(model, left, solution)
    upper, lower = right.subplots(2, 1, height_ratios=[1.6, 1])
    _draw_deflection(upper, model, solution)
    draw_shape(lower, cut_across(model, solution.gap, place), model, solution)
    lower.set(xlabel="x", title=f"Section at y = {place:.3g}")
    for axes in (left.axes[0], upper):
        axes.axhline(place, color="white", lw=1.8, alpha=0.6)
        axes.axhline(place, color=INK, lw=0.9, ls="--")
    return figure


@line_of.register(MeshMembrane)
def _no_line(model: MeshMembrane) -> Line | None:
    return None


@draw_states.register(MeshMembrane)
def _draw_states(model: MeshMembrane, axes: Axes, state: NDArray[np.int64], contact: Mask, proven: str) -> None:
    """Draw triangles in the colour of the state that all their nodes have, and what is not clear as dots as well.

    A triangle whose nodes differ is clear, or undecided if one of them is.
    """
    colours, low, high = colours_by_number()
    _pseudocolour(axes, model, states_of_triangles(model, state).astype(float), cmap=colours, vmin=low, vmax=high)
    size = float(np.clip(3000 / model.size, 0.5, 14))
    for k, colour in STATE_COLOURS.items():
        if k != NodeState.CLEAR:
            axes.scatter(model.node_x[state == k], model.node_y[state == k], s=size, color=colour, lw=0, zorder=2.5)
    draw_outline(axes, model)
    draw_legend_of_states(axes, state, proven, mark_unsupported(axes, model))
    axes.set(xlabel="x", ylabel="y", title="Contact map")
    same_scales(axes)
    tidy(axes)


@draw_values.register(MeshMembrane)
def _draw_values(model: MeshMembrane, axes: Axes, values: Vector, norm: Normalize) -> ScalarMappable:
    picture = draw_of_nodes(axes, model, values, cmap="viridis", norm=norm)
    draw_outline(axes, model)
    return picture


@settling_figure.register(MeshMembrane)
def _settling_figure(model: MeshMembrane, touchdown: Settling) -> Figure:
    figure = new_figure(8.5, map_height(model.extent, least=3.5, most=7.0) + 1.0)
    axes = figure.subplots()
    picture = draw_of_nodes(axes, model, touchdown.load, cmap="viridis")
    draw_outline(axes, model)
    figure.colorbar(picture, ax=axes, label="load factor at which the nodes settle", shrink=0.85)
    axes.set(xlabel="x", ylabel="y", title=f"Touchdown loads, known to {touchdown.width:.2g}")
    same_scales(axes)
    tidy(axes)
    return figure


def draw_of_nodes(axes: Axes, model: MeshMembrane, values: Vector, **style: Any) -> ScalarMappable:
    """Colour each triangle by the mean of its nodes' values, white where one of them is not finite."""
    everywhere = np.full(len(model.positions), np.nan)
    everywhere[model.free] = values
    corners, free = everywhere[model.triangles], ~np.isin(model.triangles, model.fixed)
    count = free.sum(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(free, corners, 0.0).sum(axis=1) / count
    return _pseudocolour(axes, model, np.ma.masked_invalid(mean), **style)


def draw_outline(axes: Axes, model: MeshMembrane) -> None:
    """Draw the boundary of the mesh, its triangles if there are few, and fixed points that are not on it."""
    load_modules("matplotlib.collections")
    from matplotlib.collections import LineCollection

    mesh = model.mesh
    parts = [(mesh.edges[mesh.boundary], INK, 1.0)]
    if len(model.triangles) <= _FEW:
        parts.insert(0, (mesh.edges, GROUND, 0.3))
    for edges, colour, width in parts:
        axes.add_collection(LineCollection(list(model.positions[edges]), colors=colour, linewidths=width, zorder=2))
    edge = np.unique(mesh.edges[mesh.boundary])
    whole = np.array_equal(edge, model.fixed)
    if not whole:
        x, y = model.positions[model.fixed].T
        axes.scatter(x, y, marker="s", s=float(np.clip(2000 / model.size, 2, 14)), color=INK, lw=0, zorder=3)
    axes.autoscale_view()


def cut_across(model: MeshMembrane, gap: Vector, place: float) -> Cut:
    """Return the section of the mesh at y = ``place``, with the gap at the nodes: linear in each triangle."""
    below = model.positions[:, 1] < place
    ends = model.mesh.edges[model.mesh.triangle_edges]
    crossing = below[ends[..., 0]] != below[ends[..., 1]]
    across = ends[crossing.any(axis=1)][crossing[crossing.any(axis=1)]].reshape(-1, 2, 2)
    y = model.positions[across, 1]
    part = (place - y[..., 0]) / (y[..., 1] - y[..., 0])

    def between(values: Vector) -> Vector:
        """Return values at both ends of each piece, and nan behind it."""
        pair = values[across]
        found = pair[..., 0] + part * (pair[..., 1] - pair[..., 0])
        return np.column_stack([found, np.full(len(found), np.nan)])

    x = between(model.positions[:, 0])
    turned = x[:, 0] > x[:, 1]
    order = np.argsort(np.minimum(x[:, 0], x[:, 1]), kind="stable")

    def laid(values: Vector) -> Vector:
        pieces = between(values)
        pieces[turned] = pieces[turned][:, [1, 0, 2]]
        return np.asarray(pieces[order].ravel())

    heights = laid(model.point_heights(model.deflection(gap)))
    at_nodes = {"ground": np.where(model.supported, model.support, np.nan)}
    at_nodes["ceiling"] = (
        np.full(model.size, np.nan) if model.ceiling is None else np.where(model.under_ceiling, model.ceiling, np.nan)
    )
    ground, ceiling = (laid(model.laid_out(values)[1]) for values in at_nodes.values())
    along, none = laid(model.positions[:, 0]), np.zeros(0)
    return Cut(along, heights, along, ground, ceiling, none, none, none, np.zeros(0, dtype=np.int64), "membrane")


def _place_of_section(model: MeshMembrane, solution: Answered, wanted: float | None) -> float:
    """Return the ordinate of the section: by default through the largest reaction where a node touches, or the middle.

    Raises
    ------
    ValueError
        If it does not cross the mesh.
    """
    low, high = float(model.positions[:, 1].min()), float(model.positions[:, 1].max())
    if wanted is None:
        middle = (low + high) / 2
        if not solution.contact.any():
            return middle
        near = np.abs(model.node_y - middle) <= 0.05 * (high - low)
        if solution.contact[near].any():
            return middle
        touching = np.where(solution.contact, np.abs(held_reaction(solution)), 0.0)
        return float(model.node_y[np.argmax(touching)])
    place = finite_number(wanted, "section")
    if not low < place < high:
        raise ValueError(f"section must lie between y = {low:g} and {high:g}, got {place:g}")
    return place


def _draw_deflection(axes: Axes, model: MeshMembrane, solution: Answered) -> None:
    heights = model.point_heights(solution.deflection)
    picture: Any = axes.tripcolor(
        _triangulation(model), heights, cmap="viridis" if model.upwards else "viridis_r", shading="gouraud"
    )
    picture.set_rasterized(True)
    draw_outline(axes, model)
    label, rounding = f"w, {model.sense}", _ROUNDING * model.problem.gap_scale
    bar_of_heights(axes, picture, heights, label, upwards=model.upwards, rounding=rounding, shrink=0.9)
    axes.set(xlabel="x", ylabel="y", title="Deflection")
    axes.locator_params(nbins=_TICKS)
    same_scales(axes)
    tidy(axes)


def states_of_triangles(model: MeshMembrane, state: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the state that all nodes of each triangle have; else clear, or undecided if one of them is."""
    everywhere = np.zeros(len(model.positions), dtype=np.int64)
    everywhere[model.free] = state
    corners, fixed = everywhere[model.triangles], np.isin(model.triangles, model.fixed)
    found = np.full(len(corners), NodeState.CLEAR.value)
    for k in STATE_COLOURS:
        found[((corners == k) | fixed).all(axis=1) & ~fixed.all(axis=1)] = k
    found[((corners == NodeState.UNDECIDED) & ~fixed).any(axis=1)] = NodeState.UNDECIDED.value
    return found


def _triangulation(model: MeshMembrane) -> Any:
    load_modules("matplotlib.tri")
    from matplotlib.tri import Triangulation

    x, y = model.positions.T
    return Triangulation(x, y, model.triangles)


def _pseudocolour(axes: Axes, model: MeshMembrane, values: Any, **style: Any) -> ScalarMappable:
    picture: ScalarMappable = axes.tripcolor(_triangulation(model), facecolors=values, rasterized=True, **style)
    return picture
