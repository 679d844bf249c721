"""Fields: the ways in which a load, a support or a frame height may be given."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..foundation.checks import Mask, Vector, finite_number, real_array
from .lattice import Lattice

Field: TypeAlias = ArrayLike | Callable[[NDArray[np.float64], NDArray[np.float64]], ArrayLike]
"""A number, an array on the lattice's shape, a vector in node order, an xarray.DataArray, or a function of (x, y)."""


def sample(lattice: Lattice, field: Any, name: str, *, allow_inf: bool = False) -> Vector:
    """Return the values of a field at the nodes.

    Parameters
    ----------
    lattice : Lattice
    field : number, array, xarray.DataArray or function of (x, y)
        An array has the lattice's shape, or is a vector in node order. A DataArray has dims y and x (or x alone
        on a cable) and, where it carries coordinates, holds the lattice's points. A function
        gets the nodes' coordinates as two vectors and returns a vector or a number.
    name : str
        The argument's name, for messages.
    allow_inf : bool
        Whether +inf is a value (a support that is not there).

    Returns
    -------
    array, shape (size,)

    Raises
    ------
    TypeError
        If the values are complex or not numeric.
    ValueError
        If the shape does not fit, or a node's value is nan or not finite.
    """
    if is_function(field):
        values = evaluated(field, lattice.node_x, lattice.node_y, name)
    elif is_dataarray(field) and field.ndim:
        values = lattice.gather(on_lattice(lattice, field, name))
    else:
        values = real_array(field, name)
        if values.shape == lattice.shape:
            values = lattice.gather(values)
        elif values.shape not in ((), (lattice.size,)):
            raise ValueError(
                f"{name} must be a number, an array of the lattice's shape {lattice.shape} or a vector of its "
                f"{lattice.size} nodes, got shape {values.shape}"
            )
    return checked(values, lattice.size, name, lattice.describe, allow_inf=allow_inf)


def evaluated(function: Any, x: Vector, y: Vector, name: str) -> NDArray[np.float64]:
    """Return what a function of (x, y) returns for points: a vector of their values, or a number."""
    values = real_array(function(x, y), f"{name}(x, y)")
    if values.shape not in ((), x.shape):
        raise ValueError(
            f"{name}(x, y) must return a number or shape {x.shape} for the {x.size} points, got {values.shape}"
        )
    return values


def checked(
    values: NDArray[np.float64], size: int, name: str, describe: Callable[[int], str], *, allow_inf: bool = False
) -> Vector:
    """Return a number or a vector as a vector of finite values, a number repeated; with ``allow_inf`` +inf is one."""
    vector = np.broadcast_to(values, (size,))
    good = np.isfinite(vector) | (vector == np.inf) if allow_inf else np.isfinite(vector)
    if not good.all():
        worst = int(np.argmin(good))
        wanted = "finite or +inf (no support)" if allow_inf else "finite"
        raise ValueError(f"{name} must be {wanted}, but is {vector[worst]} at {describe(worst)}")
    return vector


def is_function(field: Any) -> bool:
    """Whether a field is given as a function of (x, y)."""
    return callable(field) and not is_dataarray(field)


def is_dataarray(value: Any) -> bool:
    """Whether ``value`` is an xarray.DataArray, found out without importing xarray."""
    return hasattr(value, "dims") and hasattr(value, "coords")


def on_lattice(lattice: Lattice, field: Any, name: str) -> NDArray[np.float64]:
    """Return a DataArray's values on the lattice's shape."""
    wanted = ("y", "x")
    if field.dims == ("x",) and lattice.shape[0] == 1:
        field = field.expand_dims("y")
    if set(field.dims) != set(wanted):
        raise ValueError(f"{name} must have the dims ('y', 'x'), got {field.dims}")
    field = field.transpose(*wanted)
    for dim, points in (("y", lattice.y), ("x", lattice.x)):
        if dim in field.coords:
            if np.unique(field[dim].values).size != field.sizes[dim]:
                raise ValueError(f"{name} has repeated coordinates along {dim}")
            try:
                field = field.sortby(dim).sel({dim: points}, method="nearest", tolerance=1e-6 * lattice.spacing)
            except (TypeError, ValueError) as error:
                raise ValueError(f"{name} cannot be aligned with the lattice along {dim}: {error}") from None
            except KeyError:
                raise ValueError(
                    f"{name} does not cover the lattice: its {dim} must hold {points[0]:g}, ..., {points[-1]:g} "
                    f"({points.size} values, spacing {lattice.spacing:g})"
                ) from None
    values = real_array(field.values, name)
    if values.shape != lattice.shape:
        raise ValueError(f"{name} must have the lattice's shape {lattice.shape}, got {values.shape}")
    return values


def frame_heights(lattice: Lattice, needed: Mask, value: Any) -> Vector | None:
    """Return the frame's ordinates on the lattice's array with a ring about it, or None if they are zero.

    Parameters
    ----------
    lattice : Lattice
    needed : array of bool, shape (rows + 2, columns + 2)
        The frame points that an arm joins to a node.
    value : number, array, xarray.DataArray or function of (x, y)
        Ordinates of the frame, positive downwards (length).
    """
    if not is_function(value) and not is_dataarray(value) and np.ndim(value) == 0:
        value = finite_number(value, "frame_height")
        if value == 0:
            return None
    rows, columns = lattice.shape
    padded = np.zeros((rows + 2, columns + 2))
    if is_dataarray(value):
        value = on_lattice(lattice, value, "frame_height")
    if callable(value):
        row, column = np.nonzero(needed)
        padded[needed] = evaluated(value, *lattice.ring_coordinates(row, column), "frame_height")
    elif np.ndim(value) == 0:
        padded[needed] = value
    else:
        grid = real_array(value, "frame_height")
        if grid.shape != lattice.shape:
            raise ValueError(
                f"frame_height must be a number, a function or have shape {lattice.shape}, got {grid.shape}"
            )
        inner = needed[1:-1, 1:-1]
        if inner.sum() != needed.sum():
            raise ValueError(
                "frame_height as an array cannot reach frame points outside the lattice's array; "
                "pass a function of (x, y)"
            )
        padded[1:-1, 1:-1][inner] = grid[inner]
    if not np.isfinite(padded).all():
        raise ValueError("frame_height must be finite at every frame point that a node is joined to")
    return padded
