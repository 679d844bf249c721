"""The numbers of a data file laid on a lattice: which way rows go, where a geo-transform puts them, what is missing."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..errors import CaseFileError
from ..foundation.checks import Vector
from ..foundation.loading import load_modules
from ..geometry.fields import Rows, upwards_rows
from ..geometry.lattice import Lattice
from .rasters import Raster

_Grid = NDArray[np.float64]

_APART = 1e-6
"""Places nearer than this part of the spacing are the same."""


def upright(raster: Raster, rows: Rows | None, no_data: float | None, *, transform: bool) -> Raster:
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
    values = raster.values.astype(np.float64)
    for absent in (raster.no_data, no_data):
        if absent is not None:
            values[_equal(raster.values, absent)] = np.nan
    if raster.places is None or not transform:
        return Raster(upwards_rows(values, rows_of(raster, rows, transform=transform)))
    x, y = raster.places
    own = rows_of(raster, rows, transform=transform)
    if rows not in (None, own) and y.size > 1:
        raise CaseFileError(
            f"rows = {rows!r}, but by its geo-transform they go {own}; leave rows out, or set transform = false"
        )
    return Raster(upwards_rows(values, own), places=(x, y[::-1] if own == "down" else y), crs=raster.crs)


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


def on_lattice(raster: Raster, lattice: Lattice, *, resample: bool) -> _Grid:
    """Return upright numbers on the lattice's array, nan where none is known.

    Raises
    ------
    CaseFileError
        If shape or places do not fit and ``resample`` is false, or a node lies outside the file's places.
    """
    if raster.places is not None:
        return _by_places(raster.values, raster.places, lattice, resample=resample)
    values = raster.values.reshape(1, -1) if lattice.shape[0] == 1 else raster.values
    if values.shape == lattice.shape:
        return values
    if not resample:
        raise CaseFileError(
            f"it has shape {values.shape}, the lattice {lattice.shape}; bring it to that shape or set resample = true"
        )
    axes = [np.linspace(0, 1, n) if n > 1 else np.array([0.5]) for n in values.shape]
    targets = [np.linspace(0, 1, n) if n > 1 else np.array([0.5]) for n in lattice.shape]
    return _interpolated(values, axes, targets)


def _by_places(values: _Grid, places: tuple[Vector, Vector], lattice: Lattice, *, resample: bool) -> _Grid:
    x, y = places
    along_x, along_y = lattice.x, lattice.y
    if lattice.shape[0] == 1 and y.size == 1:  # a cable's ground has no y
        y = along_y
    for name, file, nodes in (("x", x, lattice.node_x), ("y", y, lattice.node_y)):
        room = _APART * lattice.spacing
        if nodes.min() < file[0] - room or nodes.max() > file[-1] + room:
            raise CaseFileError(
                f"its geo-transform puts its values from {name} = {file[0]:g} to {file[-1]:g}, but nodes lie from "
                f"{nodes.min():g} to {nodes.max():g}; place the frame there, or set transform = false to lay the "
                "values on the lattice row by row"
            )
    nearest = [_nearest(file, nodes) for file, nodes in ((y, along_y), (x, along_x))]
    on_places = all(
        (np.abs(file[at] - nodes) <= _APART * lattice.spacing)[inner].all()
        for file, nodes, at, inner in (
            (y, along_y, nearest[0], lattice.mask.any(axis=1)),
            (x, along_x, nearest[1], lattice.mask.any(axis=0)),
        )
    )
    if on_places:
        return values[np.ix_(*nearest)]
    if not resample:
        raise CaseFileError(
            "by its geo-transform its values lie between the nodes; choose spacing and origin as in the file, "
            "or set resample = true"
        )
    return _interpolated(values, [y, x], [np.clip(along_y, y[0], y[-1]), np.clip(along_x, x[0], x[-1])])


def _nearest(file: Vector, nodes: Vector) -> NDArray[np.intp]:
    if file.size == 1:
        return np.zeros(nodes.size, dtype=np.intp)
    place = np.round((nodes - file[0]) / (file[-1] - file[0]) * (file.size - 1))
    return np.asarray(np.clip(place, 0, file.size - 1).astype(np.intp))


def _interpolated(values: _Grid, axes: list[Vector], targets: list[Vector]) -> _Grid:
    """Interpolate bilinearly; what takes a share of a missing value is missing."""
    load_modules("scipy.interpolate")
    from scipy.interpolate import RegularGridInterpolator

    for axis in (0, 1):
        if axes[axis].size == 1:
            axes[axis] = np.array([targets[axis].min() - 1, targets[axis].max() + 1])
            values = np.repeat(values, 2, axis=axis)
    points = np.stack(np.meshgrid(*targets, indexing="ij"), axis=-1)
    known = np.isfinite(values)
    found = np.asarray(RegularGridInterpolator(axes, np.where(known, values, 0.0))(points))
    if not known.all():
        share = RegularGridInterpolator(axes, known.astype(np.float64))(points)
        found[share < 1 - 1e-12] = np.nan
    return found


def without_missing(grid: _Grid, lattice: Lattice, absent: float | None, describe: Callable[[int], str]) -> _Grid:
    """Return numbers on the lattice's array with ``absent`` where none is known.

    Parameters
    ----------
    grid : array, shape (rows, columns)
    lattice : Lattice
    absent : float or None
        None where a missing value is no input.
    describe : callable
        Names a node by its number.

    Raises
    ------
    CaseFileError
        If a node has no value and ``absent`` is None.
    """
    missing = np.isnan(grid)
    if not missing.any():
        return grid
    at_nodes = np.flatnonzero(lattice.gather(missing))
    if at_nodes.size and absent is None:
        more = f" and {at_nodes.size - 1} more" if at_nodes.size > 1 else ""
        raise CaseFileError(
            f"it holds no value at {describe(int(at_nodes[0]))}{more}; fill it, leave the node out of the frame, or, "
            'for a support, set missing = "none": there is no support then'
        )
    return np.where(missing, 0.0 if absent is None else absent, grid)
