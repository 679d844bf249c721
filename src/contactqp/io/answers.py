"""Answers that other programs wrote, read as gaps at a model's nodes."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import CaseFileError
from ..foundation.checks import Vector, nearest
from ..foundation.text import counted, shortened
from ..geometry.fields import Rows
from ..models.base import ContactModel
from .data_files import Reading, read_numbers
from .netcdf import read_netcdf
from .node_tables import is_node_table, read_node_table
from .zarr_stores import read_zarr

Quantity = Literal["gap", "deflection"]

_DATASETS: dict[str, Callable[[Path], Any]] = {".nc": read_netcdf, ".zarr": read_zarr}

SUFFIXES = (".npy", ".csv", *_DATASETS)


def read_answer(path: Path, model: ContactModel, quantity: Quantity = "gap", *, rows: Rows | None = None) -> Vector:
    """Return the gap at the nodes that a file holds, as a gap or as a deflection.

    Parameters
    ----------
    path : Path
        .npy or .csv: a vector in node order, or an array of the lattice's shape, whose entries that are no nodes may
        be anything. .csv with a line of names that has ``node``: a line for each node, in any order, and a column named
        after the quantity. .nc or .zarr: a variable named after it, along node, or y and x.
    model : Membrane, Cable or CableNet
    quantity : {"gap", "deflection"}
        What the file holds (length); deflections are positive as the model's heights.
    rows : {"up", "down"}, optional
        Which way y goes from row to row of an array without coordinates: up (its first row has the smallest y), if
        nothing is said; of a model that was made with ``rows="down"`` it must be said. A vector has no rows.

    Returns
    -------
    array, shape (n,)

    Raises
    ------
    CaseFileError
        If the file cannot be read, or holds something else; the message names it.

    Examples
    --------
    >>> import tempfile
    >>> import contactqp as cq
    >>> cable = cq.Cable(nodes=3, spacing=1.0, tension=1.0, load=1.0, support=1.0)
    >>> file = Path(tempfile.mkdtemp()) / "answer.csv"
    >>> _ = file.write_text("0.9,1.0,0.9")
    >>> read_answer(file, cable, "deflection").round(9)
    array([0.1, 0. , 0.1])
    """
    suffix = path.suffix.lower()
    if not (path.is_file() or (suffix in _DATASETS and path.exists())):
        raise CaseFileError(f"there is no file {shortened(path, 200)}")
    if suffix not in SUFFIXES:
        raise CaseFileError(f"{path}: unknown kind {path.suffix!r}; known: {' '.join(SUFFIXES)}")
    try:
        if suffix in _DATASETS:
            return _of_dataset(path, model, quantity, rows)
        if suffix == ".csv" and is_node_table(path):
            return _of_table(path, model, quantity)
        grid = np.asarray(read_numbers(path, Reading()).values, dtype=np.float64)
        _require_fitting(grid, model)
        given = grid.ravel() if _is_row(grid) else _in_own_rows(grid, model, quantity, rows)
        values = model.at_nodes(given, quantity, allow_inf=True)
        return _finite(_gap_of(values, model, quantity), model)
    except CaseFileError as error:
        raise CaseFileError(f"{path}: {error}") from None
    except (OSError, TypeError, ValueError) as error:
        raise CaseFileError(f"{path}: {shortened(error, 300)}") from None


def _is_row(grid: NDArray[np.float64]) -> bool:
    return 1 in grid.shape


def _require_fitting(grid: NDArray[np.float64], model: ContactModel) -> None:
    """Raise a CaseFileError, unless there is a number for each node, or an array as the nodes are laid out."""
    laid_out = model.laid_out(np.zeros(model.size))[1].shape
    row = (grid.size,) if _is_row(grid) else grid.shape
    if row in ((model.size,), laid_out) or grid.shape == laid_out:
        return
    given = counted(grid.size, "number") if _is_row(grid) else f"an array of shape {grid.shape}"
    array = f", or an array of shape {laid_out}" if len(laid_out) > 1 else ""
    raise CaseFileError(
        f"it holds {given}, and the case has {counted(model.size, 'node')}: hand over a number for each, in their "
        f"order{array}"
    )


def _in_own_rows(field: Any, model: ContactModel, name: str, rows: Rows | None) -> Any:
    try:
        return model.in_own_rows(field, name, rows)
    except ValueError:
        raise CaseFileError(
            "it does not tell which way its rows go, and those of the case's files go down while what comes out goes "
            "up: say --rows down if its first row has the largest y, --rows up if the smallest"
        ) from None


def _of_dataset(path: Path, model: ContactModel, quantity: Quantity, rows: Rows | None) -> Vector:
    data = _DATASETS[path.suffix.lower()](path)

    def values(name: Quantity) -> Vector:
        found = data[name]
        given = _in_own_rows(found, model, name, rows) if "x" in found.dims else found.to_numpy()
        return model.at_nodes(given, name, allow_inf=True)

    return _named([str(name) for name in data.data_vars], "variable", values, model, quantity)


def _of_table(path: Path, model: ContactModel, quantity: Quantity) -> Vector:
    columns = read_node_table(path, model.size)

    def values(name: Quantity) -> Vector:
        return model.at_nodes(columns[name], name, allow_inf=True)

    return _named(columns, "column", values, model, quantity)


def _named(
    known: Collection[str], noun: str, values: Callable[[Quantity], Vector], model: ContactModel, quantity: Quantity
) -> Vector:
    """Return the gap that a file holds among other quantities by their names."""
    if quantity not in known:
        found = shortened(", ".join(known), 200) or "none"
        raise CaseFileError(f"it has no {noun} {quantity}, but {found}{nearest(quantity, known)}")
    gap = _gap_of(values(quantity), model, quantity)
    if np.isinf(gap).any() and "deflection" in known:
        # Where there is no support, a gap is written as infinite: there the deflection tells where the node is.
        gap = np.where(np.isinf(gap), _gap_of(values("deflection"), model, "deflection"), gap)
    return _finite(gap, model)


def _gap_of(values: Vector, model: ContactModel, quantity: Quantity) -> Vector:
    if quantity == "gap":
        return values
    return np.asarray(model.reference + values if model.upwards else model.reference - values)


def _finite(gap: Vector, model: ContactModel) -> Vector:
    bad = np.flatnonzero(~np.isfinite(gap))
    if bad.size:
        raise CaseFileError(
            f"the gap must be finite, but is {gap[bad[0]]} at {model.describe(int(bad[0]))}; "
            "where there is no support, hand over deflections"
        )
    return gap
