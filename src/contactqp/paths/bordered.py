"""Solutions with a bordered factorisation: nodes join and leave the free set without a new factorisation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..methods.factors import factorised

if TYPE_CHECKING:
    from scipy.sparse import csr_array


_MOST_BORDERS = 48
"""Nodes that may have changed sides before the matrix of the free nodes is factorised anew."""


class Bordered:
    """Solutions of G_FF x = -q_F for a changing set F, by the factors for an earlier one and a border.

    For the earlier set F₀ let x₀ = -G₀⁻¹q. A node that is held now gives a column e of a unit force, a node that is
    free now the column of G that couples it to F₀; with Z the solutions G₀⁻¹ of these columns, x = x₀ - Zy, and
    y follows from the few equations that the held nodes have no gap and the new free nodes no reaction.
    """

    def __init__(self, matrix: csr_array, forces: Vector, free: Mask) -> None:
        self._matrix, self._forces = matrix, forces
        self.free = free.copy()
        self._known: Vector | None = None
        self._factorise()

    def toggle(self, nodes: NDArray[np.int64]) -> None:
        """Let nodes change sides."""
        self.free = self.free.copy()
        self.free[nodes] = ~self.free[nodes]
        self._known = None
        changed = set(self._borders) ^ set(nodes.tolist())
        if len(changed) > _MOST_BORDERS:
            self._factorise()
            return
        for node in [node for node in nodes.tolist() if node not in changed]:
            # The last border takes the place of the one that is given up.
            place, last = self._borders.index(node), len(self._borders) - 1
            self._columns[:, place] = self._columns[:, last]
            self._borders[place] = self._borders[last]
            self._borders.pop()
        for node in [node for node in nodes.tolist() if node in changed]:
            self._columns[:, len(self._borders)] = self._column(node)
            self._borders.append(node)

    def gap(self) -> Vector:
        """Return x on F and 0 elsewhere, for each column of the forces, shape (n, 2)."""
        if self._known is None:
            self._known = self._gap_with_border() if self._borders else self._on_nodes(self._gap)
        return self._known

    def _gap_with_border(self) -> Vector:
        borders = np.array(self._borders)
        columns = self._columns[:, : borders.size]
        place = self._place[borders]
        held, released = place >= 0, place < 0
        equations, right = np.empty((borders.size, borders.size)), np.empty((borders.size, self._forces.shape[1]))
        equations[held], right[held] = columns[place[held]], self._gap[place[held]]
        if released.any():
            rows = self._matrix[borders[released]]
            coupling = rows[:, self._first]
            among = np.where(released, rows[:, borders].toarray(), 0.0)
            equations[released] = among - coupling @ columns
            right[released] = -self._forces[borders[released]] - coupling @ self._gap
        unknown = np.linalg.solve(equations, right)
        gap = self._on_nodes(self._gap - columns @ unknown)
        gap[borders[released]] = unknown[released]
        gap[borders[held]] = 0.0
        return gap

    def _on_nodes(self, values: Vector) -> Vector:
        gap = np.zeros(self._forces.shape)
        gap[self._first] = values
        return gap

    def _column(self, node: int) -> Vector:
        if self._place[node] >= 0:
            force = np.zeros(self._first.size)
            force[self._place[node]] = 1.0
        else:
            force = self._matrix[[node]][:, self._first].toarray().ravel()
        return self._solve(force) if self._first.size else force

    def _factorise(self) -> None:
        self._first = np.flatnonzero(self.free)
        self._place = np.full(self.free.size, -1, dtype=np.int64)
        self._place[self._first] = np.arange(self._first.size)
        self._borders: list[int] = []
        # The columns Z of the borders, in their order; a whole array is made once, not at every change.
        self._columns = np.empty((self._first.size, _MOST_BORDERS), order="F")
        self._known = None
        if not self._first.size:
            self._gap = np.zeros((0, self._forces.shape[1]))
            return
        solve = factorised(self._matrix[self._first][:, self._first])
        if solve is None:
            raise RuntimeError("the matrix of the free nodes is singular in double precision")
        self._solve = solve
        self._gap = -solve(self._forces[self._first])
