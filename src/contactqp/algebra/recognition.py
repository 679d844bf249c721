"""Recognise the five-point matrix of a lattice that was given as a sparse array.

Its unknowns are the nodes of a mask, row by row. Nodes with consecutive numbers that are coupled make a run, along a
row; couplings of other nodes, of which each has one to the row before and one to the next at most, tell how runs lie to
each other. Any lattice that has the matrix will do, whether it is the one that was meant or not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Vector
from ..foundation.loading import load_modules
from .stencil import Stencil

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_ROUNDING = 1e-13
"""Relative differences that the assembly of a matrix may leave."""

_FEWEST = 4
"""Unknowns below which nothing is gained."""

_MOST_EMPTY = 8
"""Points of the mask for each node: an array of more would cost more than it saves."""

Numbers = NDArray[np.int64]


def lattice_of(matrix: csr_array) -> Stencil | None:
    """Return the stencil of a matrix whose unknowns are a lattice's nodes row by row, or None if it is not one.

    The nodes must hang together. What the diagonal has beyond the couplings, all of them <= 0, is the stiffness of arms
    that end on the frame, so it is positive at most where a neighbour is missing. A tridiagonal matrix is a lattice of
    one row. Differences as small as rounding errors are overlooked: the stencil is meant for starts and candidates,
    never for a proof.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Symmetric, which is not checked, with ascending column numbers.

    Returns
    -------
    Stencil or None

    Examples
    --------
    >>> import numpy as np
    >>> mask = np.ones((3, 4), dtype=bool)
    >>> mask[1, 2] = False
    >>> stencil = Stencil(mask, 1.0, 1.0)
    >>> lattice_of(stencil.tocsr())
    Stencil(11 nodes in 3 x 4, uniform)
    >>> lattice_of((stencil.tocsr() + stencil.tocsr() @ stencil.tocsr()).tocsr()) is None
    True
    """
    size = matrix.shape[0]
    if size < _FEWEST or matrix.nnz > 5 * size:
        return None
    couplings = _couplings(matrix)
    places = None if couplings is None else _places(couplings)
    if couplings is None or places is None:
        return None
    row, column = places
    mask = np.zeros((int(row.max()) + 1, int(column.max()) + 1), dtype=np.bool_)
    mask[row, column] = True
    return _with_frame(mask, places, couplings, matrix.diagonal())


class _Couplings(NamedTuple):
    """What each unknown is coupled to.

    Attributes
    ----------
    east : array, shape (n,)
        Stiffness of the arm to the next unknown, 0 where there is none; so for the last one.
    lower, upper : array of int
        Unknowns of different rows that are joined, each once.
    north : array
        Stiffness of their arms.
    """

    east: Vector
    lower: Numbers
    upper: Numbers
    north: Vector


def _couplings(matrix: csr_array) -> _Couplings | None:
    """Return the couplings; None if one is > 0, or an unknown has more than one to another row on either side."""
    size = matrix.shape[0]
    rows = np.repeat(np.arange(size, dtype=np.int64), np.diff(matrix.indptr))
    ahead = matrix.indices - rows
    next_to, beyond = ahead == 1, ahead > 1
    lower, upper = rows[beyond], matrix.indices[beyond].astype(np.int64)
    east, north = np.zeros(size), -matrix.data[beyond]
    east[rows[next_to]] = -matrix.data[next_to]
    if min(east.min(), north.min(initial=0.0)) < 0:
        return None
    # Along rows that follow each other, nodes and those above them are numbered in one order.
    if not ((np.diff(lower) > 0).all() and (np.diff(upper) > 0).all()):
        return None
    return _Couplings(east, lower, upper, north)


def _places(couplings: _Couplings) -> tuple[Numbers, Numbers] | None:
    """Return the rows and columns of the unknowns, each from 0 on; None where the couplings contradict each other."""
    size = couplings.east.size
    begins = np.concatenate([[True], couplings.east[:-1] == 0])
    run = np.cumsum(begins) - 1
    along = np.arange(size) - np.flatnonzero(begins)[run]
    lower, upper = couplings.lower, couplings.upper
    laid = _laid_out(run[lower], run[upper], along[lower] - along[upper], int(run[-1]) + 1)
    if laid is None:
        return None
    row, column = laid[0][run], laid[1][run] + along
    row, column = row - row.min(), column - column.min()
    width = int(column.max()) + 1
    fits = (row[upper] == row[lower] + 1).all() and (column[upper] == column[lower]).all()
    if not fits or width * (int(row.max()) + 1) > _MOST_EMPTY * size or (np.diff(row * width + column) <= 0).any():
        return None
    return row, column


def _laid_out(below: Numbers, above: Numbers, shift: Numbers, count: int) -> tuple[Numbers, Numbers] | None:
    """Return row and first column of each run, by a tree of couplings; None where the runs do not hang together.

    Parameters
    ----------
    below, above : array of int
        Runs that a coupling joins, both ascending.
    shift : array of int
        How many columns the one above begins farther on.
    count : int
        Number of runs.
    """
    load_modules("scipy.sparse.csgraph", "scipy.sparse")
    from scipy import sparse
    from scipy.sparse import csgraph

    pair = below * count + above
    first = np.flatnonzero(np.diff(pair, prepend=-1))
    pair = pair[first]
    graph = sparse.coo_array((np.ones(pair.size), (below[first], above[first])), shape=(count, count)).tocsr()
    order, before = csgraph.breadth_first_order(graph, 0, directed=False)
    if order.size < count:
        return None
    child, parent = order[1:].astype(np.int64), before[order[1:]].astype(np.int64)
    # Runs are numbered upwards, so of two that are joined the one above has the larger number.
    up = child > parent
    found = first[np.searchsorted(pair, np.where(up, parent * count + child, child * count + parent))]
    step = np.where(up, shift[found], -shift[found]).tolist()
    row, column = [0] * count, [0] * count
    for run, origin, rises, by in zip(child.tolist(), parent.tolist(), up.tolist(), step, strict=True):
        row[run] = row[origin] + (1 if rises else -1)
        column[run] = column[origin] + by
    return np.array(row), np.array(column)


def _with_frame(
    mask: NDArray[np.bool_], places: tuple[Numbers, Numbers], couplings: _Couplings, diagonal: Vector
) -> Stencil | None:
    """Return the stencil; what the diagonal has beyond the couplings goes to the arms where neighbours are missing."""
    row, column = places
    east, north = couplings.east, couplings.north
    horizontal, vertical = np.zeros((mask.shape[0], mask.shape[1] + 1)), np.zeros((mask.shape[0] + 1, mask.shape[1]))
    joined = east > 0
    horizontal[row[joined], column[joined] + 1] = east[joined]
    vertical[row[couplings.upper], column[couplings.upper]] = north
    ends = horizontal[row, column], horizontal[row, column + 1], vertical[row, column], vertical[row + 1, column]
    surplus = diagonal - ((ends[0] + ends[1]) + (ends[2] + ends[3]))
    surplus[np.abs(surplus) <= _ROUNDING * diagonal] = 0.0
    ringed = np.pad(mask, 1)
    missing = [~ringed[row + 1 + up, column + 1 + right] for up, right in ((0, -1), (0, 1), (-1, 0), (1, 0))]
    sides = np.sum(missing, axis=0)
    if surplus.min() < 0 or surplus[sides == 0].any():
        return None
    across, along = (float(np.median(arms)) if arms.size else 0.0 for arms in (east[joined], north))
    frame = across * (missing[0] + missing[1].astype(np.float64)) + along * (missing[2] + missing[3].astype(np.float64))
    if _even(surplus, frame, across + along) and _even(east[joined], across, across) and _even(north, along, along):
        beside, above = np.count_nonzero(mask[:, 1:] & mask[:, :-1]), np.count_nonzero(mask[1:] & mask[:-1])
        if beside == np.count_nonzero(joined) and above == north.size:
            return Stencil(mask, across, along)
    # A corner has two such arms, which share; a lattice of one row has its nodes between two.
    share = np.divide(surplus, sides, out=np.zeros_like(surplus), where=sides > 0)
    for arms, place, side in zip(
        (horizontal, horizontal, vertical, vertical),
        ((row, column), (row, column + 1), (row, column), (row + 1, column)),
        missing,
        strict=True,
    ):
        arms[place[0][side], place[1][side]] = share[side]
    try:
        return Stencil(mask, horizontal, vertical)
    except ValueError:  # a part that nothing holds
        return None


def _even(arms: Vector, value: Vector | float, size: float) -> bool:
    return arms.size == 0 or bool(np.abs(arms - value).max() <= _ROUNDING * size)
