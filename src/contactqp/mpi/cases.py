"""A membrane of a case file, row by row."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..io.cases import read_membrane_by_rows
from .membrane import MembraneByRows
from .ranks import Ranks

if TYPE_CHECKING:
    from mpi4py import MPI


def membrane_of_case(path: str | Path, comm: MPI.Comm | None = None) -> MembraneByRows:
    """Return the membrane that a case file describes, of which each process reads the rows that it needs.

    The frame is laid out, and files of .npy, .tif (by rasterio), .nc and .zarr are read, for these rows alone; files of
    other kinds are read whole. All processes must call it.

    Parameters
    ----------
    path : str or Path
    comm : mpi4py.MPI.Comm, optional
        By default all processes that were started together.

    Raises
    ------
    CaseFileError
        If the file is no good, or describes what several processes do not solve: the message tells what, in every
        process. What is wrong with values is told when their rows are read.
    """
    parts = read_membrane_by_rows(path, Ranks(comm))
    return MembraneByRows.on(parts.pop("lattice"), parts.pop("tension"), **parts)
