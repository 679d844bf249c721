"""ContactQP: the quadratic program min 1/2 w'Gw + q'w, l <= w <= u."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from ..algebra.kernel import Kernel
from ..algebra.sparse import SparseStiffness
from ..algebra.stiffness import Stiffness
from ..foundation.checks import Vector, read_only, unchanging, vector
from ..geometry.numbering import Grid
from .bounds import Bounds
from .contact_problem import ContactProblem, GapScale, checked_scale
from .facts import MatrixFacts
from .kernel_facts import KernelFacts


class ContactQP(ContactProblem):
    r"""A contact problem as a quadratic program: min ½ωᵀGω + qᵀω subject to l ≤ ω ≤ u.

    Its optimality conditions are a complementarity problem with the gap ω and the reaction R = Gω + q: R ≥ 0 where
    ω = l (the support pushes), R ≤ 0 where ω = u (the ceiling pushes back), and R = 0 in between. With l = 0 and no
    upper bound they are R ≥ 0, ω ≥ 0, ωᵀR = 0; eqs. (2.9)-(2.11) of the paper that contactqp starts from. The solution
    is unique because G is positive definite, or because what G does not hold is pressed on the bounds.

    Parameters
    ----------
    G : sparse array, dense array or Stencil, shape (n, n)
        Stiffness (force per length), symmetric and positive definite (with a ``kernel``: semidefinite), as is checked.
    q : array, shape (n,)
        Reaction that would hold the gap ω = 0 (force).
    lower, upper : float or array, shape (n,)
        Bounds l ≤ u of the gap (length); ``lower`` is -inf where there is no support, ``upper`` is inf where there is
        no ceiling.
    kernel : "constant" or array, shape (n,) or (n, m), optional
        Vectors k with Gk = 0, one in each column, of a G that is positive semidefinite and annihilates no others:
        ``"constant"`` for ones (rough surfaces that are periodic, Neumann conditions all around), columns for rigid
        motions or for parts that are not joined. Then forces and bounds must hold what G does not: qᵀd > 0 for every d
        in the kernel that never meets a bound. With ``"constant"`` and no upper bound the sum of q must be > 0, and the
        reactions balance it, ΣR = Σq.
    supported : array of bool, shape (n,), optional
        False where there is no support: another way to say that ``lower`` is -inf there.
    gap_scale : float, optional
        Length by which tolerances are measured. By default the mean distance from the admissible gap nearest to zero
        that the forces which leave it would make, bounded by the `barrier` (see `Barrier.mean_deflection`): an
        M-matrix's gap is at most G⁻¹ times them. Where no force is left over at all, it is the largest modulus of that
        gap, or of the bounds other than zero the least one; without any of these it is 1.

    Raises
    ------
    TypeError
        If G, q or a bound is complex or not numeric.
    ValueError
        If G is not square, finite, symmetric and positive definite, or q has the wrong shape or is not finite, or
        ``lower`` is above ``upper``; or if ``kernel`` is not what G annihilates (the message has the value), or q does
        not press on the bounds along it (the message has the force that is missing).

    Attributes
    ----------
    bounds : Bounds
        Both bounds, and what follows from them.
    reference : array, shape (n,), or float
        Ordinates that a model measures the gap from: reference - ω is its deflection. Without a model it is the
        admissible gap nearest to zero.
    frame_reference : array, shape (rows + 2, columns + 2), or None
        On a lattice whose frame is not at height zero: ordinates of the frame points, on the array with a ring.

    Notes
    -----
    A stiffness given as a `Stencil` is assembled only when `G` is asked for. A problem is never changed once it is
    made; `with_forces` makes another one that shares the matrix and all that is known of it.

    Examples
    --------
    >>> import numpy as np
    >>> import contactqp as cq
    >>> problem = cq.ContactQP(np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([-1.0, 3.0]))
    >>> problem
    ContactQP(2 unknowns, 4 nonzeros, M-matrix)
    >>> problem.reaction([0.5, 0.0])
    array([0. , 2.5])
    >>> problem.objective([0.5, 0.0])
    -0.25
    >>> cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0], lower=-1.0, upper=[0.1, 2.0])
    ContactQP(2 unknowns, 4 nonzeros, M-matrix, 2 with an upper bound)

    A ring of four nodes that nothing holds but contact, pressed by 3 and pulled by 2:

    >>> ring = 2 * np.eye(4) - np.roll(np.eye(4), 1, 0) - np.roll(np.eye(4), -1, 0)
    >>> problem = cq.ContactQP(ring, [-2.0, 0.0, 3.0, 0.0], kernel="constant")
    >>> problem
    ContactQP(4 unknowns, 12 nonzeros, singular M-matrix, kernel: constant)
    >>> solution = cq.solve(problem)
    >>> solution.gap.round(6).tolist(), solution.reaction.round(6).tolist(), solution.status.value
    ([2.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 0.0], 'certified')
    >>> problem.with_forces([-4.0, 0.0, 3.0, 0.0])  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ValueError: q must press on the bounds along the kernel, but the sum of q is -1: nothing holds the gap back, ...
    """

    def __init__(
        self,
        G: Any,
        q: ArrayLike,
        lower: ArrayLike = 0.0,
        upper: ArrayLike = np.inf,
        *,
        kernel: ArrayLike | Literal["constant"] | None = None,
        supported: ArrayLike | None = None,
        gap_scale: GapScale = None,
        reference: Vector | float | None = None,
        frame_reference: Grid | None = None,
    ) -> None:
        stiffness = G if isinstance(G, Stiffness) else SparseStiffness.of(G)
        gap_scale = checked_scale(gap_scale)
        facts = MatrixFacts(stiffness)
        if kernel is not None:
            facts = KernelFacts(stiffness, Kernel.of(kernel, stiffness.size))
        if stiffness is not G or kernel is not None:
            _require_definite(facts)
        forces = read_only(vector(q, stiffness.size, "q", copied=not unchanging(q)))
        bounds = Bounds.of(stiffness.size, lower, upper, supported)
        facts.require_balance(forces, bounds)
        self._fill(
            facts,
            forces,
            bounds,
            gap_scale,
            reference,
            frame_reference,
        )

    def objective(self, gap: ArrayLike) -> float:
        """Return ½ωᵀGω + qᵀω (force times length): the potential energy less that of the gap zero."""
        omega = vector(gap, self.size, "gap")
        return float(0.5 * (omega @ self.stiffness.matvec(omega)) + self.q @ omega)

    def prefers(self, gap: Vector) -> bool:
        """Whether a gap has no more energy than zero has, which every method lowers."""
        with np.errstate(over="ignore", invalid="ignore"):
            energy = float((0.5 * self.stiffness.matvec(gap) + self.q) @ gap)
        # Neither nan nor an overflow is <= 0.
        return energy <= 0 and bool(np.isfinite(energy))


def _require_definite(facts: MatrixFacts) -> None:
    """Raise a ValueError if a matrix is not as it must be; tell of a kernel that it seems to have."""
    try:
        facts.require_definite()
    except ValueError as error:
        seems = facts.kernel is None and Kernel.of("constant", facts.stiffness.size).annihilated_by(facts.stiffness)
        hint = "; its row sums are zero: pass kernel='constant' if contact alone is to hold the gap" if seems else ""
        raise ValueError(f"{error}{hint}") from None
