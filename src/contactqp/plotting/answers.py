"""Pictures of an answer and of a certificate, with what they are worth in the headline."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..foundation.text import at_most
from ..models.records import subject_of
from .style import head
from .views import answer_figure, certificate_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..models.base import ContactModel
    from ..models.records import Answered, Enclosed


def plot_solution(solution: Answered) -> Figure:
    """Draw a solution: for a membrane its contact map beside the middle section, for a cable the section alone.

    A cable net is drawn in plan and in space, and a bare problem by its gaps and reactions, sorted.
    """
    figure = answer_figure(subject_of(solution), solution)
    head(figure, _headline(solution))
    return figure


def plot_certificate(certificate: Enclosed, model: ContactModel) -> Figure:
    """Draw what a certificate proves: the map of states in plan, of a cable the bounds of the gap along it."""
    figure = certificate_figure(model, certificate)
    bound = f"gap certain to {at_most(certificate.gap_bound)} ({certificate.barrier})"
    figure.axes[0].set_title(bound, fontsize="medium")
    return figure


def _headline(solution: Answered) -> str:
    state = str(solution.status).replace("_", " ")
    if solution.certificate is None:
        return f"{solution.backend}: {state}, {solution.problem.size} nodes"
    return (
        f"{solution.backend}: {state}, {solution.problem.size} nodes, "
        f"gap certain to {at_most(solution.certificate.gap_bound, 1)}"
    )
