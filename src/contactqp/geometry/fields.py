"""Fields: the ways in which a load, a support or a frame height may be given."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, NamedTuple, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..foundation.checks import Mask, Vector, finite_number, one_of, real_array
from ..foundation.loading import load_modules
from ..foundation.surfaces import Ranged
from ..foundation.threads import Team
from .labelled import APART, Places, is_dataarray, is_labelled, with_places
from .lattice import Lattice
from .numbering import Grid, Numbering

FieldLike: TypeAlias = ArrayLike | Callable[[NDArray[np.float64], NDArray[np.float64]], ArrayLike]
"""A number, an array on the lattice's shape, a vector in node order, an xarray.DataArray, or a function of (x, y)."""

Rows: TypeAlias = Literal["up", "down"]
"""Which way y goes from row to row of an array: up, the first row is that of the smallest y; down, of the largest."""


def checked_rows(value: object) -> Rows:
    """Return ``value`` if it tells which way the rows of an array go."""
    return cast("Rows", one_of(value, ("up", "down"), "rows"))


def upwards_rows(grid: NDArray[Any], rows: Rows) -> NDArray[Any]:
    """Return a two-dimensional array with y ascending from row to row.

    Examples
    --------
    >>> upwards_rows(np.array([[1, 2], [3, 4]]), "down")
    array([[3, 4],
           [1, 2]])
    """
    return grid[::-1] if rows == "down" else grid


def in_rows(field: Any, name: str, given: Rows | None, own: Rows) -> Any:
    """Return an array of a lattice's shape with its rows as a model counts them, and everything else as it is.

    Parameters
    ----------
    field : number, array, xarray.DataArray or function of (x, y)
    name : str
        The argument's name, for messages.
    given : {"up", "down"} or None
        Which way the array's rows go, if that was said. A vector, and a DataArray with coordinates, do not ask for it.
    own : {"up", "down"}
        Which way they go in the arrays that the model was made from.

    Raises
    ------
    ValueError
        If an array does not tell which way its rows go, although those of the model go down: what comes out of a model
        goes up, so that either may be meant.

    Examples
    --------
    >>> in_rows(np.array([[1, 2], [3, 4]]), "gap", "up", "down")
    array([[3, 4],
           [1, 2]])
    >>> in_rows([[1, 2], [3, 4]], "gap", None, "up")
    [[1, 2], [3, 4]]
    """
    if given is not None:
        given = checked_rows(given)
    if not _has_rows(field):
        return field
    if given is None and own == "down":
        raise ValueError(
            f'{name} is an array without coordinates, and the model was made from arrays with rows="down" while what '
            'comes out of it goes up: say rows="down" if its first row has the largest y, rows="up" if the smallest, '
            "or hand over a DataArray with coordinates"
        )
    if given in (None, own):
        return field
    return field.isel(y=slice(None, None, -1)) if is_dataarray(field) else field[::-1]


def _has_rows(field: Any) -> bool:
    """Whether a field is an array of several rows that does not tell their y."""
    if is_dataarray(field):
        return "y" in field.dims and field.sizes["y"] > 1 and "y" not in field.coords
    try:
        return not callable(field) and np.ndim(field) == 2 and len(field) > 1
    except ValueError:  # of rows of several lengths, which are refused where values are read
        return False


def values_at(
    field: Any,
    name: str,
    of_function: Callable[[Any], NDArray[np.float64]],
    entries: Callable[[Any], NDArray[np.float64]],
    describe: Callable[[int], str],
    size: int,
    *,
    allow_inf: bool = False,
    absent: float = np.inf,
) -> Vector:
    """Return the values of a field at points, however the field is given.

    Parameters
    ----------
    field : number, array, xarray.DataArray or function of (x, y)
        A function gets the points' coordinates as two vectors and returns a vector or a number.
    name : str
        The argument's name, for messages.
    of_function : callable
        Returns from a function what `evaluated` does.
    entries : callable
        Returns from a field that is no function the number, or the points' values, shape (size,).
    describe : callable
        Names a point by its number among the points, for messages.
    size : int
        Number of points.
    allow_inf : bool
        Whether ``absent`` is a value (a support that is not there).
    absent : float
        Of a support inf where heights are positive downwards, -inf where they are positive upwards; of a ceiling the
        other way round.

    Returns
    -------
    array, shape (size,)
        A number is repeated without taking memory.

    Raises
    ------
    TypeError
        If the values are complex or not numeric.
    ValueError
        If the shape does not fit, or a value is nan or not finite.
    """
    values = of_function(field) if is_function(field) else entries(field)
    vector = np.broadcast_to(values, (size,))
    good = np.isfinite(vector) | (vector == absent) if allow_inf else np.isfinite(vector)
    if not good.all():
        worst = int(np.argmin(good))
        what = "ceiling" if name == "ceiling" else "support"
        wanted = f"finite or {absent:+} (no {what})" if allow_inf else "finite"
        raise ValueError(f"{name} must be {wanted}, but is {vector[worst]} at {describe(worst)}")
    return vector


