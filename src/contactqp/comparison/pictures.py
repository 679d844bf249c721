"""Pictures of a comparison: who reached what, and where the answers differ."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Vector
from ..models.cable_net import CableNet
from ..models.on_lattice import LatticeModel
from ..plotting.answers import draw_sorted_gap
from ..plotting.on_lattice import draw_contact_map, draw_frame_outline, draw_section
from ..plotting.on_net import draw_fixed, draw_net_spread, draw_plan
from ..plotting.states import seen
from ..plotting.style import BLUE, CONTACT, GROUND, INK, head, new_figure, plan_height, section_axes, tidy, two_halves

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..models.base import ContactModel
    from .comparison import Comparison

_DECADES = 6
"""Differences smaller than the largest by so many powers of ten are drawn alike."""

_NUMBERED = 10
"""Of the nodes where answers differ most, so many at most have their rank beside them."""

_LEAST_DRAWN = 1e-290
"""Logarithmic axes fail at the edge of the range of numbers."""


def plot_comparison(comparison: Comparison) -> Figure:
    """Draw the best answer's contact map or section, and for each backend its bound and its time."""
    best = comparison.best
    if best is None:
        raise ValueError(f"there is nothing to draw: no backend returned an answer ({comparison.verdict()})")
    figure = new_figure(12.5, 5.8)
    left, right = two_halves(figure)
    model = best.model
    if isinstance(model, CableNet):
        axes = left.subplots()
        draw_plan(axes, model, *seen(best))
        _mark_differences(axes, comparison, model)
    elif not isinstance(model, LatticeModel):
        draw_sorted_gap(left.subplots(), best)
    elif model.is_line:
        draw_section(section_axes(left), best, model)
    else:
        axes = left.subplots()
        draw_contact_map(axes, best, model)
        _mark_differences(axes, comparison, model)
    above, below = right.subplots(2, 1, sharey=True)
    _draw_bars(above, below, comparison)
    verdict = "all agree" if comparison.agree else "no agreement: " + ", ".join(comparison.culprits)
    title = f"{len(comparison.rows)} backends, {best.problem.size} nodes, {verdict}"
    head(figure, title)
    return figure


def _mark_differences(axes: Axes, comparison: Comparison, model: ContactModel) -> None:
    differing = _differing_nodes(comparison)
    if differing.size:
        x, y = model.node_x[differing], model.node_y[differing]
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
    colours = [BLUE if row.status in ("certified", "solved") else CONTACT for row in rows]
    errors = [(row.relative_true_error, k) for k, row in enumerate(rows) if row.relative_true_error is not None]
    errors = [(error, k) for error, k in errors if np.isfinite(error) and error > _LEAST_DRAWN]
    floor = min([*(b for b in bounds if b > _LEAST_DRAWN), *(error for error, _ in errors), comparison.tol]) / 10
    above.barh(position, np.maximum(np.array(bounds) - floor, 0.0), left=floor, color=colours, height=0.6)
    above.axvline(comparison.tol, color=INK, lw=1, ls="--")
    above.plot([error for error, _ in errors], [k for _, k in errors], "D", color=INK, ms=4)
    above.set(
        xscale="log",
        xlim=(floor, None),
        title="Gap error / gap scale: certified (bars), true (points), tol (dashed)",
        yticks=position,
        yticklabels=names,
    )
    above.invert_yaxis()
    seconds = [np.nan if row.solve_seconds is None else row.solve_seconds + (row.setup_seconds or 0) for row in rows]
    finite = [s for s in seconds if s > 0]
    start = min(finite) / 3 if finite else 1e-3
    below.barh(position, np.array(seconds) - start, left=start, color=GROUND, height=0.6)
    for k, row in enumerate(rows):
        text = row.status if row.iterations is None else _counted(comparison, row.backend, row.iterations)
        below.annotate(
            f" {text}", (seconds[k] if seconds[k] > 0 else start, k), va="center", fontsize="small", color=INK
        )
    below.set(xscale="log", xlim=(start, max([*finite, start]) * 12), title="Seconds")
    for axes in (above, below):
        axes.title.set_fontsize("medium")
        tidy(axes)


def _counted(comparison: Comparison, backend: str, iterations: int) -> str:
    unit = comparison.solutions[backend].iteration_unit
    return f"{iterations} {unit}{'' if iterations == 1 else 's'}"


