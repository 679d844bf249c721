"""Pictures of an answer and of a certificate, with what they are worth in the headline."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ..foundation.pictures import PLAIN, Wanted
from ..foundation.text import at_most, counted
from ..models.records import subject_of
from .geometry import figure_of
from .of_squares import Strip, draw_strip
from .on_line import ALONG_THE_LINE
from .section import REACTION
from .space import answer_in_space
from .style import head
from .views import GAP_AND_REACTION, answer_figure, certificate_figure, draw_into

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..models.base import ContactModel
    from ..models.records import Answered, Enclosed


def plot_solution(solution: Answered, wanted: Wanted = PLAIN, strip: Strip | None = None) -> Figure:
    """Draw a solution: for a membrane its contact map beside the middle section, for a cable the section alone.

    A cable net is drawn in plan and in space, any model whose nodes lie in a line as a cable is, and a bare problem by
    its gaps and reactions, sorted. In axes of the user's own there is the map, or a cable's shape, alone. A strip is
    drawn over the map.
    """
    subject = subject_of(solution)
    if wanted.ax is not None:
        draw_into(subject, wanted.ax, solution, wanted)
        text = headline(solution).split(",")[0] if wanted.title is None else wanted.title
        wanted.ax.set_title(text, fontsize="medium")
        with_units([wanted.ax], wanted)
        if strip is not None:
            draw_strip(wanted.ax, strip)
        return figure_of(wanted.ax)
    figure = answer_figure(subject, solution, wanted)
    head(figure, headline(solution) if wanted.title is None else wanted.title)
    with_units(figure.axes, wanted)
    if strip is not None:
        draw_strip(figure.axes[0], strip)
    return figure


def plot_in_space(solution: Answered, wanted: Wanted = PLAIN) -> Figure:
    """Draw a membrane's deflection over its support in space.

    Raises
    ------
    TypeError
        If the solution is neither a membrane's nor a plate's.
    """
    return answer_in_space(subject_of(solution), solution, wanted)


_QUANTITIES = {
    "x": "length",
    "y": "length",
    "height,\npositive downwards": "length",
    "height,\npositive upwards": "length",
    "w, positive downwards": "length",
    "w, positive upwards": "length",
    ALONG_THE_LINE: "length",
    "gap ω": "length",
    GAP_AND_REACTION: "length",
}
"""What the labels of axes are of."""


def with_units(axes: Iterable[Axes], wanted: Wanted) -> None:
    """Write the units that are wanted behind the labels of axes whose quantity is known."""
    for each in axes:
        for axis in (each.xaxis, each.yaxis):
            text = axis.get_label_text()
            if text == REACTION and wanted.unit("force"):
                axis.set_label_text(text.replace("force", wanted.unit("force")))
            if text in _QUANTITIES:
                axis.set_label_text(wanted.label(text, _QUANTITIES[text]))


def plot_certificate(certificate: Enclosed, model: ContactModel) -> Figure:
    """Draw what a certificate proves: the map of states in plan, of a cable the bounds of the gap along it."""
    figure = certificate_figure(model, certificate)
    bound = f"gap certain to {at_most(certificate.gap_bound)} ({certificate.barrier})"
    figure.axes[0].set_title(bound, fontsize="medium")
    return figure


def headline(solution: Answered) -> str:
    """Return the headline of a solution's picture: who answered, and what the answer is worth."""
    state = str(solution.status).replace("_", " ")
    unknowns = counted(solution.problem.size, "unknown" if solution.model is None else "node")
    told = f"{solution.backend}: {state}, {unknowns}"
    if solution.certificate is None:
        return told
    return f"{told}, gap certain to {at_most(solution.certificate.gap_bound, 1)}"