def sample(
    lattice: Lattice, field: Any, name: str, *, allow_inf: bool = False, absent: float = np.inf, rows: Rows = "up"
) -> Vector:
    """Return the values of a field at the nodes.

    Parameters
    ----------
    lattice : Lattice
    field : number, array, xarray.DataArray or function of (x, y)
        An array has the lattice's shape, or is a vector in node order. A DataArray has dims y and x (or x alone
        on a cable) and, where it carries coordinates, holds the lattice's points. A function
        gets the nodes' coordinates as two vectors and returns a vector or a number; on a large lattice it is called
        for some rows at a time where it can be, see `in_strips`.
    name : str
        The argument's name, for messages.
    allow_inf, absent
        See `values_at`.
    rows : {"up", "down"}
        Which way y goes from row to row of an array of the lattice's shape; a DataArray's coordinates tell it.

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
    if is_labelled(field):
        field = with_places(field, name)

    def entries(given: Any) -> NDArray[np.float64]:
        if isinstance(given, Places):
            return lattice.gather(_places_on_lattice(given, lattice, name))
        if is_dataarray(given) and given.ndim and given.dims != ("node",):
            return lattice.gather(on_lattice(lattice, given, name, rows))
        # What is masked outside the nodes does no harm.
        if _masked_grid(given, lattice):
            given = np.ma.filled(np.ma.asarray(given, dtype=np.float64), np.nan)
        values = real_array(given, name)
        if values.shape == lattice.shape:
            return lattice.gather(upwards_rows(values, rows))
        if values.shape not in ((), (lattice.size,)):
            raise ValueError(
                f"{name} must be a number, an array of the lattice's shape {lattice.shape} or a vector of its "
                f"{lattice.size} nodes, got shape {values.shape}"
            )
        return values

    def of_function(function: Any) -> NDArray[np.float64]:
        found = in_strips(lattice, function, name) if lattice.size >= _WORTH_STRIPS else None
        return evaluated(function, lattice.node_x, lattice.node_y, name) if found is None else found

    return values_at(
        field, name, of_function, entries, lattice.describe, lattice.size, allow_inf=allow_inf, absent=absent
    )


_WORTH_STRIPS = 200_000
"""Nodes from which on a function is evaluated strip by strip."""

_POINTS_OF_STRIP = 1 << 15
"""Points whose coordinates, and what a function makes of them, stay in the processor's cache."""

_PROBED_ROWS = 16
"""Rows in which a function is evaluated once more, to see that its values do not depend on what else it is given."""

_ALIKE = 1e-9
"""Part of the largest value by which what a function returns for a node may differ: by rounding."""


