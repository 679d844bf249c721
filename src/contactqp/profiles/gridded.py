"""Gridded: a surface known on a rectangular grid, such as a terrain model, interpolated between its points."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..foundation.checks import Vector, one_of, read_only, real_array, refuse_non_finite
from ..foundation.loading import load_modules
from .analytic import Profile
from .choices import OUTSIDE, REACH, Outside


class Gridded(Profile):
    """A surface through heights on a rectangular grid, bilinear between them.

    It may stand for a support, and for a load or a frame's height as well, in whichever unit its numbers are.

    Parameters
    ----------
    x : array, shape (columns,)
        Abscissae of the columns, increasing or decreasing, length.
    y : array, shape (rows,)
        Ordinates of the rows, increasing or decreasing, length.
    depth : array, shape (rows, columns)
        Heights there, positive downwards, length; nan where none is known.
    outside : {"error", "hold", "none"}
        Beyond the grid, and where none is known: refuse, continue with the value at the edge (where none is known,
        refuse all the same), or no support.
    upwards : bool
        Whether the heights given are elevations, positive upwards; the profile itself returns depths all the same.

    Raises
    ------
    TypeError, ValueError
        If there are fewer than two columns or rows, coordinates are not in order, or the shapes do not fit.

    Examples
    --------
    >>> surface = Gridded([0.0, 1.0], [0.0, 2.0], [[1.0, 2.0], [3.0, 4.0]])
    >>> surface
    Gridded(2 x 2, x from 0 to 1, y from 0 to 2)
    >>> surface(0.5, [0.0, 1.0])
    array([1.5, 2.5])
    >>> surface(3.0, 0.0)
    Traceback (most recent call last):
    ...
    ValueError: x = 3 lies outside the grid, which goes from 0 to 1; say outside="hold" or outside="none"
    """

    def __init__(
        self, x: ArrayLike, y: ArrayLike, depth: ArrayLike, *, outside: Outside = "error", upwards: bool = False
    ) -> None:
        columns, rows, values = real_array(x, "x"), real_array(y, "y"), real_array(depth, "depth")
        if values.shape != (rows.size, columns.size) or rows.ndim != 1 or columns.ndim != 1:
            raise ValueError(
                f"depth must have a row for each y and a column for each x, shape ({rows.size}, {columns.size}), "
                f"got {values.shape}"
            )
        self._lie_at(columns, rows, outside)
        values = values[:: 1 if rows[0] < rows[-1] else -1, :: 1 if columns[0] < columns[-1] else -1]
        self.depth: Vector = read_only(np.array(-values if upwards else values))

    def _lie_at(self, columns: Vector, rows: Vector, outside: Outside) -> None:
        """Take the places of columns and rows, and what holds outside of them."""
        for name, places in (("x", columns), ("y", rows)):
            refuse_non_finite(places, name)
            steps = np.diff(places)
            if places.size < 2 or not ((steps > 0).all() or (steps < 0).all()):
                raise ValueError(f"{name} must hold two places or more, in order, each once")
        self.x, self.y = (
            read_only(places if places[0] < places[-1] else places[::-1].copy()) for places in (columns, rows)
        )
        self.outside = one_of(outside, OUTSIDE, "outside")

    @classmethod
    def of(cls, array: Any, *, outside: Outside = "error", upwards: bool = False) -> Gridded:
        """Return the surface of an xarray.DataArray along y and x, with coordinates; others of one entry are left out.

        Parameters
        ----------
        array : xarray.DataArray
        outside, upwards
            See the class.

        Examples
        --------
        >>> import xarray as xr
        >>> ground = xr.DataArray([[5.0, 6.0], [7.0, 8.0]], {"y": [2.0, 0.0], "x": [0.0, 1.0]}, ("y", "x"))
        >>> Gridded.of(ground)(0.0, [0.0, 1.0, 2.0])
        array([7., 6., 5.])
        """
        grid = in_plan(array)
        return cls(grid["x"].to_numpy(), grid["y"].to_numpy(), grid.to_numpy(), outside=outside, upwards=upwards)

    def __call__(self, x: ArrayLike, y: ArrayLike = 0.0) -> NDArray[np.float64]:
        """Return the depths at places; see `Profile`."""
        load_modules("scipy.interpolate")
        from scipy.interpolate import RegularGridInterpolator

        along = [np.asarray(each, dtype=np.float64) for each in np.broadcast_arrays(y, x)]
        beyond = np.zeros(along[0].shape, dtype=np.bool_)
        for k, (name, places) in enumerate((("y", self.y), ("x", self.x))):
            room = REACH * (places[-1] - places[0])
            out = (along[k] < places[0] - room) | (along[k] > places[-1] + room)
            if out.any() and self.outside == "error":
                raise ValueError(
                    f"{name} = {along[k][out].flat[0]:g} lies outside the grid, which goes from {places[0]:g} to "
                    f'{places[-1]:g}; say outside="hold" or outside="none"'
                )
            beyond |= out
            along[k] = np.clip(along[k], places[0], places[-1])
        if not beyond.size:
            return np.empty(beyond.shape)
        rows, columns = (
            about(places, float(np.fmin.reduce(each, axis=None)), float(np.fmax.reduce(each, axis=None)))
            for places, each in zip((self.y, self.x), along, strict=True)
        )
        depth = self.heights(rows, columns)
        known = np.isfinite(depth)
        points = np.stack(along, axis=-1)

        def interpolated(values: NDArray[np.float64]) -> NDArray[np.float64]:
            found = RegularGridInterpolator((self.y[rows], self.x[columns]), values)(points)
            return np.asarray(found).reshape(beyond.shape)

        found = interpolated(np.where(known, depth, 0.0))
        if not known.all():
            lost = interpolated(known.astype(np.float64)) < 1 - 1e-12
            if lost.any() and self.outside != "none":
                place = np.flatnonzero(lost.ravel())[0]
                raise ValueError(
                    f"no height is known at x = {along[1].flat[place]:g}, y = {along[0].flat[place]:g}; fill the grid, "
                    'or say outside="none"'
                )
            beyond |= lost
        return np.asarray(np.where(beyond, np.inf, found) if self.outside == "none" else found)

    def heights(self, rows: slice, columns: slice) -> NDArray[np.float64]:
        """Return the depths in some rows and columns, which is all that an evaluation near them asks for."""
        return self.depth[rows, columns]

    def __repr__(self) -> str:
        x, y = self.x, self.y
        return f"Gridded({y.size} x {x.size}, x from {x[0]:g} to {x[-1]:g}, y from {y[0]:g} to {y[-1]:g})"


def in_plan(array: Any) -> Any:
    """Return an xarray.DataArray along y and x, with coordinates; others of one entry are left out.

    Raises
    ------
    TypeError, ValueError
        If it is none, or lies along others.
    """
    if not (hasattr(array, "dims") and hasattr(array, "coords")):
        raise TypeError(f"array must be an xarray.DataArray, got {type(array).__name__}; else say Gridded(x, y, z)")
    array = array.squeeze([dim for dim in array.dims if dim not in ("x", "y") and array.sizes[dim] == 1], drop=True)
    if set(array.dims) != {"x", "y"} or not {"x", "y"} <= set(array.coords):
        raise ValueError(f"array must lie along y and x, with coordinates, got the dims {array.dims}")
    return array.transpose("y", "x")


def about(places: Vector, low: float, high: float) -> slice:
    """Return which of some ascending places are needed to interpolate between two values, and one more on either side.

    Examples
    --------
    >>> about(np.arange(10.0), 4.0, 5.5)
    slice(3, 8, None)
    """
    begin = max(0, int(np.searchsorted(places, low, "right")) - 2)
    return slice(begin, min(places.size, int(np.searchsorted(places, high, "left")) + 2))
