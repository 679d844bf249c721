"""Sweepers: the state of a relaxation, and sweeps over it, on a lattice or on the rows of a sparse matrix."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from ...algebra.stiffness import LatticeStiffness, Stiffness
from ...foundation.checks import Vector
from ...geometry.numbering import Grid, Layout
from . import kernels


class Sweeper(Protocol):
    """The current dimensionless gap, and what can be done to it; steps and residuals are lengths in the user's unit."""

    size: int

    def sweep(self, beta: float, sweeps: int, small: float = 0.0) -> tuple[int, float]:
        """Do up to ``sweeps`` sweeps; return their number and the largest step of the last one.

        It ends early once that step is below ``small``.
        """
        ...

    def residual(self, weight: float) -> float:
        """Return the largest modulus of the natural residual, with ``weight`` times R_i/G_ii in place of R_i/G_ii."""
        ...

    def gap(self) -> Vector:
        """Return a copy of the gap in node order."""
        ...


class LatticeSweeper:
    """Sweeps on the array of a uniform stencil, row by row or in red-black order.

    Parameters
    ----------
    stencil : LatticeStiffness
        With arms that are equal in each direction.
    layout : Layout
        Its nodes by the kinds of their bounds.
    q, start : array, shape (n,)
    limits : pair of arrays
        Bounds of the nodes that are `BOUNDED`, on the layout's grid; empty where there are none.
    unit : float
        Unit of length.
    red_black : bool
    """

    def __init__(
        self,
        stencil: LatticeStiffness,
        layout: Layout,
        q: Vector,
        start: Vector,
        limits: tuple[Grid, Grid],
        unit: float = 1.0,
        *,
        red_black: bool = False,
    ) -> None:
        diagonal = float(stencil.diagonal()[0])
        self.size = stencil.size
        self._layout, self._limits, self._unit = layout, limits, unit
        self._across = float(stencil.horizontal) / diagonal
        self._along = float(stencil.vertical) / diagonal
        self._drive = layout.grid(q / diagonal)
        self._omega = layout.grid(start)
        self._kernel: Any = kernels.red_black_sweeps if red_black else kernels.lexicographic_sweeps
        self._residual: Any = kernels.lattice_residual

    def sweep(self, beta: float, sweeps: int, small: float = 0.0) -> tuple[int, float]:
        """See `Sweeper`."""
        done, step = self._kernel(*self._arguments, beta, sweeps, small / self._unit)
        return int(done), float(step) * self._unit

    def residual(self, weight: float) -> float:
        """See `Sweeper`."""
        return self._unit * float(self._residual(*self._arguments, weight))

    def gap(self) -> Vector:
        """See `Sweeper`."""
        return self._layout.vector(self._omega)

    @property
    def _arguments(self) -> tuple[Any, ...]:
        return self._omega, self._drive, *self._limits, self._layout.runs, self._across, self._along


class SparseSweeper:
    """Sweeps over the rows of a sparse matrix, in their order.

    Parameters
    ----------
    stiffness : Stiffness
    q, start : array, shape (n,)
    lower, upper : array, shape (n,)
        Bounds, -inf and inf where there is none; ``upper`` is empty where there is none at all.
    unit : float or array, shape (n,)
        Unit of length of each unknown.
    """

    def __init__(
        self,
        stiffness: Stiffness,
        q: Vector,
        start: Vector,
        lower: Vector,
        upper: Vector,
        unit: float | Vector = 1.0,
    ) -> None:
        matrix = stiffness.tocsr()
        self.size = stiffness.size
        rows = matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32), matrix.data
        bounds = np.ascontiguousarray(lower), np.ascontiguousarray(upper)
        units = np.array(np.broadcast_to(unit, (self.size,)), dtype=np.float64)
        self._omega = np.array(start, dtype=np.float64)
        self._kernel: Any = kernels.sparse_sweeps
        self._residual: Any = kernels.sparse_residual
        self._arguments: tuple[Any, ...] = *rows, stiffness.diagonal(), q, *bounds, units, self._omega

    def sweep(self, beta: float, sweeps: int, small: float = 0.0) -> tuple[int, float]:
        """See `Sweeper`."""
        done, step = self._kernel(*self._arguments, beta, sweeps, small)
        return int(done), float(step)

    def residual(self, weight: float) -> float:
        """See `Sweeper`."""
        return float(self._residual(*self._arguments, weight))

    def gap(self) -> Vector:
        """See `Sweeper`."""
        return self._omega.copy()
