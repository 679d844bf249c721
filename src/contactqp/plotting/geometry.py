"""Pictures of frames and lattices: what is node, what is frame, and which way rows are counted."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.loading import load_modules
from ..foundation.pictures import Wanted, drawn
from ..geometry.fields import Rows
from ..geometry.frame import Frame
from ..geometry.lattice import Lattice
from .style import BLUE, CLEAR, GROUND, INK, map_height, new_figure, same_scales, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@drawn.register(Frame)
def _frame_figure(frame: Frame, wanted: Wanted) -> Figure:
    left, bottom, right, top = frame.geometry.bounds
    axes = axes_for(wanted, (right - left, top - bottom))
    _draw_outline(axes, frame)
    axes.autoscale_view()
    finish(axes, wanted, f"{frame!r}, area {frame.area:.4g}")
    return figure_of(axes)


@drawn.register(Lattice)
def _lattice_figure(lattice: Lattice, wanted: Wanted) -> Figure:
    rows, columns = lattice.shape
    axes = axes_for(wanted, (columns, rows))
    size = float(np.clip(6000 / lattice.mask.size, 0.4, 30))
    if lattice.cuts is None:
        row, column = np.nonzero(~lattice.mask)
        frame_x, frame_y = lattice.x[column], lattice.y[row]
    else:
        frame_x, frame_y = lattice.frame_places
    axes.scatter(frame_x, frame_y, s=size, marker="x", lw=0.6, color=GROUND)
    axes.scatter(lattice.node_x, lattice.node_y, s=size, color=BLUE, lw=0)
    axes.plot(lattice.node_x[0], lattice.node_y[0], "o", ms=9, mfc="none", color=INK, label="node 0")
    mark_rows(axes, lattice)
    finish(axes, wanted, f"{lattice!r}: dots are nodes, crosses frame")
    return figure_of(axes)


def _draw_outline(axes: Axes, frame: Frame) -> None:
    load_modules("matplotlib.patches", "matplotlib.path")
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    for part in getattr(frame.geometry, "geoms", [frame.geometry]):
        rings = [part.exterior, *part.interiors]
        outline = Path.make_compound_path(*(Path(np.asarray(ring.coords), closed=True) for ring in rings))
        axes.add_patch(PathPatch(outline, facecolor=CLEAR, edgecolor=INK, lw=1.4))


def mark_rows(axes: Axes, lattice: Lattice, given: Rows = "up") -> None:
    """Write which way the rows and columns of an array on the lattice are counted.

    Parameters
    ----------
    axes : Axes
    lattice : Lattice
    given : {"up", "down"}
        Which way the rows of the arrays go that are given. Those of the lattice's own arrays, which come out, go up.
    """
    rows, columns = lattice.shape
    last = rows - 1
    ends = [(0, "row 0"), (last, f"row {last}")] if given == "up" else [(last, "row 0"), (0, f"row {last}")]
    if given == "down":
        ends = [(row, f"{text} of\nthe data given") for row, text in ends]
    ends = ends[: min(rows, 2)]
    marks: dict[str, Any] = {"color": INK, "fontsize": "small", "annotation_clip": False}
    for row, text in ends:
        place = (1.01, lattice.y[row])
        # Two lines stand beside the map, clear of the columns' marks.
        upright = "center" if given == "up" else "top" if row == last else "bottom"
        axes.annotate(text, place, xycoords=("axes fraction", "data"), va=upright, ha="left", **marks)
    for column, text in ((0, "column 0"), (columns - 1, f"column {columns - 1}")):
        place = (lattice.x[column], 1.01)
        axes.annotate(text, place, xycoords=("data", "axes fraction"), va="bottom", ha="center", **marks)


def axes_for(wanted: Wanted, extent: tuple[float, float]) -> Axes:
    """Return the axes that a map is to be drawn into: the user's, or those of a new figure."""
    if wanted.ax is not None:
        axes: Axes = wanted.ax
        return axes
    return new_figure(7, map_height(extent) + 0.8).subplots()


def figure_of(axes: Axes) -> Figure:
    """Return the figure that axes belong to."""
    figure: Any = axes.get_figure(root=True)
    return figure  # type: ignore[no-any-return]


def finish(axes: Axes, wanted: Wanted, title: str) -> None:
    """Label a map's axes, with a title of its own unless another is wanted."""
    axes.set(xlabel=wanted.label("x"), ylabel=wanted.label("y"))
    same_scales(axes)
    axes.set_title(title if wanted.title is None else wanted.title, fontsize="medium", pad=20)
    tidy(axes)
