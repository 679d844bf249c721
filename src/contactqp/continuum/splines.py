r"""Bicubic splines on a lattice: values at its points, ranges on its cells, and ranges of the Laplacian.

With the cubic B-spline B³ on the integers and B¹ the hat function,

.. math::

    s(x, y) &= \sum_{ij} c_{ij} B^3(x/h - i) B^3(y/h - j), \\
    h^2 Δs &= \sum_{ij} (δ_x^2 c)_{ij} B^1_i(x) B^3_j(y) + (δ_y^2 c)_{ij} B^3_i(x) B^1_j(y),

because the second derivative of a cubic spline is the linear spline of its second differences (de Boor, *A Practical
Guide to Splines*, 1978, ch. X). s is twice continuously differentiable.

*Ranges.* Between two points a cubic spline with the coefficients c₋₁, c₀, c₁, c₂ about them is a cubic polynomial
with the Bernstein coefficients

.. math:: (c_{-1} + 4 c_0 + c_1)/6, \quad (2 c_0 + c_1)/3, \quad (c_0 + 2 c_1)/3, \quad (c_0 + 4 c_1 + c_2)/6,

and a linear one, with values s₀ and s₁ at the points, has s₀, (2s₀ + s₁)/3, (s₀ + 2s₁)/3, s₁. Bernstein polynomials are
not negative and add up to one, in the plane their products are and do, too. So on a cell the spline lies between the
least and the largest of 16 Bernstein coefficients, and so does Δs less a field that is bilinear on the cell.

*Roundings.* The coefficients c are the doubles that they are: nothing is rounded there. A Bernstein coefficient is
formed from them by sums of products with weights that add up to one (in the code, as 36, 18 and 9 fold); no path from
c, or from q, to a result has more than 16 roundings, so that the result is off by at most γ₁₆ (Higham, *Accuracy and
Stability of Numerical Algorithms*, 2002, lemma 3.1) times the same sum of moduli; that is bounded by the largest
modulus that enters, of second differences by the largest sum of the moduli of the two differences that they are formed
from. γ₂₄ in the place of γ₁₆ covers the roundings of the bound itself. Where anything could overflow, ranges are
infinite.

Arrays of coefficients have one more ring than those of points: c[i + 1, j + 1] belongs to point [i, j].
"""

from __future__ import annotations

from math import comb
from typing import NamedTuple

import numpy as np

from ..foundation.checks import Vector
from ..foundation.loading import load_modules
from ..foundation.rounding import UNDERFLOW, gamma
from ..foundation.threads import shared_team
from ..geometry.numbering import Grid
from .cells import Cells, Edges

TO_BERNSTEIN = np.array([[1, 4, 1, 0], [0, 4, 2, 0], [0, 2, 4, 0], [0, 1, 4, 1]]) / 6.0
"""Bernstein coefficients of a cubic spline on a square from its four coefficients about it."""

_ERROR = gamma(24)

_LARGEST = 1e300
"""Sums and products of a few numbers that are smaller do not overflow."""


class CellRanges(NamedTuple):
    """Ranges on the cells, shape (rows + 1, columns + 1); nan on cells that do not belong to the region.

    Attributes
    ----------
    least_excess, most_excess : array
        Of TΔs less the bilinear field (force per area).
    least, most : array
        Of the spline (length).
    """

    least_excess: Grid
    most_excess: Grid
    least: Grid
    most: Grid


def ranges_on_cells(cells: Cells, coefficients: Grid, tension: float, field: Grid) -> CellRanges:
    """Return ranges of a spline, and of its Laplacian times the tension less a bilinear field, rounded outwards.

    Parameters
    ----------
    cells : Cells
    coefficients : array, shape (rows + 4, columns + 4)
        Of the spline (length).
    tension : float
        T (force per length).
    field : array, shape (rows + 2, columns + 2)
        Values at the points of a field that is bilinear on each cell (force per area); finite at corners of cells.
    """
    load_modules("contactqp.continuum.spline_kernels", kernels="splines")
    from .spline_kernels import ranges

    factor = tension / (18.0 * cells.spacing**2)
    largest = float(np.abs(coefficients).max()) * (36.0 + 144.0 * factor)
    if not largest + 9.0 * float(np.abs(field).max(where=cells.corners, initial=0.0)) < _LARGEST:
        endless = np.where(cells.inside, np.inf, np.nan)
        return CellRanges(-endless, endless, -endless, endless)
    found = [np.empty(cells.inside.shape) for _ in range(4)]
    team = shared_team()
    strips = team.strips(0, cells.inside.shape[0], cells.inside.shape[1])
    given = np.ascontiguousarray(coefficients), np.ascontiguousarray(np.where(cells.corners, field, 0.0))
    team.run(ranges, strips, *given, cells.inside, factor, *found)
    return CellRanges(*found)


