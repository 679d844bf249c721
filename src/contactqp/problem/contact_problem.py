"""ContactProblem: a complementarity problem between two bounds, whatever its matrix, and its data's properties."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Self, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..foundation.checks import Mask, Vector, positive_number, read_only, times, vector
from ..foundation.files import path_of
from ..foundation.text import counted
from ..geometry.numbering import Grid, Layout
from .barrier import Barrier
from .bounds import Bounds
from .facts import MatrixFacts
from .posed import Made, Posed, Units, made
from .program_files import PROGRAMS, write_problem
from .programs import ConvexProgram, convex_program, linear_program, qpsolvers_problem

GapScale: TypeAlias = "float | Callable[[Barrier | None], float | None] | None"
"""A length, or what finds one by the barrier; None leaves it to the problem."""


class ContactProblem(Posed):
    r"""A gap ω between two bounds, l ≤ ω ≤ u, and a reaction R = Gω + q that the bounds alone exert.

    R ≥ 0 where ω = l, R ≤ 0 where ω = u, and R = 0 in between. What is common to `contactqp.ContactQP`, whose matrix is
    symmetric, and to `contactqp.ContactLCP`, whose matrix is not: whatever needs no energy takes either.

    Attributes
    ----------
    bounds : Bounds
        Both bounds, and what follows from them.
    reference : array, shape (n,), or float
        Ordinates that a model measures the gap from: reference - ω is its deflection. Without a model it is the
        admissible gap nearest to zero.
    frame_reference : array, shape (rows + 2, columns + 2), or None
        On a lattice whose frame is not at height zero: ordinates of the frame points, on the array with a ring.
    """

    def _fill(
        self,
        facts: MatrixFacts,
        q: Made[Vector],
        bounds: Bounds,
        gap_scale: GapScale,
        reference: Made[Vector | float | None],
        frame_reference: Grid | None,
    ) -> None:
        """Set what a problem is made of, all of it checked before."""
        super().__init__(facts, q, bounds)
        self._own_gap_scale = gap_scale
        self._reference: Any = bounds.nearest_zero if reference is None else reference
        self.frame_reference = frame_reference

    @property
    def reference(self) -> Vector | float:
        """Ordinates that the gap is measured from (length), shape (n,), or the number that all have; see the class."""
        self._reference = made(self._reference)
        reference: Vector | float = self._reference
        return reference

    @classmethod
    def _of(cls, *parts: Any) -> Self:
        """Return the problem that consists of what `_fill` takes."""
        problem = cls.__new__(cls)
        problem._fill(*parts)
        return problem

    @abstractmethod
    def objective(self, gap: ArrayLike) -> float:
        """Return the function that the solution minimises, at a gap.

        Raises
        ------
        UnsuitableProblemError
            If there is none.
        """

    def require_energy(self) -> None:
        """Raise an UnsuitableProblemError where there is no function that the solution minimises, saying why."""

    @abstractmethod
    def prefers(self, gap: Vector) -> bool:
        """Whether an admissible gap is nearer to the solution than zero is, as far as numbers that cost little tell."""

    def with_forces(
        self,
        q: ArrayLike,
        *,
        gap_scale: GapScale = None,
        reference: Vector | float | None = None,
    ) -> Self:
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
            If q has the wrong kind or shape or is not finite; or if a kernel is left unbalanced by it.

        Examples
        --------
        >>> import contactqp as cq
        >>> problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
        >>> cq.solve(problem.with_forces([-2.0, 3.0])).gap
        array([1., 0.])
        """
        gap_scale = checked_scale(gap_scale)
        forces = read_only(vector(q, self.size, "q"))
        self.facts.require_balance(forces, self.bounds)
        reference = self.reference if reference is None else reference
        return self._of(self.facts, forces, self.bounds, gap_scale, reference, self.frame_reference)

    def with_data(self, q: ArrayLike, lower: ArrayLike, upper: ArrayLike) -> Self:
        """Return the problem with other forces between other bounds; it shares the matrix and what is known of it.

        Parameters
        ----------
        q : array, shape (n,)
            Force.
        lower, upper : float or array, shape (n,)
            Bounds (length), -inf and inf where there is none.
        """
        bounds = Bounds.of(self.size, lower, upper)
        forces = read_only(vector(q, self.size, "q"))
        self.facts.require_balance(forces, bounds)
        return self._of(self.facts, forces, bounds, None, None, None)

    def with_springs(self, at_lower: Mask, at_upper: Mask) -> Self:
        """Return the problem with springs at some nodes, that pull the gap to the bound which holds it there.

        Each is as stiff as the node's diagonal entry. Where they are not stretched, the solution is the same.

        Parameters
        ----------
        at_lower, at_upper : array of bool, shape (n,)
            Nodes with a spring to their lower, and to their upper bound, which are finite there.
        """
        held = at_lower | at_upper
        at_bound = np.where(at_upper, self.upper, np.where(at_lower, self.lower, 0.0))
        springs = np.where(held, self.stiffness.diagonal(), 0.0)
        forces = read_only(self.q - springs * at_bound)
        return self._of(self.facts.with_springs(held), forces, self.bounds, 1.0, self.reference, self.frame_reference)

    @property
    def own_gap_scale(self) -> float | None:
        """The gap scale that the problem was made with (length); None where it is found from the data."""
        return None if callable(self._own_gap_scale) else self._own_gap_scale

    def share_facts(self, other: ContactProblem) -> bool:
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

    def force_grid(self) -> Grid:
        """Return the forces on the grid of `layout`; if they have not been made before, they are not kept."""
        return self.layout.grid(made(self._q))

    def bound_grids(self) -> tuple[Grid, Grid]:
        """Return the bounds on the grid of `layout`; where no node is bounded by other than zero, empty grids."""
        if self.bounds.standard:
            return np.zeros((0, 0)), np.zeros((0, 0))
        layout = self.layout
        return layout.grid(np.ascontiguousarray(self.lower)), layout.grid(np.ascontiguousarray(self.upper))

    def reference_grid(self) -> Grid:
        """Return the reference ordinates of nodes and frame points on the grid of `layout`, made as in `force_grid`."""
        stencil, layout = self.stencil, self.layout
        assert stencil is not None
        reference = np.broadcast_to(np.asarray(made(self._reference), dtype=np.float64), (self.size,))
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

    def reaction(self, gap: ArrayLike) -> Vector:
        """Return R = Gω + q (force), shape (n,)."""
        omega = vector(gap, self.size, "gap")
        return self.stiffness.matvec(omega) + self.q

    def scaled(self) -> tuple[Self, Units]:
        """Return the dimensionless problem and its units.

        The largest diagonal entry of its matrix is 1, and its gap scale; a matrix gets a diagonal between 1/2 and 2,
        by units of length for its unknowns that are powers of two, so that it stays symmetric and nothing is rounded.
        The gap zero is always admissible: where the bounds exclude it, the dimensionless gap is counted from the
        admissible one nearest to it.
        """
        q, bounds, units = self.in_units(self.gap_scale)
        origin = units.origin
        if isinstance(self.reference, float) or not isinstance(origin, float):
            reference: Made[Vector | float] = (self.reference - origin) / units.length
        else:
            reference = partial(times, self.reference, 1 / units.length)
        frame = None if self.frame_reference is None else self.frame_reference / units.length
        return self._of(self.facts.scaled, q, bounds, 1.0, reference, frame), units

    def to_cvxpy(self) -> ConvexProgram:
        """Return the problem as a `cvxpy.Problem`, with its variable, parameter and constraints by name.

        Constraints and objectives of your own may be added; the dual values of the contact constraints are the
        reactions. Another load is another value of the parameter q, and nothing is compiled anew. Answers of CVXPY are
        what its solvers claim: `contactqp.certify` encloses the truth.

        Raises
        ------
        UnsuitableProblemError
            If the matrix is not symmetric: the solution minimises nothing.
        ImportError
            If CVXPY is not installed.

        Examples
        --------
        >>> import contactqp as cq
        >>> problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
        >>> program = problem.to_cvxpy()
        >>> _ = program.problem.solve(solver="CLARABEL")
        >>> program.gap.value.round(6) + 0.0, program.reaction.round(6) + 0.0
        (array([0.5, 0. ]), array([0. , 2.5]))
        >>> program.q.value = [-2.0, 3.0]
        >>> _ = program.problem.solve(solver="CLARABEL")
        >>> program.gap.value.round(6) + 0.0
        array([1., 0.])
        """
        self.require_energy()
        return convex_program(self)

    def to_qpsolvers(self) -> Any:
        """Return the problem as a `qpsolvers.Problem`: P = G in compressed columns, q, and the bounds lb and ub.

        Raises
        ------
        UnsuitableProblemError
            If the matrix is not symmetric.
        ImportError
            If qpsolvers is not installed.

        Examples
        --------
        >>> import contactqp as cq
        >>> import qpsolvers
        >>> problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
        >>> qpsolvers.solve_problem(problem.to_qpsolvers(), solver="clarabel").x.round(6) + 0.0
        array([0.5, 0. ])
        """
        self.require_energy()
        return qpsolvers_problem(self)

    def to_linprog(self) -> dict[str, Any]:
        """Return the arguments of `scipy.optimize.linprog` for a linear program whose solution is the gap.

        It is Mangasarian's: min Σω over {ω ≥ l, Gω + q ≥ 0}, whose least element solves the problem for a Z-matrix.

        Raises
        ------
        UnsuitableProblemError
            If the matrix has positive off-diagonal entries, or there are upper bounds: the program solves nothing then.

        Examples
        --------
        >>> import contactqp as cq
        >>> from scipy.optimize import linprog
        >>> problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
        >>> linprog(**problem.to_linprog()).x
        array([0.5, 0. ])
        """
        return linear_program(self)

    def write(self, path: str | Path) -> Path:
        """Write the problem into a file, for `contactqp.read` and for other programs; its numbers are kept to the bit.

        Parameters
        ----------
        path : str or Path
            ``.mps`` (free MPS with QUADOBJ) or ``.lp``, whose columns are c0, c1, ... in order; ``.npz``, arrays
            ``data``, ``indices`` and ``indptr`` of the rows of G, ``q``, ``lower``, ``upper``; ``.mtx``, G in Matrix
            Market's format, and vectors in ``x_q.mtx``, ``x_lower.mtx`` and so on beside ``x.mtx``.

        Returns
        -------
        Path

        Raises
        ------
        UnsuitableProblemError
            If ``.mps`` or ``.lp`` is asked for and the matrix is not symmetric.
        ValueError
            If the suffix is unknown, or the folder is missing.

        Examples
        --------
        >>> import tempfile
        >>> import contactqp as cq
        >>> problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
        >>> print(problem.write(Path(tempfile.mkdtemp()) / "two.lp").read_text())
        minimize
         obj:
          - 1.0 c0
          + 3.0 c1
          + [
          + 2.0 c0 ^ 2
          - 2.0 c0 * c1
          + 2.0 c1 ^ 2
          ] / 2
        subject to
        bounds
        end
        <BLANKLINE>
        """
        path = path_of(path)
        if path.suffix.lower() in PROGRAMS:
            self.require_energy()
        return write_problem(self, path, self.gap_scale)

    def __repr__(self) -> str:
        free = int(np.count_nonzero(~self.supported))
        unsupported = f", {free} unsupported" if free else ""
        ceiling = "" if self.one_sided else f", {int(np.count_nonzero(np.isfinite(self.upper)))} with an upper bound"
        entries = f"{counted(self.stiffness.nonzeros, 'nonzero')}, {self.facts.kind}"
        return f"{type(self).__name__}({counted(self.size, 'unknown')}, {entries}{unsupported}{ceiling})"


def checked_scale(value: GapScale) -> GapScale:
    """Return a gap scale that a user gives, checked."""
    return value if value is None or callable(value) else positive_number(value, "gap_scale")
