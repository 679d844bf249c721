"""Fields on the arms between the points of a lattice, such as a tension that varies from place to place."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector, positive_number, read_only, real_array
from .fields import Rows, evaluated, is_function, on_lattice, sample, upwards_rows
from .labelled import is_dataarray, is_labelled
from .lattice import Lattice
from .numbering import Grid

_AXES = {"x": 1, "y": 0}
"""The axis of a lattice's array along which arms go."""


class ArmField(NamedTuple):
    """A quantity > 0 on the arms along x or along y.

    Attributes
    ----------
    arms : float or array, shape (rows, columns + 1) along x, (rows + 1, columns) along y
        Its value on each arm; a number where all are equal. Arms that no node is at an end of have the mean.
    nodes : float or array, shape (size,)
        Its value at each node; a number where all values are equal.
    """

    arms: float | Grid
    nodes: float | Vector

    def times(self, factor: float) -> ArmField:
        """Return the field with all values ``factor`` times as large."""
        arms, nodes = (read_only(np.asarray(part * factor)) for part in self)
        return ArmField(*(float(part) if part.ndim == 0 else part for part in (arms, nodes)))


def on_arms(lattice: Lattice, field: Any, name: str, along: str, rows: Rows = "up") -> ArmField:
    """Return the values of a field > 0 on the arms of a lattice along ``"x"`` or along ``"y"``.

    An arm has the harmonic mean of the values at its two ends, which is exact where the field jumps midway, as for two
    springs in series; or, of a function, the value in its middle.

    Parameters
    ----------
    lattice : Lattice
    field : number, array, xarray.DataArray or function of (x, y)
        An array has the lattice's shape, frame points included; or that with a ring of frame points about it, (rows +
        2, columns + 2), on a cable (nodes + 2,) with both ends; or it is a vector in node order. Where it has no frame
        point, or that one is nan, an arm to the frame has the value of its node.
    name : str
        The argument's name, for messages.
    along : {"x", "y"}
    rows : {"up", "down"}
        See `contactqp.geometry.fields.sample`.

    Raises
    ------
    TypeError, ValueError
        If values have the wrong kind or shape, or are not finite and > 0.

    Examples
    --------
    >>> lattice = Lattice.from_mask([[True, True]], spacing=1.0)
    >>> on_arms(lattice, [1.0, 3.0], "tension", "x").arms
    array([[1. , 1.5, 3. ]])
    >>> on_arms(lattice, lambda x, y: 2 + x, "tension", "x").arms
    array([[1.5, 2.5, 3.5]])
    """
    if is_dataarray(field) and not field.ndim:
        field = field.item()
    if not is_function(field) and not is_dataarray(field) and np.ndim(field) == 0:
        number = positive_number(field, name)
        return ArmField(number, number)
    axis = _AXES[along]
    used = _joined(lattice, axis)
    if is_function(field):
        arms = _in_the_middle(lattice, field, name, used, axis)
        x, y = lattice.node_x, lattice.node_y
        nodes = np.array(np.broadcast_to(evaluated(field, x, y, name), x.shape))
        _refuse(nodes, name, lambda node: f"at {lattice.describe(node)}")
    else:
        grid = _with_ring(lattice, field, name, rows, used, axis)
        nodes = lattice.gather(grid[1:-1, 1:-1])
        arms = np.where(used, harmonic_mean(*_ends(grid, axis)), 0.0)
    chosen = arms[used]
    arms[~used] = chosen.mean()
    return ArmField(_one_if_equal(arms, chosen), _one_if_equal(nodes, nodes))


def at_points_of_line(lattice: Lattice, field: Any, name: str) -> float | Vector:
    """Return the values of a field > 0 at the nodes of a row and at both ends of it, the number that all have if so.

    Parameters
    ----------
    lattice : Lattice
        One row of nodes.
    field, name
        As for `on_arms`; where an array has no values for the ends, they have those of the nodes beside them.

    Returns
    -------
    float or array, shape (nodes + 2,)

    Examples
    --------
    >>> row = Lattice.from_mask([[True, True]], spacing=1.0)
    >>> at_points_of_line(row, [1.0, 3.0], "bending_stiffness")
    array([1., 1., 3., 3.])
    >>> at_points_of_line(row, lambda x, y: 2 + x, "bending_stiffness")
    array([1., 2., 3., 4.])
    """
    if is_dataarray(field) and not field.ndim:
        field = field.item()
    if is_function(field):
        column = np.arange(lattice.size + 2)
        x, y = lattice.ring_coordinates(np.ones_like(column), column)
        values = np.array(np.broadcast_to(evaluated(field, x, y, name), x.shape))
        _refuse(values, name, lambda point: f"at x={x[point]:g}")
    elif is_dataarray(field) or np.ndim(field):
        values = _with_ring(lattice, field, name, "up", _joined(lattice, _AXES["x"]), _AXES["x"])[1]
        values[[0, -1]] = np.where(np.isnan(values[[0, -1]]), values[[1, -2]], values[[0, -1]])
    else:
        return positive_number(field, name)
    return _one_if_equal(values, values)


