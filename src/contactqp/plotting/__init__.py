"""Pictures of models and answers, and the colours and axes that they share.

Each kind of model registers its pictures when its module is imported here (see `contactqp.plotting.views`).
"""

from . import before, mesh_in_space, on_beam, on_mesh, on_net, on_row, space  # noqa: F401  their pictures are registered by this
from .on_lattice import draw_frame_outline
from .style import BLUE, CLEAR, CONTACT, GROUND, INK, UNDECIDED, tidy

__all__ = [
    "BLUE",
    "CLEAR",
    "CONTACT",
    "GROUND",
    "INK",
    "UNDECIDED",
    "draw_frame_outline",
    "tidy",
]
