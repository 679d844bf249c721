r"""Windows about corners that point inwards: how a spline's Laplacian, and its height on the frame, depend on it there.

Both are linear in the coefficients c. With C the matrix that takes four coefficients of a cubic spline to its Bernstein
coefficients on a cell (see `contactqp.continuum.splines`), those of s and h²Δs on a cell are

.. math:: C c C^T, \qquad C c (R δ)^T + (R δ) c C^T,

where δ takes second differences, and R a linear function's two values to four Bernstein coefficients. Those of s along
a side of a cell are the ones at that side, and along a diagonal means of them, likewise. h²Δs is continuous, so that
cells share those of its Bernstein coefficients that lie on their sides.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..foundation.loading import load_modules
from ..geometry.numbering import Grid
from .cells import Cells, Edges
from .splines import TO_BERNSTEIN

_RADIUS = 4
"""How many spacings a window reaches to each side of its corner; with fewer more is missed at 315°."""

_LEAST_RADIUS = 2
"""Smaller windows are worse than none."""

_LARGEST, _MOST = 400, 2500
"""Coefficients of a window, and of all: corners next to each other share a window, and programs take their time.

A program of 81 coefficients takes 20 ms, one of 324 takes 0.2 s.
"""

_Numbers = NDArray[np.intp]

_LINEAR = np.array([[3, 0], [2, 1], [1, 2], [0, 3]]) / 3.0
_BENT = _LINEAR @ np.array([[1, -2, 1, 0], [0, 1, -2, 1]])
"""Two values to the Bernstein coefficients of a linear function, and four coefficients of a cubic spline to those of
its second derivative."""

_VALUES = np.kron(TO_BERNSTEIN, TO_BERNSTEIN)
_LAPLACIANS = np.kron(_BENT, TO_BERNSTEIN) + np.kron(TO_BERNSTEIN, _BENT)
_FIELDS = np.kron(_LINEAR, _LINEAR)
"""The same on a cell, from its sixteen coefficients, or four corners, counted row by row."""


class Heights(NamedTuple):
    """Bernstein coefficients of a spline on edges of the rim.

    Attributes
    ----------
    weights : sparse array, shape (n, coefficients)
        How the spline's coefficients make them up.
    start, end : arrays, shape (n,)
        Points between which each one's edge runs; they count flat.
    way : array, shape (n,)
        How far along it each lies, from 0 to 1.
    """

    weights: Any
    start: _Numbers
    end: _Numbers
    way: Vector

    def among(self, chosen: Mask) -> Heights:
        """Return some of them."""
        return Heights(self.weights[chosen], self.start[chosen], self.end[chosen], self.way[chosen])


@dataclass(frozen=True, eq=False)
class Window:
    """The coefficients about a corner that points inwards, and what depends on them; cells, points, places count flat.

    Attributes
    ----------
    places : array
        Of the coefficients that enter, those about the window among them.
    free : array of bool
        Which are the window's own.
    within : array of bool
        Which lie at points of the closed region.
    cells : array, shape (n,)
        For each Bernstein coefficient of the Laplacian its cell; those that cells share stand here for each of them.
    shared : array, shape (n,)
        A number that is the same for those that cells share.
    bends : sparse array, shape (n, places)
        How coefficients make up h²Δs there.
    corners, weights : arrays, shape (n, 4)
        Corners of the cell, and how their values make up a field there that is bilinear on it.
    heights : Heights
        On the rim, from the coefficients at ``places``.
    loose : array of bool
        Which of the heights depend on the window's own coefficients alone.
    """

    places: _Numbers
    free: Mask
    within: Mask
    cells: _Numbers
    shared: _Numbers
    bends: Any
    corners: _Numbers
    weights: Grid
    heights: Heights
    loose: Mask


def windows_of(cells: Cells) -> tuple[Window, ...]:
    """Return the windows about the corners that point inwards; none where they would be too large.

    Examples
    --------
    >>> mask = np.ones((15, 15), dtype=bool)
    >>> mask[:8, :8] = False
    >>> (window,) = windows_of(Cells(mask, 1.0))
    >>> int(window.free.sum()), int(window.places.size)  # of 9 by 9 those are missing that no cell depends on
    (72, 189)
    """
    if not cells.inward_corners[0].size:
        return ()
    load_modules("scipy.ndimage", "scipy.sparse")
    from scipy.ndimage import label, maximum_filter
    from scipy.sparse import vstack

    corners = np.zeros(_shape(cells), dtype=np.bool_)
    corners[1:-1, 1:-1][cells.inward_corners] = True
    reached = _reached(cells.inside)
    for radius in range(_RADIUS, _LEAST_RADIUS - 1, -1):
        number, count = label(reached & maximum_filter(corners, 2 * radius + 1), np.ones((3, 3)))
        sizes = np.bincount(number.ravel())[1:]
        if sizes.max() <= _LARGEST and sizes.sum() <= _MOST:
            break
    else:
        return ()
    rims = [_on_edges(edges, cells) for edges in cells.rim]
    weights = vstack([rim.weights for rim in rims], format="csr")
    start, end, way = (np.concatenate([rim[part] for rim in rims]) for part in (1, 2, 3))
    rim = Heights(weights, start, end, way)
    return tuple(_window(cells, rim, number == one) for one in range(1, count + 1))


def _window(cells: Cells, rim: Heights, own: Mask) -> Window:
    """Return the window of some coefficients."""
    width, columns = own.shape[1], cells.inside.shape[1]
    above, left = np.nonzero(cells.inside & _touched(own))
    bends = _combined(_LAPLACIANS, _blocks(above, left, width, 4), own.size)
    heights = rim.among(np.diff(rim.weights[:, own.ravel()].indptr) > 0)
    places = np.unique(np.concatenate([bends.indices, heights.weights.indices]))
    free = own.flat[places]
    return Window(
        places=places,
        free=free,
        within=np.pad(cells.closure, 1).flat[places],
        cells=np.repeat(above * columns + left, 16),
        # Bernstein coefficients lie on thirds of the cells' sides.
        shared=_blocks(3 * above, 3 * left, 3 * width, 4).ravel(),
        bends=bends[:, places],
        corners=np.repeat(_blocks(above, left, cells.nodes.shape[1], 2), 16, axis=0),
        weights=np.tile(_FIELDS, (above.size, 1)),
        heights=heights._replace(weights=heights.weights[:, places]),
        loose=np.diff(heights.weights[:, places[~free]].indptr) == 0,
    )


def _reached(cells: Mask) -> Mask:
    """Return the coefficients that splines on some cells depend on."""
    found = np.zeros((cells.shape[0] + 3, cells.shape[1] + 3), dtype=np.bool_)
    for down in range(4):
        for right in range(4):
            found[down : down + cells.shape[0], right : right + cells.shape[1]] |= cells
    return found


def _touched(coefficients: Mask) -> Mask:
    """Return the cells on which splines depend on some coefficients."""
    rows, columns = coefficients.shape[0] - 3, coefficients.shape[1] - 3
    blocks = [coefficients[down : down + rows, right : right + columns] for down in range(4) for right in range(4)]
    return np.asarray(np.logical_or.reduce(blocks))


def _on_edges(edges: Edges, cells: Cells) -> Heights:
    """Return the Bernstein coefficients of a spline on edges that run the same way, each from the cell beside it."""
    down, right = edges.step
    back = int(right < 0)
    # Of edges along lines the cell below, or to the right: of its coefficients those farthest from it do not enter.
    weights = np.asarray(_VALUES[::4] if down else _VALUES[:4], dtype=np.float64)
    if down and right:
        weights = _on_diagonal(backwards=bool(back))
    rows, columns = _shape(cells)
    places = _blocks(edges.row, edges.column - back, columns, 4)
    start, end = (np.repeat(row * cells.nodes.shape[1] + column, len(weights)) for row, column in edges.ends)
    way = np.tile(np.linspace(0.0, 1.0, len(weights)), edges.row.size)
    return Heights(_combined(weights, places, rows * columns), start, end, way)


def _on_diagonal(*, backwards: bool) -> Grid:
    """Return what makes the seven Bernstein coefficients along a cell's diagonal up from its sixteen coefficients."""
    net = _VALUES.reshape(4, 4, 16)
    net = net[:, ::-1] if backwards else net
    rows = np.zeros((7, 16))
    for k in range(4):
        for m in range(k, k + 4):
            rows[m] += comb(3, k) * comb(3, m - k) / comb(6, m) * net[k, m - k]
    return rows


def _combined(weights: Grid, places: _Numbers, size: int) -> Any:
    """Return the sparse array whose rows are the same few weights, once for each row of places."""
    load_modules("scipy.sparse")
    from scipy.sparse import csr_array

    row, part = np.nonzero(weights)
    rows = np.arange(places.shape[0])[:, None] * weights.shape[0] + row
    data = np.broadcast_to(weights[row, part], rows.shape)
    shape = places.shape[0] * weights.shape[0], size
    return csr_array((data.ravel(), (rows.ravel(), places[:, part].ravel())), shape=shape)


def _blocks(row: _Numbers, column: _Numbers, width: int, side: int) -> _Numbers:
    """Return, row by row, the places of square blocks that begin at some."""
    steps = np.arange(side)
    across = row[:, None] + steps
    return np.asarray((across[:, :, None] * width + (column[:, None] + steps)[:, None, :]).reshape(row.size, side**2))


def _shape(cells: Cells) -> tuple[int, int]:
    """Return the shape of arrays of coefficients."""
    return cells.nodes.shape[0] + 2, cells.nodes.shape[1] + 2
