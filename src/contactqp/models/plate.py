"""Plate: bent within an edge that runs along lattice lines, in the vicinity of a rigid profile."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..algebra.stencil import Stencil
from ..foundation.checks import Mask, Vector, one_of, open_interval, positive_number
from ..foundation.keywords import known_by_name
from ..foundation.loading import load_modules
from ..foundation.pictures import UnitNames
from ..foundation.units import checked_units, plain
from ..geometry.fields import FieldLike, Rows, checked_rows
from ..geometry.lattice import Lattice
from ..geometry.numbering import Grid
from .bending import BendingModel
from .on_area import AreaModel
from .sensitive import Resistance, Values
from .tension import Tension, TensionLike

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Edge: TypeAlias = Literal["clamped", "simply supported"]

EDGES: tuple[Edge, ...] = ("clamped", "simply supported")

_STRIP_OVER_MEAN: dict[Edge, float] = {"clamped": 720.0, "simply supported": 120.0}
"""pW⁴/D over the mean deflection of a strip of width W under a uniform load p."""

_CORNERS = ((0, 0, 1), (0, 1, -1), (1, 0, -1), (1, 1, 1))
"""Row, column and sign of a cell's corners in its twist."""


class Plate(AreaModel, BendingModel):
    r"""A plate over a smooth, rigid support, with tension or without.

    D∇⁴w - T∇²w + kw = p - ρ, c ≤ w ≤ f, at small deflections (Kirchhoff). The edge is held at the frame's height, and
    is level across it (clamped) or free to turn (simply supported). As with a `Beam`, reactions are concentrated where
    the plate leaves the support.

    The energy ½D∫(w_xx² + w_yy² + 2w_xy²) of second differences at the nodes and of twists in the cells gives the
    thirteen-point rows of G, (20, -8, 2, 1) D/Δ², symmetric and of second order up to the edge: a simply supported edge
    takes 1 from the diagonal of a node beside it, a clamped one adds 1, by the image of that node. For w = 0 on an edge
    that is straight the energy is that of any Poisson's ratio; at re-entrant corners, too, the twists keep it that of
    the plate (two Poisson problems one after the other would not).

    Parameters
    ----------
    lattice : Lattice
        The nodes. The edge must run along lattice lines, as that of a rectangle whose sides are multiples of the
        spacing does: a plate in a polygon that follows a curved edge in steps is another one, however small its steps.
    bending_stiffness : number
        D = Eh³/12(1 - ν²), force times length, > 0.
    tension : number, array, xarray.DataArray or function of (x, y), or a pair of these
        T, force per length: the number 0 for none, or else as for `Membrane`.
    load : number, array, xarray.DataArray or function of (x, y)
        Active pressure p, positive downwards, force per area, as for `Membrane`.
    support : number, array, xarray.DataArray or function of (x, y)
        Height f of the rigid profile (length), as for `Membrane`; ``inf`` (``-inf``) where there is none.
    edge : {"clamped", "simply supported"}
    poisson_ratio : number
        ν, between -1 and 1/2: moments depend on it, deflections do not.
    frame_height : number, array or function of (x, y)
        Height of the edge, positive as those of the support, length; along a simply supported side it should be linear.
    upwards, rows, ceiling, foundation, units
        As for `Membrane`.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong kind, shape or range, the ceiling lies below the support, or the edge does not run
        along lattice lines; the message names it.

    Attributes
    ----------
    edge : str
    poisson_ratio : float

    Examples
    --------
    >>> import contactqp as cq
    >>> lattice = cq.Frame.rectangle(1.0, 1.0).lattice(spacing=0.05)
    >>> plate = cq.Plate(lattice, 1.0, load=3000.0, support=1.0, edge="clamped")
    >>> plate
    Plate(361 nodes, spacing=0.05, bending_stiffness=1, clamped, load=3000, support=1)
    >>> solution = cq.solve(plate)
    >>> float(solution.deflection.max().round(2)), int(solution.contact.sum())
    (1.0, 37)
    """

    noun: ClassVar[str] = "plate"
    _bending_unit: ClassVar[str] = "force times length"

    @known_by_name
    def __init__(
        self,
        lattice: Lattice,
        bending_stiffness: Any,
        *,
        tension: TensionLike = 0.0,
        load: FieldLike,
        support: FieldLike,
        edge: Edge = "clamped",
        poisson_ratio: float = 0.3,
        frame_height: FieldLike = 0.0,
        upwards: bool = False,
        rows: Rows = "up",
        ceiling: FieldLike | None = None,
        foundation: FieldLike | None = None,
        units: UnitNames | None = None,
    ) -> None:
        names = checked_units(units)
        known = lattice if isinstance(lattice, Lattice) else None
        if known is not None:
            _refuse_aslant(known)
        stiffness = plain(bending_stiffness, "bending_stiffness", self._bending_unit, names)
        self.bending_stiffness: float = positive_number(stiffness, "bending_stiffness")
        self.edge: Edge = one_of(edge, EDGES, "edge")  # type: ignore[assignment]
        self.poisson_ratio = open_interval(poisson_ratio, -1.0, 0.5, "poisson_ratio")
        given = tension if isinstance(tension, tuple) else (tension,)
        given = tuple(plain(part, "tension", self._tension_unit, names) for part in given)
        one_or_two = given if isinstance(tension, tuple) else given[0]
        super().__init__(
            *(lattice, Tension.or_none(known, one_or_two, "xy", checked_rows(rows)), load, support, frame_height),
            area=1.0 if known is None else known.spacing**2,
            upwards=upwards,
            rows=rows,
            ceiling=ceiling,
            foundation=foundation,
            units=names,
        )
        self._warn()

    def frame_points(self) -> Mask:
        """See `LatticeModel.frame_points`: with the corners of the cells that a node is a corner of."""
        return _around(self.padded_mask())

    @cached_property
    def _number(self) -> NDArray[np.int64]:
        """Numbers of the nodes on the lattice's array with a ring about it, -1 elsewhere."""
        return self.lattice.numbering.to_grid(np.arange(self.size), ring=1, fill=-1)

    @cached_property
    def _stretching(self) -> Stencil | None:
        """What the tension resists with."""
        if not self._is_stretched:
            return None
        return Stencil(self.lattice.mask, *(field.arms for field in self._tension.fields))

    def _turns(self, padded: Grid, axis: int) -> tuple[Grid, Grid, Grid]:
        """Return what bends along an axis: Δ²w″ at the nodes, and at the first and the second end of each arm."""
        nodes = self.padded_mask()
        first, second = _ends(nodes, axis)
        rise = np.where(first | second, np.diff(padded, axis=axis), 0.0)
        inner = np.zeros_like(padded)
        middle = (slice(1, -1), slice(None)) if axis == 0 else (slice(None), slice(1, -1))
        inner[middle] = np.where(nodes[middle], np.diff(rise, axis=axis), 0.0)
        # A clamped edge mirrors the node beside it.
        at_edge = 2.0 * rise if self.edge == "clamped" else np.zeros_like(rise)
        starts, stops = _ends(inner, axis)
        return inner, np.where(first, starts, at_edge), np.where(second, stops, -at_edge)

    def _twists(self, padded: Grid) -> Grid:
        """Return Δ²w_xy in the cells between the points of the array with a ring, 0 where no corner is a node."""
        return np.where(_cells(self.padded_mask()), np.diff(np.diff(padded, axis=0), axis=1), 0.0)

    def _bent(self, padded: Grid) -> Vector:
        """Return the force with which a plate that bends with D = Δ² pulls each node upwards, shape (n,)."""
        pulled = np.zeros_like(padded)
        for axis in self._axes:
            _, starts, stops = self._turns(padded, axis)
            before, after = _ends(pulled, axis)
            force = starts - stops
            before -= force
            after += force
        twists = 2.0 * self._twists(padded)
        rows, columns = pulled.shape
        for row, column, sign in _CORNERS:
            pulled[row : rows - 1 + row, column : columns - 1 + column] += sign * twists
        return self.lattice.numbering.to_vector(pulled, ring=1)

    def pull(self, depths: Vector) -> Vector:
        """Return the force with which the plate pulls each node upwards; see `ContactModel.pull`."""
        padded = self._padded(depths)
        held = self._bent(padded) * self._rigidity
        if self._stretching is not None:
            held += self._stretching.pull(padded)
        return np.asarray(held if self.nodal_foundation is None else held + self.nodal_foundation * depths)

    @property
    def _rigidity(self) -> float:
        """D/Δ² (force per length)."""
        return self.bending_stiffness / self.lattice.spacing**2

    @property
    def resistances(self) -> Mapping[str, Resistance]:
        """See `ContactModel.resistances`: ``bending_stiffness``."""

        def per_stiffness(depths: Vector) -> Vector:
            return self._bent(self._padded(depths)) / self.lattice.spacing**2

        def pull(depths: Vector, stiffness: Values) -> Vector:
            return stiffness * per_stiffness(depths)

        def share(depths: Vector, weights: Vector) -> Values:
            return np.asarray(weights @ per_stiffness(depths))

        return {**super().resistances, "bending_stiffness": Resistance((), pull, share)}

    def assemble_stiffness(self) -> csr_array:
        """Return G, thirteen entries in a row."""
        load_modules("scipy.sparse")
        from scipy import sparse

        number, nodes = self._number, self.padded_mask()
        # Whole numbers, so that the matrix is symmetric to the bit.
        clamped = np.zeros(self.size)
        parts = []
        for axis in self._axes:
            first, second = (each[nodes[inner]] for each, inner in _neighbours(number, axis))
            middle = np.arange(self.size)
            second_differences = _differences([(first, 1.0), (middle, -2.0), (second, 1.0)], self.size)
            parts.append(second_differences.T @ second_differences)
            if self.edge == "clamped":
                clamped += 2.0 * (first < 0) + 2.0 * (second < 0)
        cells, (rows, columns) = _cells(nodes), number.shape
        corners = [
            (number[row : rows - 1 + row, column : columns - 1 + column][cells], float(sign))
            for row, column, sign in _CORNERS
        ]
        twists = _differences(corners, self.size)
        matrix = (sum(parts) + 2.0 * (twists.T @ twists) + sparse.diags_array(clamped)) * self._rigidity
        if self._stretching is not None:
            matrix = matrix + self._stretching.tocsr()
        if self.nodal_foundation is not None:
            matrix = matrix + sparse.diags_array(np.array(self.nodal_foundation))
        found = sparse.csr_array(matrix)
        found.eliminate_zeros()
        found.sort_indices()
        return found

    def pull_per_tension(self, depths: Vector, pull_of_arms: Vector) -> Vector:
        """See `ContactModel.pull_per_tension`."""
        return Stencil(self.lattice.mask, 1.0, 1.0).pull(self._padded(depths))

    def fields_of_answer(self, gap: Vector) -> dict[str, tuple[Vector, str, str]]:
        """See `ContactModel.fields_of_answer`: bending moments along x and y, and the twisting moment."""
        padded = self._padded(self._below(gap))
        take = self.lattice.numbering.to_vector
        along_y, along_x = (take(self._turns(padded, axis)[0], ring=1) for axis in (0, 1))
        twists = self._twists(padded)
        twist = take((twists[:-1, :-1] + twists[:-1, 1:] + twists[1:, :-1] + twists[1:, 1:]) / 4)
        rigidity, ratio = -self._rigidity, self.poisson_ratio
        unit, told = "force", "bending moment per width, positive where the plate sags along"
        return {
            "moment_x": (rigidity * (along_x + ratio * along_y), unit, f"{told} x"),
            "moment_y": (rigidity * (along_y + ratio * along_x), unit, f"{told} y"),
            "moment_xy": (rigidity * (1 - ratio) * twist, unit, "twisting moment per width, -D(1 - ν) w_xy"),
        }

    def _mean_under(self, load: float) -> float:
        rows, columns = (side.stop - side.start + 1 for side in self.lattice.numbering.box)
        widths = np.array([columns, rows]) * self.lattice.spacing
        bending = _STRIP_OVER_MEAN[self.edge] * self.bending_stiffness * float((widths**-4.0).sum())
        tensions = [float(np.min(field.arms)) for field in self._tension.fields]
        stretching = 12.0 * float((np.array(tensions) / widths**2).sum())
        return load / (bending + stretching + self._mean_foundation())

    def _stiffness_told(self) -> Iterator[str]:
        yield from super()._stiffness_told()
        yield self.edge


