"""Touchdown: the loads between which each node certainly comes into contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..foundation.cards import card
from ..foundation.checks import Vector
from ..models.base import ContactModel

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class Touchdown:
    """Brackets of the load factor at which each node settles, for a load under which nodes only settle.

    Attributes
    ----------
    model : Membrane, Cable or CableNet
        Its load is multiplied by the factors below.
    clear, contact : array, shape (n,)
        Largest load factor at which the node is certainly clear, -inf if there is none, and least one at which it
        is certainly in contact, inf if there is none: it touches down between the two.
    loads : array
        The load factors that were solved for, ascending.
    """

    model: ContactModel
    clear: Vector
    contact: Vector
    loads: Vector

    @property
    def width(self) -> float:
        """Largest width of the brackets that are closed on both sides; 0 if there is none."""
        closed = np.isfinite(self.clear) & np.isfinite(self.contact)
        return float((self.contact - self.clear)[closed].max(initial=0.0))

    @property
    def load(self) -> Vector:
        """Middle of each closed bracket, shape (n,); nan where the node settles outside the loads solved for."""
        with np.errstate(invalid="ignore"):
            middle = 0.5 * (self.clear + self.contact)
        return np.where(np.isfinite(middle), middle, np.nan)

    def to_dataset(self) -> xr.Dataset:
        """Return clear, contact and load as an xarray.Dataset with dims y and x (a cable: x, a net of cables: node)."""
        from ..io.datasets import dataset_of
        from ..io.fields import Field

        fields = {
            "clear": Field(self.clear, "1", "largest load factor at which the node is certainly clear"),
            "contact": Field(self.contact, "1", "least load factor at which the node is certainly in contact"),
            "load": Field(self.load, "1", "middle of the two, nan unless both are known"),
        }
        return dataset_of(self.model, fields)

    def plot(self) -> Figure:
        """Draw at which load each node settles."""
        from .pictures import plot_touchdown

        return plot_touchdown(self)

    def _repr_html_(self) -> str:
        facts = {
            "model": repr(self.model),
            "load factors": f"{self.loads.size} from {self.loads[0]:g} to {self.loads[-1]:g}",
            "settle between them": f"{np.count_nonzero(np.isfinite(self.load))} nodes",
            "known to": f"{self.width:.2g}",
        }
        return card("Touchdown", facts)

    def __repr__(self) -> str:
        closed = int(np.count_nonzero(np.isfinite(self.load)))
        return (
            f"Touchdown({self.model!r}, {self.loads.size} load factors from {self.loads[0]:g} to {self.loads[-1]:g}: "
            f"{closed} nodes settle between them, known to {self.width:.2g})"
        )
