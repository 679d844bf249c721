"""A section along a line of nodes: shape, gap and reaction, in the manner of the paper's Figs. 6-8."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..models.records import held_reaction
from .style import BLUE, CONTACT, CONTACT_UPPER, GROUND, INK, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

    from ..foundation.checks import Vector
    from ..models.base import ContactModel
    from ..models.on_lattice import LatticeModel
    from ..models.records import Answered


REACTION = "reaction R\n(force per node)"
"""Label of an axis."""


class Cut(NamedTuple):
    """What a section shows of a model in one shape; heights are positive as the model's own.

    Attributes
    ----------
    x, heights : array, shape (k,)
        The curve of nodes and frame, nan where nothing joins them.
    ground_x, ground, ceiling : array, shape (m,)
        The support and the ceiling, nan where there is none.
    frame_x, frame_heights : array
        The points of the frame.
    node_x, number : array, shape (s,)
        Places of the nodes along the section, ascending, and their numbers in the model.
    noun : str
        What bends, for the legend.
    """

    x: Vector
    heights: Vector
    ground_x: Vector
    ground: Vector
    ceiling: Vector
    frame_x: Vector
    frame_heights: Vector
    node_x: Vector
    number: NDArray[np.int64]
    noun: str


def cut_of_row(model: LatticeModel, gap: Vector, row: int) -> Cut:
    """Return the section along a row of a lattice's array, with the gap at the nodes."""
    lattice = model.lattice
    on_row = lattice.scatter(np.arange(lattice.size), fill=-1)[row].astype(int)
    heights = model.padded_deflection(gap)[row + 1]
    frame = model.frame_points()[row + 1]
    joined = model.padded_mask()[row + 1] | frame
    x: Vector = np.asarray(lattice.origin[0] + lattice.spacing * np.arange(-1, lattice.shape[1] + 1))
    if lattice.cuts is not None:
        arms = lattice.frame_arms
        here = arms.along_x & (arms.row == row + 1)
        place, _, height = model.frame_places
        x[arms.column[here]], heights[arms.column[here]] = place[here], height[here]
    nodes = on_row >= 0
    number = on_row[nodes]
    ground, ceiling = np.full((2, lattice.shape[1]), np.nan)
    ground[nodes], ceiling[nodes] = ground_at(model, number), ceiling_at(model, number)
    curve = np.where(joined, heights, np.nan)
    return Cut(x, curve, lattice.x, ground, ceiling, x[frame], heights[frame], lattice.x[nodes], number, model.noun)


def ground_at(model: ContactModel, number: NDArray[np.int64]) -> Vector:
    """Return the heights of the support at some nodes, nan where there is none."""
    return np.where(model.supported[number], model.support[number], np.nan)


def ceiling_at(model: ContactModel, number: NDArray[np.int64]) -> Vector:
    """Return the heights of the ceiling at some nodes, nan where there is none."""
    if model.ceiling is None:
        return np.full(number.size, np.nan)
    return np.where(model.under_ceiling[number], model.ceiling[number], np.nan)


def section_axes(part: Figure | SubFigure) -> NDArray[Any]:
    """Return the three panels that `draw_section` fills."""
    axes: NDArray[Any] = part.subplots(3, 1, sharex=True, height_ratios=[3, 1.3, 1.3])
    return axes


def draw_section(axes: NDArray[Any], cut: Cut, model: ContactModel, solution: Answered, xlabel: str = "x") -> None:
    """Draw deflection and support, gap, and reaction along a section.

    Parameters
    ----------
    axes : array of three Axes
        For the shape, the gap, and the reaction.
    cut : Cut
        The solution's shape.
    model : ContactModel
        The solution's.
    solution : Solution
    xlabel : str
        What the section runs along.
    """
    shape_axes, gap_axes, force_axes = axes
    draw_shape(shape_axes, cut, model, solution)
    node_x, number = cut.node_x, cut.number
    clearance = np.where(model.supported[number], solution.gap[number], np.nan)
    gap_axes.plot(node_x, clearance, ".-", color=INK, lw=1, ms=3)
    gap_axes.axhline(0, color=INK, lw=0.6)
    if model.under_ceiling[number].any():
        room = np.where(model.under_ceiling & model.supported, model.upper, np.nan)[number]
        gap_axes.plot(node_x, room, color=CONTACT_UPPER, lw=0.9, ls="--", label="up to the ceiling")
        gap_axes.legend(loc="best", frameon=False, fontsize="small")
    elif not np.isfinite(clearance).any():
        _tell_nothing(gap_axes, "no support here, and no gap")
    gap_axes.set(ylabel="gap ω")
    draw_reaction(force_axes, cut, solution)
    force_axes.set(xlabel=xlabel)
    for each in axes:
        tidy(each)
    for each in axes[1:]:
        each.yaxis.label.set_fontsize("small")


