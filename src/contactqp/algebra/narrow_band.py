r"""Factors LDLᵀ of a symmetric matrix in a narrow band, in twice the precision, and what they prove.

Bending in one direction has narrow bands and conditions that grow with the fourth power of the number of nodes: above
some thousand nodes double precision has no digits left. Twice the precision, by double words (see
`contactqp.algebra.double_word_kernels`), has enough for conditions up to 10²⁸.

*What the factors prove.* Let the pivots d_j of the computed factors of A - σI all be positive, b be the width of the
band, ε the relative error of an operation and γ_k = kε/(1 - kε). The entries are computed as c_ij = a_ij - Σ_k l_ik
c_jk and l_ij = c_ij/d_j, with at most b products in a sum, none outside the band, and the diagonal is shifted
exactly, because the difference of two doubles is a double word. So, as in Higham, *Accuracy and Stability of
Numerical Algorithms* (2002), lemma 8.4, the matrix E = A - σI - LDLᵀ has entries \|E_ij\| ≤ γ_{b+3} S_ij in the band
and none outside, with S_ij = Σ_k \|l_ik\| d_k \|l_jk\|: b + 1 operations for the sum, one for the quotient, and one
to spare for terms of second order. By Cauchy's inequality S_ij ≤ √(S_ii S_jj), and S_ii = Σ_k l_ik² d_k = a_ii - σ -
E_ii, hence for σ ≥ 0 S_ii ≤ a_ii/(1 - γ_{b+3}) and ‖E‖ ≤ (2b + 1) max a_ii γ_{b+3}/(1 - γ_{b+3}). As LDLᵀ is positive
definite, A has no eigenvalue below σ - ‖E‖ (Weyl). Entries c_ij below 2⁻³⁰⁰ max(1, d_j) are taken for zero, which
adds no more than that to \|E_ij\|; with pivots between 2⁻²⁰⁰ and 2²⁰⁰ no product or quotient of the others comes near
under- or overflow in its high word, and an overflow elsewhere makes a later pivot infinite or not a number, which is
no positive one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..foundation.loading import can_compile, load_modules
from ..foundation.rounding import UNIT_ROUNDOFF
from .band import Band, estimated_least_eigenvalue
from .compensated import two_sum

WIDEST = 8
"""Entries beside the diagonal of a row, on one side, up to which a band is a narrow one."""

SHORTEST = 4 * WIDEST
"""Unknowns of a matrix whose band is worth being called narrow, at least."""

STIFF = 2.0**-24
"""A smallest eigenvalue below this, for a diagonal of about one, leaves double precision half of its digits, and
exchanges of contact nodes begin to creep: a stiff pipe of 2000 nodes over a sea-bed does not come to rest in 500 steps
by double precision at 2⁻³⁰, and does in 15 by twice that."""

_OPERATIONS_AT_ONCE = 2_000_000
"""Operations on double words between two moments at which Ctrl-C is answered: some tens of milliseconds."""


class NarrowBand:
    """A symmetric matrix of doubles in a narrow band; vectors have the order of the band.

    Parameters
    ----------
    band : array, shape (n, width + 1)
        ``band[j, d]`` is the entry in column j and row j + d; those beyond the last row are zero.

    Examples
    --------
    >>> band = NarrowBand(np.array([[2.0, -1.0], [2.0, -1.0], [2.0, 0.0]]))
    >>> high, low = band.factors().solve(np.array([1.0, 0.0, 0.0]))
    >>> (high + low).tolist()
    [0.75, 0.5, 0.25]
    """

    def __init__(self, band: NDArray[np.float64]) -> None:
        self._band = band

    @classmethod
    def of(cls, band: Band) -> NarrowBand | None:
        """Return a band with compiled arithmetic; None where it is not narrow, or without numba."""
        if band.width > WIDEST or not can_compile():
            return None
        load_modules("contactqp.algebra.double_word_kernels", kernels="twice the precision")
        row, column, values = band.lower_half
        entries = np.zeros((band.size, band.width + 1))
        entries[column, row - column] = values
        return cls(entries)

    @property
    def size(self) -> int:
        """Number of rows."""
        return int(self._band.shape[0])

    @property
    def width(self) -> int:
        """Entries beside the diagonal of a row, on one side."""
        return int(self._band.shape[1]) - 1

    def diagonal(self) -> Vector:
        """Return the diagonal, shape (n,)."""
        return self._band[:, 0].copy()

    def product(self, high: Vector, low: Vector, force: Vector) -> tuple[Vector, Vector]:
        """Return A(high + low) + force as double words."""
        from .double_word_kernels import add_product

        total, total_low = force.copy(), np.zeros_like(force)
        for first, end in _chunks(self.size, self.width):
            add_product(self._band, high, low, total, total_low, first, end)
        return total, total_low

    def factors(self, added: Vector | float = 0.0, held: Mask | None = None) -> NarrowFactors | None:
        """Return the factors of A and numbers added to its diagonal; None where it is not positive definite.

        Parameters
        ----------
        added : array, shape (n,), or float
        held : array of bool, shape (n,), optional
            Rows and columns that are those of a unit matrix instead.
        """
        from .double_word_kernels import factorise

        band, low = self._band.copy(), np.zeros_like(self._band)
        band[:, 0], low[:, 0] = two_sum(
            band[:, 0], np.broadcast_to(np.asarray(added, dtype=np.float64), band[:, 0].shape)
        )
        if held is not None and held.any():
            band[held], low[held] = 0.0, 0.0
            band[held, 0] = 1.0
            for d in range(1, self.width + 1):
                band[:-d, d][held[d:]] = 0.0
        for first, end in _chunks(self.size, self.width):
            if factorise(band, low, first, end):
                return None
        return NarrowFactors(band, low)

    def proven_least_eigenvalue(self, shift: float) -> float:
        """Return a lower bound of the smallest eigenvalue that is close to ``shift`` ≥ 0, and 0 where none is proven.

        The proof stands above.
        """
        from .double_word_kernels import RELATIVE_ERROR, SMALLEST

        if self.factors(-shift) is None:
            return 0.0
        error = (self.width + 3) * RELATIVE_ERROR
        growth = error / (1 - error)
        largest = float(self._band[:, 0].max())
        lost = (2 * self.width + 1) * (growth / (1 - growth) * largest + SMALLEST * max(1.0, 2 * largest))
        return max(0.0, (shift - 1.01 * lost) * (1 - 4 * UNIT_ROUNDOFF))


def is_narrow(band: Band) -> bool:
    """Whether a band is narrow, and its matrix no small one that would be full of any band."""
    return band.width <= WIDEST and band.size >= SHORTEST


def stiff_band(band: Band) -> NarrowBand | None:
    """Return a matrix as a narrow band where double precision is too little for it; None for others.

    Parameters
    ----------
    band : Band
        Of a positive definite matrix with diagonal entries of about one.
    """
    if not is_narrow(band):
        return None
    factors = band.factors()
    if factors is not None and factors.estimated_least_eigenvalue() > STIFF:
        return None
    return NarrowBand.of(band)


def solver(band: Band, least: float) -> Callable[[Vector], Vector] | None:
    """Return a function that solves with a matrix by factors in a band, in twice the precision where that is needed.

    Parameters
    ----------
    band : Band
    least : float
        A lower bound of the smallest eigenvalue, for a diagonal of about one; 0 where none is known.

    Returns
    -------
    callable or None
        Takes and returns vectors in the order of the matrix; None where factors would take too long, or do not exist.
    """
    narrow = NarrowBand.of(band) if least < STIFF and is_narrow(band) else None
    accurate = None if narrow is None else narrow.factors()
    if accurate is not None:
        return lambda force: accurate.solve(band.inwards(force))[0][band.place]
    factors = band.factors() if band.affordable else None
    return None if factors is None else factors.solve


class NarrowFactors:
    """Factors LDLᵀ in a band, as double words.

    Parameters
    ----------
    band, low : array, shape (n, width + 1)
        D in the first column, L in the others.
    """

    def __init__(self, band: NDArray[np.float64], low: NDArray[np.float64]) -> None:
        self._band, self._low = band, low

    def estimated_least_eigenvalue(self) -> float:
        """Return an estimate of the matrix's smallest eigenvalue; it is no bound."""
        return estimated_least_eigenvalue(lambda force: self.solve(force)[0], self._band.shape[0])

    def solve(self, force: Vector, force_low: Vector | None = None) -> tuple[Vector, Vector]:
        """Return the solution of Ax = force + force_low as double words."""
        from .double_word_kernels import backwards, forwards

        high, low = force.copy(), np.zeros_like(force) if force_low is None else force_low.copy()
        ranges = list(_chunks(self._band.shape[0], self._band.shape[1] - 1))
        for first, end in ranges:
            forwards(self._band, self._low, high, low, first, end)
        for first, end in reversed(ranges):
            backwards(self._band, self._low, high, low, first, end)
        return high, low


def _chunks(size: int, width: int) -> Iterator[tuple[int, int]]:
    """Yield the first column and the end of ranges that a factorisation passes in some tens of milliseconds."""
    length = max(1, _OPERATIONS_AT_ONCE // (width + 1) ** 2)
    for first in range(0, size, length):
        yield first, min(first + length, size)
