"""Lattice: the nodes inside a frame, on a square lattice of equal spacing."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..foundation.checks import Mask, Vector, finite_number, one_of, positive_number, read_only
from ..foundation.loading import load_modules
from ..foundation.pictures import UnitNames, Wanted, drawn
from ..foundation.text import counted
from .cuts import Cuts, FrameArms, frame_arms
from .labelled import grid_of, is_dataarray, is_labelled, with_places
from .numbering import Numbering
from .outline import Outline

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Lattice:
    """The nodes of a square lattice that lie inside a frame.

    Nodes are numbered row by row: y ascending, and x ascending within a row. Two-dimensional arrays are
    indexed ``[row, column]``, that is ``[y, x]``. Every point of the array that is not a node, and
    everything outside the array, belongs to the frame.

    Parameters
    ----------
    mask : array of bool, shape (rows, columns)
        True where there is a node.
    spacing : float
        Distance of neighbouring points (length), > 0.
    origin : (float, float)
        Coordinates x, y of the point with the smallest x and y, ``mask[0, 0]`` if rows go up (length).
    rows : {"up", "down"}
        Which way y goes from row to row of ``mask``: ``"up"``, its first row is that of the smallest y; ``"down"``, of
        the largest, as in a picture. The lattice's own arrays go up in either case.
    crs : str
        The coordinate reference system of x and y, as ``"EPSG:25832"`` or as WKT; it goes into files. ``""`` if none is
        known.

    Raises
    ------
    TypeError
        If ``mask`` is not boolean.
    ValueError
        If ``mask`` is not two-dimensional or holds no node, or ``spacing`` is not positive, or so small or so large
        that numbers in double precision cannot tell neighbouring nodes, or the area of one.

    Attributes
    ----------
    overshoot : float
        How far outside the frame's contour, at most, the points lie that stand for the frame (length): 0 where the
        contour lies on the lattice, or where the lattice was made from a mask.
    caution : str
        What is to be said of a lattice that is wider than its frame: by how much, where, and which spacings fit; else
        empty.
    slanted : bool
        Whether slanted sides of the contour cut squares of the lattice that have a node at a corner: the lattice's
        points on such a side lie on the contour, but lines of the lattice do not.
    halved : array of bool, shape (rows + 1, columns + 1), or None
        Where such sides all run along diagonals of squares: the squares that they halve, between the points of the
        array with a ring about it. The half at the only node of each lies inside the contour. None where there are no
        slanted sides, or others.
    cuts : Cuts or None
        How long the arms are that end on the frame, where the lattice is fitted to its contour; None where all reach
        to the next point of the lattice.
    outline : Outline or None
        The contour itself, where the lattice is fitted to it and it is known.

    Examples
    --------
    >>> import numpy as np
    >>> import contactqp as cq
    >>> lattice = cq.Lattice.from_mask(np.array([[True, True, False], [True, True, True]]), spacing=0.5)
    >>> lattice
    Lattice(5 nodes in 2 x 3, spacing=0.5)
    >>> lattice.node_x
    array([0. , 0.5, 0. , 0.5, 1. ])
    >>> lattice.scatter([1, 2, 3, 4, 5], fill=0)
    array([[1, 2, 0],
           [3, 4, 5]])
    """

    def __init__(
        self,
        mask: ArrayLike,
        spacing: float,
        origin: tuple[float, float] = (0.0, 0.0),
        *,
        rows: str = "up",
        overshoot: float = 0.0,
        caution: str = "",
        crs: str = "",
        slanted: bool = False,
        halved: Mask | None = None,
        cuts: Cuts | None = None,
        outline: Outline | None = None,
    ) -> None:
        points = np.array(mask)
        if points.dtype != np.bool_:
            raise TypeError(
                f"mask must be boolean (True = node), got dtype {points.dtype}; compare it first, e.g. mask > 0"
            )
        if points.ndim != 2:
            raise ValueError(f"mask must be two-dimensional [row, column], got shape {points.shape}")
        if not points.any():
            raise ValueError(f"mask of shape {points.shape} holds no node: choose a smaller spacing or a larger frame")
        down = one_of(rows, ("up", "down"), "rows") == "down"
        self.mask: Mask = read_only(np.ascontiguousarray(points[::-1]) if down else points)
        self.overshoot, self.caution, self.crs = overshoot, caution, checked_crs(crs)
        self.slanted = slanted
        self.halved = None if halved is None else read_only(halved)
        self.cuts = None if cuts is None else Cuts(*map(read_only, cuts))
        self.outline = outline
        self.spacing = spacing_of_nodes(spacing)
        if np.shape(origin) != (2,):
            raise ValueError(f"origin must be a pair (x, y), got {origin!r}")
        self.origin = (finite_number(origin[0], "origin[0]"), finite_number(origin[1], "origin[1]"))
        for axis, first, count in zip("xy", self.origin, points.shape[::-1], strict=True):
            refuse_indistinct(first, first + self.spacing * (count - 1), self.spacing, axis)

    @classmethod
    def from_mask(
        cls,
        mask: ArrayLike,
        spacing: float,
        origin: tuple[float, float] = (0.0, 0.0),
        *,
        rows: str = "up",
        crs: str = "",
    ) -> Lattice:
        """Make a lattice from a boolean array: True = node, all else is frame (see the class).

        An xarray.DataArray, or a pandas.DataFrame with numbers for labels, tells by its coordinates where its points
        lie; ``rows`` and ``origin`` are then left aside.

        Raises
        ------
        ValueError
            If coordinates are not equally spaced by ``spacing``, or see the class.
        """
        mask = with_places(mask, "mask") if is_labelled(mask) else mask
        if is_dataarray(mask):
            mask, places = grid_of(mask, spacing, "mask")
            rows, origin = ("up", places) if places is not None else (rows, origin)
        return cls(mask, spacing, origin, rows=rows, crs=crs)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the array."""
        rows, columns = self.mask.shape
        return rows, columns

    @cached_property
    def size(self) -> int:
        """Number of nodes."""
        return self.numbering.size

    @cached_property
    def x(self) -> Vector:
        """Abscissae of the columns, shape (columns,), length."""
        return read_only(self.origin[0] + self.spacing * np.arange(self.shape[1]))

    @cached_property
    def y(self) -> Vector:
        """Ordinates of the rows, shape (rows,), ascending, length."""
        return read_only(self.origin[1] + self.spacing * np.arange(self.shape[0]))

    @cached_property
    def numbering(self) -> Numbering:
        """The nodes' order, and their places on the lattice's array."""
        return Numbering(self.mask)

    @property
    def node_x(self) -> Vector:
        """Abscissa of each node, shape (size,), length."""
        return self.numbering.to_vector(np.broadcast_to(self.x, self.shape))

    @property
    def node_y(self) -> Vector:
        """Ordinate of each node, shape (size,), length."""
        return self.numbering.to_vector(np.broadcast_to(self.y[:, None], self.shape))

    @cached_property
    def parts(self) -> int:
        """Number of connected parts (nodes joined by lattice arms)."""
        load_modules("scipy.ndimage")
        from scipy import ndimage

        return int(ndimage.label(self.mask)[1])

    def plot(self, ax: Any = None, *, title: str | None = None, units: UnitNames = "") -> Figure:
        """Draw the lattice: its nodes, the points of the frame, and which way rows and columns are counted.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes of your own to draw into; by default there is a new figure, which shows itself in a notebook.
        title : str, optional
            Headline in place of the picture's own.
        units : str, optional
            Unit of length for labels.
        """
        figure: Figure = drawn(self, Wanted(ax, None, title, units))
        return figure

    def scatter(self, vector: ArrayLike, fill: float = np.nan) -> NDArray[Any]:
        """Lay a vector in node order out on the lattice's array, with ``fill`` where there is no node.

        Parameters
        ----------
        vector : array, shape (size,)
            One value a node.
        fill : float
            Value of the other points.

        Returns
        -------
        array, shape (rows, columns)
        """
        values = np.asarray(vector)
        if values.shape != (self.size,):
            raise ValueError(f"vector must have shape ({self.size},), got {values.shape}")
        return self.numbering.to_grid(values, fill=fill)

    def gather(self, grid: ArrayLike) -> NDArray[Any]:
        """Take the nodes' values, in node order, from the lattice's array: the inverse of `scatter`."""
        values = np.asarray(grid)
        if values.shape != self.shape:
            raise ValueError(f"grid must have the lattice's shape {self.shape}, got {values.shape}")
        return self.numbering.to_vector(values)

    def ring_coordinates(self, row: NDArray[Any], column: NDArray[Any]) -> tuple[Vector, Vector]:
        """Return x and y of points by their places on the array with a ring of frame points about it (length)."""
        return self.origin[0] + self.spacing * (column - 1), self.origin[1] + self.spacing * (row - 1)

    def free_boundary(self, contact: Mask) -> NDArray[np.float64]:
        """Return the middles of the arms that join a node in contact to one that is not.

        Parameters
        ----------
        contact : array of bool, shape (size,)

        Returns
        -------
        array, shape (k, 2)
            x and y (length).
        """
        grid = self.scatter(contact.astype(np.int8), fill=-1)

        def middles(before: NDArray[Any], after: NDArray[Any], shift: tuple[float, float]) -> Vector:
            row, column = np.nonzero((before >= 0) & (after >= 0) & (before != after))
            step = self.spacing
            return np.column_stack(
                [self.origin[0] + step * (column + shift[0]), self.origin[1] + step * (row + shift[1])]
            )

        return np.concatenate(
            [middles(grid[:, :-1], grid[:, 1:], (0.5, 0.0)), middles(grid[:-1], grid[1:], (0.0, 0.5))]
        )

    def describe(self, node: int) -> str:
        """Name a node by its number and coordinates, for messages: ``node 3 (x=0.5, y=1)``."""
        column_x, row_y = self.node_x[node], self.node_y[node]
        return f"node {node} (x={column_x:g}, y={row_y:g})"

    @cached_property
    def frame_arms(self) -> FrameArms:
        """The arms that join a node to the frame."""
        return frame_arms(self.mask, self.cuts)

    @property
    def frame_places(self) -> tuple[Vector, Vector]:
        """Return x and y of the points at which the frame holds the `frame_arms` (length)."""
        rows, columns = self.frame_arms.ends
        return self.ring_coordinates(rows, columns)

    @property
    def fit(self) -> str:
        """How the frame lies to its contour, in a few words; empty where the one stands for the other."""
        if self.cuts is not None:
            return "fitted to its contour"
        return f"up to {self.overshoot:.2g} outside its contour" if self.overshoot else ""

    def __repr__(self) -> str:
        rows, columns = self.shape
        nodes = counted(self.size, "node")
        outside = f", {self.fit}" if self.fit else ""
        return f"Lattice({nodes} in {rows} x {columns}, spacing={self.spacing:g}{outside})"


