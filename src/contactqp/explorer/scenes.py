"""Scenes: problems as the explorer's page holds them, with the supports that the reader chooses from."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Vector, repeated
from ..foundation.pictures import Wanted
from ..geometry.numbering import Grid
from ..models.base import ContactModel
from ..models.cable import Cable
from ..models.membrane import Membrane

Shown: TypeAlias = "Membrane | Cable"

MOST_NODES = 300_000
"""Nodes up to which a browser answers a slider within seconds."""

_FARTHEST = 10 / 3
"""How many times the case's load the slider goes up to: the paper's 0.03 to its 0.10."""

_STIFFEST = 4.0
"""How many times the case's tension the slider goes up to, and down to the inverse of that."""


@dataclass(frozen=True)
class Scene:
    """A membrane or a cable, and the shapes of support that it can be laid on.

    Parameters
    ----------
    name : str
        What the page calls it.
    model : Membrane or Cable
        See `shown`.
    supports : mapping of str to array, shape (n,)
        Depths of further supports (length), positive downwards, infinite where there is none.
    own : str
        What the page calls the model's own support.
    """

    name: str
    model: Shown
    supports: Mapping[str, Vector] = field(default_factory=dict)
    own: str = "the case's own"

    def record(self) -> dict[str, Any]:
        """Return what the page needs, as JSON takes it; fields are on the grid of the nodes' box with a ring about it.

        Returns
        -------
        dict
            Numbers, words, and arrays in base 64: bytes 0 and 1 for the nodes, else doubles, smallest byte first, or
            one number where all are equal.
        """
        model, lattice = self.model, self.model.lattice
        rows, columns = lattice.numbering.box
        arms = float(model.stencil.horizontal), float(model.stencil.vertical)
        load, tension = self._load(), self._tension()
        own = np.where(model.supported, model.depth, np.inf)
        return {
            "name": self.name,
            "rows": rows.stop - rows.start,
            "columns": columns.stop - columns.start,
            "left": float(lattice.x[columns.start]),
            "bottom": float(lattice.y[rows.start]),
            "spacing": lattice.spacing,
            "area": float(model.node_area[0]),
            "sign": -1 if model.upwards else 1,
            "mask": _packed(self._boxed(np.pad(lattice.mask, 1)).astype(np.uint8)),
            "arms": [arm / tension["value"] for arm in arms],
            "tension": tension,
            "load": load,
            "pattern": self._on_box(model.nodal_load / load["value"] if load["value"] else model.node_area),
            "lift": _lift_of([own, *self.supports.values()], self._frame()),
            "frame": _numbers(self._boxed(self._frame())),
            "supports": {name: self._on_box(depth) for name, depth in {self.own: own, **self.supports}.items()},
            "labels": self._labels(),
        }

    def _labels(self) -> dict[str, str]:
        wanted, units = Wanted(units=self.model.unit_names), self.model.units
        heights = wanted.label(f"height, {self.model.sense}")
        pressure = units["contact_pressure"]
        return {
            "x": wanted.label("x"),
            "y": wanted.label("y"),
            "height": heights,
            "gap": wanted.label("gap"),
            "pressure": wanted.label("pressure", pressure),
            "measure": "length" if isinstance(self.model, Cable) else "area",
        }

    def _load(self) -> dict[str, Any]:
        """Return the slider of the load: of one that varies, its largest modulus."""
        load, wanted = self.model.load, Wanted(units=self.model.unit_names)
        largest = float(load[int(np.argmax(np.abs(load)))])
        even = repeated(load) or bool((load == load[0]).all())
        label = wanted.label("load p" if even else "load p, where it is largest", self.model.units["load"])
        if largest == 0.0:  # there is no pattern to multiply: a load of one everywhere, of a size that moves the nodes
            side = max(self.model.extent) / 2
            depth = self.model.depth[np.isfinite(self.model.depth)]
            largest = float(self._tension()["value"] * (np.ptp(depth) if depth.size else side) / side**2) or 1.0
            return {"value": 0.0, "least": 0.0, "most": largest, "label": label}
        ends = sorted((0.0, _FARTHEST * largest))
        return {"value": largest, "least": ends[0], "most": ends[1], "label": label}

    def _tension(self) -> dict[str, Any]:
        """Return the slider of the tension: of one that is not the same in both directions, a factor."""
        tension = self.model.tension_of_arms
        wanted = Wanted(units=self.model.unit_names)
        value = float(self.model.tension) if tension.constant else 1.0
        quantity = "force" if isinstance(self.model, Cable) else "force per length"
        label = wanted.label("tension T", quantity) if tension.constant else "tension, times the case's"
        return {"value": value, "least": value / _STIFFEST, "most": value * _STIFFEST, "label": label}

    def _frame(self) -> Grid:
        """Return the depth of the frame on the lattice's array with a ring, the mean where no arm ends."""
        heights = self.model.frame_heights
        if heights is None:
            return np.zeros(tuple(side + 2 for side in self.model.lattice.shape))
        depth, joined = -heights if self.model.upwards else heights, self.model.frame_points()
        return np.where(joined, depth, depth[joined].mean())

    def _boxed(self, grid: NDArray[Any]) -> NDArray[Any]:
        """Return the box of the nodes with a ring, of an array that has a ring about the whole lattice."""
        rows, columns = self.model.lattice.numbering.box
        return grid[rows.start : rows.stop + 2, columns.start : columns.stop + 2]

    def _on_box(self, values: Vector) -> str | float:
        """Return the nodes' values on the grid, packed."""
        everywhere = np.asarray(values, dtype=np.float64)
        if repeated(everywhere) or bool((everywhere == everywhere[0]).all()):
            return _numbers(everywhere)
        return _numbers(self._boxed(self.model.lattice.numbering.to_grid(everywhere, ring=1)))


