"""Pictures: contact maps and middle sections, in the manner of the paper's Figs. 5-8."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._checks import Mask

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

    from .compare import Comparison
    from .model import TensionedNet
    from .solution import Solution

CONTACT, CLEAR, UNDECIDED, INK = "#c8553d", "#dfe7ec", "#f2c14e", "#22333b"
_BLUE, _GROUND = "#2f6690", "#b9a88f"


def plot_solution(solution: Solution) -> Figure:
    """Draw a solution: for a membrane its contact map beside the middle section, for a cable the section alone."""
    model = solution.model
    if model is None:
        figure = _new_figure(7, 4.4)
        _draw_sorted_gap(figure.subplots(), solution)
    elif model.is_line:
        figure = _new_figure(9, 6)
        draw_section(_section_axes(figure), solution)
    else:
        height = float(np.clip(6.5 * model.lattice.shape[0] / model.lattice.shape[1], 3.6, 6.5))
        figure = _new_figure(12.5, height + 1.0)
        left, right = _two_halves(figure)
        draw_contact_map(left.subplots(), solution)
        draw_section(_section_axes(right), solution)
    _head(figure, _headline(solution))
    return figure


def plot_comparison(comparison: Comparison) -> Figure:
    """Draw the best answer's contact map or section, and for each backend its bound and its time."""
    best = comparison.best
    if best is None:
        raise ValueError(f"there is nothing to draw: no backend returned an answer ({comparison.verdict()})")
    figure = _new_figure(12.5, 5.8)
    left, right = _two_halves(figure)
    if best.model is None:
        _draw_sorted_gap(left.subplots(), best)
    elif best.model.is_line:
        draw_section(_section_axes(left), best)
    else:
        axes = left.subplots()
        draw_contact_map(axes, best)
        _mark_differences(axes, comparison, best.model)
    above, below = right.subplots(2, 1, sharey=True)
    _draw_bars(above, below, comparison)
    verdict = "all agree" if comparison.agree else "no agreement: " + ", ".join(comparison.culprits)
    title = f"{len(comparison.rows)} backends, {best.problem.size} nodes, {verdict}"
    _head(figure, title)
    return figure


def draw_contact_map(axes: Axes, solution: Solution) -> None:
    """Draw which nodes are certainly in contact, certainly clear, or undecided, and the free boundary."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    model = solution._physical("the contact map")
    lattice = model.lattice
    state = _states(solution)
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
    _draw_free_boundary(axes, lattice.x, lattice.y, lattice.scatter(solution.contact.astype(float)))
    _draw_frame_outline(axes, model)
    proven = "certainly " if solution.certificate is not None else ""
    labels = [f"{proven}clear", f"{proven}in contact", "undecided"]
    handles: list[Any] = [
        Patch(color=colour, label=f"{label} ({np.count_nonzero(state == k)})")
        for k, (colour, label) in enumerate(zip((CLEAR, CONTACT, UNDECIDED), labels, strict=True))
        if k < 2 or (state == 2).any()
    ]
    figure: Any = axes.get_figure(root=False)
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False, fontsize="small")
    axes.set(aspect="equal", xlabel="x", ylabel="y", title="Contact map")
    _tidy(axes)


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
    model = solution._physical("the section")
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
    shape_axes.fill_between(lattice.x, support, high + margin, color=_GROUND, alpha=0.55, lw=0, label="support f")
    shape_axes.plot(x, deflection, color=_BLUE, lw=1.8, label="membrane w" if not model.is_line else "cable w")
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
        _tidy(each)


def _states(solution: Solution) -> NDArray[np.int64]:
    """Return 1 in contact, 0 clear, 2 undecided; the backend's own view where there is no certificate."""
    certificate = solution.certificate
    if certificate is None:
        return solution.contact.astype(int)
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


def _draw_frame_outline(axes: Axes, model: TensionedNet) -> None:
    """Mark the frame points that a node is joined to."""
    row, column = np.nonzero(model.stencil.frame_points())
    lattice = model.lattice
    x = lattice.origin[0] + lattice.spacing * (column - 1)
    y = lattice.origin[1] + lattice.spacing * (row - 1)
    size = float(np.clip(4000 / max(lattice.shape) ** 1.5, 0.2, 14))
    axes.scatter(x, y, s=size, marker="s", color=INK, linewidths=0)