def in_strips(lattice: Lattice, function: Any, name: str) -> Vector | None:
    """Return what a function of (x, y) returns for the nodes, evaluated for some rows at a time, in threads.

    That takes no memory for the coordinates of all nodes and what is made of them, and less time.

    Parameters
    ----------
    lattice : Lattice
    function : callable
    name : str
        The argument's name, for messages.

    Returns
    -------
    array, shape (size,), or None
        None where the function has to be given all nodes at once: because the lattice has next to no rows, or the
        function fails, or returns one number, or of a node something else when it is given other nodes with it.

    Examples
    --------
    >>> lattice = Lattice(np.ones((300, 300), dtype=bool), 0.5)
    >>> found = in_strips(lattice, lambda x, y: x + 2 * y, "load")
    >>> bool((found == lattice.node_x + 2 * lattice.node_y).all())
    True
    >>> in_strips(lattice, lambda x, y: y / y.max(), "load") is None
    True
    """
    rows, columns = lattice.shape
    if rows < _PROBED_ROWS:
        return None
    node = np.concatenate([[0], np.cumsum(np.count_nonzero(lattice.mask, axis=1))])
    values = np.empty(lattice.size)

    def at(chosen: Any) -> NDArray[np.float64]:
        numbering = Numbering(lattice.mask[chosen])
        shape = numbering.mask.shape
        x, y = np.broadcast_to(lattice.x, shape), np.broadcast_to(lattice.y[chosen, None], shape)
        return evaluated(function, numbering.to_vector(x), numbering.to_vector(y), name)

    def evaluate(first: int, last: int) -> None:
        step = max(1, _POINTS_OF_STRIP // columns)
        for row in range(first, last, step):
            stop = min(row + step, last)
            if node[row] < node[stop]:
                values[node[row] : node[stop]] = at(slice(row, stop))

    lines = np.flatnonzero(np.diff(node))
    lines = lines[:: -(-lines.size // _PROBED_ROWS)]
    try:
        probes = at(lines)
        if probes.ndim == 0:
            return None
        with Team() as team:
            team.run(evaluate, team.strips(0, rows, columns, 1))
    except Exception:
        return None
    found = np.concatenate([values[node[line] : node[line + 1]] for line in lines])
    room = _ALIKE * float(np.abs(found).max(where=np.isfinite(found), initial=0.0))
    return values if np.allclose(found, probes, rtol=0.0, atol=room, equal_nan=True) else None


class OnFrame(NamedTuple):
    """What an array tells beside the values at the nodes.

    Attributes
    ----------
    values : array, shape (k,), or None
        At the points of the lattice's array that are no nodes, row by row, nan where there is none; None where it tells
        of the nodes alone.
    """

    values: Vector | None


def as_given(lattice: Lattice, field: Any, name: str, rows: Rows = "up") -> Any:
    """Return what tells a field between the nodes, beside the values at them that `sample` has returned.

    Parameters
    ----------
    lattice : Lattice
    field, name, rows
        See `sample`, which has accepted the field.

    Returns
    -------
    float, callable, or OnFrame
        A number and a function as they are; of an array, which may change later on, what it has on the frame.
    """
    if is_function(field):
        return field
    field = with_places(field, name) if is_labelled(field) else field
    if isinstance(field, Places):
        grid = _places_on_lattice(field, lattice, name)
    elif is_dataarray(field) and field.ndim and field.dims != ("node",):
        grid = on_lattice(lattice, field, name, rows)
    elif np.ndim(field) == 0:
        return float(field)
    elif np.shape(field) == lattice.shape != (1, lattice.size):
        grid = upwards_rows(np.ma.filled(np.ma.asarray(field, dtype=np.float64), np.nan), rows)
    else:
        return OnFrame(None)
    return OnFrame(np.array(grid[~lattice.mask]))


def sample_points(
    positions: Vector,
    chosen: NDArray[np.int64],
    field: Any,
    name: str,
    describe: Callable[[int], str],
    *,
    allow_inf: bool = False,
    absent: float = np.inf,
) -> Vector:
    """Return the values of a field at some of many points that lie anywhere in plan.

    Parameters
    ----------
    positions : array, shape (points, 2)
        Coordinates x, y of all points (length).
    chosen : array of int, shape (size,)
        Numbers of the points whose values are wanted.
    field : number, array or function of (x, y)
        An array has an entry for each of the chosen points in their order, or for each point.
    name, describe, allow_inf, absent
        See `values_at`.

    Returns
    -------
    array, shape (size,)

    Raises
    ------
    TypeError, ValueError
        See `values_at`.
    """
    if is_labelled(field):
        field = with_places(field, name)

    def entries(given: Any) -> NDArray[np.float64]:
        if is_dataarray(given) and set(given.dims) == {"x", "y"}:
            return _at_points(given, positions[chosen], name)
        values = real_array(given, name)
        if values.shape == (len(positions),):
            return values[chosen]
        if values.shape not in ((), (chosen.size,)):
            raise ValueError(
                f"{name} must be a number or have shape ({chosen.size},) or ({len(positions)},), got {values.shape}"
            )
        return values

    def of_function(function: Any) -> NDArray[np.float64]:
        x, y = positions[chosen].T
        return evaluated(function, x, y, name)

    return values_at(field, name, of_function, entries, describe, chosen.size, allow_inf=allow_inf, absent=absent)


def _at_points(field: Any, points: Vector, name: str) -> NDArray[np.float64]:
    """Return a DataArray's values at points that it holds, shape (points,)."""
    load_modules("xarray")
    import xarray as xr

    places = dict(zip("xy", points.T, strict=True))
    for dim, wanted in places.items():
        _require_reach(field, dim, float(wanted.min()), float(wanted.max()), name)
    room = APART * max(float(np.ptp(points, axis=0).max()), np.finfo(float).tiny)
    try:
        at = {dim: xr.DataArray(wanted, dims="point") for dim, wanted in places.items()}
        return real_array(field.sortby(["x", "y"]).sel(at, method="nearest", tolerance=room).values, name)
    except KeyError:
        raise ValueError(
            f"{name} has no value at some of the nodes, which lie between its places; {_BETWEEN}"
        ) from None


_BETWEEN = "interpolate it: profiles.Gridded.of(array) does so linearly"


def _require_reach(field: Any, dim: str, first: float, last: float, name: str, room: float = 0.0) -> None:
    """Raise a ValueError that says where a DataArray ends, if the nodes go on from there."""
    places = field[dim].values
    low, high = float(places.min()), float(places.max())
    if low > first + room or high < last - room:
        raise ValueError(
            f"{name} does not cover the lattice: its {dim} goes from {low:g} to {high:g}, and {first:g} to {last:g} "
            "is needed"
        )


def _places_on_lattice(given: Places, lattice: Lattice, name: str) -> NDArray[np.float64]:
    """Return the values on the lattice's array, nan where none is given; points outside it are left out.

    Raises
    ------
    ValueError
        If points lie between those of the lattice, or two at one place, or a node has none.
    """
    places = [(given.x - lattice.origin[0]) / lattice.spacing, (given.y - lattice.origin[1]) / lattice.spacing]
    column, row = (np.rint(each).astype(np.int64) for each in places)
    rows, columns = lattice.shape
    inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
    off = np.maximum(np.abs(places[0] - column), np.abs(places[1] - row)) > APART
    grid = np.full(lattice.shape, np.nan)
    on = inside & ~off
    taken, counts = np.unique(row[on] * columns + column[on], return_counts=True)
    if (counts > 1).any():
        place = int(taken[counts.argmax()])
        x, y = lattice.x[place % columns], lattice.y[place // columns]
        raise ValueError(f"{name} has {counts.max()} values at x = {x:g}, y = {y:g}; leave one")
    grid[row[on], column[on]] = given.values[on]
    without = lattice.gather(np.isin(np.arange(lattice.mask.size), taken, invert=True).reshape(lattice.shape))
    if without.any():
        node = int(np.argmax(without))
        between = "; its points lie between the nodes" if (inside & off).any() else ""
        raise ValueError(
            f"{name} has no value at {lattice.describe(node)} and {int(without.sum()) - 1} other nodes{between}; "
            "interpolate it first"
        )
    return grid


def _masked_grid(field: Any, lattice: Lattice) -> bool:
    """Whether a field is a masked array of the lattice's shape, with a value at each node."""
    if not np.ma.is_masked(field) or np.shape(field) != lattice.shape or field.dtype.kind not in "iuf":
        return False
    return not (np.ma.getmaskarray(field) & lattice.mask).any()


def of_x_and_y(field: Any) -> Any:
    """Return a function of x alone as one of (x, y), and everything else as it is.

    Examples
    --------
    >>> of_x_and_y(np.sqrt)(4.0, 0.0)
    np.float64(2.0)
    >>> of_x_and_y(lambda x, y: x - y)(4.0, 1.0)
    3.0
    >>> of_x_and_y(7.0)
    7.0
    """
    if not callable(field) or isinstance(field, Ranged):
        return field
    import inspect

    try:
        parameters = inspect.signature(field).parameters.values()
    except ValueError:  # builtins without a signature, such as numpy's ufuncs, take x
        return lambda x, y: field(x)
    required = [
        p for p in parameters if p.default is p.empty and p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)
    ]
    return field if len(required) == 2 else lambda x, y: field(x)


def evaluated(function: Any, x: Vector, y: Vector, name: str) -> NDArray[np.float64]:
    """Return what a function of (x, y) returns for points: a vector of their values, or a number."""
    try:
        returned = _values_of(function, x, y)
    except Exception as error:
        wanted = _why_not_of_two(function)
        if isinstance(error, TypeError) and wanted:
            raise TypeError(f"{name} must be a function of x and y, but {wanted}; write lambda x, y: ...") from error
        error.add_note(f"raised by the function that was given as {name}, called with x and y of {x.size} points")
        raise
    values = real_array(returned, f"{name}(x, y)")
    if values.shape not in ((), x.shape):
        raise ValueError(
            f"{name}(x, y) must return a number or shape {x.shape} for the {x.size} points, got {values.shape}"
        )
    return values


def _values_of(function: Any, x: Vector, y: Vector) -> Any:
    """Return what a function returns for vectors, or point by point where it takes numbers only."""
    try:
        return function(x, y)
    except (TypeError, ValueError):
        # As ``math.sqrt`` and ``if x > 0`` do. What is wrong with single points, too, is told of the vectors.
        try:
            return [float(function(float(a), float(b))) for a, b in zip(x, y, strict=True)]
        except (TypeError, ValueError, ArithmeticError):
            pass
        raise


def _why_not_of_two(function: Any) -> str:
    """Return why a function cannot be called with x and y, empty where it can or tells nothing of its arguments."""
    import inspect

    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        return ""
    try:
        signature.bind(0.0, 0.0)
    except TypeError as error:
        return f"{getattr(function, '__name__', 'it')}{signature} cannot be called so: {error}"
    return ""


def is_function(field: Any) -> bool:
    """Whether a field is given as a function of (x, y)."""
    return callable(field) and not is_dataarray(field)


def on_lattice(lattice: Lattice, field: Any, name: str, rows: Rows = "up") -> NDArray[np.float64]:
    """Return a DataArray's values on the lattice's shape; ``rows`` tells what a missing coordinate y does not."""
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
            room = APART * lattice.spacing
            try:
                _require_reach(field, dim, float(points[0]), float(points[-1]), name, room)
                field = field.sortby(dim).sel({dim: points}, method="nearest", tolerance=room)
            except TypeError as error:
                raise ValueError(f"{name} cannot be aligned with the lattice along {dim}: {error}") from None
            except KeyError:
                raise ValueError(
                    f"{name} has no value at some of {dim} = {points[0]:g}, ..., {points[-1]:g} "
                    f"({points.size} places, spacing {lattice.spacing:g}), which lie between its own; {_BETWEEN}"
                ) from None
    values = real_array(field.values, name)
    if "y" not in field.coords:
        values = upwards_rows(values, rows)
    if values.shape != lattice.shape:
        raise ValueError(f"{name} must have the lattice's shape {lattice.shape}, got {values.shape}")
    return values


def frame_heights(lattice: Lattice, needed: Mask, value: Any, rows: Rows = "up") -> tuple[Grid | None, Vector | None]:
    """Return the frame's heights on the lattice's array with a ring about it, and at the ends of its arms.

    Both are None if they are zero. Where the lattice is fitted to a contour, a function is evaluated on it: at the
    places where arms end, of which a point of the lattice has the mean.

    Parameters
    ----------
    lattice : Lattice
    needed : array of bool, shape (rows + 2, columns + 2)
        The frame points that an arm joins to a node.
    value : number, array, xarray.DataArray or function of (x, y)
        Heights of the frame (length).
    rows : {"up", "down"}
        See `sample`.
    """
    if not is_function(value) and not is_dataarray(value) and np.ndim(value) == 0:
        value = finite_number(value, "frame_height")
        if value == 0:
            return None, None
    if is_labelled(value):
        value = with_places(value, "frame_height")
    arms, ends = lattice.frame_arms, None
    padded = np.zeros([count + 2 for count in lattice.shape])
    if is_dataarray(value):
        value, rows = on_lattice(lattice, value, "frame_height", rows), "up"
    if callable(value) and lattice.cuts is not None:
        x, y = lattice.frame_places
        ends = np.array(np.broadcast_to(evaluated(value, x, y, "frame_height"), x.shape))
        count = np.zeros(padded.shape)
        np.add.at(padded, (arms.row, arms.column), ends)
        np.add.at(count, (arms.row, arms.column), 1.0)
        padded /= np.maximum(count, 1.0)
    elif callable(value):
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
        grid = upwards_rows(grid, rows)
        inner = needed[1:-1, 1:-1]
        if inner.sum() != needed.sum():
            raise ValueError(
                "frame_height as an array cannot reach frame points outside the lattice's array; "
                "pass a function of (x, y)"
            )
        padded[1:-1, 1:-1][inner] = grid[inner]
    if not np.isfinite(padded).all():
        raise ValueError("frame_height must be finite at every frame point that a node is joined to")
    return padded, padded[arms.row, arms.column] if ends is None else ends
