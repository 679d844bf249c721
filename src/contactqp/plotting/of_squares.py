"""Maps of squares: where a membrane certainly touches, where it certainly does not, and the strip between."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..foundation.loading import load_modules
from ..foundation.pictures import Wanted
from .geometry import axes_for, figure_of, finish
from .style import CLEAR, CONTACT, INK, UNDECIDED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_KINDS = (("certainly clear", CLEAR), ("undecided", UNDECIDED), ("certainly in contact", CONTACT))


class Halves(NamedTuple):
    """Squares of which the frame leaves a half.

    Attributes
    ----------
    squares : array of bool, shape (rows, columns)
        Which they are.
    corners : array, shape (k, 3, 2)
        x and y of the corners of each half, in the order of ``np.nonzero(squares)`` (length).
    """

    squares: Mask
    corners: NDArray[np.float64]

    def of(self, squares: Mask) -> NDArray[np.float64]:
        """Return the corners of those that are among some squares."""
        return self.corners[squares[self.squares]]


class Strip(NamedTuple):
    """Squares that hold a free boundary.

    Attributes
    ----------
    edges : pair of arrays, shapes (columns + 1,) and (rows + 1,)
        x and y of the lines between squares (length).
    squares : array of bool, shape (rows, columns)
    halves : Halves
    """

    edges: tuple[Vector, Vector]
    squares: Mask
    halves: Halves


def map_of_squares(
    edges: tuple[Vector, Vector],
    states: tuple[Mask, Mask, Mask],
    halves: Halves,
    wanted: Wanted,
    title: str,
    rings: Sequence[NDArray[np.float64]] = (),
) -> Figure:
    """Draw which squares are clear, undecided and in contact.

    Parameters
    ----------
    edges : pair of arrays, shapes (columns + 1,) and (rows + 1,)
        x and y of the lines between the squares (length).
    states : three arrays of bool, shape (rows, columns)
        Which squares are clear, which undecided, and which in contact.
    halves : Halves
    wanted : Wanted
    title : str
        The picture's own headline.
    rings : sequence of arrays, shape (k, 2)
        Corners of closed lines that cut squares: nothing is drawn outside these (length).
    """
    load_modules("matplotlib.collections", "matplotlib.colors", "matplotlib.patches", "matplotlib.path")
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch, PathPatch
    from matplotlib.path import Path

    x, y = edges
    axes = axes_for(wanted, (float(np.ptp(x)), float(np.ptp(y))))
    kind = np.full(states[0].shape, np.nan)
    for number, state in enumerate(states):
        kind[state & ~halves.squares] = number
    colours = [colour for _, colour in _KINDS]
    for colour, state in zip(colours, states, strict=True):
        shown = list(halves.of(state))
        axes.add_collection(PolyCollection(shown, facecolors=colour, edgecolors="none", rasterized=True))
    squares = axes.pcolormesh(x, y, kind, cmap=ListedColormap(colours), vmin=-0.5, vmax=2.5, rasterized=True)
    if rings:
        contour = PathPatch(Path.make_compound_path(*(Path(ring, closed=True) for ring in map(_closed, rings))))
        contour.set(facecolor="none", edgecolor=INK, linewidth=0.8)
        axes.add_patch(contour)
        squares.set_clip_path(contour)
    kinds = [
        Patch(color=colour, label=name) for (name, colour), state in zip(_KINDS, states, strict=True) if state.any()
    ]
    place: Any = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.16), "frameon": False, "fontsize": "small"}
    axes.legend(handles=kinds, ncols=3, **place)
    finish(axes, wanted, title)
    return figure_of(axes)


def _closed(ring: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.concatenate([ring, ring[:1]])


def draw_strip(axes: Axes, strip: Strip) -> None:
    """Draw over a map the squares that hold the free boundary, hatched, and say so in the map's title.

    Parameters
    ----------
    axes : Axes
    strip : Strip
    """
    load_modules("matplotlib.collections", "matplotlib.patches")
    from matplotlib.collections import LineCollection, PatchCollection
    from matplotlib.patches import Patch, Polygon, Rectangle

    x, y = strip.edges
    padded = np.pad(strip.squares & ~strip.halves.squares, 1).astype(np.int8)
    # Runs of squares along each row, so that hatches go through.
    starts, ends = (np.argwhere(np.diff(padded[1:-1], axis=1) == sign) for sign in (1, -1))
    halves = strip.halves.of(strip.squares)
    runs: list[Patch] = [
        Rectangle((x[first], y[row]), x[last] - x[first], y[row + 1] - y[row])
        for (row, first), (_, last) in zip(starts, ends, strict=True)
    ]
    axes.add_collection(
        PatchCollection(
            [*runs, *map(Polygon, halves)], facecolor="none", edgecolor=INK, hatch="/////", linewidth=0.0, zorder=2.4
        )
    )
    upright = [[(x[k], y[row]), (x[k], y[row + 1])] for row, k in np.argwhere(np.diff(padded[1:-1], axis=1))]
    level = [[(x[k], y[row]), (x[k + 1], y[row])] for row, k in np.argwhere(np.diff(padded[:, 1:-1], axis=0))]
    slanted = halves[:, 1:].tolist()
    axes.add_collection(LineCollection([*upright, *level, *slanted], colors=INK, linewidths=0.8, zorder=2.4))
    axes.set_title(
        f"{axes.get_title()}\nhatched: the strip that holds the membrane's own free boundary", fontsize="medium"
    )
