"""NetCDF files, read and written by one thread at a time."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import CaseFileError
from ..foundation.files import replaced_as_a_whole
from ..foundation.loading import load_modules

if TYPE_CHECKING:
    import xarray as xr

_ONE_AT_A_TIME = threading.RLock()
"""The library beneath ends the process where two threads are in it, also with files of their own."""


def write_netcdf(data: xr.Dataset, path: Path) -> None:
    """Write a dataset, and replace a file of that name as a whole.

    Parameters
    ----------
    data : xarray.Dataset
    path : Path
        Its folder must exist.
    """
    with replaced_as_a_whole(path) as unfinished:
        write_netcdf_anew(data, unfinished)


def write_netcdf_anew(data: xr.Dataset, path: Path) -> None:
    """Write a dataset into a file that nobody reads yet."""
    with _ONE_AT_A_TIME:
        data.to_netcdf(path, engine="netcdf4")


def read_netcdf(path: Path) -> xr.Dataset:
    """Return what a file holds, in memory, and close it.

    Raises
    ------
    OSError
        If it cannot be read, or is no NetCDF file.

    Examples
    --------
    >>> import tempfile
    >>> import xarray as xr
    >>> file = Path(tempfile.mkdtemp()) / "gap.nc"
    >>> write_netcdf(xr.Dataset({"gap": ("node", [0.0, 0.5])}), file)
    >>> read_netcdf(file)["gap"].to_numpy()
    array([0. , 0.5])
    """
    with opened_netcdf(path) as file:
        return file.load()


@contextmanager
def opened_netcdf(path: Path) -> Iterator[xr.Dataset]:
    """Open a file, of whose variables no more is read than is asked for while it is open.

    Raises
    ------
    OSError
        See `read_netcdf`; also of what is read while it is open.
    """
    load_modules("xarray", "netCDF4")
    import xarray as xr

    with _ONE_AT_A_TIME:
        try:
            with xr.open_dataset(path, engine="netcdf4") as file:
                yield file
        except (CaseFileError, FileNotFoundError, PermissionError):
            raise
        except Exception as error:  # whatever a decoder says of a damaged file
            said = getattr(error, "strerror", None) or error
            raise OSError(f"it is no NetCDF file, or a damaged one: {said}") from None
