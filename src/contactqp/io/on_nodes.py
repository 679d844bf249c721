"""The numbers of a data file laid on a lattice: which way rows go, where a geo-transform puts them, what is missing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..errors import CaseFileError
from ..foundation.checks import Vector
from ..foundation.loading import load_modules
from ..foundation.together import chunks
from ..geometry.fields import Rows, upwards_rows
from ..geometry.lattice_by_rows import LatticeByRows
from ..profiles.gridded import about
from .rasters import Raster

_Grid: TypeAlias = NDArray[np.float64]

_RowsRead: TypeAlias = Callable[[int, int], _Grid]
"""Returns the rows [first, last) on a lattice."""

_APART = 1e-6
"""Places nearer than this part of the spacing are the same."""


class Upright:
    """A file's numbers with y ascending from row to row and nan where there is none, read for some rows.

    Parameters
    ----------
    raster : Raster
        As the file has it.
    rows : {"up", "down"}
        Which way its rows go.
    absent : sequence of float
        What stands for no value.
    transform : bool
        Whether its places count.
    """

    def __init__(self, raster: Raster, rows: Rows, absent: Sequence[float], *, transform: bool) -> None:
        self._stored, self._down, self._absent = raster.values, rows == "down", absent
        self.shape: tuple[int, int] = (int(raster.values.shape[0]), int(raster.values.shape[1]))
        self.places, self.crs = None, ""
        if raster.places is not None and transform:
            x, y = raster.places
            self.places, self.crs = (x, y[::-1] if self._down else y), raster.crs

    def rows(self, first: int, last: int) -> _Grid:
        """Return the rows [first, last), shape (rows, columns)."""
        count = self.shape[0]
        begin, end = (count - last, count - first) if self._down else (first, last)
        stored = np.asarray(self._stored[begin:end])
        values = stored.astype(np.float64)
        for absent in self._absent:
            values[_equal(stored, absent)] = np.nan
        return upwards_rows(values, "down" if self._down else "up")

    @property
    def values(self) -> _Grid:
        """All rows."""
        return self.rows(0, self.shape[0])


def upright(raster: Raster, rows: Rows | None, no_data: float | None, *, transform: bool) -> Upright:
    """Return a file's numbers with y ascending from row to row and nan where there is none.

    Parameters
    ----------
    raster : Raster
        As the file has it.
    rows : {"up", "down"} or None
        Which way its rows go by the case; None leaves it to the file.
    no_data : float or None
        The value that stands for none by the case, beside what the file itself says.
    transform : bool
        Whether to use the file's geo-transform, if it has one.

    Raises
    ------
    CaseFileError
        If the rows go another way by the file's geo-transform.
    """
    own = rows_of(raster, rows, transform=transform)
    if raster.places is not None and transform and rows not in (None, own) and raster.places[1].size > 1:
        raise CaseFileError(
            f"rows = {rows!r}, but by its geo-transform they go {own}; leave rows out, or set transform = false"
        )
    absent = [value for value in (raster.no_data, no_data) if value is not None]
    return Upright(raster, own, absent, transform=transform)


def rows_of(raster: Raster, rows: Rows | None, *, transform: bool) -> Rows:
    """Return which way a file's rows go: by its geo-transform, by the case, or by the kind of file; see `upright`."""
    if raster.places is None or not transform:
        return rows or raster.rows
    _, y = raster.places
    return "down" if y.size > 1 and y[1] < y[0] else "up"


def _equal(stored: NDArray[np.generic], absent: float) -> NDArray[np.bool_]:
    """Return where a number is stored, which may be written with more digits than its kind holds."""
    if stored.dtype.kind == "f":
        with np.errstate(over="ignore"):
            return np.asarray(stored == stored.dtype.type(absent))
    return np.asarray(stored == absent)


class OnLattice:
    """Upright numbers laid on a lattice, row by row; nan where none is known.

    Parameters
    ----------
    upright : Upright
    lattice : LatticeByRows
    resample : bool
        Whether to interpolate bilinearly where values do not lie on the nodes.

    Raises
    ------
    CaseFileError
        If shape or places do not fit and ``resample`` is false, or a node lies outside the file's places.
    """

    def __init__(self, upright: Upright, lattice: LatticeByRows, *, resample: bool) -> None:
        self.lattice = lattice
        if upright.places is not None:
            self.rows = _by_places(upright, upright.places, lattice, resample=resample)
            return
        if lattice.shape[0] == 1 < upright.shape[0]:
            upright = Upright(Raster(upright.values.reshape(1, -1)), "up", (), transform=False)
        if upright.shape == lattice.shape:
            self.rows = upright.rows
            return
        if not resample:
            raise CaseFileError(
                f"it has shape {upright.shape}, the lattice {lattice.shape}; bring it to that shape or set resample = "
                "true"
            )
        axes = [np.linspace(0, 1, n) if n > 1 else np.array([0.5]) for n in upright.shape]
        targets = [np.linspace(0, 1, n) if n > 1 else np.array([0.5]) for n in lattice.shape]
        self.rows = _interpolated(upright, axes, targets)


