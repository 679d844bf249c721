"""Stiffness: what the program needs of a matrix G, whatever holds it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..foundation.rounding import UNDERFLOW, gamma
from ..geometry.numbering import Layout, Numbering

if TYPE_CHECKING:
    from scipy.sparse import csr_array


class Stiffness(ABC):
    """A matrix G with a positive diagonal, known by what it does; symmetric, but for a kind that says otherwise.

    Base of `contactqp.Stencil` and `contactqp.algebra.sparse.SparseStiffness`. One that is kept otherwise (on
    triangles, on another machine) is one more subclass in a file of its own: nothing outside asks which it is.
    """

    @property
    @abstractmethod
    def size(self) -> int:
        """Number of rows."""

    @property
    @abstractmethod
    def nonzeros(self) -> int:
        """Number of nonzero entries."""

    @property
    @abstractmethod
    def finite(self) -> bool:
        """Whether all entries are finite."""

    @property
    @abstractmethod
    def longest_row(self) -> int:
        """Largest number of entries in a row."""

    @property
    @abstractmethod
    def positive_off_diagonal(self) -> tuple[int, int, float] | None:
        """Row, column and value of the largest positive off-diagonal entry, or None for a Z-matrix."""

    @property
    def asymmetry(self) -> str | None:
        """What tells that the matrix is not symmetric, in words, or None."""
        return None

    @property
    def symmetric(self) -> bool:
        """Whether G is symmetric, so that methods may rely on it."""
        return True

    @property
    def transposed(self) -> Stiffness:
        """The transposed matrix: a symmetric one itself."""
        return self

    @property
    def lattice(self) -> LatticeStiffness | None:
        """The stiffness as a stencil on a lattice, if that is how it was given."""
        return None

    @property
    def uniform_lattice(self) -> LatticeStiffness | None:
        """The stiffness as a stencil whose arms are equal in each direction, if it was given as one."""
        return self.lattice if self.lattice is not None and self.lattice.uniform else None

    @property
    def rimmed_lattice(self) -> LatticeStiffness | None:
        """The same, where nodes beside the frame may be held more firmly."""
        return self.lattice if self.lattice is not None and self.lattice.rimmed else None

    @property
    def surplus(self) -> csr_array | None:
        """The positive off-diagonal entries that count as zero because they are no more than rounding; None for none.

        Without them G is a Z-matrix. They are part of G all the same: proofs that need a Z-matrix bound what they do.
        """
        return None

    def recognised_lattice(self) -> LatticeStiffness | None:
        """Return the lattice behind the matrix: the one given, or one that is recognised up to rounding."""
        return self.lattice

    @property
    def without_fill(self) -> bool:
        """Whether the unknowns hang together in lines, so that a factorisation has no more entries than G."""
        return self.longest_row <= 3

    @abstractmethod
    def matvec(self, vector: Vector) -> Vector:
        """Return G times ``vector``, shape (..., size): each of many vectors, which stand in rows."""

    @abstractmethod
    def modulus_matvec(self, vector: Vector) -> Vector:
        """Return |G| times ``vector``, shape (..., size)."""

    @abstractmethod
    def diagonal(self) -> Vector:
        """Return the diagonal, shape (size,)."""

    @abstractmethod
    def tocsr(self) -> csr_array:
        """Return G as a sparse array with sorted column numbers."""

    @property
    def diagonal_rounding(self) -> float:
        """What an entry of the diagonal that `diagonal` and `tocsr` return is off by at most, relative to it."""
        return 0.0

    def equals(self, other: Stiffness) -> bool:
        """Whether another stiffness is held in the same way and consists of the same numbers, to the bit."""
        if self is other:
            return True
        if type(self) is not type(other):
            return False
        return all(np.array_equal(own, its) for own, its in zip(self._arrays, other._arrays, strict=True))

    @property
    @abstractmethod
    def _arrays(self) -> tuple[NDArray[Any], ...]:
        """The arrays that the stiffness is made of."""

    def enclosed_product(self, vector: Vector, force: Vector | float = 0.0) -> tuple[Vector, Vector]:
        """Return G times a vector plus a force as computed, and a bound of its rounding error.

        Parameters
        ----------
        vector : array, shape (..., size)
            Many vectors stand in rows.
        force : array, shape (..., size), or 0

        Returns
        -------
        product, bound : array, shape (..., size)
            The exact G vector + force is within the bound of the product.
        """
        product = self.matvec(vector)
        bound = self._moduli(vector, product) + np.abs(force)
        bound *= growth_bound(self)
        bound += UNDERFLOW
        return product + force, bound

    def _moduli(self, vector: Vector, product: Vector) -> Vector:
        """Return an upper bound of |G| |vector|, where the product G vector is known already."""
        return self.modulus_matvec(np.abs(vector))

    @abstractmethod
    def accurate_product(self, high: Vector, low: Vector, force: Vector) -> tuple[Vector, Vector]:
        """Return G(high + low) + force in about twice the precision, and a bound of its error.

        Parameters
        ----------
        high, low : array, shape (size,)
            The vector is their unrounded sum.
        force : array, shape (size,)

        Returns
        -------
        product, bound : array, shape (size,)
            The bound shrinks with the product and with ``low``; not finite where numbers are too large to be split.
        """

    @abstractmethod
    def restricted(self, free: Mask) -> Stiffness:
        """Return the rows and columns of some unknowns, of which there is at least one."""

    @abstractmethod
    def comparison(self) -> Stiffness:
        """Return the comparison matrix: the diagonal of G, and -|G_ij| beside it."""

    @abstractmethod
    def in_units(self, units: float | Vector) -> Stiffness:
        """Return G_ij u_i u_j: the stiffness of unknowns that are measured in other units of length."""

    @abstractmethod
    def dimensionless(self) -> tuple[Stiffness, float | Vector, float]:
        """Return a multiple of G with a largest diagonal entry of about 1, its units, and what it was divided by.

        Returns
        -------
        stiffness : Stiffness
            G_ij u_i u_j / largest.
        units : float or array, shape (size,)
            The units of length u, relative to each other.
        largest : float
        """


class LatticeStiffness(Stiffness):
    """A stiffness that joins neighbouring nodes of a lattice by arms; see `Stencil`, which is one.

    Attributes
    ----------
    numbering : Numbering
    horizontal, vertical : array
        Stiffness of the arms: shapes (rows, columns + 1) and (rows + 1, columns), or a number where all are equal.
    ground : array
        Stiffness of the arms between the nodes and the ground, shape (rows, columns), or a number, zero for none.
    """

    numbering: Numbering
    horizontal: NDArray[np.float64]
    vertical: NDArray[np.float64]
    ground: NDArray[np.float64]

    @property
    def mask(self) -> Mask:
        """True = node, shape (rows, columns)."""
        return self.numbering.mask

    @property
    def layout(self) -> Layout:
        """The nodes within the smallest rectangle that holds them, for passes along its rows."""
        return self.numbering.layout

    @property
    def even(self) -> bool:
        """Whether all horizontal arms are equal, and all vertical ones."""
        return self.horizontal.ndim == 0 and self.vertical.ndim == 0

    @property
    def uniform(self) -> bool:
        """Whether the stiffness is `even`, and no arm ends on the ground."""
        return self.even and not self.grounded

    @cached_property
    def rimmed(self) -> bool:
        """Whether the stiffness is `even`, and arms end on the ground at nodes beside the frame alone, or at none."""
        if not self.even:
            return False
        if not self.grounded:
            return True
        if self.ground.ndim == 0:
            return False
        node = np.pad(self.mask, 1)
        inside = node[1:-1, :-2] & node[1:-1, 2:] & node[:-2, 1:-1] & node[2:, 1:-1]
        return not self.ground.any(where=inside & self.mask)

    @cached_property
    def grounded(self) -> bool:
        """Whether an arm ends on the ground."""
        return bool(self.ground.any())


def growth_bound(stiffness: Stiffness) -> float:
    """Return c such that a computed row of G x + q is within c (|G| |x| + |q|) of the exact one.

    A row with m entries takes m products and m sums (Higham 2002, eq. 3.5); four operations are added for the
    evaluation of the bound itself.
    """
    return gamma(stiffness.longest_row + 6)
