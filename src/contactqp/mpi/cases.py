"""A membrane of a case file, row by row."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..errors import CaseFileError
from ..geometry.fields import upwards_rows
from ..io.cases import read_membrane_parts
from .membrane import MembraneByRows

_FIELDS = "load", "support", "ceiling", "foundation", "frame_height"


def membrane_of_case(path: str | Path) -> MembraneByRows:
    """Return the membrane that a case file describes; its fields are evaluated row by row.

    Every process lays out the frame, one byte a point, and reads data files whole, to keep its rows of them.

    Raises
    ------
    CaseFileError
        If the file is no good, or describes what several processes do not solve: the message tells what.
    """
    parts = read_membrane_parts(path)
    lattice, rows = parts["lattice"], parts["rows"]
    if lattice.cuts is not None:
        raise CaseFileError(f"{path}: fitted = true is not solved by several processes; start one")
    return MembraneByRows(
        lattice.shape,
        lattice.spacing,
        _upright(parts["tension"], rows),
        **{name: _upright(parts[name], rows) for name in _FIELDS},
        mask=lattice.mask,
        origin=lattice.origin,
        upwards=parts["upwards"],
    )


def _upright(field: Any, rows: Any) -> Any:
    if isinstance(field, tuple):
        return tuple(_upright(part, rows) for part in field)
    return upwards_rows(field, rows) if isinstance(field, np.ndarray) and field.ndim == 2 else field
