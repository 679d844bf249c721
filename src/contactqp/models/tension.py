"""Tension: of the arms along rows and along columns of a lattice, the same in both or not, constant or varying."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from ..foundation.checks import Vector, finite_number, positive_number
from ..foundation.text import span_of
from ..geometry.between import Between
from ..geometry.fields import FieldLike, Rows, as_given
from ..geometry.lattice import Lattice
from ..geometry.on_arms import ArmField, on_arms

TensionLike: TypeAlias = FieldLike | tuple[FieldLike, FieldLike]
"""A number, array, DataArray or function, or a pair of these: along x, along y."""


@dataclass(frozen=True)
class Tension:
    """The tension of a model on a lattice.

    Attributes
    ----------
    fields : tuple of ArmField
        Along x and, on a membrane, along y.
    same : bool
        Whether one tension was given for all directions.
    source : tuple
        What tells it between the nodes along each axis, see `contactqp.geometry.fields.as_given`; empty where nothing
        but the arms is known.
    """

    fields: tuple[ArmField, ...]
    same: bool
    source: tuple[Any, ...] = ()

    @classmethod
    def of(cls, lattice: Lattice | None, value: Any, along: str, rows: Rows = "up") -> Tension:
        """Return the tension that is given for the arms along ``"xy"`` or along ``"x"``, checked.

        Without a lattice, which is refused elsewhere, it must be a number. One that is of this class is taken as it is.
        """
        if isinstance(value, Tension):
            return value
        if isinstance(value, Between):
            ends = (positive_number(value.lower, "tension between"), positive_number(value.upper, "tension between"))
            value = sum(ends) / 2
        pair = isinstance(value, tuple)
        if pair and len(value) != len(along):
            wanted = "a pair, along x and along y" if len(along) == 2 else "one, a cable's"
            raise ValueError(f"tension must be {wanted}, got a tuple of {len(value)}; arrays are no tuples")
        if pair and len(along) == 1:
            value, pair = value[0], False
        if lattice is None:
            return cls(
                (ArmField(number := positive_number(value, "tension"), number),) * len(along),
                True,
                (number,) * len(along),
            )
        given = value if pair else (value,) * len(along)
        names = [f"tension along {axis}" if pair else "tension" for axis in along]
        fields = tuple(
            on_arms(lattice, field, name, axis, rows) for field, name, axis in zip(given, names, along, strict=True)
        )
        equal = pair and all(isinstance(field.arms, float) and field.arms == fields[0].arms for field in fields)
        source = tuple(as_given(lattice, field, "tension", rows) for field in given)
        return cls(fields, not pair or equal, source)

    @classmethod
    def or_none(cls, lattice: Lattice | None, value: Any, along: str, rows: Rows = "up") -> Tension:
        """Return the tension as `of` does, where the number 0, too, is one: of what is held by its bending alone."""
        if isinstance(value, (Tension, tuple, str)) or callable(value) or np.ndim(value):
            return cls.of(lattice, value, along, rows)
        number = finite_number(value, "tension")
        if number < 0:
            raise ValueError(f"tension must be >= 0, got {number:g}: what is compressed may buckle")
        return cls((ArmField(number, number),) * len(along), True, (number,) * len(along))

    @property
    def given(self) -> Any:
        """A number or the values at the nodes, shape (n,); a pair of these where x and y differ."""
        nodes = tuple(field.nodes for field in self.fields)
        return nodes[0] if self.same else nodes

    @property
    def by_name(self) -> dict[str, float | Vector]:
        """The same by the names of quantities: tension; or tension_x and tension_y."""
        if self.same:
            return {"tension": self.fields[0].nodes}
        return {f"tension_{axis}": field.nodes for axis, field in zip("xy", self.fields, strict=True)}

    @property
    def constant(self) -> bool:
        """Whether it is one number everywhere and in all directions."""
        return self.same and all(isinstance(part, float) for field in self.fields for part in field)

    @property
    def told(self) -> str:
        """In words: ``1``, ``1 to 3``, or ``(1, 2 to 3)``."""
        spans = [
            f"{nodes:g}" if isinstance(nodes, float) else span_of(np.asarray(nodes)) for nodes in self.by_name.values()
        ]
        return spans[0] if self.same else f"({', '.join(spans)})"

    def times(self, factor: float) -> Tension:
        """Return the tension that is ``factor`` times as large everywhere."""
        return Tension(tuple(field.times(factor) for field in self.fields), self.same)
