"""Pictures of a comparison: who reached what, and where the answers differ."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..foundation.checks import Vector
from ..foundation.text import counted
from ..models.records import subject_of
from ..plotting.style import BLUE, CONTACT, GROUND, INK, head, new_figure, tidy, two_halves
from ..plotting.views import NodePlaces, draw_answer, values_figure
from .answers import Answers
from .compared import Compared
from .disagreement import worst_nodes
from .pairs import differing_nodes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .rows import Row


_DECADES = 6
"""The scale of differences spans this many powers of ten; smaller differences are drawn as its lower end."""

_NUMBERED = 10
"""Largest number of nodes that have their rank among the worst ones written beside them."""

_LEAST_DRAWN = 1e-290
"""Least number on a logarithmic axis: matplotlib fails nearer to the least one that a double can hold."""


def plot_comparison(compared: Compared, title: str | None = None) -> Figure:
    """Draw the best answer's contact map or section, and for each backend its bound and its time."""
    best, conclusion = compared.answers.best, compared.conclusion
    if best is None:
        raise ValueError(f"there is nothing to draw: no backend returned an answer ({conclusion.sentence})")
    figure = new_figure(12.5, 5.8)
    left, right = two_halves(figure)
    places = draw_answer(subject_of(best), left, best)
    if places is not None:
        _mark_differences(places, compared)
    above, below = right.subplots(2, 1, sharey=True)
    _draw_bars(above, below, compared)
    head(figure, headline(compared) if title is None else title)
    return figure


def headline(compared: Compared) -> str:
    """Return the headline of a comparison's picture: how many backends, how many nodes, and the verdict."""
    conclusion = compared.conclusion
    verdict = "all agree" if conclusion.agree else "no agreement: " + ", ".join(conclusion.culprits)
    nodes = counted(compared.answers.problem.size, "node")
    return f"{counted(len(compared.rows), 'backend')}, {nodes}, {verdict}"


def _mark_differences(places: NodePlaces, compared: Compared) -> None:
    differing = differing_nodes(compared.pairs)
    if differing.size:
        x, y = places.x[differing], places.y[differing]
        places.axes.scatter(x, y, s=26, facecolors="none", edgecolors="black")
        places.axes.set_title(f"Contact map; backends differ at {differing.size} circled nodes")


def _draw_bars(above: Axes, below: Axes, compared: Compared) -> None:
    rows = compared.rows
    position = np.arange(len(rows))
    names = [row.backend for row in rows]
    bounds = [
        row.relative_bound if row.relative_bound is not None and np.isfinite(row.relative_bound) else np.nan
        for row in rows
    ]
    colours = [BLUE if row.ok else CONTACT for row in rows]
    errors = [(row.relative_true_error, k) for k, row in enumerate(rows) if row.relative_true_error is not None]
    errors = [(error, k) for error, k in errors if np.isfinite(error) and error > _LEAST_DRAWN]
    tol = compared.tolerance.tol
    floor = min([*(b for b in bounds if b > _LEAST_DRAWN), *(error for error, _ in errors), tol]) / 10
    above.barh(position, np.maximum(np.array(bounds) - floor, 0.0), left=floor, color=colours, height=0.6)
    above.axvline(tol, color=INK, lw=1, ls="--")
    above.plot([error for error, _ in errors], [k for _, k in errors], "D", color=INK, ms=4)
    above.set(
        xscale="log",
        xlim=(floor, None),
        title="Gap error / error scale: certified (bars), true (points), tol (dashed)",
        yticks=position,
        yticklabels=names,
    )
    above.invert_yaxis()
    warm = any(row.warm_seconds is not None for row in rows)
    seconds = [_seconds(row) for row in rows]
    finite = [s for s in seconds if s > 0]
    start = min(finite) / 3 if finite else 1e-3
    below.barh(position, np.array(seconds) - start, left=start, color=GROUND, height=0.6)
    for k, row in enumerate(rows):
        text = row.status if row.iterations is None else _counted(compared, row.backend, row.iterations)
        below.annotate(
            f" {text}", (seconds[k] if seconds[k] > 0 else start, k), va="center", fontsize="small", color=INK
        )
    heading = "Seconds, warm" if warm else "Seconds of set-up and solve, all loaded"
    below.set(xscale="log", xlim=(start, max([*finite, start]) * 12), title=heading)
    for axes in (above, below):
        axes.title.set_fontsize("medium")
        tidy(axes)


def _seconds(row: Row) -> float:
    """Return the fastest warm run's time, without one that of the first run's set-up and solve; nan without any."""
    if row.warm_seconds is not None:
        return row.warm_seconds
    return np.nan if row.solve_seconds is None else row.solve_seconds + (row.setup_seconds or 0.0)


def _counted(compared: Compared, backend: str, iterations: int) -> str:
    unit = compared.answers.solutions[backend].iteration_unit
    return counted(iterations, unit)


def plot_disagreement(compared: Compared) -> Figure:
    """Draw the largest less the smallest gap at every node: a map, along a cable, or sorted for a bare matrix."""
    answers = compared.answers
    if len(answers.finite) < 2:
        raise ValueError(
            f"a disagreement needs two answers, and there are {len(answers.finite)} ({compared.conclusion.sentence})"
        )
    spread = answers.spread
    rounding = float(np.finfo(np.float64).eps) * answers.problem.gap_scale
    floor = max(float(spread.max()) * 10.0**-_DECADES, rounding, _LEAST_DRAWN)
    figure, places = values_figure(subject_of(answers), spread, floor, "difference of gaps (length)")
    if places is not None:
        _mark_worst(places, compared)
    names = ", ".join(answers.finite)
    head(figure, f"Largest less smallest gap of {len(answers.finite)} answers ({names})")
    return figure


def _mark_worst(places: NodePlaces, compared: Compared) -> None:
    """Circle the nodes whose contact differs, and number the worst ones."""
    axes, x, y, apart, ring = places
    differing = differing_nodes(compared.pairs)
    if differing.size:
        axes.scatter(x[differing], y[differing], s=ring, facecolors="none", edgecolors=CONTACT, linewidths=1.1)
    _number_worst(axes, compared.answers, x, y, apart)
    axes.set_title(_caption(differing.size), fontsize="medium")


def _number_worst(axes: Axes, answers: Answers, x: Vector, y: Vector, apart: float) -> None:
    """Write the ranks beside the worst nodes; a node that is too near to a numbered one gets no number."""
    placed: list[tuple[float, float]] = []
    for rank, node in enumerate(worst_nodes(answers, _NUMBERED)["node"], start=1):
        here = float(x[node]), float(y[node])
        if answers.spread[node] == 0 or any(np.hypot(here[0] - a, here[1] - b) < apart for a, b in placed):
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


def _caption(differing: int) -> str:
    circled = f"circled: {differing} nodes whose contact differs" if differing else "the contact sets are the same"
    return f"Numbers: rank of the worst nodes, neighbours left out; {circled}"
