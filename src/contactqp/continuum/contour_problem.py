r"""ContourProblem: the gap of a membrane within a contour that cuts the squares of a lattice anywhere.

A barrier is U = s + b + τ⁺v + δ⁺, or L = s + b - τ⁻v - δ⁻, where b is a sum of harmonic functions about the corners of
the contour, see `contactqp.continuum.background`. They are continuous on the closed region and in H¹, though their
derivatives have no bound at a corner: so ∫∇b·∇d = 0 for all d ∈ H¹ that vanish on the frame, and the proof of
`contactqp.continuum.barriers` holds with TΔs in the place of TΔU.

*Above the support in a square that is cut.* U must not be lower than ψ in the part of a square K that lies in the
region, which it may well be beyond the contour. Let U ≥ γ - ε on the contour, m the least of γ - ε there and of U at
the corners of K that lie in the region. A point of the region in K lies on a line along x, on which it is between two
points of the contour, or of the sides of K along y. A point of the latter in the region lies between two points of the
contour, or corners of K, on that side. A function f on an interval of length h is no less than the least of its values
at the ends less h²/8 max f″⁺. So in the part of K that lies in the region

.. math:: U ≥ m - \tfrac18 h² (\max_K s_{xx}^+ + \max_K s_{yy}^+) - 2 \max_K \|b - Qb\|,

where s is taken with the spline Qb that follows b, which U is compared with twice, at the ends and between, and h²s_xx
is a convex combination of second differences of the coefficients.

*About corners* some squares are hidden, in which little is known of b. Let D be the part of the region in some that
hang together, with a middle c no farther than r from any point of it, and TΔU = TΔs ≤ M there, M ≥ 0. Then U -
M\|x - c\|²/4T is superharmonic in D, and takes its least value on the edge of D, which is contour, or belongs to
squares beside those:

.. math:: U ≥ \min(γ - ε, \min U) - \tfrac{1}{4T} M r².
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, Self

import numpy as np

from ..foundation.checks import Mask, Vector
from ..foundation.loading import load_modules
from ..foundation.rounding import UNIT_ROUNDOFF, gamma
from ..geometry.numbering import Grid
from .background import Background
from .contour import Contour
from .contour_layer import Layer, second_differences
from .contour_rim import ContourRim
from .contour_settling import Settling
from .corner_functions import CornerFunction
from .ghosts import about
from .obstacle import ObstacleProblem, Resolve
from .splines import CellRanges, ranges_on_cells
from .windows import Window

_ERROR = gamma(64)

_SIXTH = 1.0 / 6.0

_NEXT, _FOCUS = 4.0, 8.0
"""How far about a corner, in spacings, a spline does not take the lattice's values, and is to be smooth."""

_BY_FRAME_ALONE = "layer", "given", "far", "heights_halfway", "least_height"
"""What takes long, and is the same for all sums of functions."""

