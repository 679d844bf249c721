"""Views in space of membranes on meshes of triangles: the deflected mesh over its support, or the support alone."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..foundation.loading import load_modules
from ..foundation.pictures import Wanted, drawn_in_space
from ..models.mesh_membrane import MeshMembrane
from ..models.records import NodeState
from .on_mesh import states_of_triangles
from .space import answer_in_space, axes_in_space, finish_in_space, title_in_space
from .states import STATE_COLOURS, seen
from .style import BLUE, GROUND, INK

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..models.records import Answered


@drawn_in_space.register(MeshMembrane)
def _support_in_space(model: MeshMembrane, wanted: Wanted) -> Figure:
    axes = axes_in_space(wanted)
    _draw_triangles(axes, model, *_known(model, model.support), GROUND, 0.85)
    _draw_fixed_points(axes, model)
    finish_in_space(axes, model, wanted)
    title = f"{type(model).__name__}, {model.size} nodes: fixed points and support"
    return title_in_space(axes, wanted, title)


@answer_in_space.register(MeshMembrane)
def _answer_in_space(model: MeshMembrane, solution: Answered, wanted: Wanted) -> Figure:
    axes = axes_in_space(wanted)
    heights = model.point_heights(solution.deflection)
    colours = np.full(len(model.triangles), BLUE, dtype=object)
    states = states_of_triangles(model, seen(solution)[0])
    for state in (NodeState.CONTACT, NodeState.CONTACT_UPPER):
        colours[states == state] = STATE_COLOURS[state]
    _draw_triangles(axes, model, heights, np.ones(len(model.triangles), dtype=np.bool_), colours, 1.0)
    # Surfaces that lie far off would flatten the membrane.
    reach = float(np.ptp(heights)) or 1.0
    below, shown, cut = _cut_off(*_known(model, model.support), model, heights.min() - reach, heights.max() + reach)
    _draw_triangles(axes, model, below, shown, GROUND, 0.25)
    if model.ceiling is not None:
        above, shown, _ = _cut_off(*_known(model, model.ceiling), model, heights.min() - reach, heights.max() + reach)
        _draw_triangles(axes, model, above, shown, GROUND, 0.15)
    _draw_fixed_points(axes, model)
    finish_in_space(axes, model, wanted)
    plane = heights.min() - reach if model.upwards else heights.max() + reach
    told = f"\nThe support goes on below {plane:.3g}." if cut else ""
    return title_in_space(axes, wanted, f"{solution.backend}: deflection over the support, heights not to scale{told}")


def _known(model: MeshMembrane, values: Vector) -> tuple[Vector, Mask]:
    """Return heights of all points, nan where none is known, and the triangles at whose corners they all are."""
    heights = np.full(len(model.positions), np.nan)
    heights[model.free] = np.where(np.isfinite(values), values, np.nan)
    return heights, np.isfinite(heights[model.triangles]).all(axis=1)


def _cut_off(heights: Vector, shown: Mask, model: MeshMembrane, low: float, high: float) -> tuple[Vector, Mask, bool]:
    """Return a surface between two planes, the triangles that reach between them, and whether others are left out."""
    between = (heights >= low) & (heights <= high)
    seen_in_part = shown & between[model.triangles].any(axis=1)
    return np.clip(heights, low, high), seen_in_part, bool((np.isfinite(heights) & ~between).any())


def _draw_triangles(
    axes: Any, model: MeshMembrane, heights: Vector, shown: Mask, colour: str | NDArray[Any], alpha: float
) -> None:
    if not shown.any():
        return
    load_modules("mpl_toolkits.mplot3d.art3d", "matplotlib.colors")
    from matplotlib.colors import to_rgba_array
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    corners = np.column_stack([model.positions, heights])[model.triangles[shown]]
    own = np.broadcast_to(np.asarray(colour, dtype=object), (len(shown),))[shown]
    colours = to_rgba_array(own.astype(str))
    colours[:, 3] = alpha
    faces = Poly3DCollection(corners, facecolors=colours, edgecolors=(1, 1, 1, 0.25), linewidths=0.15, shade=True)
    axes.add_collection3d(faces)
    axes.auto_scale_xyz(*np.moveaxis(corners, 2, 0), axes.has_data())


def _draw_fixed_points(axes: Any, model: MeshMembrane) -> None:
    x, y = model.positions[model.fixed].T
    axes.scatter(x, y, model.fixed_height, s=3, color=INK, depthshade=False)
