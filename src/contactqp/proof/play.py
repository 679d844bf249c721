r"""How far an answer can be moved where its problem has more than one solution.

All solutions of a problem with a kernel have the same reaction (`contactqp.algebra.kernel`), so that two of them differ
by a vector of the kernel that vanishes wherever the reaction does not. If forces q do no work along such a vector, and
no bound stops the answer at once, moving it changes no residual but by rounding: nothing tells which of these answers
is meant.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Vector
from ..foundation.rounding import UNIT_ROUNDOFF
from ..problem.contact_problem import ContactProblem

_FAR = 1000.0
"""Residuals that an answer must be movable by, so that it is not its own error that lets it move."""

_ROUNDINGS = 8.0
"""Roundings of qᵀd, times the root of its terms, that count as no work beside |q|ᵀ|d|."""


def play(problem: ContactProblem, gap: Vector, residual: float) -> float:
    """Return how far an answer can be moved along the kernel and still solve the problem as well (length).

    It is 0 where there is no kernel, where contact holds it, and where moving leaves a larger residual. Only the
    vectors of a basis are tried: where it is 0, combinations of them may still move the answer.

    Parameters
    ----------
    problem : ContactProblem
    gap : array, shape (n,)
        A finite answer (length).
    residual : float
        Natural residual up to which an answer counts as one (length); the answer's own counts, if it is larger.

    Examples
    --------
    >>> import contactqp as cq
    >>> row = [[1.0, -1.0], [-1.0, 1.0]]
    >>> between = cq.ContactQP(row, [0.0, 0.0], lower=0.0, upper=[1.0, 3.0], kernel="constant")
    >>> round(play(between, np.array([0.25, 0.25]), 1e-6), 9)
    0.75
    >>> play(between.with_forces([1.0, 0.0]), np.array([0.0, 0.0]), 1e-6)
    0.0
    """
    if problem.kernel is None:
        return 0.0
    diagonal, bounds = problem.stiffness.diagonal(), problem.bounds

    def correction(at: Vector) -> Vector:
        return np.asarray(problem.reaction(at) / diagonal)

    def left_over(at: Vector) -> float:
        return float(np.abs(bounds.natural_map(at, correction(at))).max())

    allowed = max(residual, left_over(gap))
    best, no_work = 0.0, _ROUNDINGS * np.sqrt(problem.size) * UNIT_ROUNDOFF
    for direction in _free(problem.kernel.vectors, np.abs(correction(gap)) > allowed):
        work, most = float(problem.q @ direction), float(np.abs(problem.q) @ np.abs(direction))
        if abs(work) > no_work * most:
            continue
        for way in (direction, -direction):
            with np.errstate(divide="ignore", invalid="ignore"):
                room = np.where(way > 0, (problem.upper - gap) / way, (problem.lower - gap) / way)
            length = float(max(room[way != 0].min(), 0.0))
            if not np.isfinite(length) or length <= max(best, _FAR * allowed):
                continue
            if left_over(problem.project(gap + length * way)) <= 2 * allowed:
                best = length
    return best


def _free(vectors: NDArray[np.float64], held: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return vectors that span what vanishes at the nodes that are held, their largest entry being one, as rows."""
    basis = np.linalg.qr(vectors / np.abs(vectors).max(axis=0))[0]
    if held.any():
        _, singular, weights = np.linalg.svd(basis[held], full_matrices=True)
        basis = basis @ weights[np.count_nonzero(singular > _HELD) :].T
    return (basis / np.abs(basis).max(axis=0)).T if basis.size else np.zeros((0, len(vectors)))


_HELD = 1e-9
"""Singular value of the kernel at nodes that are held, up to which they do not hold it."""
