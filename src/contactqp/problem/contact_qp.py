"""ContactQP: the quadratic program min 1/2 w'Gw + q'w, l <= w <= u, and its data's properties."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..algebra.sparse import SparseStiffness
from ..algebra.stiffness import Stiffness
from ..foundation.checks import Vector, positive_number, read_only, times, vector
from ..geometry.numbering import Grid, Layout
from .barrier import Barrier
from .bounds import Bounds
from .facts import MatrixFacts
from .posed import Posed, Units

_GapScale: TypeAlias = "float | Callable[[Barrier | None], float | None] | None"
"""A length, or what finds one by the barrier; None leaves it to the problem."""


class ContactQP(Posed):
    r"""A contact problem as a quadratic program: min ½ωᵀGω + qᵀω subject to l ≤ ω ≤ u.

    Its optimality conditions are a complementarity problem with the gap ω and the reaction R = Gω + q: R ≥ 0 where
    ω = l (the support pushes), R ≤ 0 where ω = u (the ceiling pushes back), and R = 0 in between. With l = 0 and no
    upper bound they are R ≥ 0, ω ≥ 0, ωᵀR = 0; eqs. (2.9)-(2.11) of the paper that contactqp starts from. The solution
    is unique because G is positive definite.

    Parameters
    ----------
    G : sparse array, dense array or Stencil, shape (n, n)
        Stiffness (force per length), symmetric and positive definite: this is checked.
    q : array, shape (n,)
        Reaction that would hold the gap ω = 0 (force).
    lower, upper : float or array, shape (n,)
        Bounds l ≤ u of the gap (length); ``lower`` is -inf where there is no support, ``upper`` is inf where there is
        no ceiling.
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
        ``lower`` is above ``upper``.

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
    """

    def __init__(
        self,
        G: Any,
        q: ArrayLike,
        lower: ArrayLike = 0.0,
        upper: ArrayLike = np.inf,
        *,
        supported: ArrayLike | None = None,
        gap_scale: _GapScale = None,
        reference: Vector | float | None = None,
        frame_reference: Grid | None = None,
    ) -> None:
        stiffness = G if isinstance(G, Stiffness) else SparseStiffness.of(G)
        gap_scale = _checked_scale(gap_scale)
        facts = MatrixFacts(stiffness)
        if stiffness is not G:
            facts.require_definite()
        self._fill(
            facts,
            read_only(vector(q, stiffness.size, "q")),
            Bounds.of(stiffness.size, lower, upper, supported),
            gap_scale,
            reference,
            frame_reference,
        )

    def _fill(
        self,
        facts: MatrixFacts,
        q: Vector,
        bounds: Bounds,
        gap_scale: _GapScale,
        reference: Vector | float | None,
        frame_reference: Grid | None,
    ) -> None:
        """Set what a problem is made of, all of it checked before."""
        super().__init__(facts, q, bounds)
        self._own_gap_scale = gap_scale
        self.reference = bounds.nearest_zero if reference is None else reference
        self.frame_reference = frame_reference

    @classmethod
    def _of(cls, *parts: Any) -> ContactQP:
        """Return the problem that consists of what `_fill` takes."""
        problem = cls.__new__(cls)
        problem._fill(*parts)
        return problem

    def with_forces(
        self,
        q: ArrayLike,
        *,
        gap_scale: _GapScale = None,
        reference: Vector | float | None = None,
    ) -> ContactQP:
        """Return the problem with other forces; it shares the matrix, the bounds and all that is known of them.

        Parameters
        ----------
        q : array, shape (n,)
            Reaction that would hold the gap ω = 0 (force).
        gap_scale : float, optional
            As for the class; by default it is found anew.
        reference : array, shape (n,), or float, optional
            As the attribute; by default this problem's.

        Raises
        ------
        TypeError, ValueError
            If q has the wrong kind or shape or is not finite.

        Examples
        --------
        >>> import contactqp as cq
        >>> problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
        >>> cq.solve(problem.with_forces([-2.0, 3.0])).gap
        array([1., 0.])
        """
        gap_scale = _checked_scale(gap_scale)
        forces = read_only(vector(q, self.size, "q"))
        reference = self.reference if reference is None else reference
        return ContactQP._of(self.facts, forces, self.bounds, gap_scale, reference, self.frame_reference)

    @property
    def own_gap_scale(self) -> float | None:
        """The gap scale that the problem was made with (length); None where it is found from the data."""
        return None if callable(self._own_gap_scale) else self._own_gap_scale

    def share_facts(self, other: ContactQP) -> bool:
        """Take over what is proven of another problem's matrix, where it equals this one's to the bit.

        Returns
        -------
        bool
            Whether it does.

        Examples
        --------
        >>> import contactqp as cq
        >>> one, other = (cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], forces) for forces in ([-1.0, 3.0], [2.0, -4.0]))
        >>> other.share_facts(one), other.facts is one.facts
        (True, True)
        """
        if not self.stiffness.equals(other.stiffness):
            return False
        self.facts = other.facts
        return True

    @property
    def layout(self) -> Layout:
        """The lattice's nodes along its rows, those with the same kind of bounds together.

        Raises
        ------
        AttributeError
            If G was given as a matrix.
        """
        stencil = self.stencil
        if stencil is None:
            raise AttributeError("layout needs a problem on a lattice; this one's G is a matrix")
        return self.bounds.layout(stencil)

    def bound_grids(self) -> tuple[Grid, Grid]:
        """Return the bounds on the grid of `layout`; where no node is bounded by other than zero, empty grids."""
        if self.bounds.standard:
            return np.zeros((0, 0)), np.zeros((0, 0))
        layout = self.layout
        return layout.grid(np.ascontiguousarray(self.lower)), layout.grid(np.ascontiguousarray(self.upper))

    def reference_grid(self) -> Grid:
        """Return the reference ordinates of nodes and frame points on the grid of `layout`."""
        stencil, layout = self.stencil, self.layout
        assert stencil is not None
        reference = np.broadcast_to(np.asarray(self.reference, dtype=np.float64), (self.size,))
        grid = layout.grid(np.ascontiguousarray(reference))
        if self.frame_reference is not None:
            rows, columns = stencil.numbering.box
            frame = self.frame_reference[rows.start : rows.stop + 2, columns.start : columns.stop + 2]
            np.copyto(grid, frame, where=~np.pad(layout.mask, 1))
        return grid

    def prepare(self) -> None:
        """Find the facts about the matrix that judging needs, so that they cost no time later."""
        _ = self.gap_scale, self.is_m_matrix

    @cached_property
    def gap_scale(self) -> float:
        """Length by which tolerances are measured, > 0 (see the class)."""
        given = self._own_gap_scale(self.barrier) if callable(self._own_gap_scale) else self._own_gap_scale
        if given is not None:
            return given
        for every in (False, True):
            scale = float(self._mean_distance(self._forces_at_origin) if every else self.mean_opening)
            if not np.isfinite(scale):
                raise ValueError("the ranges of G and q are too wide for double precision: the gap scale overflows")
            if scale > 0:
                return scale
        # The solution is the admissible gap nearest to zero. A bound far away may stand for none, the nearest one not.
        sizes = np.abs(self.bounds.nearest_zero).max(), self.bounds.least_magnitude
        return next((float(size) for size in sizes if size > 0), 1.0)

    @cached_property
    def shut(self) -> bool:
        """Whether no force moves the admissible gap nearest to zero: then it is the solution."""
        return not self.opens

    def objective(self, gap: ArrayLike) -> float:
        """Return ½ωᵀGω + qᵀω (force times length): the potential energy less that of the gap zero."""
        omega = vector(gap, self.size, "gap")
        return float(0.5 * (omega @ self.stiffness.matvec(omega)) + self.q @ omega)

    def reaction(self, gap: ArrayLike) -> Vector:
        """Return R = Gω + q (force), shape (n,)."""
        omega = vector(gap, self.size, "gap")
        return self.stiffness.matvec(omega) + self.q

    def scaled(self) -> tuple[ContactQP, Units]:
        """Return the dimensionless problem and its units.

        The largest diagonal entry of its matrix is 1, and its gap scale; a matrix gets a diagonal of ones, by a unit of
        length for each unknown, which keeps it symmetric and its signs. The gap zero is always admissible: where the
        bounds exclude it, the dimensionless gap is counted from the admissible one nearest to it.
        """
        q, bounds, units = self.in_units(self.gap_scale)
        origin = units.origin
        if isinstance(self.reference, float) or not isinstance(origin, float):
            reference = (self.reference - origin) / units.length
        else:
            reference = times(self.reference, 1 / units.length)
        frame = None if self.frame_reference is None else self.frame_reference / units.length
        return ContactQP._of(self.facts.scaled, q, bounds, 1.0, reference, frame), units

    def __repr__(self) -> str:
        kind = "M-matrix" if self.is_z_matrix else "no Z-matrix"
        free = int(np.count_nonzero(~self.supported))
        unsupported = f", {free} unsupported" if free else ""
        ceiling = "" if self.one_sided else f", {int(np.count_nonzero(np.isfinite(self.upper)))} with an upper bound"
        return f"ContactQP({self.size} unknowns, {self.stiffness.nonzeros} nonzeros, {kind}{unsupported}{ceiling})"


def _checked_scale(value: _GapScale) -> _GapScale:
    return value if value is None or callable(value) else positive_number(value, "gap_scale")
