"""BendingModel: nodes on a lattice that are held by the stiffness of what bends, over a rigid support."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from ..foundation.checks import Vector
from ..foundation.text import span_of
from ..problem.barrier import Barrier
from .on_lattice import LatticeModel


class BendingModel(LatticeModel):
    """Nodes on a lattice, held by bending stiffness, and by a tension, over a support.

    Base of `Beam` and `Plate`. Their stiffness G is symmetric and positive definite, but no M-matrix: a load may lift
    nodes elsewhere. So no support counts as out of reach, however deep it lies, and more load need not mean less gap.

    Attributes
    ----------
    bending_stiffness : float, or array of shape (n,)
        In a beam EI, force times length squared; in a plate D = Eh³/12(1 - ν²), force times length. For the others see
        `LatticeModel`.
    """

    bending_stiffness: float | Vector
    _bending_unit: ClassVar[str]

    @abstractmethod
    def _mean_under(self, load: float) -> float:
        """Estimate how far a load moves the nodes in the mean where nothing else holds them (length).

        Parameters
        ----------
        load : float
            Force per area (along a line: per length), > 0, the same everywhere.
        """

    def _gap_scale(self, barrier: Barrier | None) -> float | None:
        force, area = self._forces_at(self._datum), float(self.node_area.sum())
        down, up = (float(np.maximum(sign * force, 0.0).sum()) / area for sign in (1.0, -1.0))
        sunk, lifted = (self._mean_under(load) if load else 0.0 for load in (down, up))
        return self._scale_of(sunk, lifted, np.ones(self.size))

    def _reaction_in_balance(self, gap: Vector) -> Vector:
        # From differences of depths: products with G, whose entries are large, would leave more rounding.
        return np.asarray(self.nodal_load - self.pull(self._below(gap)))

    def _mean_foundation(self) -> float:
        """Mean stiffness of the foundation, see `ContactModel.foundation`; 0 without one."""
        return 0.0 if self.foundation is None else float(self.foundation.mean())

    @property
    def parameters(self) -> dict[str, float]:
        """The bending stiffness, where it is a number, and what any model on a lattice has."""
        stiffness = self.bending_stiffness
        return ({"bending_stiffness": stiffness} if isinstance(stiffness, float) else {}) | super().parameters

    @property
    def fields(self) -> dict[str, tuple[Vector, str, str]]:
        """See `ContactModel.fields`: with the bending stiffness where it varies."""
        stiffness = self.bending_stiffness
        if isinstance(stiffness, float):
            return super().fields
        return super().fields | {"bending_stiffness": (stiffness, self._bending_unit, "bending stiffness")}

    @property
    def units(self) -> dict[str, str]:
        """Units of the model's quantities in words, by name."""
        return super().units | {"bending_stiffness": self._bending_unit}

    def _stiffness_told(self) -> Iterator[str]:
        yield f"bending_stiffness={span_of(np.atleast_1d(self.bending_stiffness))}"
        if self._is_stretched:
            yield f"tension={self._tension.told}"

    @property
    def _is_stretched(self) -> bool:
        """Whether there is a tension."""
        return not self._tension.constant or self.tension != 0.0