def _one_if_equal(values: NDArray[np.float64], chosen: Vector) -> float | NDArray[np.float64]:
    return float(chosen[0]) if (chosen == chosen[0]).all() else read_only(values)


def _ends(grid: NDArray[Any], axis: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return what a grid with a ring has at the first and at the second end of each arm."""
    return (grid[1:-1, :-1], grid[1:-1, 1:]) if axis == 1 else (grid[:-1, 1:-1], grid[1:, 1:-1])


def _joined(lattice: Lattice, axis: int) -> Mask:
    """Return which arms have a node at one end or both."""
    return np.asarray(np.logical_or(*_ends(np.pad(lattice.mask, 1), axis)))


def harmonic_mean(first: Grid, second: Grid) -> Grid:
    """Return the harmonic mean of two numbers, of a number and nan the number; either way round the same."""
    first, second = np.where(np.isnan(first), second, first), np.where(np.isnan(second), first, second)
    less, more = np.minimum(first, second), np.maximum(first, second)
    with np.errstate(invalid="ignore"):
        return np.asarray(2 * less * (more / (less + more)))


def _in_the_middle(lattice: Lattice, function: Any, name: str, used: Mask, axis: int) -> Grid:
    row, column = np.nonzero(used)
    half = 0.5 * lattice.spacing
    # The first arm of a row begins on the ring.
    x, y = lattice.ring_coordinates(row + (axis == 1), column + (axis == 0))
    x, y = (x + half, y) if axis == 1 else (x, y + half)
    values = np.array(np.broadcast_to(evaluated(function, x, y, name), x.shape))
    _refuse(values, name, lambda arm: f"in the middle of an arm (x={x[arm]:g}, y={y[arm]:g})")
    arms = np.zeros(used.shape)
    arms[used] = values
    return arms


def _with_ring(lattice: Lattice, field: Any, name: str, rows: Rows, used: Mask, axis: int) -> Grid:
    """Return values at nodes and frame points on the array with a ring, nan where none is known."""
    count, columns = lattice.shape
    grid = np.full((count + 2, columns + 2), np.nan)
    inner = grid[1:-1, 1:-1]
    if is_dataarray(field) and field.dims != ("node",):
        inner[...] = on_lattice(lattice, field, name, rows)
    elif is_labelled(field):
        inner[lattice.mask] = sample(lattice, field, name, rows=rows)  # by node
    else:
        if np.ma.is_masked(field):
            field = np.ma.filled(np.ma.asarray(field, dtype=np.float64), np.nan)
        values = real_array(field, name)
        if values.shape == lattice.shape:
            inner[...] = upwards_rows(values, rows)
        elif values.shape == grid.shape:
            grid[...] = upwards_rows(values, rows)
        elif count == 1 and values.shape == (columns + 2,):
            grid[1] = values
        elif values.shape == (lattice.size,):
            inner[lattice.mask] = values
        else:
            raise ValueError(
                f"{name} must be a number, an array of the lattice's shape {lattice.shape} or with a ring of frame "
                f"points {grid.shape}, or a vector of its {lattice.size} nodes, got shape {values.shape}"
            )
    nodes = np.pad(lattice.mask, 1)
    _refuse(grid[nodes], name, lambda node: f"at {lattice.describe(node)}")
    first, second = _ends(nodes, axis)
    joined = np.zeros(grid.shape, dtype=np.bool_)
    ends = _ends(joined, axis)
    ends[0][...] |= used & ~first
    ends[1][...] |= used & ~second
    frame = joined & ~np.isnan(grid)
    places = np.argwhere(frame)

    def describe(k: int) -> str:
        x, y = lattice.ring_coordinates(*places[k])
        return f"at the frame point (x={x:g}, y={y:g}), where nan leaves it to the node beside it"

    _refuse(grid[frame], name, describe)
    grid[~frame & ~nodes] = np.nan
    return grid


def _refuse(values: Vector, name: str, describe: Any) -> None:
    good = np.isfinite(values) & (values > 0)
    if not good.all():
        worst = int(np.argmin(good))
        raise ValueError(f"{name} must be finite and > 0, but is {values[worst]:g} {describe(worst)}")
