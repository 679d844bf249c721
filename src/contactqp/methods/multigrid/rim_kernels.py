"""Compiled pass over the nodes beside a frame that cuts their arms: what holds a coarse lattice there."""

from __future__ import annotations

from numba import njit

from ...geometry.numbering_kernels import GRID

_MASK, _STIFFNESSES = (f"Array({kind}, 2, 'C', readonly=True)" for kind in ("boolean", "float64"))


@njit
def _is_node(mask, i, j):  # type: ignore[no-untyped-def]
    return i >= 0 and j >= 0 and i < mask.shape[0] and j < mask.shape[1] and mask[i, j]


@njit
def _share(mask, ground, i, j):  # type: ignore[no-untyped-def]
    """Return what the ground adds to each of the arms by which the frame holds a node."""
    arms = 0
    for up, right in ((0, -1), (0, 1), (-1, 0), (1, 0)):
        arms += not _is_node(mask, i + up, j + right)
    return ground[i, j] / max(1, arms)


@njit(f"void({_MASK}, {_STIFFNESSES}, {_MASK}, {GRID}, float64, float64, int64, int64)", cache=True, nogil=True)
def hold_coarse_rim(mask, ground, coarse, held, across, along, down, right):  # type: ignore[no-untyped-def]
    """Add to ``held`` by how much coarse nodes' arms to the frame are stiffer than the equal ones.

    The arm of a coarse node ends where that of the last node in its direction does: one arm long, or two in series. It
    stands for as many rows, or columns, as are joined in one.

    Parameters
    ----------
    mask : array of bool, shape (rows, columns)
        Nodes of the finer lattice.
    ground : array, shape (rows, columns)
        Stiffness of what else than equal arms holds them.
    coarse : array of bool
        Nodes of the coarser lattice.
    held : array
        Of its shape.
    across, along : float
        Stiffness of the finer lattice's arms along its rows and its columns.
    down, right : int
        By how much rows and columns are coarsened.
    """
    for row in range(coarse.shape[0]):
        for column in range(coarse.shape[1]):
            if not coarse[row, column]:
                continue
            i, j = down * (row + 1) - 1, right * (column + 1) - 1
            for up, beside in ((0, -1), (0, 1), (-1, 0), (1, 0)):
                if _is_node(coarse, row + up, column + beside):
                    continue
                arm, joined, lines = (along, down, right) if beside == 0 else (across, right, down)
                stiffness = arm + _share(mask, ground, i, j)
                if joined == 2 and _is_node(mask, i + up, j + beside):
                    beyond = arm + _share(mask, ground, i + up, j + beside)
                    stiffness = arm * (beyond / (arm + beyond)) if arm > 0.0 else beyond
                held[row, column] += max(lines * (stiffness - arm / joined), 0.0)
