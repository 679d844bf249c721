"""solve_to(): one model on finer and finer lattices, until the membrane itself is enclosed to a tolerance."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..backends.base import Backend
from ..continuum.membrane import MembraneBounds
from ..continuum.result import Continuum
from ..foundation.checks import Vector, integer_at_least, positive_number
from ..foundation.loading import load_modules
from ..foundation.text import at_most, counted, folded
from ..models.membrane import Membrane
from ..solving.solution import Solution
from ..solving.solve import solve

if TYPE_CHECKING:
    import pandas as pd

_REACHED = "tolerance reached"

_TOLD = {"data": "ranges of data"}
"""What parts of a bound are called where their names alone would say something else."""

_ALGEBRA = 0.01
"""Part of the wanted bound that the lattice's own answers may be off by."""


@dataclass(frozen=True, eq=False)
class SolvedTo:
    """One membrane's solutions on finer and finer lattices, and what each proves of the membrane itself.

    Attributes
    ----------
    solutions : tuple of Solution
        From the first lattice to the finest.
    continua : tuple of Continuum
        What each of them proves, at every point.
    seconds : array
        Time until each was there (seconds), from the start.
    tolerance : float
        The wanted bound, relative to the error scale.
    ended : str
        Why there is no finer one: ``"tolerance reached"``, or the limit that was.
    """

    solutions: tuple[Solution, ...]
    continua: tuple[Continuum, ...]
    seconds: Vector
    tolerance: float
    ended: str

    @property
    def solution(self) -> Solution:
        """The one on the finest lattice."""
        return self.solutions[-1]

    @property
    def continuum(self) -> Continuum:
        """What the one on the finest lattice proves."""
        return self.continua[-1]

    @property
    def reached(self) -> bool:
        """Whether the membrane is enclosed to the tolerance."""
        return self.ended == _REACHED

    @property
    def spacing(self) -> float:
        """Spacing of the finest lattice (length)."""
        return _spacing_of(self.solution)

    @property
    def relative_bounds(self) -> Vector:
        """`Continuum.error_bound` of each, relative to the error scale, as certificates tell it."""
        return np.array(
            [
                found.error_bound / _scale(solution)
                for found, solution in zip(self.continua, self.solutions, strict=True)
            ]
        )

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each lattice.

        Spacing, nodes, the bound of the distance from the membrane (length) and what it consists of: ``algebra``, how
        far the answer is from the lattice's exact solution, ``data``, what comes of data that are known up to a range
        between the nodes, and ``discretisation``, the rest; the part of the area whose contact is undecided; seconds.

        Returns
        -------
        pandas.DataFrame
        """
        load_modules("pandas")
        import pandas as pd

        return pd.DataFrame(
            [
                {
                    "spacing": _spacing_of(solution),
                    "nodes": solution.problem.size,
                    "error_bound": found.error_bound,
                    **_parts(solution, _pointwise(found)),
                    "undecided": _pointwise(found).part_undecided,
                    "seconds": seconds,
                }
                for solution, found, seconds in zip(self.solutions, self.continua, self.seconds, strict=True)
            ]
        )

    def __str__(self) -> str:
        """Tell of each lattice how near it comes to the membrane, and what the last bound consists of."""
        rows = ["  spacing       nodes   within  of the error scale  undecided  seconds"]
        for solution, found, relative, seconds in zip(
            self.solutions, self.continua, self.relative_bounds, self.seconds, strict=True
        ):
            share = f"{at_most(100 * _pointwise(found).part_undecided)} %"
            rows.append(
                f"  {_spacing_of(solution):<9.4g} {solution.problem.size:>9}  {at_most(found.error_bound):>7}  "
                f"{at_most(relative):>18}  {share:>9}  {seconds:>7.3g}"
            )
        parts = _parts(self.solution, _pointwise(self.continuum))
        told = ", ".join(f"{_TOLD.get(name, name)} {at_most(part)}" for name, part in parts.items())
        head = f"Membrane within {at_most(self.continuum.error_bound)} (length): {self.ended}"
        wanted = f"  wanted {self.tolerance:g} of the error scale; the bound consists of {told}"
        return "\n".join([head, *rows, folded(wanted, 80, 2)])

    def __repr__(self) -> str:
        return (
            f"SolvedTo({len(self.solutions)} solved, spacing {_spacing_of(self.solutions[0]):g} to {self.spacing:g}, "
            f"{counted(self.solution.problem.size, 'node')}, membrane within {at_most(self.continuum.error_bound)}, "
            f"{self.ended})"
        )


def solve_to(
    model_of_spacing: Callable[[float], Membrane],
    continuum_tol: float,
    *,
    spacing: float,
    backend: str | Backend = "auto",
    max_nodes: int = 1_500_000,
    time_limit: float | None = None,
) -> SolvedTo:
    """Halve the spacing of a membrane's lattice until the membrane itself is enclosed to a tolerance.

    Each lattice is solved from the answer of the one before, and `Solution.continuum` tells how far its answer is from
    the membrane, between the lattice's points and with all rounding. See `contactqp.continuum.pointwise`.

    Parameters
    ----------
    model_of_spacing : callable
        Returns the membrane on a lattice of a spacing (length): of one tension, over one support, on a frame along
        lines of all the lattices and diagonals of their squares, or on lattices that are fitted to their contour.
    continuum_tol : float
        Wanted bound of the distance from the membrane at the nodes, relative to the error scale as ``tol`` of
        `contactqp.solve` is.
    spacing : float
        Of the first lattice (length).
    backend : str or Backend
        See `contactqp.solve`.
    max_nodes : int
        No lattice with more is solved.
    time_limit : float, optional
        Limit in seconds, after which no finer lattice is begun.

    Returns
    -------
    SolvedTo

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong kind or range, or the membrane is none that can be enclosed at every point; the
        message says why.

    Examples
    --------
    >>> import contactqp as cq
    >>> def bowl(spacing):
    ...     lattice = cq.Frame.rectangle(1, 1).lattice(spacing)
    ...     return cq.Membrane(lattice, tension=1.0, load=1.0, support=0.03)
    >>> found = cq.solve_to(bowl, continuum_tol=0.01, spacing=1 / 16)
    >>> found.reached, found.spacing, bool(found.relative_bounds[-1] <= 0.01)
    (True, 0.015625, True)
    """
    wanted, step = positive_number(continuum_tol, "continuum_tol"), positive_number(spacing, "spacing")
    most = integer_at_least(max_nodes, 1, "max_nodes")
    limit = None if time_limit is None else positive_number(time_limit, "time_limit")
    started = time.perf_counter()
    solutions: list[Solution] = []
    continua: list[Continuum] = []
    seconds: list[float] = []
    while True:
        model = _model_at(model_of_spacing, step)
        if model.size > most and solutions:
            ended = f"the next lattice has more than {most} nodes"
            break
        start = interpolated(model, solutions[-1]) if solutions else None
        tol = min(1e-6, max(_ALGEBRA * wanted, 1e-10))
        solutions.append(solve(model, backend, tol=tol, warm_start=start, on_failure="ignore"))
        continua.append(solutions[-1].continuum("pointwise"))
        seconds.append(time.perf_counter() - started)
        if continua[-1].error_bound <= wanted * _scale(solutions[-1]):
            ended = _REACHED
            break
        if limit is not None and seconds[-1] >= limit:
            ended = "time limit"
            break
        step /= 2
    return SolvedTo(tuple(solutions), tuple(continua), np.array(seconds), wanted, ended)


def interpolated(model: Membrane, coarse: Solution) -> Vector:
    """Return a gap to start from, shape (n,), length: the deflection of a coarser lattice's answer, interpolated."""
    load_modules("scipy.ndimage")
    from scipy.ndimage import map_coordinates

    own = coarse.model
    assert isinstance(own, Membrane)
    lattice = own.lattice
    ring = lattice.ring_coordinates(np.array([0]), np.array([0]))
    row, column = (model.node_y - ring[1][0]) / lattice.spacing, (model.node_x - ring[0][0]) / lattice.spacing
    depths = map_coordinates(own.padded_below(coarse.gap), [row, column], order=1, mode="nearest")
    return model.problem.project(model.reference - depths)


