"""Maps of squares: where a membrane certainly touches, where it certainly does not, and the strip between."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..foundation.checks import Mask, Vector
from ..foundation.loading import load_modules
from ..foundation.pictures import Wanted
from .geometry import axes_for, figure_of, finish
from .style import CLEAR, CONTACT, UNDECIDED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_KINDS = (("certainly clear", CLEAR), ("undecided", UNDECIDED), ("certainly in contact", CONTACT))


def map_of_squares(edges: tuple[Vector, Vector], states: tuple[Mask, Mask, Mask], wanted: Wanted, title: str) -> Figure:
    """Draw which squares are clear, undecided and in contact.

    Parameters
    ----------
    edges : pair of arrays, shapes (columns + 1,) and (rows + 1,)
        x and y of the lines between the squares (length).
    states : three arrays of bool, shape (rows, columns)
        Which squares are clear, which undecided, and which in contact.
    wanted : Wanted
    title : str
        The picture's own headline.
    """
    load_modules("matplotlib.colors", "matplotlib.patches")
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    x, y = edges
    axes = axes_for(wanted, (float(np.ptp(x)), float(np.ptp(y))))
    kind = np.full(states[0].shape, np.nan)
    for number, state in enumerate(states):
        kind[state] = number
    colours = [colour for _, colour in _KINDS]
    axes.pcolormesh(x, y, kind, cmap=ListedColormap(colours), vmin=-0.5, vmax=2.5, rasterized=True)
    shown = [
        Patch(color=colour, label=name) for (name, colour), state in zip(_KINDS, states, strict=True) if state.any()
    ]
    axes.legend(handles=shown, loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    finish(axes, wanted, title)
    return figure_of(axes)