def _ends(grid: NDArray[Any], axis: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return views of what a grid has at the first and at the second end of the arms along an axis."""
    return (grid[:-1], grid[1:]) if axis == 0 else (grid[:, :-1], grid[:, 1:])


def _neighbours(number: NDArray[np.int64], axis: int) -> list[tuple[NDArray[np.int64], tuple[slice, slice]]]:
    """Return the numbers of the points before and after each one of the inner part of an array, and that part."""
    inner = (slice(1, -1), slice(1, -1))
    ends = ((slice(None, -2), slice(1, -1)), (slice(2, None), slice(1, -1)))
    if axis == 1:
        ends = ((slice(1, -1), slice(None, -2)), (slice(1, -1), slice(2, None)))
    return [(number[end], inner) for end in ends]


def _differences(terms: list[tuple[NDArray[np.int64], float]], size: int) -> csr_array:
    """Return the matrix whose row r has each term's coefficient at its r-th number, none where that is negative."""
    load_modules("scipy.sparse")
    from scipy import sparse

    places = np.concatenate([numbers for numbers, _ in terms])
    rows = np.tile(np.arange(terms[0][0].size), len(terms))
    values = np.repeat([coefficient for _, coefficient in terms], terms[0][0].size)
    there = places >= 0
    shape = (terms[0][0].size, size)
    return sparse.coo_array((values[there], (rows[there], places[there])), shape=shape).tocsr()


def _cells(nodes: Mask) -> Mask:
    """Return which cells between the points of an array have a node at a corner."""
    return np.asarray(nodes[:-1, :-1] | nodes[:-1, 1:] | nodes[1:, :-1] | nodes[1:, 1:])


def _around(nodes: Mask) -> Mask:
    """Return the points beside nodes, along rows, columns and diagonals, that are none themselves."""
    cells = np.pad(_cells(nodes), 1)
    return np.asarray(_cells(cells) & ~nodes)


def _refuse_aslant(lattice: Lattice) -> None:
    """Raise a ValueError if the edge of a plate on a lattice does not run along lattice lines.

    Around a convex corner one cell of four belongs to the plate, around a re-entrant one three. An edge of one spacing
    from one to the other is a step.
    """
    remedy = (
        "a plate whose edge follows a slant or a curve in steps is another plate, however small they are; give a frame "
        "of right angles whose sides are whole multiples of the spacing, each two spacings long or longer"
    )
    if lattice.fit:
        raise ValueError(f"lattice must have its frame along lattice lines, but it lies {lattice.fit}: {remedy}")
    cells = np.pad(_cells(np.pad(lattice.mask, 1)), 1)
    inside = [cells[:-1, :-1], cells[:-1, 1:], cells[1:, :-1], cells[1:, 1:]]
    count = np.sum(inside, axis=0)
    convex, reentrant = count == 1, count == 3
    for axis in (0, 1):
        pairs = [_ends(corners, axis) for corners in (convex, reentrant)]
        step = (pairs[0][0] & pairs[1][1]) | (pairs[1][0] & pairs[0][1])
        if step.any():
            row, column = np.argwhere(step)[0]
            x, y = lattice.ring_coordinates(row, column)
            raise ValueError(
                f"lattice must have its frame along lattice lines, but that goes in steps of one spacing, first at "
                f"x={x:g}, y={y:g}: {remedy}"
            )
