"""MembraneByRows: the data of a membrane that nobody holds whole, read row by row."""

from __future__ import annotations

from copy import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector, boolean, finite_number, positive_number, real_array
from ..geometry.fields import evaluated, is_function
from ..geometry.lattice import refuse_indistinct, spacing_of_nodes
from ..models.base import elevations_of


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
    tension : float, or pair of these
        T, force per length, > 0; of a pair the first along x, the second along y.
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
    frame_height : float
        Height of the frame (length).
    upwards : bool
        Whether heights are elevations, positive upwards.

    Attributes
    ----------
    given : dict of str to field
        Load, support, ceiling, mask and frame height as they were given.
    load_factor : float
        By what the load is multiplied, see `with_load`.

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
        tension: float | tuple[float, float],
        *,
        load: Any,
        support: Any,
        ceiling: Any = None,
        mask: Any = None,
        origin: tuple[float, float] = (0.0, 0.0),
        frame_height: float = 0.0,
        upwards: bool = False,
    ) -> None:
        if len(shape) != 2 or not all(isinstance(count, (int, np.integer)) and count > 0 for count in shape):
            raise ValueError(f"shape must be two whole numbers > 0, rows and columns, got {shape!r}")
        self.shape = int(shape[0]), int(shape[1])
        self.spacing = spacing_of_nodes(spacing)
        pair = tension if isinstance(tension, tuple) else (tension, tension)
        if len(pair) != 2:
            raise ValueError(f"tension must be a number or a pair of these, got {tension!r}")
        self.tension = positive_number(pair[0], "tension"), positive_number(pair[1], "tension")
        self.origin = finite_number(origin[0], "origin[0]"), finite_number(origin[1], "origin[1]")
        for axis, first, count in zip("xy", self.origin, self.shape[::-1], strict=True):
            refuse_indistinct(first, first + self.spacing * (count - 1), self.spacing, axis)
        self.upwards = boolean(upwards, "upwards")
        self.load_factor = 1.0
        self._sense = -1.0 if self.upwards else 1.0
        self.frame_depth = self._sense * finite_number(frame_height, "frame_height")
        self.given = {
            "load": load,
            "support": support,
            "ceiling": ceiling,
            "mask": mask,
            "frame_height": float(frame_height),
        }
        heights = {"support": support, "ceiling": ceiling}
        if self.upwards:
            heights = {name: elevations_of(height) for name, height in heights.items()}
        self._fields = {"load": load, "mask": mask, **heights}
        for name, field in self._fields.items():
            given = getattr(field, "shape", np.shape(field) if not callable(field) and field is not None else ())
            if tuple(given) not in ((), self.shape):
                raise ValueError(f"{name} must be a number, a function or have shape {self.shape}, got {tuple(given)}")

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

    @property
    def has_ceiling(self) -> bool:
        """Whether there is a ceiling."""
        return self._fields["ceiling"] is not None

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
        name : {"load", "support", "ceiling"}
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
        values = np.where(nodes, (self.load_factor if name == "load" else self._sense) * values, 0.0)
        absent = {"load": np.nan, "support": np.inf, "ceiling": -np.inf}[name]
        good = np.isfinite(values) | (values == absent)
        if not good.all():
            row, column = np.argwhere(~good)[0]
            place = f"x={self.x[column]:g}, y={self.y(first, last)[row]:g}"
            wanted = "finite" if name == "load" else f"finite or {self._sense * absent:+} (no {name})"
            value = values[row, column] if name == "load" else self._sense * values[row, column]
            raise ValueError(f"{name} must be {wanted}, but is {value} at {place}")
        return values

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
        return f"MembraneByRows({rows} x {columns}, spacing={self.spacing:g}, tension={self.tension})"


def _yes_or_no(function: Any, x: Vector, y: Vector, name: str) -> NDArray[Any]:
    answer = np.asarray(function(x, y))
    if answer.dtype != np.bool_ or answer.shape not in ((), x.shape):
        raise TypeError(
            f"{name}(x, y) must return True or False for each of {x.size} points, got {answer.dtype} of shape "
            f"{answer.shape}"
        )
    return answer
