"""Fields and masks from data files, for models that are made in Python: as case files name them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import CaseFileError
from ..foundation.checks import Vector, finite_number
from ..geometry.fields import Rows, sample
from ..geometry.lattice import Lattice
from ..geometry.lattice_by_rows import LatticeByRows
from ..profiles.gridded import Gridded
from ..profiles.sample_files import check_separators
from .data_files import Reading, read_numbers
from .on_nodes import FieldOfFile, OnLattice, upright
from .rasters import Raster
from .variables import DATASETS, variable_in_plan


def read_field(
    path: str | Path,
    lattice: Lattice,
    *,
    key: str | None = None,
    rows: Rows | None = None,
    resample: bool = False,
    no_data: float | None = None,
    missing: float | None = None,
    factor: float = 1.0,
    offset: float = 0.0,
    transform: bool = True,
    delimiter: str = ",",
    decimal: str = ".",
) -> Vector:
    r"""Return the values of a data file at the nodes of a lattice: ``offset + factor * value``, shape (n,).

    Parameters
    ----------
    path : str or Path
        ``.npy``, ``.npz``, ``.csv``: an array of the lattice's shape; ``.csv`` whose first line names x and y, and
        ``.xyz``: a place and a value in each line; ``.tif``: as its geo-transform puts it; ``.nc`` and ``.zarr``: a
        variable along y and x with coordinates; ``.png``, ``.jpg``, ``.bmp``: grey levels from 0 to 1.
    lattice : Lattice
    key : str, optional
        Which array, column, variable or band, where there are several.
    rows : {"up", "down"}, optional
        Which way y goes from row to row; by default up, but down in pictures and ``.tif``.
    resample : bool
        Whether to interpolate bilinearly where values do not lie on the nodes.
    no_data : float, optional
        A value that stands for none, beside nan and the one that a ``.tif`` file names.
    missing : float, optional
        What a node without a value gets, such as ``inf`` for no support; by default that is an error.
    factor, offset : float
    transform : bool
        Whether to use a file's geo-transform.
    delimiter, decimal : str
        What separates the columns of a text file, and what begins the decimals of its numbers.

    Raises
    ------
    CaseFileError
        If the file cannot be read, or does not fit the lattice; the message names it.

    Examples
    --------
    >>> import tempfile
    >>> import contactqp as cq
    >>> lattice = cq.Frame.rectangle(2.0, 2.0, center=(1.0, 1.0)).lattice(1.0)
    >>> file = Path(tempfile.mkdtemp()) / "ground.xyz"
    >>> _ = file.write_text("0 0 0.5\n2 0 0.5\n0 2 0.7\n2 2 0.7\n")
    >>> read_field(file, lattice, resample=True)
    array([0.6])
    """
    path, absent = Path(path), missing
    if absent is not None and not np.isinf(absent):
        absent = finite_number(missing, "missing")
    try:
        if path.suffix.lower() in DATASETS:
            values = _of_dataset(path, lattice, key, resample, absent)
            return np.asarray(np.where(np.isinf(values), values, offset + factor * values))
        raster = upright(_read(path, key, delimiter, decimal), rows, no_data, transform=transform)
        numbers = OnLattice(raster, LatticeByRows.of(lattice), resample=resample)
        return lattice.gather(FieldOfFile(numbers, factor=factor, offset=offset, absent=absent)[:])
    except (ValueError, TypeError) as error:
        raise CaseFileError(f"{path}: {error}") from None


def read_mask(
    path: str | Path,
    spacing: float | None = None,
    *,
    origin: tuple[float, float] | None = None,
    threshold: float = 0.5,
    key: str | None = None,
    rows: Rows | None = None,
    no_data: float | None = None,
    transform: bool = True,
    crs: str = "",
) -> Lattice:
    r"""Return the lattice whose nodes are where a file's values lie above a threshold.

    Parameters
    ----------
    path : str or Path
        ``.npy``, ``.npz``, ``.csv``, ``.xyz``, ``.tif``, ``.png``, ``.jpg``, ``.bmp``, as for `read_field`.
    spacing : float, optional
        Distance of neighbouring points (length); of a file that tells places it is theirs.
    origin : (float, float), optional
        The point of the smallest x and y (length); by default (0, 0), or where the file puts it.
    threshold : float
    key, rows, no_data, transform
        See `read_field`.
    crs : str
        Coordinate reference system of x and y; by default the one that a ``.tif`` file tells.

    Raises
    ------
    CaseFileError
        If the file cannot be read, or no value lies above the threshold; the message names it.

    Examples
    --------
    >>> import tempfile
    >>> file = Path(tempfile.mkdtemp()) / "mask.csv"
    >>> _ = file.write_text("0,1,1\n1,1,0\n")
    >>> read_mask(file, 0.5)
    Lattice(4 nodes in 2 x 3, spacing=0.5)
    """
    path = Path(path)
    try:
        raster = upright(_read(path, key, ",", "."), rows, no_data, transform=transform)
        found, first = spacing, (0.0, 0.0)
        if raster.places is not None:
            steps = [float(np.ptp(along)) / (along.size - 1) for along in raster.places if along.size > 1]
            found, first = _step_of(steps, spacing), (float(raster.places[0][0]), float(raster.places[1][0]))
        if found is None:
            raise CaseFileError("it tells no places: say spacing=")
        return Lattice(raster.values > threshold, found, first if origin is None else origin, crs=crs or raster.crs)
    except (ValueError, TypeError) as error:
        raise CaseFileError(f"{path}: {error}") from None


def _step_of(steps: list[float], spacing: float | None) -> float | None:
    if not steps:
        return spacing
    wanted = float(steps[0]) if spacing is None else spacing
    if not np.allclose(steps, wanted, rtol=1e-6, atol=0):
        told = " and ".join(f"{step:g}" for step in steps)
        raise CaseFileError(f"its places are {told} apart, and not {wanted:g}; bring them together first")
    return wanted


def _read(path: Path, key: str | None, delimiter: str, decimal: str) -> Raster:
    if not path.is_file():
        raise CaseFileError("there is no such file")
    check_separators(delimiter, decimal)
    return read_numbers(path, Reading(key, delimiter, decimal))


def _of_dataset(path: Path, lattice: Lattice, key: str | None, resample: bool, missing: float | None) -> Vector:
    if not path.exists():
        raise CaseFileError("there is no such file")
    field = variable_in_plan(path, key)
    if resample:
        inside = "error" if missing is None else "none"
        values = Gridded.of(field, outside=inside)(lattice.node_x, lattice.node_y)  # type: ignore[arg-type]
        return values if missing is None else np.where(np.isinf(values), missing, values)
    values = sample(lattice, field if missing is None else field.fillna(missing), path.name, allow_inf=True)
    return np.array(values)
