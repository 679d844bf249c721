"""Colours and figures that all pictures share."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.loading import load_modules

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

    from ..foundation.checks import Vector


CONTACT, CLEAR, UNDECIDED, INK = "#c8553d", "#dfe7ec", "#f2c14e", "#22333b"

CONTACT_UPPER = "#7a4e9c"
"""In contact with the upper bound."""

BLUE, GROUND = "#2f6690", "#b9a88f"


_ROOM = 0.09
"""Inches about the parts of a figure, so that no axis runs to its edge and no label to a legend."""


def new_figure(width: float, height: float) -> Figure:
    """Return a figure that belongs to no window and shows itself in a notebook."""
    from io import BytesIO

    load_modules("matplotlib.figure")
    from matplotlib.figure import Figure

    class Picture(Figure):
        def _repr_png_(self) -> bytes:
            buffer = BytesIO()
            self.savefig(buffer, format="png", dpi=90)
            return buffer.getvalue()

    picture = Picture(figsize=(width, height), layout="constrained")
    engine: Any = picture.get_layout_engine()
    engine.set(w_pad=_ROOM, h_pad=_ROOM)
    return picture


def head(figure: Figure, text: str) -> None:
    """Write a headline in lines that fit, with room below it that the titles of subfigures cannot take."""
    room = int(_LETTERS * figure.get_figwidth())
    lines = "\n".join(fill(line, room) for line in text.splitlines())
    figure.suptitle(lines + "\n", x=0.01, ha="left", fontsize="large", color=INK)


_LETTERS = 10.2
"""Letters of a headline that an inch has room for."""


def map_height(extent: tuple[float, float], full: float = 6.5, *, least: float = 3.6, most: float = 6.5) -> float:
    """Return the height of a map (inches) of something with this width and height.

    Parameters
    ----------
    extent : (float, float)
        Width and height in plan.
    full, least, most : float
        Height of the map of a square, and the bounds of any map's.
    """
    width, height = extent
    return float(np.clip(full * height / (width or height or 1.0), least, most))


def tidy_in_space(axes: Any) -> None:
    """Look at axes in space from the side, and leave out what a picture does not need."""
    axes.view_init(elev=32, azim=-60)
    axes.tick_params(labelsize="small")
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.pane.set_visible(False)
        axis.line.set_color(INK)
    axes.grid(visible=False)


def bar_of_heights(
    axes: Axes,
    picture: Any,
    heights: Vector,
    label: str,
    *,
    upwards: bool,
    rounding: float = 0.0,
    shrink: float = 0.85,
    pad: float = 0.05,
) -> None:
    """Draw the scale of heights by colour beside a map: down is down, and of one height there is that alone.

    Parameters
    ----------
    axes : Axes
        Of the map.
    picture : ScalarMappable
    heights : array
        All that the map shows (length).
    label : str
    upwards : bool
        Whether heights are positive upwards.
    rounding : float
        What counts as zero (length).
    shrink, pad : float
        As for matplotlib's colour bars.
    """
    load_modules("matplotlib.colors")
    from matplotlib.colors import ListedColormap

    figure: Any = axes.get_figure(root=False)
    largest = float(np.abs(heights).max())
    if np.ptp(heights) <= max(_LEVEL * largest, rounding):
        # One height has no scale.
        picture.set_cmap(ListedColormap([picture.get_cmap()(0.5)]))
        level = float(heights.min()) if largest > rounding else 0.0
        picture.set_clim(level - 1.0, level + 1.0)
        bar = figure.colorbar(picture, ax=axes, shrink=shrink, pad=pad, label=label)
        bar.ax.set_yticks([level], [f"{level:g}"])
        bar.ax.minorticks_off()
    else:
        bar = figure.colorbar(picture, ax=axes, shrink=shrink, pad=pad, label=label)
    if not upwards:
        bar.ax.invert_yaxis()
    bar.ax.tick_params(labelsize="small")


_LEVEL = 1e-9
"""Part of their size by which heights may vary and be level."""

_IN_A_LINE = 0.02
"""Ratio of the sides below which what a map shows lies in a line."""


def same_scales(axes: Axes) -> None:
    """Give both directions of a map one scale, unless all that it shows lies in a line: then there were no room."""
    sides = np.abs(axes.dataLim.size)
    in_a_line = bool(np.isfinite(sides).all() and sides.min() <= _IN_A_LINE * sides.max())
    axes.set_aspect("auto" if in_a_line else "equal")


def two_halves(figure: Figure) -> tuple[SubFigure, SubFigure]:
    """Return the left and the right part of a figure, the left one a little wider."""
    halves: Any = figure.subfigures(1, 2, width_ratios=[1.15, 1])
    return halves[0], halves[1]


def tidy(axes: Axes) -> None:
    """Leave out what a picture does not need."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize="small")
