"""LatticeModel: nodes on a lattice, held by a frame, over a rigid support."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..errors import UnsuitableProblemError
from ..foundation.checks import Mask, Vector, boolean, read_only
from ..foundation.text import counted
from ..geometry.between import Between, middle_of
from ..geometry.fields import Rows, as_given, checked_rows, frame_heights, in_rows, sample
from ..geometry.lattice import Lattice, patches_on_grid
from ..geometry.numbering import Grid
from ..geometry.on_arms import ArmField
from .base import ContactModel, Coordinate
from .rim import Rim
from .suspicions import Joints
from .tension import Tension


class LatticeModel(ContactModel):
    """Nodes on a lattice, whose arms join them to each other and to a frame, over a support.

    Base of `StretchedModel`, whose arms resist by their tension alone, and of `BendingModel`. A subclass sets what its
    stiffness is made of, and calls ``self._warn()`` at the end of its ``__init__``.

    Attributes
    ----------
    lattice : Lattice
    tension : float, array of shape (n,), or a pair of these
        Force per length in a membrane or plate, force in a cable or beam: a number, or the values at the nodes where it
        varies; along x and along y where these differ.
    load : array, shape (n,)
        Active pressure at the nodes, positive downwards: force per area (along a line: per length).
    support : array, shape (n,)
        Height of the rigid profile (length), positive downwards, unless ``upwards``; infinite where there is none.
    upwards : bool
        Whether heights are positive upwards.
    rows : {"up", "down"}
        Which way y goes from row to row of the arrays that the model is made from. What comes out of it goes up.
    ceiling : array, shape (n,), or None
        Height of a rigid surface above the nodes (length), positive as that of the support; infinite where there is
        none.
    foundation : array, shape (n,), or None
        Stiffness k of an elastic foundation: force per area and length (along a line: per length and length).
    noun : str
        What bends or is stretched, in a word.
    given : mapping of str to Any
        What tells load, support, ceiling, foundation and frame_height between the nodes, see
        `contactqp.geometry.fields.as_given`, and the tension's source. What a variation of a model has changed is not
        among them: it is known at the nodes alone.
    uncertain : dict of str to Between
        What was given by `contactqp.between`; the model is that of the middle.
    """

    node_area: Vector
    noun: ClassVar[str]
    _axes: ClassVar[tuple[int, ...]] = (1, 0)
    """Axes of the lattice's array along which arms join points."""
    _load_unit: str
    _pressure_unit: str
    _tension_unit: str
    _foundation_unit: str

    _takes_cuts: bool = False
    """Whether its arms may end on a contour that cuts them."""
    _rim: Rim | None = None
    """The arms that the frame's contour cuts."""

    def __init__(
        self,
        lattice: Lattice,
        tension: Tension,
        load: Any,
        support: Any,
        frame_height: Any,
        *,
        area: Any,
        upwards: bool = False,
        rows: Rows = "up",
        ceiling: Any = None,
        foundation: Any = None,
        units: Mapping[str, str] | None = None,
    ) -> None:
        if not isinstance(lattice, Lattice):
            raise TypeError(
                f"lattice must be a Lattice, got {type(lattice).__name__}; "
                "make one with Frame.lattice or Lattice.from_mask"
            )
        self.lattice = self._laid_on = lattice
        self.upwards, self.rows = boolean(upwards, "upwards"), checked_rows(rows)
        self._tension, self.unit_names = tension, units or {}
        fields = {"load": load, "support": support, "ceiling": ceiling, "foundation": foundation}
        fields |= {"frame_height": frame_height}
        self.uncertain = {name: field for name, field in fields.items() if isinstance(field, Between)}
        load, support, ceiling, foundation, frame_height = map(middle_of, fields.values())
        fields = dict(zip(fields, (load, support, ceiling, foundation, frame_height), strict=True))
        self.node_area = np.broadcast_to(np.asarray(area, dtype=np.float64), (lattice.size,))
        self.load: Vector = self.at_nodes(load, "load")
        self.support: Vector = self.support_at_nodes(support)
        self.ceiling = self.ceiling_at_nodes(ceiling)
        self.foundation = self.foundation_at_nodes(foundation)
        needed = self.frame_points()
        given = self._in_own_sense(self.without_unit(frame_height, "frame_height"))
        if lattice.cuts is not None and not self._takes_cuts:
            raise ValueError(f"a {type(self).__name__} takes no lattice that is fitted to its contour, got {lattice!r}")
        known = frame_heights(lattice, needed, given, self.rows) if needed.any() else (None, None)
        self._heights, self._end_heights = (
            np.negative(heights) if self.upwards and heights is not None else heights for heights in known
        )
        self._datum = 0.0 if self._heights is None else float(self._heights[needed].mean())
        plain = {name: self.without_unit(field, name) for name, field in fields.items() if field is not None}
        told = {name: as_given(lattice, field, name, self.rows) for name, field in plain.items()}
        self.given = MappingProxyType(told | {"tension": tension.source})

    @property
    def tension(self) -> Any:
        """Tension, see the class."""
        return self._tension.given

    @property
    def tension_of_arms(self) -> Tension:
        """The same with its value on every arm."""
        return self._tension

    def extremes(self) -> tuple[LatticeModel, LatticeModel]:
        """Return the models of the least and of the greatest depths among those that `contactqp.between` leaves open.

        Raises
        ------
        UnsuitableProblemError
            If the depths of a model of its kind do not grow, or fall, with what is uncertain.
        ValueError
            If what is lower lies above what is upper at a node.
        """
        raise UnsuitableProblemError(f"answers of {self!r} do not grow with its data: no two enclose the others")

    def at_nodes(self, field: Any, name: str, *, allow_inf: bool = False, absent: float | None = None) -> Vector:
        """See `ContactModel.at_nodes`."""
        field, absent = self.without_unit(field, name), self._no_support if absent is None else absent
        return read_only(sample(self.lattice, field, name, allow_inf=allow_inf, absent=absent, rows=self.rows))

    def in_own_rows(self, field: Any, name: str, rows: Rows | None) -> Any:
        """See `ContactModel.in_own_rows`."""
        return in_rows(field, name, rows, self.rows)

    @property
    def node_x(self) -> Vector:
        """Abscissa of each node, shape (n,), length."""
        return self.lattice.node_x

    @property
    def node_y(self) -> Vector:
        """Ordinate of each node in plan, shape (n,), length."""
        return self.lattice.node_y

    def _take_tension(self, tension: float) -> None:
        # Of a tension that varies there is no number to go from: it is multiplied.
        constant = Tension((ArmField(tension, tension),) * len(self._tension.fields), True)
        self._tension = constant if self._tension.constant else self._tension.times(tension)

    def padded_mask(self) -> Mask:
        """Return where the nodes are on the lattice's array with a ring about it."""
        return np.pad(self.lattice.mask, 1)

    def frame_points(self) -> Mask:
        """Return where, on the array with a ring about it, a frame point is joined to a node by an arm."""
        nodes = self.padded_mask()
        joined = np.zeros_like(nodes)
        for axis in self._axes:
            ends, points = _ends(joined, axis), _ends(nodes, axis)
            ends[0][...] |= points[1]
            ends[1][...] |= points[0]
        return np.asarray(joined & ~nodes)

    def describe(self, node: int) -> str:
        """Name a node by its number and coordinates, for messages: ``node 3 (x=0.5, y=1)``."""
        return self.lattice.describe(node)

    def free_boundary(self, contact: Mask) -> NDArray[np.float64]:
        """Return the middles of the arms that join a node in contact to one that is not, shape (k, 2), length."""
        return self.lattice.free_boundary(contact)

    def contact_patches(self, contact: Mask) -> tuple[NDArray[np.int64], int]:
        """See `ContactModel.contact_patches`; nodes side by side in a row or a column are joined."""
        labels, count = patches_on_grid(self.lattice.scatter(contact, fill=False))
        return self.lattice.gather(labels), count

    @property
    def frame_heights(self) -> Grid | None:
        """Heights of the frame on the lattice's array with a ring about it, positive as the model's; None for zero."""
        return np.negative(self._heights) if self.upwards and self._heights is not None else self._heights

    @property
    def frame_places(self) -> tuple[Vector, Vector, Vector]:
        """Where the frame holds arms: x, y and height (length), positive as the model's; on the contour if fitted."""
        if self._rim is None:
            row, column = np.nonzero(self.frame_points())
            x, y = self.lattice.ring_coordinates(row, column)
            heights = None if self._heights is None else self._heights[row, column]
        else:
            x, y = self.lattice.frame_places
            heights = self._rim.heights
        own = np.zeros(x.size) if heights is None else heights
        return x, y, -own if self.upwards else own

    def _frame_relief(self) -> float:
        if self._heights is None:
            return 0.0
        heights = self._heights[self.frame_points()]
        if self._end_heights is not None:
            heights = np.concatenate([heights, self._end_heights])
        return float(np.abs(heights - self._datum).max())

    def _joints(self) -> Joints:
        depth = self._padded(self.depth)
        depth[np.isinf(depth)] = np.nan
        number = self.lattice.numbering.to_grid(np.arange(self.size), ring=1, fill=-1)
        frame = self.frame_points()
        nodes, above, bends = [], [], []
        for axis in self._axes:
            across, outside = (np.moveaxis(grid, axis, 0) for grid in (number, frame))
            level = np.moveaxis(depth, axis, 0)
            at_nodes = np.where(across >= 0, level, np.nan)
            bends.append(np.abs(np.diff(at_nodes, n=2, axis=0)).ravel())
            for end in (slice(None), slice(None, None, -1)):
                node, beside, place = across[end][1:], outside[end][:-1], level[end]
                # How the support rises from the node next to the frame to the one beyond it. If it falls there, it may
                # be higher at the frame than at the node, but nobody knows how far.
                fall = np.zeros_like(at_nodes)
                fall[:-1] = np.minimum(np.nan_to_num(np.diff(at_nodes[end], axis=0)), 0.0)
                joined = (node >= 0) & beside
                nodes.append(node[joined])
                above.append((place[:-1] - place[1:] + fall[1:])[joined])
        over, bend = np.concatenate(above), np.concatenate(bends)
        return Joints(np.concatenate(nodes), np.where(np.isnan(over), -np.inf, over), bend[~np.isnan(bend)])

    def _padded(self, heights: Vector) -> Vector:
        """Return heights of nodes and frame on the lattice's array with a ring of frame points about it."""
        padded = self.lattice.numbering.to_grid(heights, ring=1)
        return padded if self._heights is None else np.where(self.padded_mask(), padded, self._heights)

    def max_slope(self, gap: Vector) -> float:
        """Return the largest difference quotient of the deflection along any arm (no unit)."""
        below = self._below(gap)
        heights, mask = self._padded(below), self.padded_mask()
        joined = mask | self.frame_points()
        steepest = 0.0 if self._rim is None else self._rim.steepest(below)
        for axis in self._axes:
            both = _pairs(joined, axis)
            touches_node = np.logical_or(*_ends(mask, axis))
            rise = np.abs(np.diff(heights, axis=axis))
            steepest = max(steepest, float(rise.max(where=both & touches_node, initial=0.0)))
        return steepest / self.lattice.spacing

    def padded_deflection(self, gap: Vector) -> Vector:
        """Return the deflection on the lattice's array with a ring of frame points, shape (rows + 2, columns + 2)."""
        below = self.padded_below(gap)
        return np.negative(below, out=below) if self.upwards else below

    def padded_below(self, gap: Vector) -> Vector:
        """Return what `padded_deflection` does, positive downwards whatever ``upwards`` is."""
        return self._padded(self._below(gap))

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height of the lattice's array (length)."""
        rows, columns = self.lattice.shape
        return columns * self.lattice.spacing, rows * self.lattice.spacing

    @property
    def parameters(self) -> dict[str, float]:
        """Tension, where it is a number in each direction, and the spacing of the lattice."""
        numbers = {name: value for name, value in self._tension.by_name.items() if isinstance(value, float)}
        return numbers | {"spacing": self.lattice.spacing}

    @property
    def fields(self) -> dict[str, tuple[Vector, str, str]]:
        """See `ContactModel.fields`: with the tension where it varies."""
        varying = {name: value for name, value in self._tension.by_name.items() if not isinstance(value, float)}
        unit = self.units["tension"]
        along = {"tension": "tension", "tension_x": "tension along x", "tension_y": "tension along y"}
        return super().fields | {name: (value, unit, along[name]) for name, value in varying.items()}

    @property
    def coordinates(self) -> dict[str, Coordinate]:
        """Coordinates of the lattice's columns and rows (length)."""
        axes = {"x": self.lattice.x, "y": self.lattice.y}
        return {name: Coordinate(name, np.array(places), {"units": "length"}) for name, places in axes.items()}

    def laid_out(self, values: Vector | Mask) -> tuple[tuple[str, ...], NDArray[Any]]:
        """Return the nodes' values on the lattice's array, nan or False elsewhere; see `ContactModel.laid_out`."""
        return ("y", "x"), self.lattice.scatter(values, fill=False if values.dtype == np.bool_ else np.nan)

    @property
    def units(self) -> dict[str, str]:
        """Units of the model's quantities in words, by name."""
        own = {"load": self._load_unit, "contact_pressure": self._pressure_unit}
        return super().units | own | {"tension": self._tension_unit, "foundation": self._foundation_unit}

    def __repr__(self) -> str:
        nodes = counted(self.lattice.size, "node")
        return self._line_of_text(nodes, f"spacing={self.lattice.spacing:g}", *self._stiffness_told())

    @abstractmethod
    def _stiffness_told(self) -> Iterator[str]:
        """Tell what the nodes resist by, for the model's line of text."""


def _ends(points: Mask, axis: int) -> tuple[Mask, Mask]:
    return (points[:-1], points[1:]) if axis == 0 else (points[:, :-1], points[:, 1:])


def _pairs(points: Mask, axis: int) -> Mask:
    return np.asarray(np.logical_and(*_ends(points, axis)))
