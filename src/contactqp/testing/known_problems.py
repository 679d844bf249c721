"""Small problems that are made from their solutions, for backends of all kinds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..algebra.stencil import Stencil
from ..foundation.checks import Vector
from ..foundation.loading import load_modules
from ..problem.contact_lcp import ContactLCP
from ..problem.contact_problem import ContactProblem
from ..problem.contact_qp import ContactQP

_SEED = 20


@dataclass(frozen=True)
class Known:
    """A problem and its solution.

    Attributes
    ----------
    label : str
        The problem in words.
    problem : ContactProblem
    gap : array, shape (n,)
        The solution ω (length).
    """

    label: str
    problem: ContactProblem
    gap: Vector


def one_sided() -> list[Known]:
    """Return problems without an upper bound: on a lattice, with a matrix, and without contact.

    Examples
    --------
    >>> [known.problem.size for known in one_sided()]
    [100, 12, 12]
    """
    return [
        _made("a lattice of 100 nodes", ContactQP, _lattice(), upper=np.inf),
        _made("a matrix with 12 unknowns", ContactQP, _matrix(), upper=np.inf),
        _made("a matrix with 12 unknowns, and contact nowhere", ContactQP, _matrix(), upper=np.inf, touching=False),
    ]


def two_sided() -> list[Known]:
    """Return problems with both bounds: on a lattice, with a matrix, and some unknowns with one bound or none."""
    lower = np.where(np.arange(12) % 4 == 0, -np.inf, -1.0)
    upper = np.where(np.arange(12) % 3 == 0, np.inf, 1.0)
    return [
        _made("a lattice of 100 nodes between two bounds", ContactQP, _lattice(), upper=1.0),
        _made("a matrix with 12 unknowns between two bounds", ContactQP, _matrix(), upper=1.0),
        _made("a matrix with 12 unknowns, some without a bound", ContactQP, _matrix(), lower=lower, upper=upper),
    ]


def other_matrices() -> list[Known]:
    """Return problems with positive off-diagonal entries, with a kernel, and with a matrix that is not symmetric."""
    size = 12
    ring = 2 * np.eye(size) - np.roll(np.eye(size), 1, axis=0) - np.roll(np.eye(size), -1, axis=0)
    beam = _matrix() + 0.2 * (np.eye(size, k=2) + np.eye(size, k=-2))
    drift = _matrix() - 0.3 * np.eye(size, k=1)
    return [
        _made("a matrix with positive off-diagonal entries", ContactQP, beam, upper=np.inf),
        _made("a ring that contact alone holds", ContactQP, ring, upper=np.inf, kernel="constant"),
        _made("a matrix that is not symmetric (ContactLCP)", ContactLCP, drift, upper=np.inf),
    ]


def _lattice() -> Stencil:
    return Stencil(np.ones((10, 10), dtype=bool), horizontal=1.0, vertical=1.0)


def _matrix() -> Vector:
    """Return an M-matrix, shape (12, 12)."""
    size = 12
    chords = np.eye(size, k=5) + np.eye(size, k=-5)
    return np.asarray(3.0 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1) - 0.3 * chords)


def _made(
    label: str,
    kind: Callable[..., ContactProblem],
    matrix: Any,
    *,
    lower: float | Vector = 0.0,
    upper: float | Vector,
    touching: bool = True,
    **options: Any,
) -> Known:
    """Return the problem of which a chosen gap is the solution: q = R - Gω, where the bounds exert R."""
    load_modules("scipy.sparse")
    size = matrix.shape[0] if isinstance(matrix, np.ndarray) else matrix.size
    low, high = np.broadcast_to(lower, size), np.broadcast_to(upper, size)
    rng = np.random.default_rng(_SEED)
    state = rng.integers(-1, 2 if touching else 1, size) if touching else np.zeros(size, dtype=int)
    at_low, at_high = (state < 0) & np.isfinite(low), (state > 0) & np.isfinite(high)
    inside = np.clip(rng.uniform(0.2, 0.8, size), low, high)
    gap = np.where(at_low, low, np.where(at_high, high, inside))
    reaction = rng.uniform(0.5, 1.5, size) * (at_low.astype(float) - at_high.astype(float))
    product = matrix @ gap if isinstance(matrix, np.ndarray) else matrix.matvec(gap)
    return Known(label, kind(matrix, reaction - product, lower, upper, **options), gap)
