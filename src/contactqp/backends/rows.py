"""The bounds of a problem as rows of a program in standard form, A ω + s = b with s in a cone."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from ..foundation.checks import Mask, Vector
from ..foundation.loading import load_modules
from ..problem.contact_problem import ContactProblem
from .library import Ask, LibraryState, Vectors

_CLOSE = 0.01
"""Width between two bounds that is none, in tolerances of the gap under the largest force on a node alone."""


class Rows:
    """Rows -ω ≤ -l and ω ≤ u where there is such a bound; where both are close, an equation in their place.

    An interior point needs an interior. The equations come first, and ask for the middle of the two bounds.

    Parameters
    ----------
    problem : ContactProblem
    tol : float
        The wanted bound of the gap's error, which tells what is close.

    Attributes
    ----------
    equations, inequalities : int
        How many rows there are of each kind.

    Examples
    --------
    >>> import contactqp as cq
    >>> problem = cq.ContactQP(np.eye(3), [-1.0, 2.0, 0.0], [0.0, 1.0, -np.inf], [np.inf, 1.0, 4.0])
    >>> rows = Rows(problem, 1e-6)
    >>> rows.matrix.toarray()
    array([[ 0.,  1.,  0.],
           [-1.,  0.,  0.],
           [ 0.,  0.,  1.]])
    >>> rows.limits(problem)
    array([1., 0., 4.])
    """

    def __init__(self, problem: ContactProblem, tol: float) -> None:
        self._close = _close(problem, tol)
        masks = self._close, problem.supported & ~self._close, np.isfinite(problem.upper) & ~self._close
        self._equal, self._below, self._above = (np.flatnonzero(mask) for mask in masks)
        self.equations, self.inequalities = self._equal.size, self._below.size + self._above.size

    def __eq__(self, other: object) -> bool:
        """Whether these are the rows of another problem with bounds of the same kinds."""
        return isinstance(other, Rows) and np.array_equal(self._close, other._close)

    __hash__ = None  # type: ignore[assignment]

    @cached_property
    def matrix(self) -> Any:
        """The matrix A, in compressed columns."""
        load_modules("scipy.sparse")
        from scipy import sparse

        columns = np.concatenate([self._equal, self._below, self._above])
        signs = np.repeat([1.0, -1.0, 1.0], [self._equal.size, self._below.size, self._above.size])
        places, shape = (np.arange(columns.size), columns), (columns.size, self._close.size)
        return sparse.csc_matrix(sparse.csc_array((signs, places), shape=shape))

    def limits(self, problem: ContactProblem) -> Vector:
        """Return the right-hand side b."""
        middle = 0.5 * (problem.lower[self._equal] + problem.upper[self._equal])
        return np.concatenate([middle, 0.0 - problem.lower[self._below], problem.upper[self._above]])

    def box(self, problem: ContactProblem) -> tuple[Vector, Vector]:
        """Return lower and upper bounds, infinite where an equation stands in their place."""
        return np.where(self._close, -np.inf, problem.lower), np.where(self._close, np.inf, problem.upper)

    def gap(self, problem: ContactProblem, solution: Vector, multiplier: Vector) -> Vector:
        """Return a program's solution as a gap: at an equation it is the bound that its multiplier tells.

        Parameters
        ----------
        problem : ContactProblem
        solution : array, shape (n,)
            It is changed.
        multiplier : array
            One number for each row, >= 0 for an inequality.
        """
        equal = self._equal
        # The multiplier of an equation is -R, and R >= 0 at the lower bound.
        solution[equal] = np.where(multiplier[: equal.size] <= 0, problem.lower[equal], problem.upper[equal])
        return solution


class StateInRows(LibraryState):
    """The state of a library that takes bounds as such rows, with its forces called q and its limits b."""

    def form(self, problem: ContactProblem, tol: float) -> Rows:
        """See `LibraryState.form`."""
        return Rows(problem, tol)

    def vectors(self, ask: Ask) -> Vectors:
        """See `LibraryState.vectors`."""
        return {"q": ask.problem.q * ask.weight, "b": ask.form.limits(ask.problem)}


def _close(problem: ContactProblem, tol: float) -> Mask:
    """Where bounds are closer than the tolerance tells."""
    scale = float(np.abs(problem.q / problem.stiffness.diagonal()).max())
    return problem.upper - problem.lower <= _CLOSE * tol * scale
