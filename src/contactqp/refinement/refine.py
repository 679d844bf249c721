"""refine(): one model on finer and finer meshes, until its free boundary is known to a length."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..backends.base import Backend
from ..foundation.cards import card
from ..foundation.checks import Vector, integer_at_least, positive_number
from ..foundation.loading import load_modules
from ..foundation.text import counted
from ..models.mesh_membrane import MeshMembrane
from ..solving.solution import OnFailure, Solution
from ..solving.solve import solve
from .indicator import crossed, too_large

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class Refinement:
    """One model's solutions on finer and finer meshes.

    Attributes
    ----------
    solutions : tuple of Solution
        From the mesh that was given to the finest.
    seconds : array
        Time until each was there (seconds), from the start of the refinement.
    target : float
        The wanted size of the triangles that the free boundary crosses (length).
    ended : str
        Why there is no finer one: ``"target reached"``, or the limit that was.
    """

    solutions: tuple[Solution, ...]
    seconds: Vector
    target: float
    ended: str

    @property
    def solution(self) -> Solution:
        """The one on the finest mesh."""
        return self.solutions[-1]

    @property
    def reached(self) -> bool:
        """Whether the free boundary is known to the target."""
        return self.ended == _REACHED

    @property
    def free_boundary_widths(self) -> Vector:
        """Longest side of the triangles that the free boundary crosses, for each mesh (length); 0 without one."""
        return np.array([_width(solution) for solution in self.solutions])

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each mesh: nodes, triangles, nodes in contact, width of the free boundary, status, seconds.

        Returns
        -------
        pandas.DataFrame
        """
        load_modules("pandas")
        import pandas as pd

        models = [_mesh_of(solution) for solution in self.solutions]
        return pd.DataFrame(
            {
                "nodes": [model.size for model in models],
                "triangles": [len(model.triangles) for model in models],
                "contact": [int(solution.contact.sum()) for solution in self.solutions],
                "width": self.free_boundary_widths,
                "status": [str(solution.status) for solution in self.solutions],
                "seconds": self.seconds,
            }
        )

    def __repr__(self) -> str:
        first, last = self.solutions[0].problem.size, counted(self.solution.problem.size, "node")
        return (
            f"Refinement({len(self.solutions)} solved, {first} to {last}, free boundary known to "
            f"{_width(self.solution):.3g}, {self.solution.status}, {self.ended})"
        )

    def _repr_html_(self) -> str:
        facts = {
            "meshes": str(len(self.solutions)),
            "nodes": f"{self.solutions[0].problem.size} to {self.solution.problem.size}",
            "free boundary": f"known to {_width(self.solution):.3g} (length), target {self.target:.3g}",
            "status": str(self.solution.status),
            "ended": self.ended,
        }
        return card("Refinement", facts)


_REACHED = "target reached"


def refine(
    solution: Solution,
    target: float,
    *,
    backend: str | Backend = "auto",
    tol: float | str | None = None,
    max_nodes: int = 1_000_000,
    time_limit: float | None = None,
    on_failure: OnFailure = "warn",
) -> Refinement:
    """Refine a membrane's mesh towards its free boundary, and solve on each mesh, until the boundary is known.

    Triangles are split that have nodes in contact and others and are larger than ``target``; and those elsewhere whose
    residual, the jump of the flux across their sides and what is out of balance within, moves the free boundary by more
    than that: see `contactqp.refinement.indicator`. The model is made anew on each mesh (`MeshMembrane.refined`), and
    solved from the interpolated deflection. The indicators are estimates; what is certified of each solution is its
    distance from the exact solution on its own mesh.

    Parameters
    ----------
    solution : Solution
        Of a `MeshMembrane`.
    target : float
        Longest side of the triangles that the free boundary crosses (length), > 0.
    backend : str or Backend
        See `contactqp.solve`.
    tol : float or str, optional
        See `contactqp.solve`; by default the solution's.
    max_nodes : int
        No mesh with more is solved.
    time_limit : float, optional
        Limit in seconds, after which no finer mesh is made; the solve that it ends in is stopped.
    on_failure : {"warn", "raise", "ignore"}
        See `contactqp.solve`.

    Returns
    -------
    Refinement
        Its `solution` is the one on the finest mesh.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong kind or range, or the solution is none of a `MeshMembrane`, or holds no answer.

    Examples
    --------
    >>> import skfem
    >>> import contactqp as cq
    >>> square = skfem.MeshTri().refined(3)
    >>> coarse = cq.MeshMembrane.from_skfem(square, 1.0, load=8.0, support=0.2)
    >>> refinement = cq.refine(cq.solve(coarse), target=0.03)
    >>> refinement.reached, bool(refinement.free_boundary_widths[-1] <= 0.03)
    (True, True)
    """
    model = _mesh_of(solution)
    if not solution.finite:
        raise ValueError(
            f"solution must hold an answer to go on from: {solution.backend} said {solution.termination!r}"
        )
    target, most = positive_number(target, "target"), integer_at_least(max_nodes, 1, "max_nodes")
    tol = solution.tol if tol is None else tol
    limit = None if time_limit is None else positive_number(time_limit, "time_limit")
    started, found, seconds = time.perf_counter(), [solution], [0.0]
    while True:
        chosen = too_large(found[-1], model, target)
        if not chosen.any():
            ended = _REACHED
            break
        finer = model.refined(chosen)
        left = None if limit is None else limit - (time.perf_counter() - started)
        if finer.size > most:
            ended = f"the next mesh has more than {most} nodes"
            break
        if left is not None and left <= 0:
            ended = "time limit"
            break
        start = start_on(finer, model, found[-1])
        found.append(solve(finer, backend, tol=tol, time_limit=left, warm_start=start, on_failure=on_failure))
        seconds.append(time.perf_counter() - started)
        model = finer
        if not found[-1].finite:
            ended = "no answer"
            break
    return Refinement(tuple(found), np.array(seconds), target, ended)


def start_on(finer: MeshMembrane, model: MeshMembrane, solution: Solution) -> Vector:
    """Return a gap to start from on the mesh that a model's was refined to, shape (n,), length.

    The deflection is interpolated; between two nodes in contact there is contact.
    """
    halving = finer.halving
    assert halving is not None
    depths = halving.between(model.point_heights(solution.deflection))[finer.free]
    gap = finer.reference - (-depths if finer.upwards else depths)
    held = np.zeros(len(model.positions))
    held[model.free] = np.where(solution.contact_lower, 1.0, np.where(solution.contact_upper, -1.0, 0.0))
    between = halving.between(held)[finer.free]
    gap = np.where(between == 1.0, finer.problem.lower, np.where(between == -1.0, finer.problem.upper, gap))
    return finer.problem.project(gap)


def _mesh_of(solution: Any) -> MeshMembrane:
    model = getattr(solution, "model", None)
    if not isinstance(solution, Solution) or not isinstance(model, MeshMembrane):
        told = repr(model) if isinstance(solution, Solution) and model is not None else type(solution).__name__
        raise TypeError(f"solution must be that of a MeshMembrane, whose mesh can be refined, got {told}")
    return model


def _width(solution: Solution) -> float:
    model = _mesh_of(solution)
    return float(model.mesh.longest_sides.max(where=crossed(model, solution.contact), initial=0.0))
