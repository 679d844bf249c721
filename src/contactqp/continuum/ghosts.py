"""Coefficients beyond the rim: what a spline near the frame is continued by.

Any numbers there make a spline, and what is proven of it does not depend on where they come from; these make its
Laplacian nearly what the load wants. Across a side, the second difference is what the wanted Laplacian leaves once that
along the side is known. At a convex corner those along both sides are known, and need not add up to what is wanted:
under a uniform load, on a frame at one height, they are zero. There the second difference is either that along the
side, carried on to the corner, or what is wanted less that along the other side: a supersolution takes what bends less,
a subsolution what bends more.

Across a diagonal of the lattice points are mirrored onto points: with n the distance from it, w(-n) = 2w(0) - w(n) +
n² w_nn. Next to a corner between such a side and another one a ghost is what the sum of second differences wants at the
corner, if one of the two is known by then.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..geometry.numbering import Grid
from .cells import Cells, Edges

Corner: TypeAlias = Literal["less", "more"]
"""How a spline bends at a convex corner: as little as it can, or as much."""

_Places: TypeAlias = NDArray[np.int64]

_MARGIN = 2

Feet: TypeAlias = tuple[tuple[int, int], ...]
"""Places beyond an edge along a diagonal: half diagonals from its line, and half edges from its middle."""

_NEAR: Feet = ((1, 0), (2, -1), (2, 1), (3, 0))
_FAR: Feet = ((1, -2), (1, 2), (2, -3), (2, 3), (3, -2), (3, 2))


class Continuation:
    """Continues values at the points of a region by a ring beyond its rim.

    Parameters
    ----------
    cells : Cells
    """

    def __init__(self, cells: Cells) -> None:
        known = np.pad(cells.closure, 1)
        self._known = known
        reached = about(np.pad(cells.corners, 1)) & ~known
        self._stages: list[_Stage | _Mirrored | _Nearest] = []

        def taken(stage: _Stage | _Mirrored | _Nearest) -> Mask:
            """Return where the ghosts of a stage are, which are known from then on."""
            nonlocal known
            ghosts = np.zeros_like(known)
            ghosts.flat[stage.ghosts] = True
            if stage.ghosts.size:
                self._stages.append(stage)
            known = known | ghosts
            return ghosts

        if not cells.cut.any():
            beyond = taken(_Stage.of(known, (known & ~np.pad(cells.nodes, 1),) * 2, reached))
            # Beyond a corner two of the first ones meet; what bends less or more is chosen at the corner itself alone.
            taken(_Stage.of(known, (beyond, beyond), reached).without_choice())
            return
        rims = [np.zeros_like(known), np.zeros_like(known)]
        for axis, edges in enumerate(cells.rim[:2]):
            for row, column in edges.ends:
                rims[axis][row + 1, column + 1] = True
        taken(_Mirrored.of(cells, known, reached, _NEAR))
        beyond = taken(_Stage.of(known, (rims[0], rims[1]), reached))
        taken(_Mirrored.of(cells, known, reached, _NEAR))
        taken(_Stage.of(known, (beyond, beyond), reached).without_choice())
        for _ in range(2):
            taken(_Mirrored.of(cells, known, reached, _NEAR + _FAR))
        while (reached & ~known).any():
            taken(_Nearest.of(known, reached))

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
    def of(cls, known: Mask, rims: tuple[Mask, Mask], reached: Mask) -> _Stage:
        """Return the ghosts next to rims along rows and along columns that are reached, from what is known."""
        # With a margin, no step leads from one row to another.
        known, reached, *rim = (np.pad(points, _MARGIN) for points in (known, reached, *rims))
        strides = known.shape[1], 1
        flat = known.reshape(-1)
        rows = []
        for axis in (0, 1):
            across, along, on_rim = strides[axis], strides[1 - axis], rim[axis].reshape(-1)
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


@dataclass(frozen=True, eq=False)
class _Mirrored:
    """Ghosts that are mirrored from points that are known, across diagonals; places count flat.

    Attributes
    ----------
    ghosts : array
        Places of the ghosts.
    ghost : array
        Which ghost a proposal is for.
    mirror : array
        The point that it is mirrored from.
    start, end : array
        Ends of the edge across which it is.
    before, middle, after : array
        Three points of the side that follow each other, next to the edge; all the same where there are no three.
    across : array
        Half the square of how many levels the ghost lies beyond the edge, (n/h)².
    along : array
        Where between start and end its foot lies: 0 in the middle, ½ at the end.
    choice, step : array
        Where the mirror lies on another side of the frame: the point in its middle, and the step along it; else -1.
    """

    ghosts: _Places
    ghost: _Places
    mirror: _Places
    start: _Places
    end: _Places
    before: _Places
    middle: _Places
    after: _Places
    across: Vector
    along: Vector
    choice: _Places
    step: _Places

    @classmethod
    def of(cls, cells: Cells, known: Mask, reached: Mask, feet: Feet) -> _Mirrored:
        """Return the ghosts that are reached and not known, whose mirrors are known."""
        width = known.shape[1]
        rim, nodes = np.pad(cells.closure & ~cells.nodes, 1), np.pad(cells.nodes, 1)
        rows = []
        for edges in cells.slanted:
            for level, along in feet:
                rows.append(_across(edges, level, along, nodes, rim, known, reached))
        table = np.concatenate(rows, axis=1)
        ghost, mirror, start, end, before, middle, after, choice = (
            np.where(row < 0, -1, row * width + column)
            for row, column in zip(table[0:16:2], table[1:16:2], strict=True)
        )
        ghosts, number = np.unique(ghost, return_inverse=True)
        levels, along, down, right = table[16:]
        return cls(
            *(ghosts, number, mirror, start, end, before, middle, after),
            *(levels**2 / 2.0, along / 2.0, choice, down * width + right),
        )

    def fill(self, values: Vector, wanted: Vector, choose: np.ufunc) -> None:
        """Write the ghosts' values, and the sums of second differences that are wanted there."""
        start, end = values[self.start], values[self.end]
        bent = values[self.before] - 2.0 * values[self.middle] + values[self.after]
        foot = (start + end) / 2.0 + self.along * (end - start) + (self.along**2 - 0.25) / 2.0 * bent
        there = (wanted[self.start] + wanted[self.end]) / 2.0
        rise = self.across * (there - bent / 2.0)
        chosen = self.choice >= 0
        rise[chosen] = choose(rise[chosen], _bends(values, self.choice[chosen], self.step[chosen]))
        proposed = 2.0 * foot - values[self.mirror] + rise
        count = np.bincount(self.ghost, minlength=self.ghosts.size)
        values[self.ghosts] = np.bincount(self.ghost, proposed, self.ghosts.size) / count
        wanted[self.ghosts] = np.bincount(self.ghost, there, self.ghosts.size) / count