def _by_places(upright: Upright, places: tuple[Vector, Vector], lattice: LatticeByRows, *, resample: bool) -> _RowsRead:
    x, y = places
    along_x, along_y = lattice.x, lattice.y
    if lattice.shape[0] == 1 and y.size == 1:  # a cable's ground has no y
        y = along_y
    room = _APART * lattice.spacing
    held_x, held_y = along_x[lattice.held.columns], along_y[lattice.held.rows]
    for name, file, nodes in (("x", x, held_x), ("y", y, held_y)):
        if nodes[0] < file[0] - room or nodes[-1] > file[-1] + room:
            raise CaseFileError(
                f"its geo-transform puts its values from {name} = {file[0]:g} to {file[-1]:g}, but nodes lie from "
                f"{nodes[0]:g} to {nodes[-1]:g}; place the frame there, or set transform = false to lay the "
                "values on the lattice row by row"
            )
    on_places = all(
        (np.abs(file[_nearest(file, nodes)] - nodes) <= room).all() for file, nodes in ((y, held_y), (x, held_x))
    )
    if on_places:
        rows, columns = _nearest(y, along_y), _nearest(x, along_x)

        def chosen(first: int, last: int) -> _Grid:
            if first == last:
                return np.empty((0, columns.size))
            begin, end = int(rows[first]), int(rows[last - 1]) + 1
            return upright.rows(begin, end)[np.ix_(rows[first:last] - begin, columns)]

        return chosen
    if not resample:
        raise CaseFileError(
            "by its geo-transform its values lie between the nodes; choose spacing and origin as in the file, "
            "or set resample = true"
        )
    return _interpolated(upright, [y, x], [np.clip(along_y, y[0], y[-1]), np.clip(along_x, x[0], x[-1])])


def _nearest(file: Vector, nodes: Vector) -> NDArray[np.intp]:
    if file.size == 1:
        return np.zeros(nodes.size, dtype=np.intp)
    place = np.round((nodes - file[0]) / (file[-1] - file[0]) * (file.size - 1))
    return np.asarray(np.clip(place, 0, file.size - 1).astype(np.intp))


def _interpolated(upright: Upright, axes: list[Vector], targets: list[Vector]) -> _RowsRead:
    """Return what interpolates bilinearly; what takes a share of a missing value is missing."""
    load_modules("scipy.interpolate")
    from scipy.interpolate import RegularGridInterpolator

    repeats = [2 if axis.size == 1 else 1 for axis in axes]
    axes = [
        np.array([along.min() - 1, along.max() + 1]) if axis.size == 1 else axis
        for axis, along in zip(axes, targets, strict=True)
    ]

    def part(first: int, last: int) -> _Grid:
        """Return some rows from the file's rows that they lie between, and one more on either side."""
        along = targets[0][first:last]
        near = about(axes[0], float(along[0]), float(along[-1]))
        values = upright.rows(*((0, 1) if repeats[0] > 1 else (near.start, near.stop)))
        values = values.repeat(repeats[0], axis=0).repeat(repeats[1], axis=1)
        points = np.stack(np.meshgrid(along, targets[1], indexing="ij"), axis=-1)
        known, places = np.isfinite(values), (axes[0][near], axes[1])
        found = np.asarray(RegularGridInterpolator(places, np.where(known, values, 0.0))(points))
        if not known.all():
            share = RegularGridInterpolator(places, known.astype(np.float64))(points)
            found[share < 1 - 1e-12] = np.nan
        return found

    def rows(first: int, last: int) -> _Grid:
        found = np.empty((last - first, targets[1].size))
        for begin, end in chunks(first, last, targets[1].size):
            found[begin - first : end - first] = part(begin, end)
        return found

    return rows


class FieldOfFile:
    """Numbers of a file on a lattice, ``offset + factor * value``, read by ``field[first:last]``.

    Parameters
    ----------
    numbers : OnLattice
    factor, offset : float
    absent : float or None
        What stands where no value is known; None where a node without one is no input.
    told : str
        What messages begin with.

    Attributes
    ----------
    shape : (int, int)
        That of the lattice.
    """

    ndim = 2

    def __init__(
        self,
        numbers: OnLattice,
        *,
        factor: float = 1.0,
        offset: float = 0.0,
        absent: float | None = None,
        told: str = "",
    ) -> None:
        self.shape = numbers.lattice.shape
        self._numbers, self._factor, self._offset = numbers, factor, offset
        self._absent, self._told = absent, told

    def __getitem__(self, rows: slice) -> _Grid:
        """Return some rows.

        Raises
        ------
        CaseFileError
            If a node has no value and there is nothing that stands for it.
        """
        first, last, _ = rows.indices(self.shape[0])
        grid = self._offset + self._factor * self._numbers.rows(first, last)
        missing = np.isnan(grid)
        if not missing.any():
            return grid
        if self._absent is None:
            lost = np.argwhere(missing & self._numbers.lattice[first:last])
            if lost.size:
                row, column = map(int, lost[0])
                more = f" and {len(lost) - 1} more" if len(lost) > 1 else ""
                raise CaseFileError(
                    f"{self._told}it holds no value at {self._numbers.lattice.describe(first + row, column)}{more}; "
                    'fill it, leave the node out of the frame, or, for a support, set missing = "none": there is no '
                    "support then"
                )
        return np.where(missing, 0.0 if self._absent is None else self._absent, grid)
