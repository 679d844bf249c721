"""Resolved: a model's problem solved again under loads that differ from its own by little."""

from __future__ import annotations

import numpy as np

from ..backends.base import State
from ..foundation.checks import Vector
from ..foundation.progress import Progress
from ..models.on_lattice import LatticeModel
from ..models.varied import with_load_of
from ..problem.contact_problem import ContactProblem
from .choice import chosen_backend
from .request import Request

_TOLERANCE = 1e-5
"""Of the answers, relative to the error scale. What is left of an error is smooth, and stands for little load."""

_CYCLES = 2
"""More of them change little: what is far from the changed loads hardly moves."""


class Resolved:
    """Answers of a lattice's problem under changed loads, each begun from the one before.

    They are not judged: a bound that is made of one is proven by itself, whatever the answer is.

    Parameters
    ----------
    model : LatticeModel
    gap : array, shape (n,)
        Where to begin (length).
    """

    def __init__(self, model: LatticeModel, gap: Vector) -> None:
        self._model, self._gap = model, gap
        self._backend, _ = chosen_backend("auto", model.problem, {})
        self._request = Request.of(_TOLERANCE, max_iter=_CYCLES)
        self._gap_scale = model.problem.gap_scale
        self._state: State | None = None

    def __call__(self, change: Vector) -> Vector:
        """Return the gap after a change of the load at the nodes (force per area), both of shape (n,)."""
        varied = with_load_of(self._model, self._model.load + change).problem
        problem = varied.with_forces(varied.q, gap_scale=self._gap_scale)
        with Progress(f"{self._backend.name} · {problem.size} unknowns, loads changed") as progress:
            gap = self._answered(problem, progress)
        if gap is not None and np.isfinite(gap).all():
            self._gap = gap
        return self._gap

    def _answered(self, problem: ContactProblem, progress: Progress) -> Vector | None:
        scaled, units = problem.scaled()
        task = self._request.task(
            problem, units, _unasked, warm_start=units.dimensionless(self._gap), progress=progress, keeps=True
        )
        if self._state is None:
            self._state = self._backend.state_of(scaled, task, self._request.options)
        gap = self._state.solve_problem(scaled, task).gap
        return None if gap is None else units.gap(gap)


def _unasked(gap: Vector) -> float:
    """Return the bound that ends a solve where the backend's own estimate has come down to the tolerance."""
    return 0.0
