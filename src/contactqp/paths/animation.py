"""Films of load paths, by matplotlib's own writers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import singledispatch
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.checks import Vector
from ..foundation.files import replaced_as_a_whole, require_folder, require_suffix
from ..foundation.loading import load_modules
from ..foundation.pictures import Wanted
from ..foundation.text import counted
from ..models.base import ContactModel
from ..models.on_lattice import LatticeModel
from ..models.on_line import LineModel
from ..plotting.answers import with_units
from ..plotting.on_lattice import mark_section, section_row, telling_row, title_of_section
from ..plotting.on_line import cut_along, line_of
from ..plotting.section import cut_of_row, draw_shape
from ..plotting.style import map_height, new_figure
from ..plotting.views import draw_into

if TYPE_CHECKING:
    from matplotlib.animation import FuncAnimation
    from matplotlib.figure import Figure

    from ..solving.solution import Solution

_BY_SUFFIX = {".gif": "pillow", ".html": "html"}
_BY_FFMPEG = ".mp4", ".mov", ".mkv", ".avi", ".webm"

_SHARPNESS = 110
"""Pixels an inch."""


def animated(
    model: ContactModel,
    answers: Sequence[tuple[str, Solution]],
    wanted: Wanted,
    seconds: float,
    file: str | Path | None,
    writer: Any,
) -> FuncAnimation:
    """Return a film of answers, and write it to a file if there is one; see `LoadPath.animate`.

    Parameters
    ----------
    model : ContactModel
    answers : sequence of (str, Solution)
        What stands behind the title, and what is drawn.
    wanted : Wanted
    seconds : float
        For each picture.
    file, writer
        See `LoadPath.animate`.
    """
    load_modules("matplotlib.animation")
    from matplotlib.animation import FuncAnimation, writers

    if file is not None:
        if writer is None:
            known = (*_BY_SUFFIX, *(_BY_FFMPEG if writers.is_available("ffmpeg") else ()))
            require_suffix(Path(file), known, "film")
        require_folder(Path(file), "film")
    solutions = [solution for _, solution in answers]
    if isinstance(model, LatticeModel) and wanted.section is None:
        # All pictures show one row.
        wanted = replace(wanted, section=float(model.lattice.y[telling_row(model, solutions, None)]))
    figure = _figure(model)

    def draw(k: int) -> list[Any]:
        name, solution = answers[k]
        for axes in figure.axes:
            axes.clear()
        _draw(model, figure, solution, wanted)
        _scale(model, figure, solutions)
        with_units(figure.axes, wanted)
        title = f"{type(model).__name__}, {counted(model.size, 'node')}" if wanted.title is None else wanted.title
        figure.suptitle(f"{title}: {name}" if title else name, x=0.01, ha="left", fontsize="medium")
        return list(figure.axes)

    layout: Any = figure.get_layout_engine()
    layout.set(rect=(0, 0.07, 1, 0.93))  # room for the legend below a map
    draw(0)
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # all pictures are laid out as the first one
    film = FuncAnimation(figure, draw, frames=len(answers), interval=1000 * seconds, blit=False, init_func=list)
    if file is not None:
        _write(film, Path(file), writer, seconds)
    return film


def _write(film: FuncAnimation, file: Path, writer: Any, seconds: float) -> None:
    rate: Any = 1 / seconds
    chosen = _BY_SUFFIX.get(file.suffix.lower(), "ffmpeg") if writer is None else writer
    if chosen == "html":
        with replaced_as_a_whole(file) as part:
            part.write_text(film.to_jshtml(fps=rate), encoding="utf-8")
    else:
        film.save(file, writer=chosen, fps=rate, dpi=_SHARPNESS)


@singledispatch
def _figure(model: ContactModel) -> Figure:
    figure = new_figure(7, map_height(model.extent) + 1.4) if line_of(model) is None else new_figure(9, 4)
    figure.subplots()
    return figure


@_figure.register(LatticeModel)
def _two_panels(model: LatticeModel) -> Figure:
    figure = new_figure(12, map_height(model.extent, 5.0) + 1.4)
    figure.subplots(1, 2, width_ratios=[1.1, 1])
    return figure


@_figure.register(LineModel)
def _one_panel(model: LineModel) -> Figure:
    figure = new_figure(9, 4)
    figure.subplots()
    return figure


@singledispatch
def _scale(model: ContactModel, figure: Figure, solutions: Sequence[Solution]) -> None:
    """Give a section's axis the same ends in all pictures; a map in plan has them already."""
    line = line_of(model)
    if line is not None:
        _scale_heights(model, figure, solutions, cut_along(model, line, solutions[0].gap).frame_heights)


@_scale.register(LatticeModel)
def _scale_section(model: LatticeModel, figure: Figure, solutions: Sequence[Solution]) -> None:
    _scale_heights(model, figure, solutions, model.frame_places[2])


def _scale_heights(model: ContactModel, figure: Figure, solutions: Sequence[Solution], frame: Vector) -> None:
    down = -1.0 if model.upwards else 1.0
    shown = down * np.concatenate([frame, *(solution.deflection for solution in solutions)])
    support = down * model.support[model.supported]
    # A support that lies deep would flatten the sections.
    near = support[support <= shown.max() + (np.ptp(shown) or 1.0)]
    if model.ceiling_depth is not None:
        near = np.concatenate([near, model.ceiling_depth[model.under_ceiling]])
    highest, lowest = (
        float(min(shown.min(), near.min(initial=np.inf))),
        float(max(shown.max(), near.max(initial=-np.inf))),
    )
    margin = 0.12 * (lowest - highest or 1.0)
    figure.axes[-1].set_ylim(down * (lowest + margin), down * (highest - margin))


@singledispatch
def _draw(model: ContactModel, figure: Figure, solution: Solution, wanted: Wanted) -> None:
    draw_into(model, figure.axes[0], solution, wanted)


@_draw.register(LatticeModel)
def _draw_map_and_shape(model: LatticeModel, figure: Figure, solution: Solution, wanted: Wanted) -> None:
    draw_into(model, figure.axes[0], solution, replace(wanted, ax=figure.axes[0]))
    row = section_row(model, wanted.section)
    mark_section(figure.axes[0], model, row)
    draw_shape(figure.axes[1], cut_of_row(model, solution.gap, row), model, solution)
    figure.axes[1].set(xlabel="x", title=title_of_section(model, row, wanted.section))


@_draw.register(LineModel)
def _draw_line(model: LineModel, figure: Figure, solution: Solution, wanted: Wanted) -> None:
    draw_into(model, figure.axes[0], solution, wanted)
