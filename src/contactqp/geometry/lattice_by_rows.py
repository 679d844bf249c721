"""LatticeByRows: the nodes of a lattice, told for the rows that are asked for."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..foundation.together import ALONE, Together, share_of
from .lattice import Lattice

NodesOfRows: TypeAlias = Callable[[int, int], Mask]
"""Returns where there are nodes in the rows [first, last), shape (rows, columns)."""


class LatticeFacts(NamedTuple):
    """What is known of a lattice as a whole, see `Lattice`.

    Attributes
    ----------
    overshoot : float
    caution : str
    slanted : bool
    crs : str
    """

    overshoot: float = 0.0
    caution: str = ""
    slanted: bool = False
    crs: str = ""


EXACT = LatticeFacts()
"""What is known of a lattice whose points are its contour."""


class Held(NamedTuple):
    """Which rows and columns of a lattice have nodes.

    Attributes
    ----------
    rows : array of bool, shape (rows,)
    columns : array of bool, shape (columns,)
    """

    rows: Mask
    columns: Mask

    @classmethod
    def of(cls, own: Mask, together: Together) -> Held:
        """Return what all processes hold, each of which hands over its rows, shape (rows, columns)."""
        rows, columns = zip(*together.everyones([(own.any(axis=1), own.any(axis=0))]), strict=True)
        return cls(np.concatenate(rows), np.logical_or.reduce(columns))


class LatticeByRows:
    """A lattice of which nobody lays out more than some rows; its nodes are read by ``lattice[first:last]``.

    It has shape and dimensions as an array has.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns.
    spacing : float
        Distance of neighbouring points (length).
    origin : (float, float)
        x and y of the point of the first row and column (length).
    nodes : callable
        See `NodesOfRows`.
    held : Held
    facts : LatticeFacts
    describe : callable, optional
        Names the node in a row and a column, for messages; by default by its place.

    Examples
    --------
    >>> lattice = LatticeByRows.of(Lattice.from_mask(np.eye(3, 4) > 0, 0.5))
    >>> lattice[1:3]
    array([[False,  True, False, False],
           [False, False,  True, False]])
    >>> lattice.held.columns
    array([ True,  True,  True, False])
    """

    ndim = 2

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: float,
        origin: tuple[float, float],
        nodes: NodesOfRows,
        held: Held,
        facts: LatticeFacts = EXACT,
        describe: Callable[[int, int], str] | None = None,
    ) -> None:
        self.shape, self.spacing, self.origin = shape, spacing, origin
        self.held, self.facts = held, facts
        self._nodes, self._describe = nodes, describe

    @classmethod
    def of(cls, lattice: Lattice) -> LatticeByRows:
        """Return a lattice that is laid out, row by row."""
        mask = lattice.mask

        def describe(row: int, column: int) -> str:
            before = np.count_nonzero(mask[:row]) + np.count_nonzero(mask[row, :column])
            return lattice.describe(int(before))

        held = Held.of(mask, ALONE)
        facts = LatticeFacts(lattice.overshoot, lattice.caution, lattice.slanted, lattice.crs)
        nodes = _rows_of(mask)
        return cls(lattice.shape, lattice.spacing, lattice.origin, nodes, held, facts, describe)

    @classmethod
    def read(
        cls,
        shape: tuple[int, int],
        spacing: float,
        origin: tuple[float, float],
        nodes: NodesOfRows,
        together: Together,
        facts: LatticeFacts,
    ) -> LatticeByRows:
        """Return a lattice of whose nodes each process looks at some, so that all know which rows and columns have any.

        Raises
        ------
        ValueError
            If it has no node, in every process.
        """
        held = Held.of(together.agreed(lambda: nodes(*share_of(shape[0], together))), together)
        if not held.rows.any():
            raise ValueError(f"mask of shape {shape} holds no node: choose a smaller spacing or a larger frame")
        return cls(shape, spacing, origin, nodes, held, facts)

    def __getitem__(self, rows: slice) -> Mask:
        first, last, _ = rows.indices(self.shape[0])
        return self._nodes(first, last)

    @property
    def x(self) -> Vector:
        """Abscissae of the columns, shape (columns,), length."""
        return np.asarray(self.origin[0] + self.spacing * np.arange(self.shape[1]))

    @property
    def y(self) -> Vector:
        """Ordinates of the rows, shape (rows,), ascending, length."""
        return np.asarray(self.origin[1] + self.spacing * np.arange(self.shape[0]))

    def describe(self, row: int, column: int) -> str:
        """Name a node, for messages."""
        if self._describe is not None:
            return self._describe(row, column)
        x, y = self.origin[0] + self.spacing * column, self.origin[1] + self.spacing * row
        return f"x={x:g}, y={y:g}"


def _rows_of(mask: NDArray[np.bool_]) -> NodesOfRows:
    return lambda first, last: mask[first:last]