_IN_THE_MIDDLE = np.array([1, 6, 15, 20, 15, 6, 1]) / 64.0
"""Weights of the Bernstein coefficients of a polynomial of degree six in its value halfway."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ContourProblem(ObstacleProblem):
    """An obstacle problem within a contour, see `ObstacleProblem`.

    Attributes
    ----------
    rim : ContourRim
        What is known of γ along the contour (length); over a floor F of γ - F.
    held : array of bool, shape (rows + 2, columns + 2)
        Which points lie in the closed region, or next to it by rounding.
    springs : array, shape (rows + 2, columns + 2)
        Stiffness of the arms by which the lattice's nodes are held by the contour (force per length).
    background : Background
        b, which is added to splines.
    """

    rim: ContourRim
    held: Mask
    springs: Grid
    background: Background

    patience: ClassVar[int] = 3
    near: ClassVar[float] = 1.5

    def __post_init__(self) -> None:
        pass  # the frame has no edges between points, by which a lattice's problem is continued

    @property
    def contour(self) -> Contour:
        """The contour on the lattice."""
        return self.rim.contour

    @property
    def windows(self) -> tuple[Window, ...]:
        """None: corners that point inwards have functions."""
        return ()

    def with_rim(self, gap: Grid) -> Grid:
        """Return a gap at the nodes, zero elsewhere."""
        return np.where(self.cells.nodes, gap, 0.0)

    def with_background(self, background: Background) -> Self:
        """Return the problem with another sum of the same functions."""
        found = replace(self, background=background)
        for name in _BY_FRAME_ALONE:
            found.__dict__[name] = getattr(self, name)
        return found

    @cached_property
    def layer(self) -> Layer:
        """How coefficients next to the contour follow from those farther away."""
        contour, known = self.contour, np.pad(self.given, 1)
        reached, halfway = about(np.pad(self.cells.corners, 1)), (contour.start + contour.end) / 2.0
        away = self._from_corners
        focus = known & (away < _FOCUS)
        return Layer(known, reached, focus, away, self.cells.corners, contour.row, contour.column, halfway)

    @cached_property
    def _from_corners(self) -> Grid:
        """How far places of coefficients are from the nearest corner that has functions (spacings)."""
        rows, columns = self.cells.nodes.shape
        down, right = np.ogrid[: rows + 2, : columns + 2]
        found = np.full((rows + 2, columns + 2), np.inf)
        contour = self.contour
        for corner in {function.corner for function in self.background.functions}:
            column, row = ((at - first) / contour.spacing + 1 for at, first in zip(corner, contour.first, strict=True))
            np.minimum(found, np.hypot(down - row, right - column), out=found)
        return found

    @cached_property
    def given(self) -> Mask:
        """Which nodes give the spline its coefficients: those away from the contour, and from its corners."""
        return self.far & (self._from_corners[1:-1, 1:-1] > _NEXT)

    @cached_property
    def far(self) -> Mask:
        """Which nodes have no arm that ends on the contour: their values are those of the lattice."""
        nodes = self.cells.nodes
        found = nodes.copy()
        found[1:-1, 1:-1] &= nodes[:-2, 1:-1] & nodes[2:, 1:-1] & nodes[1:-1, :-2] & nodes[1:-1, 2:]
        return found

    @cached_property
    def heights_halfway(self) -> Vector:
        """About γ in the middles of the pieces of the contour (length)."""
        heights = self.rim.halfway
        return heights if self.floor is None else heights + _IN_THE_MIDDLE @ self.rim.values(self.floor)[0]

    @cached_property
    def least_height(self) -> float:
        """No more than γ anywhere on the contour (length)."""
        least = self.rim.lower.min(axis=0)
        if self.floor is not None:
            values, error = self.rim.values(self.floor)
            least = least + values.min(axis=0) - error - _ERROR * (np.abs(least) + np.abs(values).max(axis=0))
        return float(least.min())

    @property
    def highest(self) -> float | None:
        """About the largest γ (length); None where functions about corners are added to splines."""
        return None if self.background.parts else float(self.heights_halfway.max())

    def wanted_in_layer(self, bend: Grid, rise: float) -> tuple[Vector, Vector]:
        """Return h²Δs at the layer's points, and s on the contour: above γ - b by a part of the wanted bends (length).

        Parameters
        ----------
        bend : array, shape (rows + 2, columns + 2)
            The wanted sums of second differences at the points (length).
        rise : float
        """
        contour = self.contour
        corners = [bend[contour.row + i, contour.column + j] for i in (0, 1) for j in (0, 1)]
        heights = self.heights_halfway - self.background.along.halfway
        return bend.reshape(-1)[self.layer.points], heights + rise * np.mean(corners, axis=0)

    def _filled(self, coefficients: Grid, bend: Grid, rise: float) -> Grid:
        """Return coefficients with those of the layer."""
        found = np.pad(np.where(self.given, coefficients, 0.0), 1)
        self.layer.fill(found, *self.wanted_in_layer(bend, rise))
        return found

    def upper_coefficients(self, values: Grid, bend: Grid) -> Grid:
        """Return coefficients of a spline that lies above a membrane's values at the nodes, less b."""
        return self._filled(values - self.background.at_points, self._where_free(values, bend), _SIXTH)

    def lower_coefficients(self, values: Grid, bend: Grid) -> Grid:
        """Return coefficients of a spline that goes through such values, less b, nearly."""
        lowered = values - self.background.at_points
        lowered[1:-1, 1:-1] -= second_differences(lowered) * _SIXTH
        return self._filled(lowered, self._where_free(values, bend), 0.0)

    def _where_free(self, values: Grid, bend: Grid) -> Grid:
        """Return the wanted sums of second differences, none at nodes in contact."""
        return np.where(self.cells.nodes & (values <= 0.0), 0.0, bend)

    def ranges(self, coefficients: Grid) -> CellRanges:
        """Return ranges on the cells, of TΔs - q but for `load_range`, and of s + b."""
        found = super().ranges(coefficients)
        if not self.background.parts:
            return found
        both, slip = coefficients + self.background.coefficients, self.slip(coefficients)
        values = ranges_on_cells(self.cells, both, self.tension, np.zeros(self.cells.nodes.shape))
        off = self.background.beside + slip + 2 * UNIT_ROUNDOFF * float(np.abs(both).max())
        least, most = values.least - off, values.most + off
        low, high = self.background.ranges_in_hidden(coefficients)
        least[self.background.hidden], most[self.background.hidden] = low - slip, high + slip
        return CellRanges(found.least_excess, found.most_excess, least, most)

    def at_points(self, coefficients: Grid) -> tuple[Grid, Grid]:
        """Return s + b at the points, and how far off it may be."""
        values, error = super().at_points(coefficients)
        found = values + self.background.at_points
        return found, error + self.background.points_error + 2 * UNIT_ROUNDOFF * np.abs(found)

    def depth_spline(self, coefficients: Grid) -> tuple[Grid, Grid]:
        """See `ObstacleProblem.depth_spline`."""
        both = coefficients + self.background.coefficients
        return both, self.background.beside + 2 * UNIT_ROUNDOFF * float(np.abs(both).max())

    def excess_along_rim(self, coefficients: Grid) -> tuple[Vector, Vector]:
        """Return the least and the largest of s + b - γ on the pieces of the contour."""
        own = coefficients if self.floor is None else coefficients - self.floor
        least, most = self._rim_without_background.excess(own)
        slip = self.slip(coefficients)
        return least - slip, most + slip

    @cached_property
    def _rim_without_background(self) -> ContourRim:
        return self.rim + -self.background.along

    def least_in_region(self, coefficients: Grid, ranges: CellRanges, missing: float) -> Grid:
        """Return no more than the least of s + b in the part of each cell that belongs to the region.

        Parameters
        ----------
        coefficients : array, shape (rows + 4, columns + 4)
        ranges : CellRanges
            Of that spline.
        missing : float
            How far s + b lies below γ along the contour at most (length).
        """
        row, column = np.nonzero(self.contour.cut)
        values, error = self.at_points(coefficients)
        corners = [(row + i, column + j) for i, j in ((0, 0), (0, 1), (1, 0), (1, 1))]
        low = values - error
        least = np.minimum.reduce([np.where(self.held[place], low[place], np.inf) for place in corners])
        least = np.minimum(least, self.least_height - missing)
        both = coefficients + self.background.coefficients
        block = np.stack([[both[row + i, column + j] for j in range(4)] for i in range(4)])
        bends = [np.diff(block, n=2, axis=axis).max(axis=(0, 1)) for axis in (0, 1)]
        bent = sum(np.maximum(bend, 0.0) for bend in bends) / 8.0 + _ERROR * np.abs(block).max(axis=(0, 1))
        bent = bent + 2 * self.background.beside[row, column]
        found = ranges.least.copy()
        found[row, column] = np.maximum(found[row, column], least - bent * (1 + _ERROR) - _ERROR * abs(missing))
        return self._least_about_corners(coefficients, found, self.least_height - missing)

    def _least_about_corners(self, coefficients: Grid, found: Grid, on_contour: float) -> Grid:
        """Return bounds from below, those of hidden squares by what is known about these; see the module."""
        if not self.background.hidden[0].size:
            return found
        load_modules("scipy.ndimage")
        from scipy.ndimage import binary_dilation, find_objects, label

        hidden = np.zeros(found.shape, dtype=np.bool_)
        hidden[self.background.hidden] = True
        pulled = ranges_on_cells(self.cells, coefficients, self.tension, np.zeros(self.cells.nodes.shape)).most_excess
        labels, _ = label(hidden, np.ones((3, 3)))
        better = found.copy()
        for number, place in enumerate(find_objects(labels), start=1):
            rows, columns = (slice(max(part.start - 1, 0), part.stop + 1) for part in place)
            own = labels[rows, columns] == number
            beside = binary_dilation(own, np.ones((3, 3))) & self.cells.inside[rows, columns] & ~own
            height, width = (part.stop - part.start for part in place)
            bend = max(0.0, float(pulled[rows, columns][own].max())) * self.cells.spacing**2 / self.tension
            edge = min(on_contour, float(found[rows, columns].min(where=beside, initial=np.inf)))
            least = edge - bend * (height**2 + width**2) / 16.0 * (1 + _ERROR) - _ERROR * abs(edge)
            better[rows, columns][own] = np.maximum(better[rows, columns][own], least)
        return better

    def moved_at_rim(self, wanted: Vector) -> Grid:
        """Return changes of coefficients by which a spline moves so far, about, along each piece of the contour."""
        moved = np.zeros(tuple(np.array(self.cells.nodes.shape) + 2))
        for i in (1, 2):
            for j in (1, 2):
                np.maximum.at(moved, (self.contour.row + i, self.contour.column + j), wanted)
        return moved

    def settled(self, gap: Grid, resolve: Resolve) -> tuple[ContourProblem, Grid, Resolve] | None:
        """See `ObstacleProblem.settled`: b is chosen by the lattice's answer, too."""
        settling = Settling(self, resolve)
        found = settling.settle(self.with_rim(gap))
        return None if found is None else (settling.problem, found, settling.resolved)

    @cached_property
    def corner_load(self) -> Grid:
        """What differences take b for a load, at nodes away from the contour (force per area)."""
        bent = np.pad(second_differences(self.background.at_points), 1)
        return np.where(self.far, self.tension / self.cells.spacing**2 * bent, 0.0)

    def fitted_to(self, gap: Grid, bend: Grid) -> tuple[Self, Grid]:
        """Return the problem with as much of the functions about corners as an answer has.

        At a corner that points inwards loads next to it bring in the dual ℑz^(-β) of a function as well, which no
        membrane has: the answer is returned without it.

        Parameters
        ----------
        gap : array, shape (rows + 2, columns + 2)
            The lattice's answer (length).
        bend : array, shape (rows + 2, columns + 2)
            The wanted sums of second differences at the points (length).
        """
        parts = self.background.parts
        if not parts:
            return self, gap
        taken = np.array([self._taken_by_logarithm(part.function, bend) for part in parts])
        start = self.with_background(self.background.with_factors(taken))
        powers = np.array([not part.function.logarithmic for part in parts])
        steep = [function for function in self.background.functions if function.exponent < 1]
        duals = Background.nothing_of(
            self.contour, [replace(function, exponent=-function.exponent) for function in steep]
        )
        functions = [part for part, power in zip(parts, powers, strict=True) if power] + list(duals.parts)
        coefficients = np.pad(np.where(self.given, gap - start.background.at_points, 0.0), 1)
        shares = self.layer.shares(
            [(part.spline, part.halfway) for part in functions], coefficients, *start.wanted_in_layer(bend, _SIXTH)
        )
        taken[powers] = shares[: np.count_nonzero(powers)]
        unwanted = duals.with_factors(shares[np.count_nonzero(powers) :]).at_points
        return self.with_background(self.background.with_factors(taken)), gap - np.where(self.far, unwanted, 0.0)

    def _taken_by_logarithm(self, function: CornerFunction, bend: Grid) -> float:
        """Return how much of a function with a logarithm the load, and the bend of the frame, bring in at a corner.

        No polynomial takes anything of κ = q/T - γ₁″ - γ₂″, with the second derivatives of γ along both sides; a =
        κ/2ω of the function takes all. Zero of other functions.
        """
        if not function.logarithmic:
            return 0.0
        contour = self.contour
        x, y = contour.places((contour.start + contour.end) / 2)
        distance = np.hypot(x - function.corner[0], y - function.corner[1])
        nearest = int(np.argmin(distance))
        left = bend[contour.row[nearest], contour.column[nearest]] / contour.spacing**2
        for side in function.sides:
            near = (contour.segment == side) & (distance < min(_FOCUS * contour.spacing, function.scale))
            left -= 2 * np.polyfit(distance[near], self.heights_halfway[near], 2)[0]
        return float(left * function.scale**2 / (2 * function.angle))
