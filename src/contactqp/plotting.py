"""Pictures: contact maps and middle sections, in the manner of the paper's Figs. 5-8."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._checks import Mask
from .model import TensionedNet
from .rounding import at_most

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

    from .certificate import Certificate
    from .model import ContactModel
    from .solution import Solution

CONTACT, CLEAR, UNDECIDED, INK = "#c8553d", "#dfe7ec", "#f2c14e", "#22333b"
BLUE, GROUND = "#2f6690", "#b9a88f"


def plot_solution(solution: Solution) -> Figure:
    """Draw a solution: for a membrane its contact map beside the middle section, for a cable the section alone.

    A cable net is drawn in plan and in space.
    """
    from .cable_net import CableNet

    model = solution.model
    if isinstance(model, CableNet):
        from .plotting_net import draw_in_space, draw_plan

        figure = new_figure(12.5, plan_height(model.positions) + 1.0)
        left, right = two_halves(figure)
        draw_plan(left.subplots(), model, *seen(solution))
        draw_in_space(right, solution, model)
    elif not isinstance(model, TensionedNet):
        figure = new_figure(7, 4.4)
        draw_sorted_gap(figure.subplots(), solution)
    elif model.is_line:
        figure = new_figure(9, 6)
        draw_section(section_axes(figure), solution)
    else:
        height = float(np.clip(6.5 * model.lattice.shape[0] / model.lattice.shape[1], 3.6, 6.5))
        figure = new_figure(12.5, height + 1.0)
        left, right = two_halves(figure)
        draw_contact_map(left.subplots(), solution)
        draw_section(section_axes(right), solution)
    head(figure, _headline(solution))
    return figure


def plot_certificate(certificate: Certificate, model: ContactModel) -> Figure:
    """Draw what a certificate proves: of a membrane its contact map, of a cable the bounds of the gap along it.

    Of a cable net it is the plan, and of a model that has no picture of its own a `ValueError`.
    """
    from .cable_net import CableNet

    state = _states_of(certificate)
    if isinstance(model, CableNet):
        from .plotting_net import draw_plan

        figure = new_figure(7, plan_height(model.positions) + 1.2)
        axes = figure.subplots()
        draw_plan(axes, model, state, "certainly ")
    elif not isinstance(model, TensionedNet):
        raise ValueError(f"there is no picture of a certificate of {model!r}")
    elif model.is_line:
        figure = new_figure(9, 3.6)
        axes = figure.subplots()
        _draw_bounds(axes, certificate, model, state)
    else:
        height = float(np.clip(6.5 * model.lattice.shape[0] / model.lattice.shape[1], 3.0, 6.5))
        figure = new_figure(7, height + 1.2)
        axes = figure.subplots()
        _draw_states(axes, model, state, certificate.contact, "certainly ")
    axes.set_title(f"gap certain to {at_most(certificate.gap_bound)} ({certificate.barrier})", fontsize="medium")
    return figure


def _draw_bounds(axes: Axes, certificate: Certificate, model: TensionedNet, state: NDArray[np.int64]) -> None:
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


def draw_contact_map(axes: Axes, solution: Solution) -> None:
    """Draw which nodes are certainly in contact, certainly clear, or undecided, and the free boundary."""
    state, proven = seen(solution)
    _draw_states(axes, solution._on_lattice("the contact map"), state, solution.contact, proven)


def _draw_states(axes: Axes, model: TensionedNet, state: NDArray[np.int64], contact: Mask, proven: str) -> None:
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


def draw_legend_of_states(axes: Axes, state: NDArray[np.int64], proven: str, more: Sequence[Any] = ()) -> None:
    """Write below the axes what the colours of the states mean and how many nodes there are of each."""
    from matplotlib.patches import Patch

    labels = [f"{proven}clear", f"{proven}in contact", "undecided"]
    handles: list[Any] = [
        Patch(color=colour, label=f"{label} ({np.count_nonzero(state == k)})")
        for k, (colour, label) in enumerate(zip((CLEAR, CONTACT, UNDECIDED), labels, strict=True))
        if k < 2 or (state == 2).any()
    ]
    figure: Any = axes.get_figure(root=False)
    figure.legend(
        handles=[*handles, *more], loc="outside lower center", ncols=3 + len(more), frameon=False, fontsize="small"
    )


def draw_section(axes: NDArray[Any], solution: Solution, row: int | None = None) -> None:
    """Draw deflection and support, gap, and reaction along a row of the net, by default the middle one.

    Parameters
    ----------
    axes : array of three Axes
        For the shape, the gap, and the reaction.
    solution : Solution
    row : int, optional
        Row of the lattice's array; by default the row with nodes that is nearest to the middle.
    """
    model = solution._on_lattice("the section")
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


def seen(solution: Solution) -> tuple[NDArray[np.int64], str]:
    """Return the nodes' states and how sure they are: by the certificate, or else in the backend's own view."""
    if solution.certificate is None:
        return solution.contact.astype(int), ""
    return _states_of(solution.certificate), "certainly "


def _states_of(certificate: Certificate) -> NDArray[np.int64]:
    """Return 1 in contact, 0 clear, 2 undecided."""
    return np.where(certificate.contact, 1, np.where(certificate.clear, 0, 2))


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


def draw_frame_outline(axes: Axes, model: TensionedNet) -> None:
    """Mark the frame points that a node is joined to."""
    row, column = np.nonzero(model.stencil.frame_points())
    lattice = model.lattice
    x, y = lattice.ring_coordinates(row, column)
    size = float(np.clip(4000 / max(lattice.shape) ** 1.5, 0.2, 14))
    axes.scatter(x, y, s=size, marker="s", color=INK, linewidths=0)


def draw_sorted_gap(axes: Axes, solution: Solution) -> None:
    """Draw gap and reaction of a problem without coordinates, sorted by gap."""
    order = np.argsort(solution.gap - solution.reaction / solution.problem.stiffness.diagonal())
    axes.plot(solution.gap[order], color=BLUE, label="gap ω")
    axes.plot(
        (solution.reaction / solution.problem.stiffness.diagonal())[order], color=CONTACT, label="reaction R / G_ii"
    )
    axes.set(xlabel="unknowns, sorted", ylabel="length", title="Gap and reaction")
    axes.legend(frameon=False)
    tidy(axes)


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


def _middle_row(mask: Mask) -> int:
    """Return the row of most nodes among those in the middle fifth, the nearest to the middle first."""
    middle = (mask.shape[0] - 1) / 2
    count = mask.sum(axis=1)
    distance = np.abs(np.arange(mask.shape[0]) - middle)
    reach = max(distance[count > 0].min(), 0.1 * mask.shape[0])
    candidates = np.flatnonzero((distance <= reach) & (count > 0))
    return int(min(candidates, key=lambda row: (-count[row], distance[row])))


def _headline(solution: Solution) -> str:
    state = solution.status.value.replace("_", " ")
    if solution.certificate is None:
        return f"{solution.backend}: {state}, {solution.problem.size} nodes"
    return (
        f"{solution.backend}: {state}, {solution.problem.size} nodes, "
        f"gap certain to {at_most(solution.certificate.gap_bound, 1)}"
    )


def tidy(axes: Axes) -> None:
    """Leave out what a picture does not need."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize="small")
