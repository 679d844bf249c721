r"""Functions that the membrane's gap certainly lies below or above: splines with verified differential inequalities.

Let Ω be bounded and connected along Lipschitz curves, T > 0, q ∈ L^∞(Ω), γ ≥ 0 on ∂Ω. The gap u* of the membrane
minimises ∫ ½T|∇u|² + qu among all u ∈ H¹(Ω) with u ≥ ψ and u = γ on ∂Ω; so, with K for these,

.. math:: \int T ∇u^*·∇(φ - u^*) + q (φ - u^*) \, ≥ 0 \qquad \text{for all } φ ∈ K.

ψ is zero, or, where u is counted from a spline F in the place of the support f, ψ = F - f: kinks of f are in ψ alone.

*Supersolution.* Let U be twice continuously differentiable on the closed region, U ≥ ψ, U ≥ γ on ∂Ω, and TΔU ≤ q almost
everywhere. Then u* ≤ U.

*Subsolution.* Let L be twice continuously differentiable, L ≤ γ on ∂Ω, and TΔL ≥ q almost everywhere where L > ψ. Then
L ≤ u*.

Proof (Kinderlehrer and Stampacchia, *An Introduction to Variational Inequalities and Their Applications*, 1980,
ch. II, theorem 6.4, where it is that u* is the least supersolution). Let d = (u* - U)⁺. It is in H¹ and vanishes on the
frame, and φ = u* - d = min(u*, U) is in K: hence -∫ T∇u*·∇d + qd ≥ 0. The product of q - TΔU ≥ 0 with d ≥ 0 is
integrated by parts, ∫ T∇U·∇d + qd ≥ 0. The sum is -∫ T∇(u* - U)·∇d = -∫ T|∇d|² ≥ 0, so d = 0. Likewise with
d = (L - u*)⁺ and φ = u* + d = max(u*, L): ∫ T∇u*·∇d + qd ≥ 0, and as d > 0 only where L > u* ≥ ψ,
-∫ T∇L·∇d - qd ≥ 0; the sum is -∫ T|∇d|² ≥ 0.

*From a spline.* Let s be a bicubic spline (see `contactqp.continuum.splines`), x the coordinate across a strip of
width d that holds Ω, counted from its side, and v = x(d - x)/(2T): v ≥ 0 in Ω, and -TΔv = 1. For any δ,

.. math::

    U &= s + τ^+ v + δ^+, & τ^+ &= \max_K \max_K (TΔs - q)^+, & δ^+ &= \max\{0, \max_{∂Ω} (γ - s), \max_Ω (ψ - s)\}, \\
    L &= s - τ^- v - δ^-, & τ^- &= \max_{K: \max_K (s - ψ) > δ^-} \max_K (q - TΔs)^+, & δ^- &≥ \max_{∂Ω} (s - γ)

are such functions: TΔU = TΔs - τ⁺ ≤ q; and where L > ψ it is s - ψ > δ⁻, so that the cell is among those of τ⁻, and
TΔL = TΔs + τ⁻ ≥ q. The maxima over cells K and edges are bounded by those of Bernstein coefficients, rounded outwards;
q and γ may be known up to ranges. δ⁻ leaves out the cells about the free boundary, where second differences of the
lattice's answer change from zero to what the load wants over a spacing or two. δ⁻ is chosen
so that τ⁻d²/8T + δ⁻ is small.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..foundation.checks import Mask, Vector
from ..foundation.rounding import UNDERFLOW, UNIT_ROUNDOFF
from ..geometry.numbering import Grid
from .obstacle import ObstacleProblem
from .splines import CellRanges

_SLACK = 8 * UNIT_ROUNDOFF
"""More than the roundings of three sums and products in a row, relative to the sum of their moduli."""


_FEW = 10.0


@dataclass(frozen=True, eq=False)
class Barrier:
    """A spline, moved by a multiple of a parabola and by a constant, that the gap certainly lies below, or above.

    Attributes
    ----------
    problem : ObstacleProblem
    side : {1, -1}
        1 for an upper bound, s + τv + δ; -1 for a lower one, s - τv - δ.
    coefficients : array, shape (rows + 4, columns + 4)
        Of the spline s (length).
    multiple : float
        τ (force per area).
    shift : float
        δ (length).
    ranges : CellRanges
        Of the spline.
    defects : array, shape (rows + 1, columns + 1)
        By how much each cell misses the differential inequality at most (force per area), whether it is asked or not.
    """

    problem: ObstacleProblem
    side: Literal[1, -1]
    coefficients: Grid
    multiple: float
    shift: float
    ranges: CellRanges
    defects: Grid

    @property
    def holds(self) -> bool:
        """Whether it is a bound at all: all numbers are finite."""
        return bool(np.isfinite([self.multiple, self.shift]).all())

    def at_points(self) -> Grid:
        """Return the bound at the points of the closed region, rounded outwards; nan elsewhere."""
        values, error = self.problem.at_points(self.coefficients)
        moved = self._moved(values, self.multiple * _height_at_lines(self.problem), error)
        return np.where(self.problem.cells.closure, moved, np.nan)

    def nearly_at_points(self) -> Grid:
        """Return the bound at the points but for its roundings: it may be used to choose, and proves nothing."""
        values, _ = self.problem.at_points(self.coefficients)
        values += self.side * (self.multiple * _height_at_lines(self.problem) + self.shift)
        return values

    def on_cells(self) -> Grid:
        """Return the largest value in each cell of an upper bound, the least of a lower one; nan outside."""
        extreme = self.ranges.most if self.side > 0 else self.ranges.least
        return self._moved(extreme, self.multiple * _most_height_on_cells(self.problem), 0.0)

    def _moved(self, values: Grid, lift: Grid, error: float | Grid) -> Grid:
        size = np.abs(values) + lift + self.shift
        return np.asarray(values + self.side * ((lift + self.shift) + (_SLACK * size + (error + UNDERFLOW))))


def supersolution(problem: ObstacleProblem, coefficients: Grid) -> Barrier:
    """Return an upper bound of the gap from a spline; see the module.

    Parameters
    ----------
    problem : ObstacleProblem
    coefficients : array, shape (rows + 4, columns + 4)
        Of any spline (length).

    Examples
    --------
    >>> from contactqp.continuum.cells import Cells
    >>> cells = Cells(np.ones((3, 3), dtype=bool), 0.25)
    >>> problem = ObstacleProblem(cells, 2.0, np.ones((5, 5)), np.ones((5, 5)))
    >>> barrier = supersolution(problem, np.full((7, 7), 1.0))  # u = 1, and TΔu = 0 <= q
    >>> barrier.multiple, bool(0 <= barrier.shift < 1e-13), bool(barrier.at_points().max() < 1 + 1e-13)
    (0.0, True, True)
    """
    inside = problem.cells.inside
    ranges = problem.ranges(coefficients)
    defects = _above_zero(ranges.most_excess - problem.load_range[0], inside)
    least, _ = problem.excess_along_rim(coefficients)
    missing = problem.height_range[1] - least
    lowest = problem.least_in_region(coefficients, ranges, _raised(missing))
    shift = _raised(missing, -_sum(lowest, problem.rest[0], -1)[inside])
    return Barrier(problem, 1, coefficients, float(defects.max()), shift, ranges, defects)


def subsolution(problem: ObstacleProblem, coefficients: Grid) -> Barrier:
    """Return a lower bound of the gap from a spline, with the best δ⁻; see the module.

    Parameters
    ----------
    problem : ObstacleProblem
    coefficients : array, shape (rows + 4, columns + 4)
        Of any spline (length).

    Examples
    --------
    >>> from contactqp.continuum.cells import Cells
    >>> cells = Cells(np.ones((3, 3), dtype=bool), 0.25)
    >>> problem = ObstacleProblem(cells, 2.0, np.ones((5, 5)), np.zeros((5, 5)))
    >>> barrier = subsolution(problem, np.zeros((7, 7)))  # L = 0 is below every gap
    >>> barrier.multiple, bool(barrier.shift < 1e-100)
    (0.0, True)
    """
    inside = problem.cells.inside
    ranges = problem.ranges(coefficients)
    defects = _above_zero(problem.load_range[1] - ranges.least_excess, inside)
    _, most = problem.excess_along_rim(coefficients)
    least_shift = _raised(most - problem.height_range[0])
    shift, multiple = _best_shift(problem, _sum(ranges.most, problem.rest[1], 1), defects, least_shift)
    return Barrier(problem, -1, coefficients, multiple, shift, ranges, defects)


def _best_shift(problem: ObstacleProblem, most: Grid, defects: Grid, least_shift: float) -> tuple[float, float]:
    """Return the δ that makes τ(δ) d²/8T + δ least, and τ(δ): the largest defect of the cells where s - ψ exceeds δ.

    Up to a few times what a membrane bends on a cell, and kinks stand out, every δ is tried, and beyond that the one
    that leaves out all.
    """
    inside = problem.cells.inside
    if not (np.isfinite(defects[inside]).all() and np.isfinite(most[inside]).all()):
        return np.inf, np.inf
    near = inside & (most <= max(_FEW * (problem.largest_bend + problem.largest_kink), least_shift))
    always = float(defects.max(where=inside & ~near, initial=0.0))
    chosen = near & (defects > always)
    order = np.argsort(most[chosen])[::-1]
    values, found = most[chosen][order], defects[chosen][order]
    # Of the cells from the highest down to each, the largest defect: τ if δ is the value of the next.
    multiples = np.concatenate([[always], np.maximum.accumulate(found), [0.0]])
    shifts = np.maximum(np.concatenate([values, [0.0], [most.max(where=inside, initial=0.0)]]), least_shift)
    shift = float(shifts[np.argmin(multiples * problem.largest_height + shifts)])
    return shift, float(defects.max(where=inside & (most > shift), initial=0.0))


def _above_zero(values: Grid, inside: Mask) -> Grid:
    """Return the positive parts of rounded differences, rounded up; infinite for nan, zero outside."""
    positive = np.maximum(values, 0.0)
    positive *= 1 + _SLACK
    np.copyto(positive, 0.0, where=~inside)
    return np.where(np.isnan(positive), np.inf, positive) if np.isnan(positive.max()) else positive


def _sum(lengths: Grid, rest: Grid | float, side: int) -> Grid:
    """Return lengths and what is added to them, moved to a side by more than the sum is rounded."""
    return np.asarray((lengths + rest) + side * _SLACK * (np.abs(lengths) + np.abs(rest)))


def _raised(*lengths: Vector) -> float:
    """Return the largest of some lengths and zero, raised by its rounding; infinite if any is not a number."""
    largest = max([0.0, *(float(length.max(initial=0.0)) for length in lengths)])
    if any(np.isnan(length).any() for length in lengths):
        return np.inf
    return largest * (1 + _SLACK) + UNDERFLOW


def _height_at_lines(problem: ObstacleProblem) -> Grid:
    """Return v at the points, raised by its rounding, in a shape that broadcasts."""
    axis, first, width = problem.cells.strip
    lines = np.arange(problem.cells.nodes.shape[axis]) - float(first)
    heights = np.maximum(lines * (width - lines), 0.0) * (problem.cells.spacing**2 / (2.0 * problem.tension))
    heights = heights * (1 + _SLACK) + UNDERFLOW
    return heights[:, None] if axis == 0 else heights[None, :]


def _most_height_on_cells(problem: ObstacleProblem) -> Grid:
    """Return the largest v in each cell, raised by its rounding, in a shape that broadcasts."""
    axis, _, width = problem.cells.strip
    lines = np.asarray(_height_at_lines(problem)).ravel()
    largest = np.maximum(lines[:-1], lines[1:])
    if width % 2:  # between the two middle lines it is as high as it gets
        largest = np.where(lines[:-1] == lines[1:], problem.largest_height, largest)
    return largest[:, None] if axis == 0 else largest[None, :]