def at_points(coefficients: Grid) -> tuple[Grid, float]:
    """Return a spline's values at the points, shape (rows + 2, columns + 2), and a bound of their rounding errors.

    Examples
    --------
    >>> values, error = at_points(np.full((5, 6), 3.0))
    >>> values.shape, bool(np.abs(values - 3.0).max() <= error < 1e-13)
    ((3, 4), True)
    """
    rows = (coefficients[:-2] + 4.0 * coefficients[1:-1]) + coefficients[2:]
    values = ((rows[:, :-2] + 4.0 * rows[:, 1:-1]) + rows[:, 2:]) / 36.0
    return values, _ERROR * float(np.abs(coefficients).max()) + UNDERFLOW


def excess_along_rim(cells: Cells, coefficients: Grid, heights: Grid) -> tuple[Vector, Vector]:
    """Return the range of a spline less a field that is linear between points, on each edge of the rim.

    Parameters
    ----------
    heights : array, shape (rows + 2, columns + 2)
        Values of the field at the points; finite on the rim.

    Returns
    -------
    least, most : array
        On the edges, in the order of `Cells.rim`.
    """
    found = []
    for edges in cells.rim:
        start, end = (heights[place] for place in edges.ends)
        values, largest = (_along_diagonals if all(edges.step) else _along_lines)(edges, coefficients)
        degree = len(values) - 1
        bernstein = [value - ((degree - part) * start + part * end) / degree for part, value in enumerate(values)]
        size = np.maximum.reduce([np.abs(start), np.abs(end), largest])
        error = 2.0 * _ERROR * size + UNDERFLOW
        found.append((np.minimum.reduce(bernstein) - error, np.maximum.reduce(bernstein) + error))
    least, most = zip(*found, strict=True)
    return np.concatenate(least), np.concatenate(most)


def _along_lines(edges: Edges, coefficients: Grid) -> tuple[list[Vector], Vector]:
    """Return the four Bernstein coefficients of a spline along sides of cells, and the largest modulus that enters."""
    (down, right), lines, largest = edges.step, [], []
    for along in range(4):
        # Four coefficients along the edge, each of which three across it make up.
        before, at, after = (
            coefficients[edges.row + along * down + across * right, edges.column + along * right + across * down]
            for across in range(3)
        )
        lines.append((before + 4.0 * at) + after)
        largest += [np.abs(before), np.abs(at), np.abs(after)]
    return [_bernstein(lines, part) / 36.0 for part in range(4)], np.maximum.reduce(largest)


def _along_diagonals(edges: Edges, coefficients: Grid) -> tuple[list[Vector], Vector]:
    """Return the seven Bernstein coefficients of a spline along diagonals, and the largest modulus that enters.

    With the sixteen b_kl of the cell, those of the polynomial in (t, t) are the means of b_kl with k + l = m, weighted
    by the products of binomials: B_k(t) B_l(t) = (3 k)(3 l)/(6 m) B_m(t). On the other diagonal l counts backwards.
    """
    back = edges.step[1] < 0
    column = edges.column - back
    block = [[coefficients[edges.row + i, column + j] for j in range(4)] for i in range(4)]
    rows = [[_bernstein([block[i][j] for i in range(4)], part) for j in range(4)] for part in range(4)]
    net = [[_bernstein(row, part) / 36.0 for part in range(4)] for row in rows]
    if back:
        net = [row[::-1] for row in net]
    values = []
    for m in range(7):
        parts = [(comb(3, k) * comb(3, m - k), net[k][m - k]) for k in range(max(0, m - 3), min(3, m) + 1)]
        values.append(np.asarray(sum(weight * part for weight, part in parts) / comb(6, m)))
    return values, np.maximum.reduce([np.abs(one) for row in block for one in row])


def excess_on_cells(cells: Cells, coefficients: Grid, field: Grid) -> tuple[Grid, Grid]:
    """Return the least and the largest of a spline less a bilinear field in each cell; nan outside.

    Parameters
    ----------
    coefficients : array, shape (rows + 4, columns + 4)
    field : array, shape (rows + 2, columns + 2)
        Values at the points.
    """
    load_modules("contactqp.continuum.spline_kernels", kernels="splines")
    from .spline_kernels import excesses

    sizes = float(np.abs(coefficients).max()) + float(np.abs(field).max(where=cells.corners, initial=0.0))
    if not 36.0 * sizes < _LARGEST:
        endless = np.where(cells.inside, np.inf, np.nan)
        return -endless, endless
    least, most = np.empty(cells.inside.shape), np.empty(cells.inside.shape)
    team = shared_team()
    strips = team.strips(0, cells.inside.shape[0], cells.inside.shape[1])
    given = np.ascontiguousarray(coefficients), np.ascontiguousarray(np.where(cells.corners, field, 0.0))
    team.run(excesses, strips, *given, cells.inside, least, most)
    error = 2.0 * _ERROR * sizes + UNDERFLOW
    return least - error, most + error


def _bernstein(lines: list[Vector], part: int) -> Vector:
    """Return six times one of the Bernstein coefficients of cubic splines from four lines of coefficients."""
    first, second, third, fourth = lines
    formed = (
        lambda: (first + 4.0 * second) + third,
        lambda: 4.0 * second + 2.0 * third,
        lambda: 2.0 * second + 4.0 * third,
        lambda: (second + 4.0 * third) + fourth,
    )
    return formed[part]()
