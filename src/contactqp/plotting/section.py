"""A section along a row of a lattice: shape, gap and reaction, in the manner of the paper's Figs. 6-8."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .style import BLUE, CONTACT, CONTACT_UPPER, GROUND, INK, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

    from ..foundation.checks import Vector
    from ..models.on_lattice import LatticeModel
    from ..models.records import Answered


def section_axes(part: Figure | SubFigure) -> NDArray[Any]:
    """Return the three panels that `draw_section` fills."""
    axes: NDArray[Any] = part.subplots(3, 1, sharex=True, height_ratios=[3, 1.3, 1.3])
    return axes


def draw_section(axes: NDArray[Any], model: LatticeModel, solution: Answered, row: int, *, noun: str) -> None:
    """Draw deflection and support, gap, and reaction along a row of a lattice.

    Parameters
    ----------
    axes : array of three Axes
        For the shape, the gap, and the reaction.
    model : LatticeModel
        The solution's.
    solution : Solution
    row : int
        Row of the lattice's array.
    noun : str
        What bends, for the legend.
    """
    shape_axes, gap_axes, force_axes = axes
    node_x, number = draw_shape(shape_axes, model, solution, row, noun=noun)
    upper = solution.contact_upper[number]
    clearance = np.where(model.supported[number], solution.gap[number], np.nan)
    gap_axes.plot(node_x, clearance, ".-", color=INK, lw=1, ms=3)
    gap_axes.axhline(0, color=INK, lw=0.6)
    gap_axes.set(ylabel="gap ω")
    reaction, width = solution.reaction[number], max(0.6, min(2.0, 150 / node_x.size))
    for chosen, colour in ((~upper, CONTACT), (upper, CONTACT_UPPER)):
        force_axes.vlines(node_x[chosen], 0, reaction[chosen], color=colour, lw=width)
    force_axes.axhline(0, color=INK, lw=0.6)
    force_axes.set(xlabel="x", ylabel="reaction R")
    for each in axes:
        tidy(each)


def draw_shape(
    axes: Axes, model: LatticeModel, solution: Answered, row: int, *, noun: str
) -> tuple[Vector, NDArray[np.int64]]:
    """Draw deflection and support along a row of a lattice, and return abscissae and numbers of its nodes.

    Parameters
    ----------
    axes : Axes
    model, solution, row, noun
        See `draw_section`.
    """
    lattice = model.lattice
    on_row = lattice.scatter(np.arange(lattice.size), fill=-1)[row].astype(int)
    heights = model.padded_deflection(solution.gap)[row + 1]
    joined = (model.stencil.padded_mask() | model.stencil.frame_points())[row + 1]
    x = lattice.origin[0] + lattice.spacing * np.arange(-1, lattice.shape[1] + 1)
    deflection = np.where(joined, heights, np.nan)
    nodes = on_row >= 0
    node_x, number = lattice.x[nodes], on_row[nodes]
    support = np.full(lattice.shape[1], np.nan)
    support[nodes] = np.where(model.supported[number], model.support[number], np.nan)

    drawn = np.concatenate([deflection[np.isfinite(deflection)], support[np.isfinite(support)]])
    low, high = float(drawn.min()), float(drawn.max())
    margin = 0.12 * (high - low or 1.0)
    top, bottom = (high + margin, low - margin) if model.upwards else (low - margin, high + margin)
    axes.fill_between(lattice.x, support, bottom, color=GROUND, alpha=0.55, lw=0, label="support f")
    axes.plot(x, deflection, color=BLUE, lw=1.8, label=f"{noun} w")
    at_nodes, upper = deflection[1:-1][nodes], solution.contact_upper[number]
    lower = solution.contact_lower[number]
    axes.plot(node_x[lower], at_nodes[lower], ".", color=CONTACT, ms=4, label="in contact")
    if upper.any():
        axes.plot(node_x[upper], at_nodes[upper], ".", color=CONTACT_UPPER, ms=4, label="at the upper bound")
    axes.set_ylim(bottom, top)
    axes.legend(loc="best", frameon=False, fontsize="small")
    axes.set(ylabel=f"height,\n{model.sense}", title="Section")
    tidy(axes)
    return node_x, number
