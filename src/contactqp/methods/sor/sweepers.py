"""Sweepers: the state of a relaxation, and sweeps over it, on a lattice or on the rows of a sparse matrix."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from ...algebra.stiffness import LatticeStiffness, Stiffness
from ...foundation.checks import Mask, Vector
from ...geometry.numbering import Layout
from ..sor import kernels


class FreeNodes(NamedTuple):
    """Nodes of a net that are not in contact.

    Attributes
    ----------
    mask : array of bool, shape (rows + 2, columns + 2)
        True = free.
    across, along : float
        Stiffness of a horizontal and of a vertical arm over G_ii.
    """

    mask: Mask
    across: float
    along: float


class Sweeper(Protocol):
    """The current dimensionless gap, and what can be done to it; steps and residuals are lengths in the user's unit."""

    size: int

    def sweep(self, beta: float, sweeps: int, small: float = 0.0) -> tuple[int, float]:
        """Do up to ``sweeps`` sweeps; return their number and the largest step of the last one.

        It ends early once that step is below ``small``.
        """
        ...

    def residual(self, weight: float) -> float:
        """Return max |min(ω_i, weight R_i/G_ii)|."""
        ...

    def gap(self) -> Vector:
        """Return a copy of the gap in node order."""
        ...

    def free(self) -> FreeNodes | None:
        """Return the nodes that are not in contact, or None where they are no part of a net of equal arms."""
        ...


class LatticeSweeper:
    """Sweeps on the padded net of a uniform stencil, row by row or in red-black order."""

    def __init__(
        self,
        stencil: LatticeStiffness,
        q: Vector,
        supported: Mask,
        start: Vector | None = None,
        unit: float = 1.0,
        *,
        red_black: bool = False,
    ) -> None:
        diagonal = float(stencil.diagonal()[0])
        self.size = stencil.size
        self._mask = stencil.mask
        self._unit = unit
        self._across = float(stencil.horizontal) / diagonal
        self._along = float(stencil.vertical) / diagonal
        self._drive = stencil.numbering.to_grid(q / diagonal, ring=1)
        self._lower = stencil.numbering.to_grid(np.where(supported, 0.0, -np.inf), ring=1)
        self._omega = stencil.numbering.to_grid(np.zeros(self.size) if start is None else start, ring=1)
        self._runs = np.ascontiguousarray(Layout(stencil.mask).runs[:, :3])
        self._kernel = kernels.red_black_sweeps if red_black else kernels.lexicographic_sweeps

    def sweep(self, beta: float, sweeps: int, small: float = 0.0) -> tuple[int, float]:
        """See `Sweeper`."""
        done, step = self._kernel(
            self._omega,
            self._drive,
            self._lower,
            self._runs,
            self._across,
            self._along,
            beta,
            sweeps,
            small / self._unit,
        )
        return int(done), float(step) * self._unit

    def residual(self, weight: float) -> float:
        """See `Sweeper`."""
        return self._unit * float(
            kernels.lattice_residual(
                self._omega, self._drive, self._lower, self._runs, self._across, self._along, weight
            )
        )

    def gap(self) -> Vector:
        """See `Sweeper`."""
        return np.asarray(self._omega[1:-1, 1:-1][self._mask])

    def free(self) -> FreeNodes | None:
        """See `Sweeper`."""
        # Unsupported nodes lie above their bound of -inf; points that are no nodes rest at zero, as at their bound.
        return FreeNodes(self._omega > self._lower, self._across, self._along)


class SparseSweeper:
    """Sweeps over the rows of a sparse matrix, in their order."""

    def __init__(
        self,
        stiffness: Stiffness,
        q: Vector,
        supported: Mask,
        start: Vector | None = None,
        unit: float | Vector = 1.0,
    ) -> None:
        matrix = stiffness.tocsr()
        self.size = stiffness.size
        self._rows = (matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32), matrix.data)
        self._diagonal = stiffness.diagonal()
        self._unit = np.array(np.broadcast_to(unit, (self.size,)))
        self._q = np.array(q)
        self._lower = np.where(supported, 0.0, -np.inf)
        self._omega = np.zeros(self.size) if start is None else np.array(start)

    def sweep(self, beta: float, sweeps: int, small: float = 0.0) -> tuple[int, float]:
        """See `Sweeper`."""
        done, step = kernels.sparse_sweeps(
            *self._rows, self._diagonal, self._q, self._lower, self._unit, self._omega, beta, sweeps, small
        )
        return int(done), float(step)

    def residual(self, weight: float) -> float:
        """See `Sweeper`."""
        return float(
            kernels.sparse_residual(*self._rows, self._diagonal, self._q, self._lower, self._unit, self._omega, weight)
        )

    def gap(self) -> Vector:
        """See `Sweeper`."""
        return self._omega.copy()

    def free(self) -> FreeNodes | None:
        """See `Sweeper`."""
        return None
