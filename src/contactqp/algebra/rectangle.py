"""Recognise the five-point matrix of a rectangular lattice, or of a line, that was given as a sparse array."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .stencil import Stencil

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_ROUNDING = 1e-13
"""Relative differences that the assembly of a matrix may leave."""


def rectangle_of(matrix: csr_array) -> Stencil | None:
    """Return the stencil of a matrix whose unknowns are a rectangle's nodes row by row, or None if it is not one.

    Such a matrix couples each unknown to the next and to the one a row further on, with entries <= 0; what the diagonal
    has beyond the sum of these is the stiffness of arms that end on the frame, so it is positive along the border at
    most. A tridiagonal matrix is a rectangle of one row. Differences as small as rounding errors are overlooked: the
    stencil is meant for starts and candidates, never for a proof.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Symmetric; that is not checked.

    Returns
    -------
    Stencil or None

    Examples
    --------
    >>> import numpy as np
    >>> stencil = Stencil(np.ones((3, 4), dtype=bool), 1.0, 1.0)
    >>> rectangle_of(stencil.tocsr())
    Stencil(12 nodes in 3 x 4, uniform)
    >>> rectangle_of((stencil.tocsr() + stencil.tocsr() @ stencil.tocsr()).tocsr()) is None
    True
    """
    size = matrix.shape[0]
    if matrix.nnz > 5 * size or size < 4:
        return None
    rows = np.repeat(np.arange(size), np.diff(matrix.indptr))
    offset = matrix.indices - rows
    columns = int(offset.max(initial=0))
    if columns == 1:
        columns = size
    if columns < 2 or size % columns or not np.isin(offset, (-columns, -1, 0, 1, columns)).all():
        return None
    count = size // columns
    diagonal = matrix.diagonal()
    east, north = np.zeros(size), np.zeros(size)
    east[rows[offset == 1]] = -matrix.data[offset == 1]
    north[rows[offset == columns]] = -matrix.data[offset == columns]
    east, north, diagonal = (values.reshape(count, columns) for values in (east, north, diagonal))
    if east[:, -1].any() or north[-1].any() or min(east.min(), north.min()) < 0:
        return None
    horizontal, vertical = np.zeros((count, columns + 1)), np.zeros((count + 1, columns))
    horizontal[:, 1:], vertical[1:] = east, north
    inner = (horizontal[:, :-1] + horizontal[:, 1:]) + (vertical[:-1] + vertical[1:])
    surplus = diagonal - inner
    surplus[np.abs(surplus) <= _ROUNDING * diagonal] = 0.0
    if surplus.min() < 0 or surplus[1:-1, 1:-1].any():
        return None
    return _with_frame(horizontal, vertical, surplus)


def _with_frame(horizontal: np.ndarray, vertical: np.ndarray, surplus: np.ndarray) -> Stencil:
    """Return the stencil with the surplus of the border nodes given to the arms that end on the frame."""
    mask = np.ones(surplus.shape, dtype=np.bool_)
    across = float(np.median(horizontal[:, 1:-1]))
    along = float(np.median(vertical[1:-1])) if len(mask) > 1 else 0.0
    frame = np.zeros(surplus.shape)
    frame[:, 0] += across
    frame[:, -1] += across
    frame[0] += along
    frame[-1] += along
    same = np.abs(surplus - frame).max() <= _ROUNDING * (across + along)
    even = _even(horizontal[:, 1:-1], across) and _even(vertical[1:-1], along)
    if same and even:
        return Stencil(mask, across, along)
    # A corner has two such arms, which share; a rectangle of one row has its nodes between two.
    sides = np.zeros(surplus.shape)
    sides[:, 0] += 1
    sides[:, -1] += 1
    sides[0] += 1
    sides[-1] += 1
    share = np.divide(surplus, sides, out=np.zeros_like(surplus), where=sides > 0)
    horizontal[:, 0], horizontal[:, -1] = share[:, 0], share[:, -1]
    vertical[0], vertical[-1] = share[0], share[-1]
    return Stencil(mask, horizontal, vertical)


def _even(arms: np.ndarray, value: float) -> bool:
    return arms.size == 0 or bool(np.abs(arms - value).max() <= _ROUNDING * value)
