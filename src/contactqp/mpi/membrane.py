"""MembraneByRows: the data of a membrane that nobody holds whole, read row by row."""

from __future__ import annotations

from copy import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector, boolean, finite_number, positive_number, real_array
from ..foundation.text import shortened
from ..geometry.fields import Rows, checked_rows, evaluated, is_function
from ..geometry.lattice import refuse_indistinct, spacing_of_nodes
from ..geometry.lattice_by_rows import EXACT, LatticeByRows
from ..geometry.numbering import Grid
from ..geometry.on_arms import harmonic_mean
from ..models.base import elevations_of

_ENDS = {
    "x": ((slice(1, -1), slice(None, -1)), (slice(1, -1), slice(1, None))),
    "y": ((slice(None, -1), slice(1, -1)), (slice(1, None), slice(1, -1))),
}
"""Where the first and the second ends of arms along an axis lie on an array with a ring."""


class MembraneByRows:
    """A membrane over a rigid support, as `contactqp.Membrane`, whose data are read for a few rows at a time.

    Each field is a number, a function of (x, y), or an array of the lattice's shape that need not be in memory: what
    has a ``shape`` and is read by ``field[first:last]``, as `numpy.memmap`, a Zarr array or a variable of netCDF4. A
    function is called once for each row, with x of the row's nodes and their y, so that its values do not depend on
    who asks for which rows; it must not depend on anything else that differs between processes.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns of the lattice.
    spacing : float
        Distance of neighbouring points (length), > 0.
    tension : number, function or array, or a pair of these
        T, force per length, > 0; of a pair (a tuple) the first along x, the second along y. Of a function an arm has
        the value in its middle, else the harmonic mean of the values at its ends; where an array has none on the frame,
        or nan, an arm that ends there has that of its node.
    load : number, function or array
        Active pressure, positive downwards, force per area.
    support : number, function or array
        Height of the rigid profile (length), positive downwards unless ``upwards``; ``inf`` (``-inf``) where there is
        no support.
    ceiling : number, function or array, optional
        Height of a rigid surface above the membrane; ``-inf`` (``inf``) where there is none.
    mask : function or array, optional
        True where there is a node; by default everywhere. All other points, and what lies outside the array, belong to
        the frame.
    origin : (float, float)
        x and y of the point of the first row and column (length).
    frame_height : number, function or array
        Height of the frame (length), at the points where it holds arms.
    foundation : number, function or array, optional
        Stiffness k >= 0 of an elastic foundation, which pulls the membrane to height zero: force per area and length.
    upwards : bool
        Whether heights are elevations, positive upwards.

    Attributes
    ----------
    given : dict of str to field
        Load, support, ceiling, mask, foundation and frame height as they were given.
    tension : pair of fields
        Along x and along y.
    load_factor : float
        By what the load is multiplied, see `with_load`.
    facts : LatticeFacts
        How the lattice lies to a frame's contour, and its coordinate reference system.
    rows : {"up", "down"}
        See `on`.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong kind, shape or range; of fields it is told when their rows are read.

    Examples
    --------
    >>> membrane = MembraneByRows((3, 4), 0.5, 1.0, load=lambda x, y: x * y, support=0.25)
    >>> membrane.rows_of("load", 1, 3)
    array([[0.  , 0.25, 0.5 , 0.75],
           [0.  , 0.5 , 1.  , 1.5 ]])
    """

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: float,
        tension: Any,
        *,
        load: Any,
        support: Any,
        ceiling: Any = None,
        mask: Any = None,
        origin: tuple[float, float] = (0.0, 0.0),
        frame_height: Any = 0.0,
        foundation: Any = None,
        upwards: bool = False,
    ) -> None:
        if len(shape) != 2 or not all(isinstance(count, (int, np.integer)) and count > 0 for count in shape):
            raise ValueError(f"shape must be two whole numbers > 0, rows and columns, got {shape!r}")
        self.shape = int(shape[0]), int(shape[1])
        self.spacing = spacing_of_nodes(spacing)
        pair = tension if isinstance(tension, tuple) else (tension, tension)
        if len(pair) != 2:
            raise ValueError(
                f"tension must be a number, a function, an array or a pair of these, got a tuple of {len(pair)}"
            )
        self.tension = tuple(positive_number(part, "tension") if _is_number(part) else part for part in pair)
        self.origin = finite_number(origin[0], "origin[0]"), finite_number(origin[1], "origin[1]")
        for axis, first, count in zip("xy", self.origin, self.shape[::-1], strict=True):
            refuse_indistinct(first, first + self.spacing * (count - 1), self.spacing, axis)
        self.upwards = boolean(upwards, "upwards")
        self.load_factor = 1.0
        self.facts, self.rows = EXACT, checked_rows("up")
        self._sense = -1.0 if self.upwards else 1.0
        if _is_number(frame_height):
            frame_height = finite_number(frame_height, "frame_height")
        self.given = {
            "load": load,
            "support": support,
            "ceiling": ceiling,
            "mask": mask,
            "foundation": foundation,
            "frame_height": frame_height,
        }
        heights = {"support": support, "ceiling": ceiling, "frame_height": frame_height}
        if self.upwards:
            heights = {name: elevations_of(height) for name, height in heights.items()}
        self._fields = {"load": load, "mask": mask, "foundation": foundation, **heights}
        self._refuse_other_shapes()

    def _refuse_other_shapes(self) -> None:
        for name, field in [*self._fields.items(), *(("tension", part) for part in self.tension)]:
            given = getattr(field, "shape", np.shape(field) if not callable(field) and field is not None else ())
            if tuple(given) not in ((), self.shape):
                raise ValueError(f"{name} must be a number, a function or have shape {self.shape}, got {tuple(given)}")

    @classmethod
    def on(cls, lattice: LatticeByRows, tension: Any, *, rows: Rows = "up", **fields: Any) -> MembraneByRows:
        """Return a membrane on a lattice that is laid over a frame, see `contactqp.Frame.lattice_by_rows`.

        Parameters
        ----------
        lattice : LatticeByRows
        tension
            See the class.
        rows : {"up", "down"}
            Which way y went from row to row of the arrays that the fields come from; those of the fields go up.
        **fields
            See the class: load, support and so on, but neither mask nor origin.

        Examples
        --------
        >>> import contactqp as cq
        >>> lattice = cq.Frame.disk(1.0).lattice_by_rows(0.25)
        >>> MembraneByRows.on(lattice, 1.0, load=2.0, support=0.1)
        MembraneByRows(9 x 9, spacing=0.25, tension=1)
        """
        membrane = cls(lattice.shape, lattice.spacing, tension, mask=lattice, origin=lattice.origin, **fields)
        membrane.facts, membrane.rows = lattice.facts, checked_rows(rows)
        return membrane

    def with_load(self, factor: float) -> MembraneByRows:
        """Return the membrane under so many times its load.

        Examples
        --------
        >>> membrane = MembraneByRows((1, 2), 1.0, 1.0, load=lambda x, y: 1.0 + x, support=1.0)
        >>> membrane.with_load(0.5).rows_of("load", 0, 1)
        array([[0.5, 1. ]])
        """
        other = copy(self)
        other.load_factor = self.load_factor * finite_number(factor, "factor")
        return other

    def under(self, load: Any) -> MembraneByRows:
        """Return the membrane under another load, given as when it was made.

        Examples
        --------
        >>> membrane = MembraneByRows((1, 2), 1.0, 1.0, load=1.0, support=1.0)
        >>> membrane.under(lambda x, y: 1.0 + x).rows_of("load", 0, 1)
        array([[1., 2.]])
        """
        other = copy(self)
        other.load_factor = 1.0
        other.given, other._fields = ({**fields, "load": load} for fields in (self.given, self._fields))
        other._refuse_other_shapes()
        return other

    def differs_in_load_alone(self, other: MembraneByRows) -> bool:
        """Whether all but the load, and its factor, are the very same objects: as `with_load` and `under` make it."""
        same = self.tension is other.tension and all(
            field is other._fields[name] for name, field in self._fields.items() if name != "load"
        )
        places = (self.shape, self.spacing, self.origin) == (other.shape, other.spacing, other.origin)
        return same and places and self.upwards == other.upwards

    def has(self, name: str) -> bool:
        """Whether there is a ``"ceiling"``, or a ``"foundation"``."""
        return self._fields[name] is not None

    @property
    def node_area(self) -> float:
        """Area that each node stands for."""
        return self.spacing**2

    @property
    def x(self) -> Vector:
        """Abscissae of the columns, shape (columns,), length."""
        return np.asarray(self.origin[0] + self.spacing * np.arange(self.shape[1]), dtype=np.float64)

    def y(self, first: int, last: int) -> Vector:
        """Return the ordinates of rows (length)."""
        return np.asarray(self.origin[1] + self.spacing * np.arange(first, last), dtype=np.float64)

    def nodes(self, first: int, last: int) -> Mask:
        """Return where there are nodes in the rows [first, last), shape (rows, columns)."""
        if self._fields["mask"] is None:
            return np.ones((last - first, self.shape[1]), dtype=np.bool_)
        nodes = self._read(self._fields["mask"], "mask", first, last, None)
        if nodes.dtype != np.bool_:
            raise TypeError(f"mask must be boolean (True = node), got dtype {nodes.dtype}; compare it first")
        return nodes

    def rows_of(self, name: str, first: int, last: int, nodes: Mask | None = None) -> NDArray[np.float64]:
        """Return a field at the nodes of the rows [first, last), shape (rows, columns); 0 elsewhere.

        Heights are returned as depths, positive downwards whatever ``upwards`` is.

        Parameters
        ----------
        name : {"load", "support", "ceiling", "foundation"}
        first, last : int
        nodes : array of bool, shape (rows, columns), optional
            What `nodes` returns of them.

        Raises
        ------
        ValueError
            If a value is not finite, and does not say that there is no support (ceiling).
        """
        nodes = self.nodes(first, last) if nodes is None else nodes
        values = np.where(nodes, self._read(self._fields[name], name, first, last, nodes), 0.0)
        factor = {"load": self.load_factor, "foundation": 1.0}.get(name, self._sense)
        absent = {"support": np.inf, "ceiling": -np.inf}.get(name, np.nan)
        good = np.isfinite(values) | (self._sense * values == absent)
        if name == "foundation":
            good &= values >= 0
        if not good.all():
            row, column = np.argwhere(~good)[0]
            place = f"x={self.x[column]:g}, y={self.y(first, last)[row]:g}"
            wanted = {"load": "finite", "foundation": "finite and >= 0"}
            told = wanted.get(name, f"finite or {self._sense * absent:+} (no {name})")
            raise ValueError(f"{name} must be {told}, but is {values[row, column]} at {place}")
        return np.where(nodes, factor * values, 0.0)

    def arms(self, axis: str, first: int, left: int, nodes: Mask) -> float | Grid:
        """Return the tension of the arms along an axis between the points of a window, a number where it is one.

        Parameters
        ----------
        axis : {"x", "y"}
        first, left : int
            Row and column of the lattice at which the window begins; they may lie outside.
        nodes : array of bool, shape (rows + 2, columns + 2)
            Where there are nodes; the outermost rows and columns are the window's ring.

        Returns
        -------
        float or array, shape (rows, columns + 1) along x, (rows + 1, columns) along y
            Zero for arms that no node is at an end of.

        Raises
        ------
        ValueError
            If it is not finite and > 0 somewhere.
        """
        field = self.tension["xy".index(axis)]
        if isinstance(field, float):
            return field
        one, other = _ENDS[axis]
        used = nodes[one] | nodes[other]
        half = 0.5 * self.spacing
        x, y = self._places(first, left, nodes.shape)
        x, y = (x[:-1] + half, y[1:-1]) if axis == "x" else (x[1:-1], y[:-1] + half)
        if is_function(field):
            found = np.zeros(used.shape)
            for row, there in enumerate(used):
                if there.any():
                    found[row, there] = evaluated(field, x[there], np.full(np.count_nonzero(there), y[row]), "tension")
        else:
            values = self._window(field, "tension", first, left, nodes.shape)
            values[nodes & np.isnan(values)] = 0.0
            lesser = np.fmin(values[one], values[other])
            good = used & (lesser > 0)
            mean = harmonic_mean(*(np.where(good, values[end], np.nan) for end in (one, other)))
            found = np.where(good, mean, np.where(used, lesser, 0.0))
        good = ~used | (np.isfinite(found) & (found > 0))
        if not good.all():
            row, column = np.argwhere(~good)[0]
            raise ValueError(
                f"tension must be finite and > 0, but is {found[row, column]:g} on the arm about x={x[column]:g}, "
                f"y={y[row]:g}"
            )
        return found

    def frame_depths(self, first: int, left: int, nodes: Mask) -> float | Grid:
        """Return depths of the frame where it holds arms of a window, and nan elsewhere; a number where they are one.

        Parameters
        ----------
        first, left, nodes
            See `arms`.

        Raises
        ------
        ValueError
            If a depth is not finite, or an array does not reach a point of the frame.
        """
        field = self._fields["frame_height"]
        if isinstance(field, float):
            return self._sense * field
        held = np.zeros_like(nodes)
        for one, other in _ENDS.values():
            held[one] |= nodes[other]
            held[other] |= nodes[one]
        held &= ~nodes
        x, y = self._places(first, left, nodes.shape)
        if is_function(field):
            found = np.full(nodes.shape, np.nan)
            for row, there in enumerate(held):
                if there.any():
                    at = x[there], np.full(np.count_nonzero(there), y[row])
                    found[row, there] = evaluated(field, *at, "frame_height")
        else:
            found = self._window(field, "frame_height", first, left, nodes.shape)
            found[~held] = np.nan
        if (unknown := held & ~np.isfinite(found)).any():
            row, column = np.argwhere(unknown)[0]
            raise ValueError(
                "frame_height must be finite wherever a node is joined to the frame, but is not known at "
                f"x={x[column]:g}, y={y[row]:g}; pass a function where an array does not reach"
            )
        return np.asarray(self._sense * found)

    def _places(self, first: int, left: int, shape: tuple[int, ...]) -> tuple[Vector, Vector]:
        """Return the abscissae and the ordinates of a window's points."""
        rows, columns = shape
        x = self.origin[0] + self.spacing * np.arange(left, left + columns)
        return np.asarray(x, dtype=np.float64), self.y(first, first + rows)

    def _window(self, field: Any, name: str, first: int, left: int, shape: tuple[int, ...]) -> Grid:
        """Return the values of a number or an array on a window; nan where it does not reach."""
        if _is_number(field):
            return np.full(shape, float(field))
        found = np.full(shape, np.nan)
        (low, high), (begin, end) = (
            (max(0, start), min(size, start + count))
            for start, count, size in zip((first, left), shape, self.shape, strict=True)
        )
        values = real_array(np.asarray(field[low:high]), name)
        found[low - first : high - first, begin - left : end - left] = values[:, begin:end]
        return found

    def _read(self, field: Any, name: str, first: int, last: int, nodes: Mask | None) -> NDArray[Any]:
        shape = last - first, self.shape[1]
        if is_function(field):
            return self._evaluated(field, name, first, last, nodes)
        if getattr(field, "shape", None) == self.shape or np.ndim(field) == 2:
            field = np.asarray(field[first:last])
        if name == "mask":
            return np.broadcast_to(np.asarray(field), shape)
        return np.broadcast_to(real_array(field, name), shape)

    def _evaluated(self, field: Any, name: str, first: int, last: int, nodes: Mask | None) -> NDArray[Any]:
        x = self.x
        found: NDArray[Any] = np.zeros((last - first, x.size), dtype=np.bool_ if nodes is None else np.float64)
        for row, y in enumerate(self.y(first, last)):
            if nodes is None:
                found[row] = _yes_or_no(field, x, np.full(x.shape, y), name)
            elif (there := nodes[row]).any():
                found[row, there] = evaluated(field, x[there], np.full(np.count_nonzero(there), y), name)
        return found

    def __repr__(self) -> str:
        rows, columns = self.shape
        x, y = (f"{part:g}" if isinstance(part, float) else "varying" for part in self.tension)
        tension = x if x == y else f"({x}, {y})"
        return f"MembraneByRows({rows} x {columns}, spacing={self.spacing:g}, tension={tension})"


def require_rows(membrane: object) -> None:
    """Raise a TypeError where something is no `MembraneByRows`."""
    if not isinstance(membrane, MembraneByRows):
        raise TypeError(
            f"membrane must be a contactqp.mpi.MembraneByRows, whose rows are read where they are needed, got "
            f"{shortened(membrane)}; what one process holds is solved by contactqp.solve, and traced by contactqp.trace"
        )


def _is_number(field: Any) -> bool:
    return not callable(field) and np.ndim(field) == 0


def _yes_or_no(function: Any, x: Vector, y: Vector, name: str) -> NDArray[Any]:
    answer = np.asarray(function(x, y))
    if answer.dtype != np.bool_ or answer.shape not in ((), x.shape):
        raise TypeError(
            f"{name}(x, y) must return True or False for each of {x.size} points, got {answer.dtype} of shape "
            f"{answer.shape}"
        )
    return answer
