"""Coefficients beyond the rim: what a spline near the frame is continued by.

Any numbers there make a spline, and what is proven of it does not depend on where they come from; these make its
Laplacian nearly what the load wants. Across a side, the second difference is what the wanted Laplacian leaves once that
along the side is known. At a convex corner those along both sides are known, and need not add up to what is wanted:
under a uniform load, on a frame at one height, they are zero. There the second difference is either that along the
side, carried on to the corner, or what is wanted less that along the other side: a supersolution takes what bends less,
a subsolution what bends more.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..geometry.numbering import Grid
from .cells import Cells

Corner: TypeAlias = Literal["less", "more"]
"""How a spline bends at a convex corner: as little as it can, or as much."""

_Places: TypeAlias = NDArray[np.int64]

_MARGIN = 2


class Continuation:
    """Continues values at the points of a region by a ring beyond its rim.

    Parameters
    ----------
    cells : Cells
    """

    def __init__(self, cells: Cells) -> None:
        known = np.pad(cells.closure, 1)
        self._known = known
        reached = _about(known)
        first = _Stage.of(known, known & ~np.pad(cells.nodes, 1), reached)
        beyond = np.zeros_like(known)
        beyond.flat[first.ghosts] = True
        # Beyond a corner two of the first ones meet; what bends less or more is chosen at the corner itself alone.
        self._stages = first, _Stage.of(known | beyond, beyond, reached).without_choice()

    def __call__(self, values: Grid, bend: Grid, corner: Corner) -> Grid:
        """Return the values with a ring about them.

        Parameters
        ----------
        values : array, shape (rows + 2, columns + 2)
            At the points; what they are outside the closed region does not matter.
        bend : array, shape (rows + 2, columns + 2)
            The wanted sum of the second differences along rows and columns at the points, in the unit of the values.
        corner : {"less", "more"}
            See `Corner`.

        Returns
        -------
        array, shape (rows + 4, columns + 4)
            Zero where no cell reaches.
        """
        found = np.where(self._known, np.pad(values, 1), 0.0)
        wanted = np.pad(bend, 1)
        for stage in self._stages:
            stage.fill(found.reshape(-1), wanted.reshape(-1), np.minimum if corner == "less" else np.maximum)
        return found


@dataclass(frozen=True, eq=False)
class _Stage:
    """Ghosts next to points that are known, and how each is proposed from one side or more; places count flat.

    Attributes
    ----------
    ghosts : array
        Places of the ghosts.
    ghost : array
        Which ghost a proposal is for.
    at, beyond : array
        The point next to it, and the one next to that.
    along, step_along : array
        Centre and step of the second difference along the side.
    choice, step_across : array
        Where there is one to choose from, centre and step of the second difference across, carried on; else -1.
    """

    ghosts: _Places
    ghost: _Places
    at: _Places
    beyond: _Places
    along: _Places
    step_along: _Places
    choice: _Places
    step_across: _Places

    @classmethod
    def of(cls, known: Mask, rim: Mask, reached: Mask) -> _Stage:
        """Return the ghosts next to the points of a rim that are reached, from what is known."""
        # With a margin, no step leads from one row to another.
        known, rim, reached = (np.pad(points, _MARGIN) for points in (known, rim, reached))
        strides = known.shape[1], 1
        flat, on_rim = known.reshape(-1), rim.reshape(-1)
        rows = []
        for axis in (0, 1):
            across, along = strides[axis], strides[1 - axis]
            inner_along, inner_across = (flat & np.roll(flat, step) & np.roll(flat, -step) for step in (along, across))
            for step in (across, -across):
                ghost = np.flatnonzero(reached.reshape(-1) & ~flat & np.roll(on_rim, -step) & np.roll(flat, -2 * step))
                at = ghost + step
                centre = np.where(inner_along[at], at, np.where(inner_along[at + along], at + along, at - along))
                corner = ~inner_along[at] & inner_across[at + step]
                choice = np.where(corner, at + step, -1)
                steps = np.full(ghost.size, along), np.full(ghost.size, step)
                usable = inner_along[centre]
                row = np.array([ghost, at, ghost + 2 * step, centre, steps[0], choice, steps[1]], dtype=np.int64)
                rows.append(row[:, usable])
        ghost, at, beyond, centre, along, choice, across = np.concatenate(rows, axis=1)
        width = known.shape[1]

        def place(padded: _Places) -> _Places:
            row, column = np.divmod(padded, width)
            return np.where(padded < 0, -1, (row - _MARGIN) * (width - 2 * _MARGIN) + column - _MARGIN)

        def stride(padded: _Places) -> _Places:
            return np.where(np.abs(padded) == width, np.sign(padded) * (width - 2 * _MARGIN), padded)

        ghosts, number = np.unique(place(ghost), return_inverse=True)
        return cls(
            ghosts, number, place(at), place(beyond), place(centre), stride(along), place(choice), stride(across)
        )

    def without_choice(self) -> _Stage:
        """Return the same with no second differences carried on."""
        return _Stage(
            *(self.ghosts, self.ghost, self.at, self.beyond, self.along, self.step_along),
            *(np.full_like(self.choice, -1), self.step_across),
        )

    def fill(self, values: Vector, wanted: Vector, choose: np.ufunc) -> None:
        """Write the ghosts' values, and the sums of second differences that are wanted there."""
        bent = wanted[self.at] - _bends(values, self.along, self.step_along)
        chosen = self.choice >= 0
        carried = _bends(values, self.choice[chosen], self.step_across[chosen])
        bent[chosen] = choose(bent[chosen], carried)
        proposed = 2.0 * values[self.at] - values[self.beyond] + bent
        count = np.bincount(self.ghost, minlength=self.ghosts.size)
        values[self.ghosts] = np.bincount(self.ghost, proposed, self.ghosts.size) / count
        wanted[self.ghosts] = np.bincount(self.ghost, wanted[self.at], self.ghosts.size) / count


def _about(points: Mask) -> Mask:
    """Return some points of an array and all next to them, diagonally as well; none of them is at the array's end."""
    rows = points.copy()
    rows[1:] |= points[:-1]
    rows[:-1] |= points[1:]
    found = rows.copy()
    found[:, 1:] |= rows[:, :-1]
    found[:, :-1] |= rows[:, 1:]
    return found


def _bends(values: Vector, at: _Places, step: _Places) -> Vector:
    return np.asarray(values[at - step] - 2.0 * values[at] + values[at + step])
