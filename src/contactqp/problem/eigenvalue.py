"""A proven lower bound of the smallest eigenvalue of a symmetric matrix: by factors, or by an M-matrix below it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..algebra.balanced import balanced
from ..algebra.band import Band
from ..algebra.conductances import m_matrix_below
from ..algebra.narrow_band import WIDEST, NarrowBand, is_narrow
from ..algebra.sparse import SparseStiffness
from ..foundation.checks import Vector
from ..foundation.rounding import UNIT_ROUNDOFF
from ..methods.factors import DIRECT_SIZE, Solve
from .barrier import Preconditioner, find_barrier

if TYPE_CHECKING:
    from scipy.sparse import csr_array


_TRIALS = (0.9, 0.5, 0.1, 1e-2, 1e-4)
"""Parts of an estimate of the smallest eigenvalue that are tried as a proven bound, in turn."""


@dataclass(frozen=True)
class LeastEigenvalue:
    """A proven lower bound of the smallest eigenvalue of DGD.

    Attributes
    ----------
    bound : float
        Positive.
    units : array, shape (n,)
        Powers of two, the diagonal of D.
    proof : str
        What it rests on. ``"factors"``: Cholesky's factors of DGD less the bound, which exist, with their roundings
        bounded, so that what is left is positive definite; ``"factors in twice the precision"``: the same with 106
        bits; ``"an M-matrix below"``: an M-matrix that is less than DGD by something semidefinite, and of which a
        vector v > 0 shows that its smallest eigenvalue is the bound at least.
    """

    bound: float
    units: Vector
    proof: str

    def of_exact_diagonal(self, diagonal: Vector, rounding: float) -> LeastEigenvalue | None:
        """Return the bound for the matrix whose diagonal was rounded before this one was found; None if none is left.

        Parameters
        ----------
        diagonal : array, shape (n,)
            As rounded.
        rounding : float
            What each entry of it is off by at most, relative to it: no eigenvalue is off by more than the largest of
            them (Weyl).
        """
        if not rounding:
            return self
        lost = 1.01 * rounding * float((diagonal * self.units * self.units).max())
        bound = (self.bound - lost) * (1 - 4 * UNIT_ROUNDOFF)
        return replace(self, bound=bound) if bound > 0 else None


def proven_least_eigenvalue(
    matrix: csr_array, cycle: Callable[[], Solve | None] | None = None
) -> LeastEigenvalue | None:
    """Return a proven lower bound of the smallest eigenvalue of DGD; None where none is proven.

    That is so for a matrix that is not positive definite, to rounding, and for one with positive entries that cannot be
    paid (see `contactqp.algebra.conductances`) whose factorisation would take too long. Of few unknowns, and
    in a narrow band, the factors are tried first, whose bound comes closer; else the M-matrix below, which takes the
    time of a linear solve.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        Symmetric; D brings its diagonal into [1/2, 2).
    cycle : callable, optional
        Returns a preconditioner of DGD, None where there is none; by default it is made where it is needed.

    Examples
    --------
    >>> from scipy.sparse import csr_array
    >>> least = proven_least_eigenvalue(csr_array([[1.0, 0.5], [0.5, 1.0]]))
    >>> 0.4 < least.bound < 0.5, least.units.tolist(), least.proof
    (True, [1.0, 1.0], 'factors')
    """
    exponents = np.round(-0.5 * np.log2(matrix.diagonal()))
    units = np.ldexp(1.0, exponents.astype(int))
    by_factors, by_m_matrix = partial(_by_factors, matrix, units), partial(_by_m_matrix_below, matrix, units, cycle)
    proofs: list[Callable[[], tuple[float, str]]] = [by_factors, by_m_matrix]
    if matrix.shape[0] > DIRECT_SIZE and narrow_band_of(matrix) is None:
        proofs.reverse()
    for proof in proofs:
        bound, name = proof()
        if bound > 0:
            return LeastEigenvalue(bound, units, name)
    return None


def _by_factors(matrix: csr_array, units: Vector) -> tuple[float, str]:
    """Return a bound by factors in a band, and their kind; 0 where there is none.

    They are Cholesky's in double precision, or, where those prove nothing and the band is narrow, in twice the
    precision.
    """
    scaled = _scaled(matrix, units)
    band = None if scaled is None else Band(scaled)
    bound = 0.0 if band is None or not band.affordable else _proven(band)
    if bound > 0 or band is None or not is_narrow(band):
        return bound, "factors"
    narrow = NarrowBand.of(band)
    return (0.0 if narrow is None else _proven(narrow)), "factors in twice the precision"


def _proven(band: Band | NarrowBand) -> float:
    """Return the bound that is proven first of some parts of an estimate, 0 where none is."""
    factors = band.factors()
    if factors is None:
        return 0.0
    estimate = factors.estimated_least_eigenvalue()
    return next((bound for part in _TRIALS if (bound := band.proven_least_eigenvalue(part * estimate)) > 0), 0.0)


def _by_m_matrix_below(matrix: csr_array, units: Vector, cycle: Callable[[], Solve | None] | None) -> tuple[float, str]:
    r"""Return a bound by an M-matrix Ã ≼ A = DGD with a barrier v > 0, 0 < s ≤ Ãv, and its name; 0 for none.

    It is Ã = DG̃D with G̃ ≼ G, for the conductances of G itself say which vectors cost little energy.
    λ_min(A) ≥ λ_min(Ã) ≥ min s_i/v_i. For an eigenvector of the smallest eigenvalue λ of the symmetric M-matrix Ã can
    be taken x ≥ 0 (Perron and Frobenius, for Ã⁻¹ ≥ 0), and λxᵀv = xᵀÃv ≥ xᵀs ≥ min(s_i/v_i) xᵀv with xᵀv > 0 (the
    bound of Collatz and Wielandt).
    """
    # Of subnormal numbers the units are so large that their product overflows.
    middle = int(np.round((np.log2(units.min()) + np.log2(units.max())) / 2))
    one_unit = np.full_like(units, np.ldexp(1.0, middle))
    below = _scaled(matrix, one_unit)
    below = None if below is None else m_matrix_below(below)
    below = None if below is None else _scaled(below, units / one_unit)
    # What is below the matrix is near enough to it for the same preconditioner, in the same units.
    made = None if cycle is None else Preconditioner(np.ones_like(units), cycle)
    barrier = None if below is None else find_barrier(SparseStiffness(below), made)
    bound = 0.0 if barrier is None else float((barrier.s / barrier.v).min()) * (1 - 4 * UNIT_ROUNDOFF)
    return bound, "an M-matrix below"


def narrow_band_of(matrix: csr_array) -> Band | None:
    """Return a matrix as a narrow band, whose factors take next to no time; None where it is none."""
    if int(np.diff(matrix.indptr).max()) > 2 * WIDEST + 1:
        return None
    band = Band(matrix)
    return band if is_narrow(band) else None


def affordable(matrix: csr_array) -> bool:
    """Whether the factorisation that the proof needs does not take too long."""
    return Band(matrix).affordable


def _scaled(matrix: csr_array, units: Vector) -> csr_array | None:
    """Return DGD for powers of two D; None where an entry is rounded by it."""
    rows = np.repeat(np.arange(matrix.shape[0], dtype=np.int32), np.diff(matrix.indptr))
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        scaled = balanced(matrix, units)
        exact = np.array_equal(scaled.data / units[rows] / units[matrix.indices], matrix.data)
    return scaled if exact and np.isfinite(scaled.data).all() and np.isfinite(units).all() else None