@dataclass(frozen=True, eq=False)
class _Nearest:
    """Ghosts that no rule reaches: the mean of what is known about them.

    Attributes
    ----------
    ghosts : array
        Their places.
    near : array
        Places of the eight points about each; its own where one is not known.
    """

    ghosts: _Places
    near: _Places

    @classmethod
    def of(cls, known: Mask, reached: Mask) -> _Nearest:
        """Return the ghosts that are reached, and have something known about them."""
        row, column = np.nonzero(reached & ~known & about(known))
        width = known.shape[1]
        own = row * width + column
        near = []
        for down in (-1, 0, 1):
            for right in (-1, 0, 1):
                i, j = row + down, column + right
                there = (i >= 0) & (i < known.shape[0]) & (j >= 0) & (j < width)
                there[there] = known[i[there], j[there]]
                near.append(np.where(there, i * width + j, own))
        return cls(own, np.array(near))

    def fill(self, values: Vector, wanted: Vector, _: np.ufunc) -> None:
        """Write the ghosts' values, and the sums of second differences that are wanted there."""
        given = self.near != self.ghosts
        for field in (values, wanted):
            field[self.ghosts] = np.where(given, field[self.near], 0.0).sum(axis=0) / given.sum(axis=0)


def _across(
    edges: Edges, level: int, along: int, nodes: Mask, rim: Mask, known: Mask, reached: Mask
) -> NDArray[np.int64]:
    """Return rows and columns of ghosts, and of what `_Mirrored` keeps of each, at one place beyond each edge.

    They lie ``level`` half diagonals beyond the edges, and ``along`` half edges from their middles.
    """
    down, right = edges.step
    start = np.array([edges.row, edges.column]) + 1
    step = np.array([[down], [right]])
    end = start + step
    # Of the two corners of the cell beside the edge one is a node.
    corner = start + np.array([[0], [right]])
    out = np.where(nodes[tuple(corner)], 1, -1) * np.array([[down], [-right]])
    twice = start + end + along * step
    ghost, mirror = (twice + side * level * out for side in (1, -1))
    ghost, mirror = ghost // 2, mirror // 2
    rows, columns = known.shape

    def among(points: Mask, place: NDArray[np.int64]) -> Mask:
        inside: Mask = np.asarray(((place >= 0) & (place < np.array([[rows], [columns]]))).all(axis=0))
        inside[inside] = points[tuple(place[:, inside])]
        return inside

    usable = among(reached & ~known, ghost) & among(known, mirror)
    before, after = among(rim, start - step), among(rim, end + step)
    middle = np.where(before, start, end)
    three = before | after
    three_before, three_after = np.where(before, start - step, start), np.where(before, end, end + step)
    first, middle, last = (np.where(three, place, start) for place in (three_before, middle, three_after))
    # On another side of the frame: ghost, foot and mirror on one line, and the point after that.
    foot, beyond = (ghost + mirror) // 2, mirror + (mirror - ghost) // 2
    other = among(rim, mirror) & among(rim, foot) & among(rim, beyond) & (level == 2)
    choice = np.where(other, mirror, -1)
    steps = np.where(other, foot - mirror, 0)
    size = np.ones(edges.row.size, dtype=np.int64)
    table = np.concatenate(
        [ghost, mirror, start, end, first, middle, last, choice, [level * size, along * size], steps]
    )
    return np.asarray(table[:, usable], dtype=np.int64)


def about(points: Mask) -> Mask:
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
