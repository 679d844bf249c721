"""ContactQP: the quadratic program min 1/2 w'Gw + q'w, w >= 0, and its data's properties."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..algebra.definiteness import refuse_indefinite, weakly_dominant
from ..algebra.sparse import SparseStiffness, checked_matrix
from ..algebra.stencil import Stencil
from ..foundation.checks import Mask, Vector, positive_number, read_only, times, vector
from ..geometry.numbering import Grid, Layout, bounding_box
from .barrier import Barrier, find_barrier

if TYPE_CHECKING:
    from scipy.sparse import csr_array


@dataclass(frozen=True)
class Units:
    """What one of a dimensionless problem's units is worth in the original problem's.

    Attributes
    ----------
    length : float or array, shape (n,)
        Unit of the gap (length); each unknown of a matrix has its own.
    force : float or array, shape (n,)
        Unit of q and of the reaction (force).
    """

    length: float | Vector
    force: float | Vector


class ContactQP:
    r"""A contact problem as a quadratic program: min ½ωᵀGω + qᵀω subject to ω ≥ 0.

    Its optimality conditions are the linear complementarity problem R = Gω + q ≥ 0, ω ≥ 0, ωᵀR = 0, with the
    gap ω and the reaction R; eqs. (2.9)-(2.11) of the paper that contactqp starts from. The solution is
    unique because G is positive definite.

    Parameters
    ----------
    G : sparse array, dense array or Stencil, shape (n, n)
        Stiffness (force per length), symmetric and positive definite: this is checked.
    q : array, shape (n,)
        Reaction that would hold the gap shut (force).
    supported : array of bool, shape (n,), optional
        False where there is no support: there ω may take either sign, and R = 0. All True by default.
    gap_scale : float, optional
        Length by which tolerances are measured. By default the mean gap that the opening forces max(0, -q) (|q| where
        there is no support) would leave, bounded by the `barrier` (see `Barrier.mean_deflection`): an M-matrix's
        gap is at most G⁻¹ times them.

    Raises
    ------
    TypeError
        If G or q is complex or not numeric.
    ValueError
        If G is not square, finite, symmetric and positive definite, or q has the wrong shape or is not finite.

    Attributes
    ----------
    reference : array, shape (n,), or 0
        Ordinates that a model measures the gap from: reference - ω is its deflection.
    frame_reference : array, shape (rows + 2, columns + 2), or None
        On a lattice whose frame is not at height zero: ordinates of the frame points, on the net with a ring about it.

    Notes
    -----
    A stiffness given as a `Stencil` is assembled only when `G` is asked for.

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
    """

    def __init__(
        self,
        G: Any,
        q: ArrayLike,
        *,
        supported: ArrayLike | None = None,
        gap_scale: float | None = None,
    ) -> None:
        self.stiffness: Stencil | SparseStiffness
        if isinstance(G, Stencil):
            self.stiffness = G
        else:
            matrix = checked_matrix(G)
            if not weakly_dominant(matrix):
                refuse_indefinite(matrix)
            matrix.data.setflags(write=False)
            self.stiffness = SparseStiffness(matrix)
        self.q: Vector = read_only(vector(q, self.stiffness.size, "q"))
        self.supported: Mask = read_only(_support_mask(supported, self.size))
        self._gap_scale = None if gap_scale is None else positive_number(gap_scale, "gap_scale")
        self.reference: Vector | float = 0.0
        self.frame_reference: Grid | None = None

    @property
    def size(self) -> int:
        """Number of unknowns n."""
        return self.stiffness.size

    @cached_property
    def G(self) -> csr_array:
        """The stiffness as a sparse array, read-only; assembled at the first call."""
        matrix = self.stiffness.tocsr()
        matrix.data.setflags(write=False)
        return matrix

    @property
    def stencil(self) -> Stencil | None:
        """The stiffness as a lattice stencil, or None where G was given as a matrix."""
        return self.stiffness if isinstance(self.stiffness, Stencil) else None

    @cached_property
    def layout(self) -> Layout:
        """The lattice's nodes along its rows, apart with and without a support.

        Raises
        ------
        AttributeError
            If G was given as a matrix.
        """
        stencil = self.stencil
        if stencil is None:
            raise AttributeError("layout needs a problem on a lattice; this one's G is a matrix")
        if self.supported.all():
            return stencil.layout
        supported = np.zeros(stencil.mask.shape, dtype=np.bool_)
        supported[stencil.mask] = self.supported
        return Layout(stencil.layout.mask, np.ascontiguousarray(supported[bounding_box(stencil.mask)]))

    def reference_grid(self) -> Grid:
        """Return the reference ordinates of nodes and frame points on the grid of `layout`."""
        stencil, layout = self.stencil, self.layout
        assert stencil is not None
        reference = np.broadcast_to(np.asarray(self.reference, dtype=np.float64), (self.size,))
        grid = layout.grid(np.ascontiguousarray(reference))
        if self.frame_reference is not None:
            rows, columns = bounding_box(stencil.mask)
            frame = self.frame_reference[rows.start : rows.stop + 2, columns.start : columns.stop + 2]
            np.copyto(grid, frame, where=~np.pad(layout.mask, 1))
        return grid

    @cached_property
    def positive_off_diagonal(self) -> tuple[int, int, float] | None:
        """Row, column and value of the largest positive off-diagonal entry, or None for a Z-matrix."""
        if isinstance(self.stiffness, Stencil):
            return None
        entries = self.G.tocoo()
        i, j = entries.coords
        off = np.where(i != j, entries.data, 0.0)
        worst = int(np.argmax(off))
        return (int(i[worst]), int(j[worst]), float(off[worst])) if off[worst] > 0 else None

    @property
    def is_z_matrix(self) -> bool:
        """Whether every off-diagonal entry of G is <= 0."""
        return self.positive_off_diagonal is None

    @property
    def is_m_matrix(self) -> bool:
        """Whether G is a Z-matrix with a verified `barrier`."""
        return self.barrier is not None

    @cached_property
    def barrier(self) -> Barrier | None:
        """A vector v > 0 with Gv > 0 that proves G an M-matrix, or None where G is no Z-matrix.

        Raises
        ------
        ValueError
            If G turns out not to be positive definite.
        """
        if not self.is_z_matrix:
            return None
        found = find_barrier(self.stiffness)
        if found is None:
            refuse_indefinite(self.G)
        return found

    @cached_property
    def comparison_barrier(self) -> Barrier | None:
        """A vector v > 0 with ⟨G⟩v > 0, where ⟨G⟩ is G with its off-diagonal entries made ≤ 0, or None.

        It proves G an H-matrix, for which an enclosure is known as well (see `contactqp.proof.beyond_m_matrices`).
        """
        if self.is_z_matrix:
            return self.barrier
        return find_barrier(self.stiffness.comparison()) if isinstance(self.stiffness, SparseStiffness) else None

    @cached_property
    def least_eigenvalue(self) -> tuple[float, Vector] | None:
        """A proven lower bound > 0 of the smallest eigenvalue of DGD, and the diagonal D; None for large matrices."""
        from .eigenvalue import proven_least_eigenvalue

        return proven_least_eigenvalue(self.G)

    @cached_property
    def gap_scale(self) -> float:
        """Length by which tolerances are measured, > 0 (see the class)."""
        if self._gap_scale is not None:
            return self._gap_scale
        for force in (self._opening_forces, np.abs(self.q)):
            if self.barrier is not None:
                scale = self.barrier.mean_deflection(force)
            else:
                scale = float((force / self.stiffness.diagonal()).max())
            if not np.isfinite(scale):
                raise ValueError("the ranges of G and q are too wide for double precision: the gap scale overflows")
            if scale > 0:
                return scale
        return 1.0

    @property
    def _opening_forces(self) -> Vector:
        """What of q opens gaps: max(0, -q), and |q| where there is no support."""
        return np.where(self.supported, np.maximum(-self.q, 0.0), np.abs(self.q))

    @cached_property
    def shut(self) -> bool:
        """Whether no force opens a gap: then ω = 0 is the solution."""
        if (self.q < 0).any():
            return False
        return bool(self.supported.all()) or not self.q[~self.supported].any()

    def objective(self, gap: ArrayLike) -> float:
        """Return ½ωᵀGω + qᵀω (force times length): the potential energy less that of the shut gap."""
        omega = vector(gap, self.size, "gap")
        return float(0.5 * (omega @ self.stiffness.matvec(omega)) + self.q @ omega)

    def reaction(self, gap: ArrayLike) -> Vector:
        """Return R = Gω + q (force), shape (n,)."""
        omega = vector(gap, self.size, "gap")
        return self.stiffness.matvec(omega) + self.q

    def scaled(self) -> tuple[ContactQP, Units]:
        """Return the dimensionless problem and its units.

        Its solution times ``units.length`` is this problem's. The largest diagonal entry is 1, and the gap scale; a
        matrix gets a diagonal of ones, by a unit of length for each unknown, which keeps it symmetric and its signs.
        """
        problem = ContactQP.__new__(ContactQP)
        units: Units
        with np.errstate(over="ignore"):
            if isinstance(self.stiffness, SparseStiffness):
                diagonal = self.stiffness.diagonal()
                largest = float(diagonal.max())
                relative = np.sqrt(largest / diagonal)
                problem.stiffness = self.stiffness.balanced(relative / np.sqrt(largest))
                units = Units(self.gap_scale * relative, self.gap_scale * largest / relative)
            else:
                largest = self.stiffness.largest_diagonal
                problem.stiffness = self.stiffness.scaled(1 / largest)
                units = Units(self.gap_scale, self.gap_scale * largest)
            problem.q = read_only(self.q / units.force)
        if not (np.isfinite(problem.q).all() and problem.stiffness.finite):
            raise ValueError("the ranges of G and q are too wide for double precision: the scaled problem overflows")
        problem.supported = self.supported
        problem._gap_scale = 1.0
        if isinstance(self.reference, float):
            problem.reference = self.reference / units.length
        else:
            problem.reference = times(self.reference, 1 / units.length)
        problem.frame_reference = None if self.frame_reference is None else self.frame_reference / units.length
        if self.stencil is not None:
            problem.__dict__["layout"] = self.layout
        problem.__dict__["positive_off_diagonal"] = self.positive_off_diagonal
        return problem, units

    def __repr__(self) -> str:
        kind = "M-matrix" if self.is_m_matrix else "Z-matrix" if self.is_z_matrix else "no Z-matrix"
        free = int(np.count_nonzero(~self.supported))
        unsupported = f", {free} unsupported" if free else ""
        return f"ContactQP({self.size} unknowns, {self.stiffness.nonzeros} nonzeros, {kind}{unsupported})"


def _support_mask(value: ArrayLike | None, size: int) -> Mask:
    if value is None:
        return np.ones(size, dtype=np.bool_)
    mask = np.array(value)
    if mask.dtype != np.bool_:
        raise TypeError(f"supported must be boolean, got dtype {mask.dtype}")
    if mask.shape != (size,):
        raise ValueError(f"supported must have shape ({size},), got {mask.shape}")
    return mask
