"""Pictures of models and answers, and the colours and axes that they share."""

from .on_lattice import draw_frame_outline
from .style import BLUE, CLEAR, CONTACT, GROUND, INK, UNDECIDED, tidy

__all__ = ["BLUE", "CLEAR", "CONTACT", "GROUND", "INK", "UNDECIDED", "draw_frame_outline", "tidy"]
