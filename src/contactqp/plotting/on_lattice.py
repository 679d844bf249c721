"""Contact maps and sections of models on a lattice, in the manner of the paper's Figs. 5-8."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask
from ..models.on_lattice import LatticeModel
from .states import draw_legend_of_states, seen
from .style import BLUE, CLEAR, CONTACT, GROUND, INK, UNDECIDED, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..models.records import Answered, Enclosed


def draw_bounds(axes: Axes, certificate: Enclosed, model: LatticeModel, state: NDArray[np.int64]) -> None:
    """Draw the bounds of the gap along a cable, and the states of its nodes."""
    x = model.lattice.node_x
    known = np.isfinite(certificate.lower) & np.isfinite(certificate.upper) & model.supported
    lower, upper = (np.where(known, bound, np.nan) for bound in (certificate.lower, certificate.upper))
    axes.fill_between(x, lower, upper, color=BLUE, alpha=0.3, lw=0, label="between the bounds of the gap")
    axes.plot(x, upper, color=BLUE, lw=1)
    for k, label in enumerate(("certainly clear", "certainly in contact", "undecided")):
        chosen = state == k
        if k < 2 or chosen.any():
            axes.plot(
                x[chosen], upper[chosen], "o", ms=4, mec=INK, mew=0.4, color=(CLEAR, CONTACT, UNDECIDED)[k],
                label=f"{label} ({np.count_nonzero(chosen)})",
            )  # fmt: skip
    axes.axhline(0, color=INK, lw=0.6)
    figure: Any = axes.get_figure(root=False)
    figure.legend(loc="outside lower center", ncols=4, frameon=False, fontsize="small")
    axes.set(xlabel="x", ylabel="gap ω")
    tidy(axes)


def draw_contact_map(axes: Axes, solution: Answered, model: LatticeModel) -> None:
    """Draw which nodes are certainly in contact, certainly clear, or undecided, and the free boundary."""
    state, proven = seen(solution)
    draw_states(axes, model, state, solution.contact, proven)


def draw_states(axes: Axes, model: LatticeModel, state: NDArray[np.int64], contact: Mask, proven: str) -> None:
    """Draw the nodes' states, 0 clear, 1 in contact, 2 undecided, and the boundary of a contact set."""
    from matplotlib.colors import ListedColormap

    lattice = model.lattice
    grid = lattice.scatter(state.astype(float))
    axes.pcolormesh(
        lattice.x,
        lattice.y,
        grid,
        cmap=ListedColormap([CLEAR, CONTACT, UNDECIDED]),
        vmin=-0.5,
        vmax=2.5,
        shading="nearest",
        rasterized=True,
    )
    _draw_free_boundary(axes, lattice.x, lattice.y, lattice.scatter(contact.astype(float)))
    draw_frame_outline(axes, model)
    draw_legend_of_states(axes, state, proven)
    axes.set(aspect="equal", xlabel="x", ylabel="y", title="Contact map")
    tidy(axes)


