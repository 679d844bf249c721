"""A contact problem as a layer of a differentiable program: values and gradients for batches of loads and supports."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import positive_number
from ..models.base import ContactModel
from .sensitivity import Sensitivity
from .solver import Solver

if TYPE_CHECKING:
    from .solution import Solution

Batch = NDArray[np.float64]


class Fields(NamedTuple):
    """Gap and deflection (length), and reaction (force) at the nodes, each of shape (..., n)."""

    gap: Batch
    deflection: Batch
    reaction: Batch


class _Answered(NamedTuple):
    """What was answered last: gradients are asked for after answers, to the same loads and supports."""

    load: Batch
    support: Batch
    solutions: list[Solution]

    def same(self, load: Batch, support: Batch) -> bool:
        return np.array_equal(load, self.load) and np.array_equal(support, self.support)


@dataclass
class Layer:
    """What a model answers to loads and supports, and what a number changes by with them.

    Parameters
    ----------
    model : ContactModel
        Its load and support are replaced.
    tol : float
        Bound of the error, relative to the error scale, to which each problem is solved.

    Examples
    --------
    >>> import contactqp as cq
    >>> layer = Layer(cq.Cable(nodes=9, spacing=1.0, tension=1.0, load=1.0, support=2.0))
    >>> fields = layer.answers(np.ones((2, 9)), np.full((2, 9), 2.0))
    >>> fields.reaction.shape, fields.reaction[0].sum().round(6).item()
    ((2, 9), 6.0)
    >>> load, support = layer.gradients(np.ones(9), np.full(9, 2.0), Fields(0.0, 0.0, np.ones(9)))
    >>> load.shape
    (9,)
    """

    model: ContactModel
    tol: float = 1e-10
    _last: _Answered | None = field(default=None, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not isinstance(self.model, ContactModel):
            raise TypeError(f"model must be a Membrane, Cable or CableNet, or one of one's own, got {self.model!r}")
        positive_number(self.tol, "tol")

    def answers(self, load: Batch, support: Batch) -> Fields:
        """Return what the model answers to loads and supports, each of shape (..., n)."""
        found = [(solution.gap, solution.deflection, solution.reaction) for solution in self._solutions(load, support)]
        return Fields(*(np.reshape(part, np.shape(load)) for part in zip(*found, strict=True)))

    def gradients(self, load: Batch, support: Batch, weights: Fields) -> tuple[Batch, Batch]:
        """Return the derivatives of Σ weight times field by load and by support, each of shape (..., n).

        Nodes that have neither gap nor reaction count as held: of the one-sided derivatives it is one.
        """
        shape = np.shape(load)
        rows = [np.broadcast_to(weight, shape).reshape(-1, shape[-1]) for weight in weights]
        by = "load", "support"
        found = [
            Sensitivity(solution).adjoint(gap=gap, deflection=deflection, reaction=reaction, by=by, biactive="held")
            for solution, gap, deflection, reaction in zip(self._solutions(load, support), *rows, strict=True)
        ]
        by_load, by_support = ([each[name] for each in found] for name in by)
        return np.reshape(by_load, shape), np.reshape(by_support, shape)

    def _solutions(self, load: Batch, support: Batch) -> list[Solution]:
        size = self.model.size
        for name, value in (("load", load), ("support", support)):
            if np.shape(value)[-1:] != (size,):
                raise ValueError(f"{name} must have shape (..., {size}), got {np.shape(value)}")
        last = self._last
        if last is not None and last.same(load, support):
            return last.solutions
        session = Solver(self.model, tol=self.tol)
        load, support = np.array(load), np.array(support)
        pairs = zip(np.reshape(load, (-1, size)), np.reshape(support, (-1, size)), strict=True)
        solutions = [session.solve(load=forces, support=heights) for forces, heights in pairs]
        self._last = _Answered(load, support, solutions)
        return solutions
