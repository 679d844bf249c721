"""Zarr stores: folders that hold a dataset in parts, as cloud stores do."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import CaseFileError
from ..foundation.loading import load_modules, needed

if TYPE_CHECKING:
    import xarray as xr

INSTALL = "contactqp[zarr]"


def write_zarr(data: xr.Dataset, path: Path) -> None:
    """Write a dataset into a folder that is not there yet."""
    needed("zarr", "writing .zarr", INSTALL)
    data.to_zarr(path, mode="w", consolidated=False)


def read_zarr(path: Path) -> xr.Dataset:
    """Return what a store holds, in memory.

    Raises
    ------
    OSError
        If it cannot be read, or is no store.
    """
    with opened_zarr(path) as store:
        return store.load()


@contextmanager
def opened_zarr(path: Path) -> Iterator[xr.Dataset]:
    """Open a store, of whose variables no more is read than is asked for while it is open.

    Raises
    ------
    OSError
        See `read_zarr`; also of what is read while it is open.
    """
    needed("zarr", "reading .zarr", INSTALL)
    load_modules("xarray")
    import xarray as xr

    try:
        store: xr.Dataset
        with xr.open_zarr(path, consolidated=False, chunks=None) as store:
            yield store
    except CaseFileError:
        raise
    except Exception as error:  # whatever a decoder says of a damaged store
        raise OSError(f"it is no Zarr store, or a damaged one: {error}") from None
