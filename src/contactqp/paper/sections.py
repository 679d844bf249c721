"""Middle sections in the paper's dimensionless quantities, as in its Figs. 6-8."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..foundation.checks import Vector
from ..models.stretched import StretchedModel
from ..paths.load_path import LoadPath
from ..solving.solution import Solution
from .facts import SECTION_LOADS


@dataclass(frozen=True, eq=False)
class Section:
    """A row of nodes, in the paper's quantities without unit.

    Attributes
    ----------
    x, support, deflection, gap, reaction : array, shape (k,)
        x/Δ, f/Δ, w′ = w/Δ, ω′ = ω/Δ and R′ = R/(TΔ), node by node.
    frame : (float, float)
        x/Δ of the points of the frame on either side.
    """

    x: Vector
    support: Vector
    deflection: Vector
    gap: Vector
    reaction: Vector
    frame: tuple[float, float]


def middle_section(solution: Solution) -> Section:
    """Return the section of a membrane along the row of nodes that is nearest to y = 0.

    Parameters
    ----------
    solution : Solution
        Of a membrane whose row has no holes.

    Raises
    ------
    ValueError
        If the solution is of a bare problem.

    Examples
    --------
    >>> import contactqp as cq
    >>> section = middle_section(cq.solve(cq.gallery.paper_hexagon(0.05)))
    >>> section.x.size, section.frame, bool(np.allclose(section.support, section.deflection + section.gap))
    (63, (-32.0, 32.0), True)
    """
    model = solution.model
    if not isinstance(model, StretchedModel):
        raise ValueError(f"a section needs a membrane's solution, and this one is of {model or 'a bare ContactQP'!r}")
    lattice = model.lattice
    y = lattice.node_y
    row = y == y[np.argmin(np.abs(y))]
    x = lattice.node_x[row] / lattice.spacing
    return Section(
        x=x,
        support=model.support[row] / lattice.spacing,
        deflection=solution.deflection[row] / lattice.spacing,
        gap=solution.gap[row] / lattice.spacing,
        reaction=solution.reaction[row] / (model.tension * lattice.spacing),
        frame=(float(x[0] - 1), float(x[-1] + 1)),
    )


def section_solutions(path: LoadPath) -> list[tuple[float, Solution]]:
    """Return load and solution where the paper shows a section; of a path without any of these loads, all there are.

    Examples
    --------
    >>> import contactqp as cq
    >>> path = cq.trace(cq.gallery.paper_hexagon(1.0), loads=[0.01, 0.02, 0.05])
    >>> [load for load, _ in section_solutions(path)]
    [0.01, 0.05]
    """
    solved = list(zip(path.values.tolist(), path.solutions, strict=True))
    return [pair for pair in solved if pair[0] in SECTION_LOADS] or solved
