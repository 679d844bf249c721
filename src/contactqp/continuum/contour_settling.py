r"""Settling: what load brings a lattice's values next to a contour to those of splines that fit to it.

Five-point differences with shortened arms leave, at the nodes they end at, an error of the second derivatives that does
not shrink with the spacing. Let d be how far the values at these nodes are to move. Then the load there changes by -Sd
over the area of a node, where S is the lattice's own stiffness of a strip along the contour, held at its inner side,
with all but the nodes of d eliminated. What comes of it is measured again: no proof depends on it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Generic, Protocol, Self, TypeVar

import numpy as np

from ..foundation.checks import Mask
from ..foundation.loading import load_modules
from ..geometry.numbering import Grid
from ..methods.mixing import Mixing
from .background import Background
from .cells import Cells
from .obstacle import Resolve

_WIDTH = 6
"""Nodes across the strip."""

_ROUNDS, _PATIENCE, _FEW, _DEPTH = 40, 15, 1, 8

_ENOUGH, _FAIR = 2e-3, 0.1
"""How far values are to be from those of splines, and may be, in units of what a membrane bends on a square."""


@dataclass(frozen=True, eq=False)
class EdgeStiffness:
    """The stiffness S of a lattice at the nodes next to a contour.

    Attributes
    ----------
    nodes, edge : array of bool, shape (rows + 2, columns + 2)
        The nodes, and those that arms join to the contour.
    springs : array, shape (rows + 2, columns + 2)
        Stiffness of these arms at each node (force per length).
    tension : float
        Of the other arms (force per length).
    """

    nodes: Mask
    edge: Mask
    springs: Grid
    tension: float

    @cached_property
    def _parts(self) -> tuple[Any, Any, Any, Any]:
        load_modules("scipy.sparse.linalg", "scipy.ndimage")
        from scipy.ndimage import binary_dilation
        from scipy.sparse import csr_array
        from scipy.sparse.linalg import splu

        strip = binary_dilation(self.edge, np.ones((3, 3), dtype=bool), _WIDTH) & self.nodes
        number = np.full(strip.shape, -1)
        count = int(strip.sum())
        number[strip] = np.arange(count)
        own, diagonal = number[strip], self.springs[strip].copy()
        entries = []
        for step in ((0, 1), (1, 0), (0, -1), (-1, 0)):
            beside, joined = (np.roll(each, step, (0, 1))[strip] for each in (number, self.nodes))
            diagonal += self.tension * joined
            entries.append((own[beside >= 0], beside[beside >= 0]))
        row, column = (np.concatenate(part) for part in zip(*entries, strict=True))
        weights = np.concatenate([np.full(row.size, -self.tension), diagonal])
        places = np.concatenate([row, own]), np.concatenate([column, own])
        matrix = csr_array((weights, places), shape=(count, count))
        edge = self.edge[strip]
        inner = splu(matrix[~edge][:, ~edge].tocsc()) if (~edge).any() else None
        return matrix[edge][:, edge], matrix[edge][:, ~edge], matrix[~edge][:, edge], inner

    def force(self, moved: Grid) -> Grid:
        """Return Sd at the nodes that arms join to the contour, zero elsewhere (force)."""
        own, out, back, inner = self._parts
        d = moved[self.edge]
        force = own @ d
        if inner is not None:
            force = force - out @ inner.solve(back @ d)
        found = np.zeros(moved.shape)
        found[self.edge] = force
        return found


class Fitting(Protocol):
    """What is asked of a problem within a contour, see `contactqp.continuum.contour_problem.ContourProblem`."""

    @property
    def cells(self) -> Cells:
        """The squares."""

    @property
    def tension(self) -> float:
        """T (force per length)."""

    @property
    def springs(self) -> Grid:
        """Stiffness of the arms by which the nodes are held by the contour (force per length)."""

    @property
    def background(self) -> Background:
        """What is added to splines."""

    @property
    def far(self) -> Mask:
        """Which nodes have no arm that ends on the contour."""

    @property
    def wanted(self) -> Grid:
        """About q at the points (force per area)."""

    @property
    def largest_bend(self) -> float:
        """What a membrane bends on a square (length)."""

    @property
    def corner_load(self) -> Grid:
        """What differences take the background for, a load (force per area)."""

    def bend(self, load: Grid) -> Grid:
        """Return the wanted sums of second differences under a load (length)."""

    def with_rim(self, gap: Grid) -> Grid:
        """Return a gap with that of the frame."""

    def with_background(self, background: Background) -> Self:
        """Return the problem with another background."""

    def fitted_to(self, gap: Grid, bend: Grid) -> tuple[Self, Grid]:
        """Return the problem with the background that an answer has, and the answer without what no membrane has."""

    def upper_coefficients(self, values: Grid, bend: Grid) -> Grid:
        """Return the coefficients of a spline through values."""


Problem = TypeVar("Problem", bound=Fitting)


class Settling(Generic[Problem]):
    """Solves a lattice again with loads that bring its values next to a contour to those of splines.

    Parameters
    ----------
    problem : Fitting
        Its background is chosen by the first call of `settle`.
    resolve : callable
        See `contactqp.continuum.obstacle.Resolve`.
    """

    def __init__(self, problem: Problem, resolve: Resolve) -> None:
        self.problem = problem
        self._resolve = resolve
        nodes = problem.cells.nodes
        edge = nodes & ~problem.far
        self._stiffness = EdgeStiffness(nodes, edge, np.where(edge, problem.springs, 0.0), problem.tension)
        self._moved = np.zeros(nodes.shape)

    def settle(self, gap: Grid) -> Grid | None:
        """Return the lattice's gap when its values next to the contour are those of a spline that fits to it.

        None if it does not come to that: where it touches next to a corner that points inwards.
        """
        change, mixing, best = np.zeros(gap.shape), Mixing(_DEPTH), np.inf
        edge, count = self._stiffness.edge, int(self._stiffness.edge.sum())
        bend = self.problem.bend(self.problem.wanted)
        # Functions count by what they are next to their corners.
        sizes = np.array(
            [(self.problem.cells.spacing / one.scale) ** one.exponent for one in self.problem.background.functions]
        )
        waited = 0
        for _ in range(_ROUNDS):
            fitted, clean = self.problem.fitted_to(gap, bend)
            away = self._away(fitted, clean, gap, bend)
            largest = float(np.abs(away).max())
            waited = 0 if largest < 0.7 * best else waited + 1
            best = min(best, largest)
            if largest <= _ENOUGH * self.problem.largest_bend or waited > _PATIENCE:
                break
            own, found = self.problem.background.factors, fitted.background.factors
            place = np.concatenate([self._moved[edge], sizes * own])
            place = mixing.next(place, np.concatenate([away[edge], sizes * (found - own)]))
            self._moved[edge] = place[:count]
            factors = place[count:] / sizes
            self.problem = self.problem.with_background(self.problem.background.with_factors(factors))
            gap = self._solved(change, self._moved)
        return gap if best <= _FAIR * self.problem.largest_bend else None

    def resolved(self, change: Grid) -> Grid:
        """Return the lattice's gap after its load changes at the points, settled anew."""
        bend, mixing, edge = self.problem.bend(self.problem.wanted + change), Mixing(), self._stiffness.edge
        moved = self._moved.copy()
        gap = self._solved(change, moved)
        for _ in range(_FEW):
            away = self._away(self.problem, gap, gap, bend)
            moved[edge] = mixing.next(moved[edge], away[edge])
            gap = self._solved(change, moved)
        return gap

    def _away(self, problem: Problem, clean: Grid, gap: Grid, bend: Grid) -> Grid:
        """Return how far the values next to the contour are to move, where there is no contact."""
        spline = problem.upper_coefficients(clean, bend)
        wanted = spline[1:-1, 1:-1] + problem.background.at_points
        return np.where(self._stiffness.edge & (gap > 0.0), wanted - gap, 0.0)

    def _solved(self, change: Grid, moved: Grid) -> Grid:
        added = -self._stiffness.force(moved) / self.problem.cells.spacing**2
        return self.problem.with_rim(self._resolve(change + added + self.problem.corner_load))
