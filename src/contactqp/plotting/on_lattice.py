"""Pictures of models on a lattice: maps cell by cell, as in the paper's Fig. 5, beside the middle section."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector, finite_number
from ..foundation.loading import load_modules
from ..foundation.pictures import PLAIN, Wanted
from ..models.on_lattice import LatticeModel
from ..models.records import held_reaction
from .section import cut_of_row, draw_section, section_axes
from .states import colours_by_number, draw_legend_of_states, mark_unsupported
from .style import CLEAR, CONTACT, INK, map_height, new_figure, same_scales, tidy, two_halves
from .views import answer_figure, draw_answer, draw_states, draw_values, settling_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    from ..models.records import Answered, Settling


@answer_figure.register(LatticeModel)
def _map_and_section(model: LatticeModel, solution: Answered, wanted: Wanted = PLAIN) -> Figure:
    figure = new_figure(12.5, map_height(model.extent) + 1.0)
    left, right = two_halves(figure)
    draw_answer(model, left, solution)
    row, axes = telling_row(model, [solution], wanted.section), section_axes(right)
    draw_section(axes, cut_of_row(model, solution.gap, row), model, solution)
    mark_section(left.axes[0], model, row)
    axes[0].set_title(title_of_section(model, row, wanted.section))
    return figure


@draw_states.register(LatticeModel)
def _draw_states(model: LatticeModel, axes: Axes, state: NDArray[np.int64], contact: Mask, proven: str) -> None:
    lattice = model.lattice
    colours, low, high = colours_by_number()
    grid = lattice.scatter(state.astype(float))
    axes.pcolormesh(lattice.x, lattice.y, grid, cmap=colours, vmin=low, vmax=high, shading="nearest", rasterized=True)
    _draw_free_boundary(axes, lattice.x, lattice.y, lattice.scatter(contact.astype(float)))
    draw_frame_outline(axes, model)
    draw_legend_of_states(axes, state, proven, mark_unsupported(axes, model))
    axes.set(xlabel="x", ylabel="y", title="Contact map")
    same_scales(axes)
    tidy(axes)


@draw_values.register(LatticeModel)
def _draw_values(model: LatticeModel, axes: Axes, values: Vector, norm: Normalize) -> ScalarMappable:
    lattice = model.lattice
    grid = lattice.scatter(values)
    picture = axes.pcolormesh(lattice.x, lattice.y, grid, cmap="viridis", norm=norm, shading="nearest", rasterized=True)
    draw_frame_outline(axes, model)
    return picture


@settling_figure.register(LatticeModel)
def _settling_figure(model: LatticeModel, touchdown: Settling) -> Figure:
    load_modules("matplotlib.colors", "matplotlib.patches")
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    lattice = model.lattice
    figure = new_figure(8.5, map_height(model.extent, least=3.5, most=7.0) + 1.3)
    axes = figure.subplots()
    early = np.isinf(touchdown.clear) & np.isfinite(touchdown.contact)
    never = np.isinf(touchdown.contact)
    grid = np.ma.masked_invalid(lattice.scatter(touchdown.load))
    picture = axes.pcolormesh(lattice.x, lattice.y, grid, cmap="viridis", shading="nearest", rasterized=True)
    handles: list[Any] = []
    for chosen, colour, label in (
        (early, CONTACT, f"in contact at {touchdown.loads[0]:g} ({np.count_nonzero(early)})"),
        (never, CLEAR, f"not certainly in contact at {touchdown.loads[-1]:g} ({np.count_nonzero(never)})"),
    ):
        if chosen.any():
            mask = np.ma.masked_equal(lattice.scatter(chosen.astype(float), fill=0.0), 0.0)
            axes.pcolormesh(
                lattice.x, lattice.y, mask, cmap=ListedColormap([colour]), shading="nearest", rasterized=True
            )
            handles.append(Patch(color=colour, label=label))
    draw_frame_outline(axes, model)
    figure.colorbar(picture, ax=axes, label="load factor at which the node settles", shrink=0.85)
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False, fontsize="small")
    known = f", known to {touchdown.width:.2g}" if touchdown.width else ""
    axes.set(xlabel="x", ylabel="y", title=f"Touchdown loads{known}")
    same_scales(axes)
    tidy(axes)
    return figure


def _draw_free_boundary(axes: Axes, x: NDArray[Any], y: NDArray[Any], contact: NDArray[Any]) -> None:
    """Draw the edges between nodes in contact and nodes that are not."""
    load_modules("matplotlib.collections")
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
    """Mark the places of the frame that a node is joined to."""
    x, y, _ = model.frame_places
    size = float(np.clip(4000 / max(model.lattice.shape) ** 1.5, 0.2, 14))
    axes.scatter(x, y, s=size, marker="s", color=INK, linewidths=0)


def section_row(model: LatticeModel, place: float | None) -> int:
    """Return the row of a section: the one with nodes that is nearest to a place y (length), by default the middle."""
    if place is None:
        return _middle_row(model.lattice.mask)
    place = finite_number(place, "section")
    y, half = model.lattice.y, model.lattice.spacing / 2
    if not y[0] - half <= place <= y[-1] + half:
        raise ValueError(f"section must lie between y = {y[0]:g} and {y[-1]:g}, got {place:g}")
    rows = np.flatnonzero(model.lattice.mask.any(axis=1))
    return int(rows[np.argmin(np.abs(y[rows] - place))])


def telling_row(model: LatticeModel, solutions: Sequence[Answered], place: float | None) -> int:
    """Return the row of the section of some answers: as `section_row`, but by default one in which a node touches.

    That is the middle row if it touches anywhere in one of the answers, or none does; else the row in which the largest
    reaction is found.
    """
    row = section_row(model, place)
    if place is not None:
        return row
    touching = [np.where(solution.contact, np.abs(held_reaction(solution)), 0.0) for solution in solutions]
    rows = np.max([model.lattice.scatter(reaction, fill=0.0).max(axis=1) for reaction in touching], axis=0)
    return row if rows[row] > 0 or not rows.any() else int(rows.argmax())


def title_of_section(model: LatticeModel, row: int, place: float | None) -> str:
    """Return at which y a section lies, and that another one was asked for where that is between rows."""
    y = float(model.lattice.y[row])
    if place is None or abs(place - y) <= 1e-6 * model.lattice.spacing:
        return f"Section at y = {y:g}"
    return f"Section at y = {y:g}, the row nearest to {place:g}"


def mark_section(axes: Axes, model: LatticeModel, row: int) -> None:
    """Draw where a section runs, as a line that is seen on any colour."""
    y = float(model.lattice.y[row])
    axes.axhline(y, color="white", lw=1.8, alpha=0.6)
    axes.axhline(y, color=INK, lw=0.9, ls="--")


def _middle_row(mask: Mask) -> int:
    """Return the row of most nodes among those in the middle fifth, the nearest to the middle first."""
    middle = (mask.shape[0] - 1) / 2
    count = mask.sum(axis=1)
    distance = np.abs(np.arange(mask.shape[0]) - middle)
    reach = max(distance[count > 0].min(), 0.1 * mask.shape[0])
    candidates = np.flatnonzero((distance <= reach) & (count > 0))
    return int(min(candidates, key=lambda row: (-count[row], distance[row])))
