r"""Howard's policy iteration on min(max(R(ω), ω - u), ω - l) = 0, R(ω) = Mω + q, for an M-matrix M.

A policy says of each node which of the three vanishes: it is free (R = 0), or held by the lower or by the upper bound.
A step solves the equations of a policy, and takes the next one by the signs of what it finds. Without upper bounds the
gaps rise from step to step, and as there are finitely many policies it ends (Howard, *Dynamic Programming and Markov
Processes*, 1960; it is the primal-dual active set method, whose monotone convergence for M-matrices Hintermüller, Ito
and Kunisch show, SIAM J. Optim. 13, 2002). No symmetry is used. Where the contact set creeps, layers of nodes are
released together (`widening`), as long as that ends; whatever policy that leaves is as good a start as any.

*Two bounds.* Exchanging nodes at both bounds at once mostly ends as fast, but a policy may come back. From then on the
nodes at the lower bound, L, are held until those at the upper one have come to rest (cf. Bokanowski, Maroso and Zidani,
*Some convergence results for Howard's algorithm*, SIAM J. Numer. Anal. 47, 2009). Let H_L(ω)_i be ω_i - l_i on L and
max(R(ω), ω - u)_i off it. H_L(x) ≥ H_L(y) implies x ≥ y: on the nodes where x < y, none of which is in L, it is
R(x)_i ≥ R(y)_i (as x_i - u_i < y_i - u_i), which for an M-matrix leaves no such nodes (the proof of
`contactqp.proof.enclosure`). If ω solves H_L(ω) = 0 and L' is where ω_i - l_i is the lesser of the two, then
H_L'(ω) ≤ H_L(ω) = 0 = H_L'(ω'), so that ω ≤ ω': the gaps rise, and no L comes back unless nothing changes. Inside, the
gaps fall in the same way. Rounding errors may still exchange nodes at which gap and reaction both vanish for ever; a
policy that comes back then ends it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...foundation.checks import Mask, Vector
from ..parts import parts_of
from .primal_dual import Step
from .widening import Widening

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_FREE, _AT_LOWER, _AT_UPPER = 0, 1, 2

_EMPTY = np.zeros(0)

_MOST_WIDENED = 200
"""Steps after which layers are added no more."""


class PolicyIteration:
    """The iteration on R = Mω + q between bounds l ≤ 0 ≤ u.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        An M-matrix, with ascending column numbers.
    q : array, shape (n,)
    lower, upper : array, shape (n,)
        Bounds, -inf and inf where there is none; ``upper`` is empty where there is none at all.

    Attributes
    ----------
    omega : array, shape (n,)
        The gap.

    Examples
    --------
    >>> from scipy import sparse
    >>> iteration = PolicyIteration(sparse.csr_array([[2.0, -1.0], [0.0, 2.0]]), np.array([-1.0, 3.0]), np.zeros(2))
    >>> while not iteration.step().finished:
    ...     pass
    >>> iteration.omega
    array([0.5, 0. ])
    """

    def __init__(self, matrix: csr_array, q: Vector, lower: Vector, upper: Vector = _EMPTY) -> None:
        self._parts, self._diagonal = parts_of(matrix, symmetric=False), matrix.diagonal()
        self._widening = Widening(matrix)
        self.restart(q, lower, upper)

    def restart(self, q: Vector, lower: Vector, upper: Vector) -> None:
        """Go back to ω = 0 with other forces and other values of the bounds."""
        self._q, self._lower, self._upper = q, lower, upper if upper.size else np.full(q.size, np.inf)
        self.omega = np.zeros(q.size)
        self._policy: NDArray[np.int8] | None = None
        self._seen: set[bytes] = set()
        self._in_turn, self._widens, self._steps, self._exchanged = False, True, 0, 0
        self._widening.restart()

    def start(self, report: Callable[[str], None] = lambda text: None) -> None:
        """Start from ω = 0: its reactions tell the first policy."""

    def start_from(self, gap: Vector) -> None:
        """Start from a gap: its reactions tell the first policy."""
        self.omega = gap

    def feasible(self) -> Vector:
        """Return ω between its bounds, which it may leave on its way."""
        return np.minimum(np.maximum(self._lower, self.omega), self._upper)

    def step(self) -> Step:
        """Solve the equations of the policy, and take the next one."""
        before = self._policy
        if before is None:
            before = self._improved(self.omega, self._corrections())
        self._solve(before)
        self._widening.learn(self._exchanged, self.omega, self._lower, self._upper)
        after = self._next(before)
        exchanged, self._steps = int(np.count_nonzero(after != before)), self._steps + 1
        self._widens = self._widens and self._steps < _MOST_WIDENED
        finished = exchanged == 0
        if not finished:
            if self._widens:
                after = self._widened(after, before)
            mark = after.tobytes()
            finished = mark in self._seen and self._comes_back()
            self._seen.add(mark)
        self._exchanged, self._policy = int(np.count_nonzero(after != before)), after
        return Step(exchanged, finished)

    def _comes_back(self) -> bool:
        """Go on with more caution after a policy has come back; return whether only rounding can be the reason."""
        self._seen.clear()
        if self._widens:
            self._widens = False
        elif np.isfinite(self._upper).any() and not self._in_turn:
            self._in_turn = True
        else:
            return True
        return False

    def _widened(self, after: NDArray[np.int8], before: NDArray[np.int8]) -> NDArray[np.int8]:
        """Return the policy with the layers of nodes free that are released with others."""
        held, held_before = ((policy == _AT_LOWER, policy == _AT_UPPER) for policy in (after, before))
        at_lower, at_upper = self._widening.widened(held, held_before)
        return np.where(at_lower, _AT_LOWER, np.where(at_upper, _AT_UPPER, _FREE)).astype(np.int8)

    def _solve(self, policy: NDArray[np.int8]) -> None:
        """Set ω to the solution of a policy's equations."""
        free = policy == _FREE
        held = np.where(policy == _AT_UPPER, self._upper, self._lower)
        self.omega = np.where(free, self.omega, held)
        if not free.any():
            return
        solve = self._parts.solver(free)
        if solve is None:
            raise np.linalg.LinAlgError("the matrix of the free nodes is singular in double precision")
        for _ in range(2):  # the second time for what rounding has left
            self.omega[free] -= solve(self._reaction()[free])

    def _reaction(self) -> Vector:
        return self._parts.product(self.omega) + self._q

    def _corrections(self) -> Vector:
        return np.asarray(self._reaction() / self._diagonal)

    def _next(self, policy: NDArray[np.int8]) -> NDArray[np.int8]:
        """Return the policy after one whose equations ω solves."""
        # Of free nodes the reaction is zero but for rounding.
        correction = np.where(policy == _FREE, 0.0, self._corrections())
        if not self._in_turn:
            return self._improved(self.omega, correction)
        at_lower = policy == _AT_LOWER
        after = np.where(at_lower, _AT_LOWER, self._above(self.omega, correction)).astype(np.int8)
        if np.array_equal(after, policy):
            return self._improved(self.omega, correction)
        return after

    def _improved(self, omega: Vector, correction: Vector) -> NDArray[np.int8]:
        """Return which of the three each node has least of max(R, ω - u) and ω - l, by R over the diagonal."""
        above = self._above(omega, correction)
        least = np.where(above == _AT_UPPER, omega - self._upper, correction)
        return np.where(omega - self._lower < least, _AT_LOWER, above).astype(np.int8)

    def _above(self, omega: Vector, correction: Vector) -> Mask:
        """Return the nodes' part of a policy without lower bounds."""
        return np.where(omega - self._upper > correction, _AT_UPPER, _FREE)
