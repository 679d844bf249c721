r"""Kernel: the vectors that a semidefinite matrix annihilates, and how forces and bounds hold them.

Along a kernel vector k the energy ½ωᵀGω + qᵀω changes by qᵀk alone, because Gk = 0. So a problem between bounds has a
solution if qᵀd ≥ 0 for every d in the kernel that never meets a bound (a ray: d_i ≥ 0 where there is a lower bound, and
d_i ≤ 0 where there is an upper one), and the solutions are bounded if qᵀd > 0 for all of them but zero (Rockafellar,
*Convex Analysis*, 1970, theorem 27.1). All solutions have the same reaction: R* balances q along the kernel, kᵀR* =
kᵀq.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector, read_only, real_array
from ..foundation.loading import load_modules

if TYPE_CHECKING:
    from .stiffness import Stiffness

_ROUNDING = 1e-12
"""Part of |G| |k| that Gk may be, and of |q|ᵀ|d| that counts as zero: what assembling a matrix leaves."""

_SNAPPED = 1e-9
"""Relative distance from a bound that a linear program leaves."""


@dataclass(frozen=True)
class Ray:
    """A direction in the kernel along which no bound is met.

    Attributes
    ----------
    name : str
        What it is, in terms of the kernel that was given.
    work : float
        qᵀd, zero where it is no more than rounding.
    """

    name: str
    work: float


class Kernel:
    """Linearly independent vectors k with Gk = 0.

    Parameters
    ----------
    vectors : array, shape (n, m)
    constant : bool
        Whether it was given as ``"constant"``.

    Examples
    --------
    >>> kernel = Kernel.of("constant", 3)
    >>> kernel
    Kernel(constant)
    >>> lower, upper = np.zeros(3), np.full(3, np.inf)
    >>> kernel.unbalanced(np.array([-2.0, 1.0, 0.5]), lower, upper)
    Ray(name='ones', work=-0.5)
    >>> kernel.at_rest(np.array([1.0, 2.0, 3.0]), np.ones(3), lower, upper)
    array([0., 1., 2.])
    """

    def __init__(self, vectors: NDArray[np.float64], constant: bool = False) -> None:
        self.vectors, self.constant = vectors, constant

    @classmethod
    def of(cls, value: Any, size: int) -> Kernel:
        """Return the kernel that a user gives, checked.

        Parameters
        ----------
        value : "constant" or array, shape (n,) or (n, m)
            ``"constant"`` is the vector of ones.
        size : int
            n.

        Raises
        ------
        TypeError, ValueError
            If it has the wrong kind or shape, is not finite, or its columns depend on each other.
        """
        if isinstance(value, str):
            if value != "constant":
                raise ValueError(
                    f"kernel must be 'constant', or vectors as an array of shape ({size}, m), got {value!r}"
                )
            return cls(np.ones((size, 1)), constant=True)
        vectors = real_array(value, "kernel")
        if vectors.ndim == 1:
            vectors = vectors[:, None]
        if vectors.ndim != 2 or vectors.shape[0] != size or not 0 < vectors.shape[1] <= size:
            raise ValueError(f"kernel must be 'constant' or have shape ({size},) or ({size}, m), got {np.shape(value)}")
        bad = np.argwhere(~np.isfinite(vectors))
        if bad.size:
            row, column = (int(place) for place in bad[0])
            raise ValueError(f"kernel must be finite, but entry [{row}, {column}] is {vectors[row, column]}")
        found = cls(read_only(np.array(vectors)))
        if not found.held_by(np.ones(size, dtype=np.bool_)):
            raise ValueError(
                f"kernel must have linearly independent columns, but its {vectors.shape[1]} columns span less; "
                "leave out those that are combinations of others, or zero"
            )
        return found

    @property
    def size(self) -> int:
        """Number of vectors m."""
        return int(self.vectors.shape[1])

    def annihilated_by(self, stiffness: Stiffness) -> bool:
        """Whether a matrix annihilates the vectors, to rounding."""
        return self._objection(stiffness) is None

    def require_of(self, stiffness: Stiffness) -> None:
        """Raise a ValueError, with the value, if a matrix does not annihilate the vectors, to rounding."""
        found = self._objection(stiffness)
        if found is not None:
            column, row, value = found
            name = "the constant (row sums)" if self.constant else f"kernel[:, {column}]"
            raise ValueError(
                f"kernel must consist of vectors k with G k = 0, but for {name} (G k)[{row}] = {value:g}; "
                "leave kernel out if G is positive definite"
            )

    def _objection(self, stiffness: Stiffness) -> tuple[int, int, float] | None:
        """Return column, row and value of an entry of GK that is more than rounding, None where there is none."""
        for column, vector in enumerate(np.ascontiguousarray(self.vectors.T)):
            image, most = stiffness.matvec(vector), stiffness.modulus_matvec(np.abs(vector))
            worst = int(np.argmax(np.abs(image) - _ROUNDING * most))
            if abs(image[worst]) > _ROUNDING * most[worst]:
                return column, worst, float(image[worst])
        return None

    def in_units(self, units: float | Vector) -> Kernel:
        """Return the kernel of unknowns that are measured in units of length."""
        return Kernel(read_only(self.vectors / np.broadcast_to(units, (len(self.vectors),))[:, None]))

    def taken(self, order: Callable[[NDArray[np.float64]], NDArray[np.float64]]) -> Kernel:
        """Return the kernel of unknowns that are numbered otherwise, given what brings rows into that order."""
        return Kernel(order(self.vectors), self.constant)

    @cached_property
    def grounds(self) -> NDArray[np.intp]:
        """As many unknowns as there are vectors, which hold the kernel well if they are held, shape (m,)."""
        if self.size == 1:
            return np.array([int(np.argmax(np.abs(self.vectors[:, 0])))])
        load_modules("scipy.linalg")
        from scipy.linalg import qr

        _, order = qr(self._orthonormal.T, mode="r", pivoting=True)
        return np.sort(np.asarray(order[: self.size], dtype=np.intp))

    @cached_property
    def _orthonormal(self) -> NDArray[np.float64]:
        return np.asarray(np.linalg.qr(self.vectors / np.abs(self.vectors).max(axis=0))[0])

    def energy_left(self, stiffness: Stiffness) -> float:
        """Return the largest modulus of dᵀGd, d of length one in the kernel: 0 where GK = 0, else what rounding leaves.

        Examples
        --------
        >>> from contactqp.algebra.sparse import SparseStiffness
        >>> kernel = Kernel.of("constant", 2)
        >>> kernel.energy_left(SparseStiffness.of([[1.0, -1.0], [-1.0, 1.0]]))
        0.0
        >>> round(kernel.energy_left(SparseStiffness.of([[1.5, -1.0], [-1.0, 1.5]])), 9)
        0.5
        """
        vectors = np.ascontiguousarray((self.vectors / np.abs(self.vectors).max(axis=0)).T)
        none = np.zeros(len(self.vectors))
        left = vectors @ np.array([stiffness.accurate_product(vector, none, none)[0] for vector in vectors]).T
        shortest = float(np.linalg.svd(vectors, compute_uv=False).min())
        return float(np.linalg.norm(left, 2)) / shortest**2

    def least_hold(self, springs: Vector) -> float:
        """Return the least length of ``springs`` times d, entry by entry, for a d of length one in the kernel."""
        return float(np.linalg.svd(springs[:, None] * self._orthonormal, compute_uv=False).min())

    def held_by(self, held: Mask) -> bool:
        """Whether no vector of the kernel but zero vanishes at all the nodes that are held."""
        if self.size == 1:
            return bool(self.vectors[held].any())
        scaled = self.vectors / np.maximum(np.abs(self.vectors).max(axis=0), np.finfo(np.float64).tiny)
        return bool(np.linalg.matrix_rank(scaled[held], tol=_SNAPPED) == self.size)

    def at_rest(self, gap: Vector, force: Vector, lower: Vector, upper: Vector) -> Vector:
        """Return the gap after it has moved along the kernel to where the energy is least, between the bounds.

        Parameters
        ----------
        gap : array, shape (n,)
            Between the bounds.
        force : array, shape (n,)
            q, which leaves no ray unbalanced.
        lower, upper : array, shape (n,)
            l ≤ u, -inf and inf where there is none; ``upper`` may be empty where there is none at all.
        """
        if not upper.size:
            upper = np.full(gap.size, np.inf)
        if self.size > 1:
            return self._at_rest_by_program(gap, force, lower, upper)
        vector = self.vectors[:, 0] * -np.sign(force @ self.vectors[:, 0])
        moving = np.flatnonzero(vector)
        room = np.where(vector > 0, upper - gap, lower - gap)[moving] / vector[moving]
        if not moving.size or not np.isfinite(room.min()):
            return gap
        nearest = int(np.argmin(room))
        moved = gap + room[nearest] * vector
        met = moving[nearest]
        moved[met] = upper[met] if vector[met] > 0 else lower[met]
        return np.asarray(np.minimum(np.maximum(moved, lower), upper))

    def _at_rest_by_program(self, gap: Vector, force: Vector, lower: Vector, upper: Vector) -> Vector:
        """Return the same by a linear program: a vertex, so that as many nodes as there are vectors meet a bound."""
        basis = self._orthonormal
        below, above = np.isfinite(lower), np.isfinite(upper)
        rows = np.concatenate([-basis[below], basis[above]])
        limits = np.concatenate([(gap - lower)[below], (upper - gap)[above]])
        found = _least(force @ basis, rows, limits)
        if found is None:
            return gap
        moved = gap + basis @ found
        near = _SNAPPED * (np.abs(moved).max() + np.abs(gap).max())
        moved = np.where(moved <= lower + near, lower, moved)
        return np.asarray(np.where(moved >= upper - near, upper, moved))

    def unbalanced(self, force: Vector, lower: Vector, upper: Vector) -> Ray | None:
        """Return a ray along which forces q press on no bound, so that no gap, or not one alone, is the solution.

        Parameters
        ----------
        force : array, shape (n,)
            q.
        lower, upper : array, shape (n,)
            l ≤ u, -inf and inf where there is none.
        """
        if self.size > 1:
            return self._unbalanced_by_program(force, lower, upper)
        name = "ones" if self.constant else "kernel[:, 0]"
        for sign in (1.0, -1.0):
            vector = sign * self.vectors[:, 0]
            if np.isinf(np.where(vector < 0, lower, np.where(vector > 0, upper, np.inf))).all():
                work = _work(force, vector)
                if work <= 0:
                    return Ray(name if sign > 0 else f"-{name}", work)
        return None

    def _unbalanced_by_program(self, force: Vector, lower: Vector, upper: Vector) -> Ray | None:
        basis = self.vectors / np.abs(self.vectors).max(axis=0)
        below, above = np.isfinite(lower), np.isfinite(upper)
        if not self.held_by(below | above):
            null = np.linalg.svd(basis[below | above], full_matrices=True)[2][-1] if (below | above).any() else None
            weights = np.eye(self.size)[0] if null is None else null
            ray = self._ray(force, weights)
            return ray if ray.work <= 0 else self._ray(force, -weights)
        rays = np.concatenate([-basis[below], basis[above]])
        length = (basis[below & ~above]).sum(axis=0) - (basis[above & ~below]).sum(axis=0)
        if not length.any():
            return None
        # Of all rays of one length the one with the least work.
        found = _least(force @ basis, rays, np.zeros(len(rays)), (length[None, :], np.ones(1)))
        if found is None:
            return None
        ray = self._ray(force, found)
        return ray if ray.work <= 0 else None

    def _ray(self, force: Vector, weights: Vector) -> Ray:
        """Return the ray of some weights of the scaled vectors, in terms of those that were given."""
        given = weights / np.abs(self.vectors).max(axis=0)
        given = given / np.abs(given).max()
        name = f"kernel @ [{', '.join(f'{weight:.3g}' for weight in given + 0.0)}]"
        return Ray(name, _work(force, self.vectors @ given))

    def __repr__(self) -> str:
        return "Kernel(constant)" if self.constant else f"Kernel({self.size} of {len(self.vectors)} dimensions)"


def _work(force: Vector, vector: Vector) -> float:
    """Return qᵀd, and zero where it is no more than rounding."""
    work, most = float(force @ vector), float(np.abs(force) @ np.abs(vector))
    return work if abs(work) > _ROUNDING * most else 0.0


def _least(
    cost: Vector,
    rows: NDArray[np.float64],
    limits: Vector,
    equation: tuple[NDArray[np.float64], Vector] | None = None,
) -> Vector | None:
    """Return the free numbers a of least cost with rows @ a ≤ limits; None where there are none, or no least ones."""
    load_modules("scipy.optimize")
    from scipy.optimize import linprog

    size = float(np.abs(cost).max()) or 1.0
    equations = {} if equation is None else {"A_eq": equation[0], "b_eq": equation[1]}
    result = linprog(cost / size, A_ub=rows, b_ub=limits, bounds=(None, None), method="highs-ds", **equations)
    return np.asarray(result.x) if result.status == 0 else None
