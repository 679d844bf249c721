"""Carried: bounds of the membrane itself, which go along with an answer into files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, NamedTuple

from .fields import Field, fields_of

if TYPE_CHECKING:
    import xarray as xr

    from ..models.records import Answered

BESIDE = "continuum_"
"""What the names of bounds of the membrane itself begin with beside an answer's own."""


class Quantity(NamedTuple):
    """A number that is proven of a membrane.

    Attributes
    ----------
    value : float
    unit : str
        In words, as `contactqp.io.fields.Field` has it.
    meaning : str
        What it is, in a few words.
    """

    value: float
    unit: str
    meaning: str


class Carried(NamedTuple):
    """What is proven of the membrane itself, by names without `BESIDE`.

    Attributes
    ----------
    at_nodes : mapping of str to Field
        Bounds at the nodes; none of a membrane whose energy alone was enclosed.
    numbers : mapping of str to Quantity
    told : mapping of str to str
        How much was asked for, and what is known of the data.
    dataset : callable
        Returns all of that as an xarray.Dataset, and bounds in the squares between points besides.
    """

    at_nodes: Mapping[str, Field]
    numbers: Mapping[str, Quantity]
    told: Mapping[str, str]
    dataset: Callable[[], xr.Dataset]

    @property
    def facts(self) -> dict[str, float | str]:
        """What is neither at nodes nor in squares, by names that begin with `BESIDE`."""
        numbers = {name: quantity.value for name, quantity in self.numbers.items()}
        return {f"{BESIDE}{name}": value for name, value in (numbers | dict(self.told)).items()}


def fields_with(solution: Answered, carried: Carried | None) -> dict[str, Field]:
    """Return the quantities of an answer at the nodes, and what is carried there."""
    beside = {} if carried is None else {f"{BESIDE}{name}": field for name, field in carried.at_nodes.items()}
    return fields_of(solution) | beside
