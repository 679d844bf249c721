"""Pictures of an answer and of a certificate."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..foundation.text import at_most
from ..models.on_lattice import LatticeModel
from .on_lattice import draw_bounds, draw_contact_map, draw_section, draw_states
from .states import seen, states_of
from .style import BLUE, CONTACT, head, new_figure, plan_height, section_axes, tidy, two_halves

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..models.base import ContactModel
    from ..models.records import Answered, Enclosed


def plot_solution(solution: Answered) -> Figure:
    """Draw a solution: for a membrane its contact map beside the middle section, for a cable the section alone.

    A cable net is drawn in plan and in space.
    """
    from ..models.cable_net import CableNet

    model = solution.model
    if isinstance(model, CableNet):
        from .on_net import draw_in_space, draw_plan

        figure = new_figure(12.5, plan_height(model.positions) + 1.0)
        left, right = two_halves(figure)
        draw_plan(left.subplots(), model, *seen(solution))
        draw_in_space(right, solution, model)
    elif not isinstance(model, LatticeModel):
        figure = new_figure(7, 4.4)
        draw_sorted_gap(figure.subplots(), solution)
    elif model.is_line:
        figure = new_figure(9, 6)
        draw_section(section_axes(figure), solution, model)
    else:
        height = float(np.clip(6.5 * model.lattice.shape[0] / model.lattice.shape[1], 3.6, 6.5))
        figure = new_figure(12.5, height + 1.0)
        left, right = two_halves(figure)
        draw_contact_map(left.subplots(), solution, model)
        draw_section(section_axes(right), solution, model)
    head(figure, _headline(solution))
    return figure


def plot_certificate(certificate: Enclosed, model: ContactModel) -> Figure:
    """Draw what a certificate proves: of a membrane its contact map, of a cable the bounds of the gap along it.

    Of a cable net it is the plan, and of a model that has no picture of its own a `ValueError`.
    """
    from ..models.cable_net import CableNet

    state = states_of(certificate)
    if isinstance(model, CableNet):
        from .on_net import draw_plan

        figure = new_figure(7, plan_height(model.positions) + 1.2)
        axes = figure.subplots()
        draw_plan(axes, model, state, "certainly ")
    elif not isinstance(model, LatticeModel):
        raise ValueError(f"there is no picture of a certificate of {model!r}")
    elif model.is_line:
        figure = new_figure(9, 3.6)
        axes = figure.subplots()
        draw_bounds(axes, certificate, model, state)
    else:
        height = float(np.clip(6.5 * model.lattice.shape[0] / model.lattice.shape[1], 3.0, 6.5))
        figure = new_figure(7, height + 1.2)
        axes = figure.subplots()
        draw_states(axes, model, state, certificate.contact, "certainly ")
    axes.set_title(f"gap certain to {at_most(certificate.gap_bound)} ({certificate.barrier})", fontsize="medium")
    return figure


def draw_sorted_gap(axes: Axes, solution: Answered) -> None:
    """Draw gap and reaction of a problem without coordinates, sorted by gap."""
    order = np.argsort(solution.gap - solution.reaction / solution.problem.stiffness.diagonal())
    axes.plot(solution.gap[order], color=BLUE, label="gap ω")
    axes.plot(
        (solution.reaction / solution.problem.stiffness.diagonal())[order], color=CONTACT, label="reaction R / G_ii"
    )
    axes.set(xlabel="unknowns, sorted", ylabel="length", title="Gap and reaction")
    axes.legend(frameon=False)
    tidy(axes)


def _headline(solution: Answered) -> str:
    state = str(solution.status).replace("_", " ")
    if solution.certificate is None:
        return f"{solution.backend}: {state}, {solution.problem.size} nodes"
    return (
        f"{solution.backend}: {state}, {solution.problem.size} nodes, "
        f"gap certain to {at_most(solution.certificate.gap_bound, 1)}"
    )