def _model_at(model_of_spacing: Any, spacing: float) -> Membrane:
    if not callable(model_of_spacing):
        raise TypeError(
            f"model_of_spacing must be a function that returns a Membrane for a spacing, got {model_of_spacing!r}"
        )
    model = model_of_spacing(spacing)
    if not isinstance(model, Membrane):
        raise TypeError(f"model_of_spacing must return a Membrane, got {model!r}")
    if not np.isclose(model.lattice.spacing, spacing, rtol=1e-6, atol=0):
        raise ValueError(
            f"model_of_spacing({spacing:g}) must return a model of that spacing, got one of {model.lattice.spacing:g}"
        )
    return model


def _scale(solution: Solution) -> float:
    return solution.verdict.scale


def _spacing_of(solution: Solution) -> float:
    model = solution.model
    assert isinstance(model, Membrane)
    return model.lattice.spacing


def _pointwise(found: Continuum) -> MembraneBounds:
    assert found.pointwise is not None
    return found.pointwise


def _parts(solution: Solution, found: MembraneBounds) -> dict[str, float]:
    algebra = np.inf if solution.certificate is None else solution.certificate.gap_bound
    rest = found.error_bound - algebra - found.data_part
    return {"algebra": float(algebra), "data": found.data_part, "discretisation": max(0.0, float(rest))}
