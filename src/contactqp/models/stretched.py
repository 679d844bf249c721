"""StretchedModel: tensioned arms between the nodes of a lattice, over a rigid support."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebra.stencil import Stencil
from ..foundation.checks import Vector, repeated
from ..geometry.fields import Rows
from ..geometry.lattice import Lattice
from ..geometry.numbering import Grid
from .on_lattice import LatticeModel
from .reach import reach_on_lattice
from .sensitive import ArmTension, FrameHeights
from .tension import Tension


class StretchedModel(LatticeModel):
    """Nodes on a lattice, joined to their neighbours by tensioned arms, over a support.

    Base of `Membrane` and `Cable`, which choose the stiffness of the arms and the load's unit.

    Attributes
    ----------
    stencil : Stencil
        The stiffness G; for the others see `LatticeModel`.
    """

    _stiffness_of_tension: float = 1.0
    """Stiffness of an arm over its tension: of a membrane's the width that an arm stands for over its length."""

    def __init__(
        self,
        lattice: Lattice,
        tension: Tension,
        load: Any,
        support: Any,
        frame_height: Any,
        *,
        area: float,
        arms: tuple[Any, Any],
        upwards: bool = False,
        rows: Rows = "up",
        ceiling: Any = None,
        foundation: Any = None,
        units: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(
            *(lattice, tension, load, support, frame_height),
            area=area,
            upwards=upwards,
            rows=rows,
            ceiling=ceiling,
            foundation=foundation,
            units=units,
        )
        self.stencil = Stencil(lattice.mask, *arms, self._ground())
        self._warn()

    def _ground(self) -> Any:
        """Return the stiffness of the foundation as a stencil takes it."""
        springs = self.nodal_foundation
        if springs is None or not springs.any():
            return 0.0
        return float(springs[0]) if repeated(springs) else self.lattice.scatter(springs, fill=0.0)

    def _take_tension(self, tension: float) -> None:
        self.stencil = self.stencil.tensioned(tension / self.tension if self._tension.constant else tension)
        super()._take_tension(tension)

    def assemble_stiffness(self) -> Stencil:
        """Return the stencil."""
        return self.stencil

    def pull(self, depths: Vector) -> Vector:
        """Return the force with which the arms pull each node upwards; see `ContactModel.pull`."""
        return self.stencil.pull(self._padded(depths))

    @property
    def arm_tensions(self) -> Mapping[str, ArmTension]:
        """By ``arms_x``, shape (rows, columns + 1), and on a membrane ``arms_y``, shape (rows + 1, columns)."""
        names = ("arms_x", "arms_y")[: len(self._tension.fields)]
        return {name: self._tension_along(axis) for name, axis in zip(names, (1, 0), strict=False)}

    def _tension_along(self, axis: int) -> ArmTension:
        """Return how the arms along an axis of the lattice's array pull."""
        rows, columns = self.lattice.shape
        numbering, factor = self.stencil.numbering, self._stiffness_of_tension
        inner = (slice(1, -1), slice(None)) if axis == 1 else (slice(None), slice(1, -1))

        def rises(grid: Grid) -> Grid:
            return np.asarray(np.diff(grid[inner], axis=axis))

        def pull(depths: Vector, tensions: Grid) -> Vector:
            return numbering.to_vector(-np.diff(factor * tensions * rises(self._padded(depths)), axis=axis))

        def share(depths: Vector, weights: Vector) -> Grid:
            return factor * rises(self._padded(depths)) * rises(numbering.to_grid(weights, ring=1))

        return ArmTension((rows, columns + 1) if axis == 1 else (rows + 1, columns), pull, share)

    @property
    def heights_of_frame(self) -> FrameHeights:
        """By ``frame_heights``, shape (rows + 2, columns + 2): on the lattice's array with a ring about it."""
        stencil, rows, columns = self.stencil, *self.lattice.shape
        frame = self.frame_points()
        along_x = np.broadcast_to(stencil.horizontal, (rows, columns + 1))
        along_y = np.broadcast_to(stencil.vertical, (rows + 1, columns))

        def force(depths: Grid) -> Vector:
            return -stencil.pull(np.where(frame, depths, 0.0))

        def share(weights: Vector) -> Grid:
            grid = stencil.numbering.to_grid(weights, ring=1)
            found = np.zeros(frame.shape)
            found[1:-1, 1:] += along_x * grid[1:-1, :-1]
            found[1:-1, :-1] += along_x * grid[1:-1, 1:]
            found[1:, 1:-1] += along_y * grid[:-1, 1:-1]
            found[:-1, 1:-1] += along_y * grid[1:, 1:-1]
            return np.where(frame, found, 0.0)

        return FrameHeights("frame_heights", frame / frame.sum(), force, share)

    def _frame_grid(self) -> Grid | None:
        if self._heights is None:
            return None
        return np.where(self.frame_points(), self._heights - self._datum, 0.0)

    def _reach(self) -> float:
        return self._reach_of(self._forces_at(self._datum + self._frame_relief()))

    def _reach_upwards(self) -> float:
        return self._reach_of(-self._forces_at(self._datum - self._frame_relief()))

    def _reach_of(self, force: Vector) -> float:
        return reach_on_lattice(self.lattice.shape, (self.stencil.horizontal, self.stencil.vertical), force)

    @property
    def stiffness_data(self) -> tuple[NDArray[Any], ...]:
        """Shape, mask and arms of the stencil; see `ContactModel.stiffness_data`."""
        stencil = self.stencil
        springs = (stencil.ground,) * stencil.grounded
        return np.array(stencil.mask.shape), stencil.mask, stencil.horizontal, stencil.vertical, *springs

    def _stiffness_told(self) -> Iterator[str]:
        yield f"tension={self._tension.told}"