def patches_on_grid(contact: Mask) -> tuple[NDArray[np.int64], int]:
    """Return to which patch each point of an array belongs that is True, from 1 on, and how many there are.

    Points side by side in a row or a column are joined.

    Examples
    --------
    >>> patches_on_grid(np.array([[True, False, True], [False, True, True]]))
    (array([[1, 0, 2],
           [0, 2, 2]]), 2)
    """
    load_modules("scipy.ndimage")
    from scipy import ndimage

    labels, count = ndimage.label(contact)
    return labels.astype(np.int64), int(count)


def checked_crs(value: object) -> str:
    """Return ``value`` if it names a coordinate reference system, or none by ``""``; a number is an EPSG code.

    Examples
    --------
    >>> checked_crs(25832), checked_crs(" EPSG:4326 "), checked_crs("")
    ('EPSG:25832', 'EPSG:4326', '')
    """
    if isinstance(value, int) and not isinstance(value, bool) and value > 0:
        return f"EPSG:{value}"
    if not isinstance(value, str):
        raise TypeError(f"crs must be text, as 'EPSG:25832' or WKT, or an EPSG code, got {value!r}")
    return value.strip()


_LEAST_SPACING, _LARGEST_SPACING = 1e-140, 1e140
"""Beyond, the area that a node stands for is no normal number in double precision."""


def spacing_of_nodes(value: object) -> float:
    """Return ``value`` as a spacing of nodes: a positive number with a square."""
    spacing = positive_number(value, "spacing")
    if not _LEAST_SPACING <= spacing <= _LARGEST_SPACING:
        raise ValueError(
            f"spacing must lie between {_LEAST_SPACING:g} and {_LARGEST_SPACING:g}, got {spacing:g}; "
            "choose another unit of length"
        )
    return spacing


def refuse_indistinct(first: float, last: float, spacing: float, axis: str) -> None:
    """Raise a ValueError, if from ``first`` to ``last`` points are so far from 0 that rounding takes the spacing."""
    farthest = max(abs(first), abs(last))
    if not np.isfinite(farthest) or spacing <= 8 * np.spacing(farthest):
        raise ValueError(
            f"spacing {spacing:g} is lost by rounding at {axis} = {farthest:g}; choose a larger spacing, "
            "or an origin nearer to 0"
        )
