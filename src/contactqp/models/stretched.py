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
from .tension import Tension


class StretchedModel(LatticeModel):
    """Nodes on a lattice, joined to their neighbours by tensioned arms, over a support.

    Base of `Membrane` and `Cable`, which choose the stiffness of the arms and the load's unit.

    Attributes
    ----------
    stencil : Stencil
        The stiffness G; for the others see `LatticeModel`.
    """

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