def draw_reaction(axes: Axes, cut: Cut, solution: Answered) -> None:
    """Draw the reaction at each node of a section."""
    node_x, number = cut.node_x, cut.number
    upper, held = solution.contact_upper[number], held_reaction(solution)
    reaction, width = held[number], max(0.6, min(2.0, 150 / node_x.size))
    for chosen, colour in ((~upper, CONTACT), (upper, CONTACT_UPPER)):
        chosen = chosen & (reaction != 0)
        axes.vlines(node_x[chosen], 0, reaction[chosen], color=colour, lw=width)
    axes.axhline(0, color=INK, lw=0.6)
    # The scale is that of the whole answer: beside its largest reaction, what rounding leaves is nothing.
    low, high = min(0.0, float(held.min())), max(0.0, float(held.max()))
    margin = 0.08 * (high - low)
    if margin:
        axes.set_ylim(low - margin if low else -0.4 * margin, high + margin if high else 0.4 * margin)
    else:
        axes.set(ylim=(-0.05, 1.0))
        _tell_nothing(axes, "no node touches")
    axes.set(ylabel=REACTION)


def _tell_nothing(axes: Axes, words: str) -> None:
    """Write in a panel why there is nothing in it."""
    axes.text(0.5, 0.55, words, transform=axes.transAxes, ha="center", fontsize="small", color=INK)
    axes.set_yticks([0.0])


def draw_shape(axes: Axes, cut: Cut, model: ContactModel, solution: Answered) -> None:
    """Draw deflection, support and ceiling along a section.

    Parameters
    ----------
    axes : Axes
    cut, model, solution
        See `draw_section`.
    """
    drawn = np.concatenate([line[np.isfinite(line)] for line in (cut.heights, cut.ground, cut.ceiling)])
    low, high = float(drawn.min()), float(drawn.max())
    margin = 0.12 * (high - low or 1.0)
    top, bottom = (high + margin, low - margin) if model.upwards else (low - margin, high + margin)
    # Deeper than is seen, for films, whose pictures get one scale afterwards.
    foot = bottom + 100 * (bottom - top)
    draw_ground(axes, cut, foot)
    draw_ceiling(axes, cut, top + 100 * (top - bottom))
    axes.plot(cut.x, cut.heights, color=BLUE, lw=1.8, label=f"{cut.noun} w")
    at_nodes, upper = solution.deflection[cut.number], solution.contact_upper[cut.number]
    lower = solution.contact_lower[cut.number]
    if lower.any():
        axes.plot(cut.node_x[lower], at_nodes[lower], ".", color=CONTACT, ms=4, label="in contact")
    if upper.any():
        axes.plot(cut.node_x[upper], at_nodes[upper], ".", color=CONTACT_UPPER, ms=4, label="at the upper bound")
    axes.set_ylim(bottom, top)
    axes.legend(loc="best", frameon=False, fontsize="small")
    axes.set(ylabel=f"height,\n{model.sense}", title="Section")
    tidy(axes)


def draw_ground(axes: Axes, cut: Cut, foot: float) -> None:
    """Draw the support of a section, if there is one, as a body that goes down to some height."""
    if np.isfinite(cut.ground).any():
        axes.fill_between(cut.ground_x, cut.ground, foot, color=GROUND, alpha=0.55, lw=0, label="support f")


def draw_ceiling(axes: Axes, cut: Cut, top: float) -> None:
    """Draw the ceiling of a section, if there is one, as a body that goes up to some height."""
    if np.isfinite(cut.ceiling).any():
        axes.fill_between(
            cut.ground_x, cut.ceiling, top, facecolor="none", edgecolor=GROUND, hatch="////", lw=0, label="ceiling c"
        )
        axes.plot(cut.ground_x, cut.ceiling, color=GROUND, lw=1.2)
