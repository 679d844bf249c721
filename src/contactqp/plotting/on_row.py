"""Pictures of cables and beams: everything along x, and not as other models on a lattice are drawn."""

from __future__ import annotations

from ..models.base import ContactModel
from ..models.on_line import LineModel
from .views import answer_figure, certificate_figure, draw_answer, draw_into, settling_figure, values_figure

for view in (answer_figure, certificate_figure, draw_answer, draw_into, settling_figure, values_figure):
    view.register(LineModel)(view.dispatch(ContactModel))
