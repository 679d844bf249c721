"""Views in space of membranes: the deflected surface over its support, or the support alone before solving."""

from __future__ import annotations

from functools import singledispatch
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.loading import load_modules
from ..foundation.pictures import Wanted, drawn_in_space
from ..models.base import ContactModel
from ..models.on_area import AreaModel
from ..models.records import NodeState
from .states import STATE_COLOURS, seen
from .style import BLUE, GROUND, INK, head, new_figure, tidy_in_space

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..models.records import Answered

_FINEST = 90
"""Facets along a side of a surface."""


@drawn_in_space.register(AreaModel)
def _support_in_space(membrane: AreaModel, wanted: Wanted) -> Figure:
    axes = axes_in_space(wanted)
    _draw_surface(axes, membrane, _laid(membrane, membrane.support), GROUND, 0.85)
    _draw_frame(axes, membrane)
    finish_in_space(axes, membrane, wanted)
    title = f"{type(membrane).__name__}, {membrane.size} nodes: frame and support"
    return title_in_space(axes, wanted, title)


@singledispatch
def answer_in_space(model: Any, solution: Answered, wanted: Wanted) -> Figure:
    """Draw what a model deflects to in space.

    Raises
    ------
    TypeError
        If there is no such picture of the model.
    """
    raise TypeError(
        f"a view in space needs a Membrane, a MeshMembrane or a Plate, this solution is of {model!r}; use plot()"
    )


@answer_in_space.register(AreaModel)
def _membrane_in_space(membrane: AreaModel, solution: Answered, wanted: Wanted) -> Figure:
    """Draw the deflected membrane between support and ceiling, facets in contact in their own colours."""
    axes = axes_in_space(wanted)
    heights = membrane.padded_deflection(solution.gap)
    joined = membrane.padded_mask() | membrane.frame_points()
    surface = np.where(joined, heights, np.nan)
    state, _ = seen(solution)
    held = np.pad(membrane.lattice.scatter(np.maximum(state, 0), fill=0), 1)
    _draw_surface(axes, membrane, surface, BLUE, 1.0, held)
    below = _laid(membrane, membrane.support)
    known = surface[np.isfinite(surface)]
    reach, lowest = float(np.ptp(known)) or 1.0, membrane.lowest(known)
    # A support that lies deep would flatten the membrane.
    plane = lowest - reach if membrane.upwards else lowest + reach
    cut = _cut_off(below, plane, membrane.upwards)
    _draw_surface(axes, membrane, below, GROUND, 0.25)
    if membrane.ceiling is not None:
        above = _laid(membrane, membrane.ceiling)
        highest = float(known.max() if membrane.upwards else known.min())
        _cut_off(above, highest + reach if membrane.upwards else highest - reach, not membrane.upwards)
        _draw_surface(axes, membrane, above, GROUND, 0.15)
    _draw_frame(axes, membrane)
    finish_in_space(axes, membrane, wanted)
    told = f"\nThe support goes on below {plane:.3g}." if cut else ""
    return title_in_space(axes, wanted, f"{solution.backend}: deflection over the support, heights not to scale{told}")


def _cut_off(heights: NDArray[Any], plane: float, upwards: bool) -> bool:
    """Cut a surface off at a plane, in place, and return whether anything lay below it.

    What lies below the plane is left out, but for the points next to what is seen, which are moved up to it: so the
    surface ends at the plane and not wherever its last facet did.
    """
    seen = np.isfinite(heights) & (heights >= plane if upwards else heights <= plane)
    below = np.isfinite(heights) & ~seen
    beside = np.zeros_like(seen)
    ring = np.pad(seen, 1)
    rows, columns = seen.shape
    for row, column in np.ndindex(3, 3):
        beside |= ring[row : row + rows, column : column + columns]
    heights[below] = np.where(beside[below], plane, np.nan)
    return bool(below.any())


def _laid(membrane: AreaModel, values: NDArray[Any]) -> NDArray[Any]:
    grid = membrane.lattice.scatter(np.where(np.isfinite(values), values, np.nan))
    return np.pad(grid, 1, constant_values=np.nan)


def axes_in_space(wanted: Wanted) -> Any:
    """Return axes in space: those that are wanted, or of a new figure."""
    load_modules("mpl_toolkits.mplot3d.axes3d")
    if wanted.ax is None:
        return new_figure(7.5, 5).add_subplot(projection="3d")
    if getattr(wanted.ax, "name", "") != "3d":
        raise TypeError('ax must be axes in space; make them by figure.add_subplot(projection="3d")')
    return wanted.ax


def _draw_surface(
    axes: Any, membrane: AreaModel, heights: NDArray[Any], colour: str, alpha: float, held: Any = None
) -> None:
    if not np.isfinite(heights).any():
        return
    load_modules("matplotlib.colors")
    from matplotlib.colors import to_rgba

    lattice = membrane.lattice
    step = -(-max(heights.shape) // _FINEST)
    rows, columns = (np.unique([*range(0, size, step), size - 1]) for size in heights.shape)
    x = lattice.origin[0] + lattice.spacing * (columns - 1.0)
    y = lattice.origin[1] + lattice.spacing * (rows - 1.0)
    colours = np.broadcast_to(to_rgba(colour, alpha), (rows.size, columns.size, 4)).copy()
    if held is not None:
        for state in (NodeState.CONTACT, NodeState.CONTACT_UPPER):
            colours[held[np.ix_(rows, columns)] == state] = to_rgba(STATE_COLOURS[state], alpha)
    grid_x, grid_y = np.meshgrid(x, y)
    axes.plot_surface(
        *(grid_x, grid_y, heights[np.ix_(rows, columns)]),
        facecolors=colours,
        rstride=1,
        cstride=1,
        linewidth=0.15,
        edgecolor=(1, 1, 1, 0.25),
        shade=True,
    )


def _draw_frame(axes: Any, membrane: AreaModel) -> None:
    axes.scatter(*membrane.frame_places, s=3, color=INK, depthshade=False)


def finish_in_space(axes: Any, membrane: ContactModel, wanted: Wanted) -> None:
    """Label the axes, and let heights go the model's way."""
    if not membrane.upwards:
        axes.invert_zaxis()
    axes.set(xlabel=wanted.label("x"), ylabel=wanted.label("y"), zlabel=wanted.label(f"height, {membrane.sense}"))
    axes.set_box_aspect((1, 1, 0.5), zoom=1.1)
    tidy_in_space(axes)


def title_in_space(axes: Any, wanted: Wanted, title: str) -> Figure:
    """Write the headline that is wanted, or the own one, and return the figure."""
    figure: Figure = axes.get_figure(root=True)
    text = title if wanted.title is None else wanted.title
    if wanted.ax is None:
        head(figure, text)
    else:
        axes.set_title(text, fontsize="medium")
    return figure
