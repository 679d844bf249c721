"""A membrane of a case file, row by row."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..errors import CaseFileError
from ..geometry.fields import upwards_rows
from ..io.cases import read_membrane_parts
from .membrane import MembraneByRows


def membrane_of_case(path: str | Path) -> MembraneByRows:
    """Return the membrane that a case file describes; its fields are evaluated row by row.

    Every process lays out the frame, one byte a point, and reads data files whole, to keep its rows of them.

    Raises
    ------
    CaseFileError
        If the file is no good, or describes what several processes do not solve: the message tells what.
    """
    parts = read_membrane_parts(path)
    lattice, tension, frame_height = parts["lattice"], parts["tension"], parts["frame_height"]
    pair = tension if isinstance(tension, tuple) else (tension,)
    refused = {
        "fitted = true": lattice.cuts is not None,
        "a tension that varies": not all(isinstance(part, float) for part in pair),
        "a foundation": parts["foundation"] is not None,
        "a frame_height that varies": not isinstance(frame_height, float),
    }
    for what, given in refused.items():
        if given:
            raise CaseFileError(f"{path}: {what} is not solved by several processes; start one")
    return MembraneByRows(
        lattice.shape,
        lattice.spacing,
        tension,
        **{name: _upright(parts[name], parts["rows"]) for name in ("load", "support", "ceiling")},
        mask=lattice.mask,
        origin=lattice.origin,
        frame_height=frame_height,
        upwards=parts["upwards"],
    )


def _upright(field: Any, rows: Any) -> Any:
    return upwards_rows(field, rows) if isinstance(field, np.ndarray) and field.ndim == 2 else field