def draw_section(axes: NDArray[Any], solution: Answered, model: LatticeModel, row: int | None = None) -> None:
    """Draw deflection and support, gap, and reaction along a row of the net, by default the middle one.

    Parameters
    ----------
    axes : array of three Axes
        For the shape, the gap, and the reaction.
    solution : Solution
    model : LatticeModel
        The solution's.
    row : int, optional
        Row of the lattice's array; by default the row with nodes that is nearest to the middle.
    """
    lattice = model.lattice
    row = _middle_row(lattice.mask) if row is None else row
    on_row = lattice.scatter(np.arange(lattice.size), fill=-1)[row].astype(int)
    heights = model.padded_deflection(solution.gap)[row + 1]
    joined = (model.stencil.padded_mask() | model.stencil.frame_points())[row + 1]
    x = lattice.origin[0] + lattice.spacing * np.arange(-1, lattice.shape[1] + 1)
    deflection = np.where(joined, heights, np.nan)
    nodes = on_row >= 0
    node_x, number = lattice.x[nodes], on_row[nodes]
    support = np.full(lattice.shape[1], np.nan)
    support[nodes] = np.where(np.isfinite(model.support[number]), model.support[number], np.nan)

    shape_axes, gap_axes, force_axes = axes
    drawn = np.concatenate([deflection[np.isfinite(deflection)], support[np.isfinite(support)]])
    low, high = float(drawn.min()), float(drawn.max())
    margin = 0.12 * (high - low or 1.0)
    shape_axes.fill_between(lattice.x, support, high + margin, color=GROUND, alpha=0.55, lw=0, label="support f")
    shape_axes.plot(x, deflection, color=BLUE, lw=1.8, label="membrane w" if not model.is_line else "cable w")
    touching = solution.contact[number]
    shape_axes.plot(node_x[touching], deflection[1:-1][nodes][touching], ".", color=CONTACT, ms=4, label="in contact")
    shape_axes.set_ylim(high + margin, low - margin)
    shape_axes.legend(loc="best", frameon=False, fontsize="small")
    where = "" if model.is_line else f" at y = {lattice.y[row]:g}"
    shape_axes.set(ylabel="ordinate, downwards", title=f"Section{where}")
    clearance = np.where(model.supported[number], solution.gap[number], np.nan)
    gap_axes.plot(node_x, clearance, ".-", color=INK, lw=1, ms=3)
    gap_axes.axhline(0, color=INK, lw=0.6)
    gap_axes.set(ylabel="gap ω")
    force_axes.vlines(node_x, 0, solution.reaction[number], color=CONTACT, lw=max(0.6, min(2.0, 150 / node_x.size)))
    force_axes.axhline(0, color=INK, lw=0.6)
    force_axes.set(xlabel="x", ylabel="reaction R")
    for each in axes:
        tidy(each)


def _draw_free_boundary(axes: Axes, x: NDArray[Any], y: NDArray[Any], contact: NDArray[Any]) -> None:
    """Draw the edges between nodes in contact and nodes that are not."""
    from matplotlib.collections import LineCollection

    half_x = (x[1] - x[0]) / 2 if x.size > 1 else 0.5
    half_y = (y[1] - y[0]) / 2 if y.size > 1 else 0.5
    segments: list[Any] = []
    row, column = np.nonzero(np.abs(np.diff(contact, axis=1)) == 1)
    middle = (x[column] + x[column + 1]) / 2
    segments += list(
        np.stack([np.column_stack([middle, y[row] - half_y]), np.column_stack([middle, y[row] + half_y])], 1)
    )
    row, column = np.nonzero(np.abs(np.diff(contact, axis=0)) == 1)
    middle = (y[row] + y[row + 1]) / 2
    segments += list(
        np.stack([np.column_stack([x[column] - half_x, middle]), np.column_stack([x[column] + half_x, middle])], 1)
    )
    if segments:
        axes.add_collection(LineCollection(segments, colors=INK, linewidths=1.0, capstyle="round"))


def draw_frame_outline(axes: Axes, model: LatticeModel) -> None:
    """Mark the frame points that a node is joined to."""
    row, column = np.nonzero(model.stencil.frame_points())
    lattice = model.lattice
    x, y = lattice.ring_coordinates(row, column)
    size = float(np.clip(4000 / max(lattice.shape) ** 1.5, 0.2, 14))
    axes.scatter(x, y, s=size, marker="s", color=INK, linewidths=0)


def _middle_row(mask: Mask) -> int:
    """Return the row of most nodes among those in the middle fifth, the nearest to the middle first."""
    middle = (mask.shape[0] - 1) / 2
    count = mask.sum(axis=1)
    distance = np.abs(np.arange(mask.shape[0]) - middle)
    reach = max(distance[count > 0].min(), 0.1 * mask.shape[0])
    candidates = np.flatnonzero((distance <= reach) & (count > 0))
    return int(min(candidates, key=lambda row: (-count[row], distance[row])))
