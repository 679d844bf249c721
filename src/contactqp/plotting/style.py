"""Colours and figures that all pictures share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure


CONTACT, CLEAR, UNDECIDED, INK = "#c8553d", "#dfe7ec", "#f2c14e", "#22333b"

BLUE, GROUND = "#2f6690", "#b9a88f"


def new_figure(width: float, height: float) -> Figure:
    """Return a figure that belongs to no window and shows itself in a notebook."""
    from io import BytesIO

    from matplotlib.figure import Figure

    class Picture(Figure):
        def _repr_png_(self) -> bytes:
            buffer = BytesIO()
            self.savefig(buffer, format="png", dpi=90)
            return buffer.getvalue()

    return Picture(figsize=(width, height), layout="constrained")


def head(figure: Figure, text: str) -> None:
    """Write a headline, with room below it that the titles of subfigures cannot take."""
    figure.suptitle(text + "\n", x=0.01, ha="left", fontsize="large", color=INK)


def section_axes(part: Figure | SubFigure) -> NDArray[Any]:
    """Return the three panels that `draw_section` fills."""
    axes: NDArray[Any] = part.subplots(3, 1, sharex=True, height_ratios=[3, 1.3, 1.3])
    return axes


def plan_height(positions: NDArray[np.float64]) -> float:
    """Return the height of a figure whose left half shows these points in plan, shape (n, 2)."""
    width, height = np.ptp(positions, axis=0)
    return float(np.clip(6.5 * height / (width or height), 3.6, 6.5))


def two_halves(figure: Figure) -> tuple[SubFigure, SubFigure]:
    """Return the left and the right part of a figure, the left one a little wider."""
    halves: Any = figure.subfigures(1, 2, width_ratios=[1.15, 1])
    return halves[0], halves[1]


def tidy(axes: Axes) -> None:
    """Leave out what a picture does not need."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize="small")
