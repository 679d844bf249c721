"""ContactLCP: a complementarity problem whose M-matrix need not be symmetric."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..algebra.nonsymmetric import NonsymmetricStiffness
from ..errors import UnsuitableProblemError
from ..foundation.checks import Vector, read_only, vector
from .bounds import Bounds
from .contact_problem import ContactProblem, checked_scale
from .m_matrix_facts import MMatrixFacts


class ContactLCP(ContactProblem):
    r"""A linear complementarity problem: R = Mω + q, l ≤ ω ≤ u, for an M-matrix M that need not be symmetric.

    R ≥ 0 where ω = l, R ≤ 0 where ω = u, and R = 0 in between; with l = 0 and no upper bound R ≥ 0, ω ≥ 0, ωᵀR = 0.
    Such problems come of upwind differences: optimal stopping, options that may be exercised early (ω is the value, l
    the payoff), contact under a flow that carries heat or load along. M-matrices are P-matrices, so the solution is
    unique for any q (Cottle, Pang and Stone, *The Linear Complementarity Problem*, 1992, theorem 3.3.7). It minimises
    nothing where M is not symmetric, so that only backends which need no quadratic program take it: ``"active-set"``
    (Howard's policy iteration), ``"psor"`` and ``"mangasarian"``. The certificate's proofs use no symmetry (see
    `contactqp.proof.enclosure`).

    Parameters
    ----------
    M : sparse array or dense array, shape (n, n)
        Off-diagonal entries ≤ 0, diagonal > 0, and a vector v > 0 with Mv > 0: that is looked for by a linear solve,
        and checked with all rounding bounded. Neither rows nor columns need to be diagonally dominant.
    q : array, shape (n,)
        Reaction that would hold the gap ω = 0 (force).
    lower, upper : float or array, shape (n,)
        Bounds l ≤ u of the gap (length); -inf and inf where there is none.
    gap_scale : float, optional
        Length by which tolerances are measured, as for `ContactQP`.

    Raises
    ------
    TypeError
        If M, q or a bound is complex or not numeric.
    ValueError
        If M is not square, finite and a nonsingular M-matrix, or q has the wrong shape or is not finite, or ``lower``
        is above ``upper``.

    Examples
    --------
    A flow to the right, by upwind differences; the heated nodes rise to their upper bound, and those behind them are
    warm:

    >>> import numpy as np
    >>> import contactqp as cq
    >>> M = np.diag(np.full(4, 3.0)) - np.diag(np.full(3, 2.0), -1) - np.diag(np.full(3, 0.5), 1)
    >>> problem = cq.ContactLCP(M, [-6.0, 0.0, 0.0, 1.0], upper=1.0)
    >>> problem
    ContactLCP(4 unknowns, 10 nonzeros, M-matrix, 4 with an upper bound)
    >>> solution = cq.solve(problem)
    >>> solution.gap.round(6).tolist(), solution.status.value
    ([1.0, 0.75, 0.5, 0.0], 'certified')
    """

    def __init__(
        self,
        M: Any,
        q: ArrayLike,
        lower: ArrayLike = 0.0,
        upper: ArrayLike = np.inf,
        *,
        gap_scale: float | None = None,
    ) -> None:
        facts = MMatrixFacts(NonsymmetricStiffness.of(M))
        gap_scale = checked_scale(gap_scale)  # type: ignore[assignment]
        forces = read_only(vector(q, facts.stiffness.size, "q"))
        bounds = Bounds.of(facts.stiffness.size, lower, upper)
        facts.require_definite()
        self._fill(facts, forces, bounds, gap_scale, None, None)

    def objective(self, gap: ArrayLike) -> float:
        """Raise an UnsuitableProblemError: there is no function that the solution minimises."""
        self.require_energy()
        raise AssertionError

    def require_energy(self) -> None:
        """Raise an UnsuitableProblemError, which says that there is no energy, and why."""
        asymmetry = self.stiffness.asymmetry
        why = "is symmetric: pose it as ContactQP(M, q)" if asymmetry is None else f"is not symmetric: {asymmetry}"
        raise UnsuitableProblemError(f"there is no energy of {self!r}, whose matrix {why}")

    def prefers(self, gap: Vector) -> bool:
        """Whether the largest natural residual of a gap is no more than that of zero."""
        zero = np.zeros_like(gap)
        own, of_zero = (self._natural_residual(vector) for vector in (gap, zero))
        return bool(own <= of_zero)

    def _natural_residual(self, gap: Vector) -> float:
        with np.errstate(over="ignore", invalid="ignore"):
            correction = (self.stiffness.matvec(gap) + self.q) / self.stiffness.diagonal()
            return float(np.abs(self.bounds.natural_map(gap, correction)).max())
