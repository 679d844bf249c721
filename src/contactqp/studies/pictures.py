"""The picture of a study: errors over the spacing, both logarithmic."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ..plotting.style import BLUE, CONTACT, CONTACT_UPPER, GROUND, INK, new_figure, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..foundation.checks import Vector
    from .errors import Errors

_LINES = {
    "deflection": ("largest error of the deflection", "o-", BLUE),
    "reaction": ("reaction, of the whole", "s-", CONTACT),
    "contact_area": ("contact area, of it", "^-", CONTACT_UPPER),
    "free_boundary": ("distance from the free boundary", "v-", GROUND),
}


def study_figure(study: Errors) -> Figure:
    """Return the figure; a quantity of which nothing is known, or whose errors are all zero, is left out."""
    figure = new_figure(8.4, 4.4)
    axes = figure.subplots()
    spacing = np.array([row.spacing for row in study.rows])
    for quantity, (label, style, colour) in _LINES.items():
        error = np.array([getattr(row, quantity) for row in study.rows])
        seen = error > 0
        if not seen.any():
            continue
        order = study.order(quantity)
        told = f"{label}, order {order:.2f}" if math.isfinite(order) else label
        axes.loglog(spacing[seen], error[seen], style, color=colour, markersize=5, label=told)
    falling = [getattr(row, name) for name in _LINES if math.isfinite(study.order(name)) for row in study.rows]
    if falling:
        level = math.exp(np.log([error for error in falling if error > 0]).mean())
        for power in (1, 2):
            _slope(axes, spacing, level, power)
    axes.set_xticks(spacing, [f"{value:.3g}" for value in spacing])
    axes.set_xticks([], minor=True)
    axes.set(xlabel="spacing (length)", ylabel="error")
    axes.set_title(f"{study.name}: errors against the closed form", loc="left", fontsize="medium", color=INK)
    axes.legend(frameon=False, fontsize="small", loc="upper left", bbox_to_anchor=(1.0, 1.0))
    tidy(axes)
    return figure


def _slope(axes: Axes, spacing: Vector, level: float, power: int) -> None:
    """Draw a line of an order amid the errors that have one, and name it at its coarse end."""
    centre = math.sqrt(spacing.min() * spacing.max())
    values = level * (spacing / centre) ** power
    axes.loglog(spacing, values, ":", color=INK, linewidth=0.9)
    axes.annotate(
        f"order {power}",
        (spacing[0], values[0]),
        xytext=(4, 0),
        textcoords="offset points",
        fontsize="x-small",
        va="center",
    )