def shown(model: ContactModel) -> Shown:
    """Return a model that the page can solve, and refuse others.

    Raises
    ------
    TypeError
        If it is no Membrane and no Cable.
    ValueError
        If its tension varies from place to place, it has a ceiling or a foundation, its lattice is fitted to its
        contour, or has more than `MOST_NODES` nodes.
    """
    if not isinstance(model, (Membrane, Cable)):
        raise TypeError(f"the explorer shows a Membrane or a Cable, got {model!r}")
    refusals = {
        "its lattice is fitted to the contour; take Frame.lattice without fitted": model.lattice.cuts is not None,
        "it has a ceiling; leave that out": model.ceiling is not None,
        "it has an elastic foundation; leave that out": model.foundation is not None,
        "its tension varies from place to place; take a number, or a pair of these": not model.stencil.uniform,
        f"it has {model.size} nodes, of at most {MOST_NODES}; take a larger spacing": model.size > MOST_NODES,
    }
    for refusal, holds in refusals.items():
        if holds:
            raise ValueError(f"the explorer's own solver does not take {model!r}: {refusal}")
    return model


def _lift_of(supports: list[Vector], frame: Grid) -> dict[str, float]:
    """Return how far the slider of the lift goes: as far as any support lies below the frame, or is high itself."""
    depths = np.concatenate([depth[np.isfinite(depth)] for depth in supports])
    level = float(frame.mean())
    most = float(np.abs(depths - level).max(initial=0.0)) or 1.0
    return {"least": -most, "most": most}


def _numbers(values: NDArray[np.float64]) -> str | float:
    """Return numbers packed, or a single one where all are equal and finite."""
    first = float(values.flat[0])
    return first if np.isfinite(first) and bool((values == first).all()) else _packed(values)


def _packed(values: NDArray[Any]) -> str:
    little = values.astype(values.dtype.newbyteorder("<"), copy=False)
    return base64.b64encode(np.ascontiguousarray(little).tobytes()).decode("ascii")
