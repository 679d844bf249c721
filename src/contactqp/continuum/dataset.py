"""Bounds of the membrane itself as a dataset: numbers, fields at the nodes, fields in the squares between points."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..foundation.brackets import Bracket
from ..foundation.checks import Mask, Vector
from ..foundation.loading import load_modules
from ..foundation.units import unit_of
from ..geometry.numbering import Grid
from ..io.carried import Quantity
from ..io.datasets import dataset_of
from ..io.fields import Field
from ..models.base import ContactModel
from ..models.records import NodeState
from .contact import ContactBounds

if TYPE_CHECKING:
    import xarray as xr

_STATES = NodeState.CONTACT, NodeState.CLEAR, NodeState.UNDECIDED


class InSquares(NamedTuple):
    """What is proven in the squares between the points of a lattice.

    Attributes
    ----------
    edges : pair of arrays, shapes (columns + 1,) and (rows + 1,)
        x and y of the lines between the squares (length).
    gap_lower, gap_upper : array, shape (rows, columns)
        Bounds of the gap (length), nan outside the frame.
    contact : ContactBounds
    """

    edges: tuple[Vector, Vector]
    gap_lower: Grid
    gap_upper: Grid
    contact: ContactBounds

    @property
    def fields(self) -> dict[str, Field]:
        """Bounds of the gap, and `contactqp.models.records.NodeState` of the squares."""
        told = "1 certainly in contact, 0 certainly clear, -1 undecided, in all of the square"
        found = {
            f"gap_{end}_in_squares": Field(
                getattr(self, f"gap_{end}"), "length", f"proven {end} bound of the membrane's gap in the square"
            )
            for end in ("lower", "upper")
        }
        return found | {_STATE: Field(_states(self.contact), "1", told)}


_STATE = "contact_state_in_squares"


def both_ends(name: str, bracket: Bracket, unit: str, meaning: str) -> dict[str, Quantity]:
    """Return the ends of a bracket as two numbers, whose names end in ``_lower`` and ``_upper``."""
    return {
        f"{name}_{end}": Quantity(bound, unit, f"{end} bound of the {meaning}")
        for end, bound in zip(("lower", "upper"), bracket, strict=True)
    }


def bounds_dataset(
    model: ContactModel, numbers: Mapping[str, Quantity], nodal: Mapping[str, Field], squares: InSquares | None
) -> xr.Dataset:
    """Return bounds as a dataset.

    Parameters
    ----------
    model : Membrane or Cable
        Knows units, and places of the nodes.
    numbers : mapping of str to Quantity
    nodal : mapping of str to Field
    squares : InSquares or None
    """
    load_modules("xarray")
    import xarray as xr

    data = dataset_of(model, nodal)
    for name, (value, unit, meaning) in numbers.items():
        data[name] = ((), value, {"units": unit_of(unit, model.unit_names) or unit, "long_name": meaning})
    if squares is None:
        return data
    length = unit_of("length", model.unit_names) or "length"
    for name, (values, unit, meaning) in squares.fields.items():
        about = {"units": unit_of(unit, model.unit_names) or unit, "long_name": meaning}
        data[name] = (("y_square", "x_square"), values, about)
    data[_STATE].attrs |= {
        "flag_values": np.array([float(kind) for kind in _STATES]),
        "flag_meanings": " ".join(kind.name.lower() for kind in _STATES),
    }
    for axis, edges in zip("xy", squares.edges, strict=True):
        place, bounds = f"{axis}_square", f"{axis}_square_bounds"
        about = {"units": length, "long_name": f"{axis} of the middles of the squares", "bounds": bounds}
        middles = xr.Variable((place,), (edges[1:] + edges[:-1]) / 2, about)
        data = data.assign_coords({place: middles})
        data[bounds] = ((place, "side"), np.column_stack([edges[:-1], edges[1:]]))
    return data


def _states(contact: ContactBounds) -> Grid:
    known: dict[NodeState, Mask] = dict(zip(_STATES, (contact.contact, contact.clear, contact.undecided), strict=True))
    state = np.full(contact.clear.shape, np.nan)
    for kind, where in known.items():
        state[where] = kind.value
    return state
