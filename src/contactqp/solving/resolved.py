"""Resolved: a model's problem solved again under loads that differ from its own by little."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..backends.base import State
from ..foundation.checks import Vector
from ..models.on_lattice import LatticeModel
from ..models.varied import with_load_of
from .choice import chosen_backend
from .request import Request

_TOLERANCE = 1e-8
"""Of the answers, relative to the gap's scale: second differences of them stand for loads."""


class Resolved:
    """Answers of a lattice's problem under changed loads, each begun from the one before.

    Parameters
    ----------
    model : LatticeModel
    gap : array, shape (n,)
        Where to begin (length).
    answered : callable
        Asks a backend: `Solution.by`.
    """

    def __init__(self, model: LatticeModel, gap: Vector, answered: Callable[..., Any]) -> None:
        self._model, self._gap, self._answered = model, gap, answered
        self._backend, _ = chosen_backend("auto", model.problem, {})
        self._request = Request.of(_TOLERANCE)
        self._state: State | None = None

    def __call__(self, change: Vector) -> Vector:
        """Return the gap after a change of the load at the nodes (force per area), both of shape (n,)."""
        varied = with_load_of(self._model, self._model.load + change)
        solution = self._answered(
            self._backend, varied, self._request, warm_start=self._gap, state=lambda: self._prepared(varied)
        )
        if solution.finite:
            self._gap = solution.gap
        return self._gap

    def _prepared(self, varied: LatticeModel) -> State:
        if self._state is None:
            scaled, units = varied.problem.scaled()
            task = self._request.task(varied.problem, units, lambda gap: float("inf"), keeps=True)
            self._state = self._backend.state_of(scaled, task, self._request.options)
        return self._state
