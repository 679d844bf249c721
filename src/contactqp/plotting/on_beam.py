"""Pictures of beams: shape, bending moment, shear, and reactions with those that are concentrated at touchdown."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.pictures import PLAIN, Wanted
from ..models.beam import Beam
from ..models.records import held_reaction
from .on_line import ALONG_X, cut_along
from .section import draw_reaction, draw_shape
from .style import BLUE, CONTACT, INK, new_figure, tidy
from .views import answer_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..models.records import Answered

_MOST_TOLD = 12
"""Concentrated reactions whose size is written beside them, at most."""


@answer_figure.register(Beam)
def _beam_figure(beam: Beam, solution: Answered, wanted: Wanted = PLAIN) -> Figure:
    figure = new_figure(9, 8.5)
    panels: Any = figure.subplots(4, 1, sharex=True, height_ratios=[2.4, 1.3, 1.3, 1.3])
    shape, bending, shearing, reaction = panels
    cut, forces = cut_along(beam, ALONG_X, solution.gap), beam.internal_forces(solution.gap)
    draw_shape(shape, cut, beam, solution)
    bending.plot(forces.x, forces.moment, color=BLUE, lw=1.4)
    bending.invert_yaxis()  # the moment is drawn on the side that it stretches
    bending.set(ylabel=wanted.label("moment M,\nsagging > 0", "force times length"))
    shearing.step(forces.arm_x, forces.shear, where="mid", color=BLUE, lw=1.4)
    shearing.set(ylabel=wanted.label("shear V", "force"))
    for axes in (bending, shearing):
        axes.axhline(0, color=INK, lw=0.6)
        tidy(axes)
    draw_reaction(reaction, cut, solution)
    _tell_touchdown(reaction, beam, solution)
    reaction.set(xlabel=wanted.label("x"))
    tidy(reaction)
    return figure


def _tell_touchdown(axes: Axes, beam: Beam, solution: Answered) -> None:
    """Write beside the ends of contact stretches with which concentrated reaction the beam comes down there."""
    told = []
    if solution.finite:
        spans = beam.spans(solution)
        touching = spans[spans["kind"] == "contact"]
        ends = np.array([beam.start, beam.start + beam.span])
        for place, force in (("start", "force_at_start"), ("end", "force_at_end")):
            inside = ~np.isin(touching[place], ends) & (np.abs(touching[force]) > 0)
            told += list(zip(touching[place][inside], touching[force][inside], strict=True))
    if not 0 < len(told) <= _MOST_TOLD:
        return
    reaction, x = held_reaction(solution), beam.node_x
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.25 * (high - low))
    for place, force in told:
        near = np.abs(x - place) <= 1.5 * beam.lattice.spacing
        foot = max(0.0, float(reaction[near].max()))
        text: Any = {"ha": "center", "va": "bottom", "fontsize": "small", "color": CONTACT}
        axes.annotate(f"{force:.3g}", (place, foot), (0, 2), textcoords="offset points", **text)
    axes.set_title("numbers: concentrated reactions at touchdown, beside what lies under the load", fontsize="small")