def _mark_differences(axes: Axes, comparison: Comparison, model: TensionedNet) -> None:
    nodes = [pair.differing_nodes for pair in comparison.pairs]
    differing = np.unique(np.concatenate(nodes)) if nodes else np.array([], dtype=int)
    if differing.size:
        x, y = model.lattice.node_x[differing], model.lattice.node_y[differing]
        axes.scatter(x, y, s=26, facecolors="none", edgecolors="black")
        axes.set_title(f"Contact map; backends differ at {differing.size} circled nodes")


def _draw_bars(above: Axes, below: Axes, comparison: Comparison) -> None:
    rows = comparison.rows
    position = np.arange(len(rows))
    names = [row.backend for row in rows]
    bounds = [
        row.relative_bound if row.relative_bound is not None and np.isfinite(row.relative_bound) else np.nan
        for row in rows
    ]
    colours = [_BLUE if row.status in ("certified", "solved") else CONTACT for row in rows]
    floor = min([*(b for b in bounds if b > 0), comparison.tol]) / 10
    above.barh(position, np.array(bounds) - floor, left=floor, color=colours, height=0.6)
    above.axvline(comparison.tol, color=INK, lw=1, ls="--")
    above.set(
        xscale="log",
        xlim=(floor, None),
        title=f"Certified error of the gap over the gap scale; dashed: tol {comparison.tol:g}",
        yticks=position,
        yticklabels=names,
    )
    above.invert_yaxis()
    seconds = [np.nan if row.solve_seconds is None else row.solve_seconds + (row.setup_seconds or 0) for row in rows]
    finite = [s for s in seconds if s > 0]
    start = min(finite) / 3 if finite else 1e-3
    below.barh(position, np.array(seconds) - start, left=start, color=_GROUND, height=0.6)
    for k, row in enumerate(rows):
        text = row.status if row.iterations is None else _counted(comparison, row.backend, row.iterations)
        below.annotate(
            f" {text}", (seconds[k] if seconds[k] > 0 else start, k), va="center", fontsize="small", color=INK
        )
    below.set(xscale="log", xlim=(start, max([*finite, start]) * 12), title="Seconds")
    for axes in (above, below):
        axes.title.set_fontsize("medium")
        _tidy(axes)


def _counted(comparison: Comparison, backend: str, iterations: int) -> str:
    unit = comparison.solutions[backend].iteration_unit
    return f"{iterations} {unit}{'' if iterations == 1 else 's'}"


def _draw_sorted_gap(axes: Axes, solution: Solution) -> None:
    """Draw gap and reaction of a problem without coordinates, sorted by gap."""
    order = np.argsort(solution.gap - solution.reaction / solution.problem.stiffness.diagonal())
    axes.plot(solution.gap[order], color=_BLUE, label="gap ω")
    axes.plot(
        (solution.reaction / solution.problem.stiffness.diagonal())[order], color=CONTACT, label="reaction R / G_ii"
    )
    axes.set(xlabel="unknowns, sorted", ylabel="length", title="Gap and reaction")
    axes.legend(frameon=False)
    _tidy(axes)


def _new_figure(width: float, height: float) -> Figure:
    """Return a figure that belongs to no window and shows itself in a notebook."""
    from io import BytesIO

    from matplotlib.figure import Figure

    class Picture(Figure):
        def _repr_png_(self) -> bytes:
            buffer = BytesIO()
            self.savefig(buffer, format="png", dpi=90)
            return buffer.getvalue()

    return Picture(figsize=(width, height), layout="constrained")


def _head(figure: Figure, text: str) -> None:
    """Write a headline, with room below it that the titles of subfigures cannot take."""
    figure.suptitle(text + "\n", x=0.01, ha="left", fontsize="large", color=INK)


def _section_axes(part: Figure | SubFigure) -> NDArray[Any]:
    """Return the three panels that `draw_section` fills."""
    axes: NDArray[Any] = part.subplots(3, 1, sharex=True, height_ratios=[3, 1.3, 1.3])
    return axes


def _two_halves(figure: Figure) -> tuple[SubFigure, SubFigure]:
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
        f"gap certain to {solution.certificate.gap_bound:.1g}"
    )


def _tidy(axes: Axes) -> None:
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize="small")