def plot_disagreement(comparison: Comparison) -> Figure:
    """Draw the largest less the smallest gap at every node: a map, along a cable, or sorted for a bare matrix."""
    if len(comparison.usable) < 2:
        raise ValueError(
            f"a disagreement needs two answers, and there are {len(comparison.usable)} ({comparison.verdict()})"
        )
    spread = comparison.spread
    rounding = float(np.finfo(np.float64).eps) * comparison.problem.gap_scale
    floor = max(float(spread.max()) * 10.0**-_DECADES, rounding, _LEAST_DRAWN)
    model = comparison.model
    if isinstance(model, CableNet):
        figure = new_figure(8.5, plan_height(model.positions) + 1.0)
        _draw_spread_map(figure.subplots(), comparison, model, floor)
    elif not isinstance(model, LatticeModel):
        figure = new_figure(8, 4.6)
        _draw_sorted_spread(figure.subplots(), spread, floor)
    elif model.is_line:
        figure = new_figure(9, 4.6)
        _draw_spread_along(figure.subplots(), comparison, model, floor)
    else:
        rows, columns = model.lattice.shape
        figure = new_figure(8.5, float(np.clip(6.8 * rows / columns, 2.2, 7.5)) + 1.0)
        _draw_spread_map(figure.subplots(), comparison, model, floor)
    names = ", ".join(comparison.usable)
    head(figure, f"Largest less smallest gap of {len(comparison.usable)} answers ({names})")
    return figure


def _draw_spread_map(axes: Axes, comparison: Comparison, model: LatticeModel | CableNet, floor: float) -> None:
    from matplotlib.colors import LogNorm

    spread = np.maximum(comparison.spread, floor)
    norm = LogNorm(floor, max(float(spread.max()), 10 * floor))
    x, y = model.node_x, model.node_y
    if isinstance(model, CableNet):
        width, height = np.ptp(model.positions, axis=0)
        picture: Any = draw_net_spread(axes, model, spread, norm)
        draw_fixed(axes, model)
    else:
        lattice = model.lattice
        height, width = lattice.shape
        picture = axes.pcolormesh(
            lattice.x, lattice.y, lattice.scatter(spread), cmap="viridis", norm=norm, shading="nearest", rasterized=True
        )
        draw_frame_outline(axes, model)
    figure = axes.get_figure(root=False)
    assert figure is not None
    place = "bottom" if width > 2 * height else "right"
    figure.colorbar(picture, ax=axes, extend="min", label="difference of gaps (length)", shrink=0.85, location=place)
    differing = _differing_nodes(comparison)
    if differing.size:
        axes.scatter(x[differing], y[differing], s=34, facecolors="none", edgecolors=CONTACT, linewidths=1.1)
    _number_worst(axes, comparison, x, y, 0.05 * max(np.ptp(x), np.ptp(y)))
    axes.set(aspect="equal", xlabel="x", ylabel="y")
    axes.set_title(_caption(differing.size), fontsize="medium")
    tidy(axes)


def _draw_spread_along(axes: Axes, comparison: Comparison, model: LatticeModel, floor: float) -> None:
    x, height = model.lattice.node_x, np.maximum(comparison.spread, floor)
    axes.plot(x, height, ".-", color=BLUE, lw=1, ms=4)
    differing = _differing_nodes(comparison)
    axes.scatter(x[differing], height[differing], s=60, facecolors="none", edgecolors=CONTACT, linewidths=1.1)
    _number_worst(axes, comparison, x, height, 0.03 * np.ptp(x))
    axes.set(yscale="log", xlabel="x", ylabel="difference of gaps (length)")
    axes.set_title(_caption(differing.size), fontsize="medium")
    tidy(axes)


def _draw_sorted_spread(axes: Axes, spread: Vector, floor: float) -> None:
    axes.plot(np.arange(1, spread.size + 1), np.maximum(np.sort(spread)[::-1], floor), ".-", color=BLUE, lw=1, ms=4)
    axes.set(yscale="log", xlabel="unknowns, sorted", ylabel="difference of gaps (length)")
    tidy(axes)


def _number_worst(axes: Axes, comparison: Comparison, x: Vector, y: Vector, apart: float) -> None:
    """Write the rank beside the worst nodes, except those too near to one that has its number."""
    placed: list[tuple[float, float]] = []
    for rank, node in enumerate(comparison.worst_nodes(_NUMBERED)["node"], start=1):
        here = float(x[node]), float(y[node])
        if comparison.spread[node] == 0 or any(np.hypot(here[0] - a, here[1] - b) < apart for a, b in placed):
            continue
        placed.append(here)
        axes.annotate(
            str(rank),
            here,
            xytext=(9, 9),
            textcoords="offset points",
            fontsize="small",
            color=INK,
            bbox={"boxstyle": "circle,pad=0.15", "facecolor": "white", "edgecolor": INK, "linewidth": 0.6},
            arrowprops={"arrowstyle": "-", "color": INK, "linewidth": 0.8},
        )


def _differing_nodes(comparison: Comparison) -> NDArray[np.int64]:
    """Return the nodes that some backends have in contact and others do not."""
    nodes = [pair.differing_nodes for pair in comparison.pairs]
    return np.unique(np.concatenate(nodes)) if nodes else np.array([], dtype=np.int64)


def _caption(differing: int) -> str:
    circled = f"circled: {differing} nodes whose contact differs" if differing else "the contact sets are the same"
    return f"Numbers: rank of the worst nodes, neighbours left out; {circled}"
