"""Case files: a contact problem described in TOML, validated before anything is computed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from ..errors import CaseFileError
from ..geometry.lattice import Lattice
from ..models.cable import Cable
from ..models.membrane import Membrane
from .case_errors import explained
from .case_sections import PROFILES, CableCase, DataFile, MaskFile, MembraneCase, SampledSection, Section
from .data_files import Reading, existing_file, read_array, resampled
from .toml_files import read_toml


def load_case(path: str | Path) -> Membrane | Cable:
    """Return the model that a case file describes.

    Parameters
    ----------
    path : str or Path
        A TOML file; paths inside it are relative to its folder.

    Raises
    ------
    CaseFileError
        If the file cannot be read or holds a bad value; the message names the file, the key and the value.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> case = pathlib.Path(tempfile.mkdtemp()) / "case.toml"
    >>> _ = case.write_text('''
    ... spacing = 0.5
    ... tension = 1.0
    ... load = 2.0
    ... support = {profile = "plane", depth = 0.3}
    ... frame = {shape = "disk", radius = 2.0}
    ... ''')
    >>> load_case(case)
    Membrane(45 nodes, spacing=0.5, tension=1)
    """
    path = Path(path)
    data = read_toml(path)
    section, model_of = _KINDS.get(str(data.get("model")), _KINDS["membrane"])
    try:
        case = section.model_validate(data)
        # Numbers that overflow on the way are no input, though each of them is one.
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            model = model_of(case, path)
            _ = model.problem
            return model
    except ValidationError as error:
        raise CaseFileError(f"{path}: {explained(error, section)}") from None
    except CaseFileError:
        raise
    except (ArithmeticError, RuntimeWarning) as error:
        raise CaseFileError(f"{path}: numbers too large or too small for double precision: {error}") from None
    except RecursionError:
        raise CaseFileError(f"{path}: not a case file: too deeply nested") from None
    except MemoryError as error:
        raise CaseFileError(f"{path}: not enough memory: {error}") from None
    except (ValueError, TypeError) as error:
        raise CaseFileError(f"{path}: {error}") from None


def _membrane(case: MembraneCase, path: Path) -> Membrane:
    if isinstance(case.frame, MaskFile):
        grid = read_array(path, "frame.file", case.frame.file, _reading(case.frame))
        lattice = Lattice(grid > case.frame.threshold, case.spacing, case.origin)
    else:
        lattice = case.frame.build().lattice(case.spacing, case.origin)
    return Membrane(
        lattice,
        tension=case.tension,
        load=_field(case.load, "load", lattice, path),
        support=_field(case.support, "support", lattice, path),
        frame_height=_field(case.frame_height, "frame_height", lattice, path),
    )


def _cable(case: CableCase, path: Path) -> Cable:
    lattice = Cable.lattice_of(case.span, spacing=case.spacing, start=case.start)
    return Cable(
        span=case.span,
        spacing=case.spacing,
        tension=case.tension,
        load=_field(case.load, "load", lattice, path),
        support=_field(case.support, "support", lattice, path),
        frame_height=_field(case.frame_height, "frame_height", lattice, path),
        start=case.start,
    )


_KINDS: dict[str, tuple[type[Section], Callable[[Any, Path], Membrane | Cable]]] = {
    "membrane": (MembraneCase, _membrane),
    "cable": (CableCase, _cable),
}
"""The section that describes a kind of model, and what makes the model of it, by the name in the file."""


def _reading(section: DataFile | MaskFile) -> Reading:
    return Reading(section.key, section.separator, section.decimal)


def _field(value: Any, key: str, lattice: Lattice, path: Path) -> Any:
    if isinstance(value, float):
        return value
    if isinstance(value, DataFile):
        grid = read_array(path, f"{key}.file", value.file, _reading(value))
        if lattice.shape[0] == 1:
            grid = grid.reshape(1, -1)
        if grid.shape != lattice.shape:
            if not value.resample:
                raise CaseFileError(
                    f"{path}: {key}.file = {value.file!r} has shape {grid.shape}, the lattice {lattice.shape}; "
                    "bring it to that shape or set resample = true"
                )
            grid = resampled(grid, lattice)
        return value.offset + value.factor * grid
    parameters = value.model_dump(exclude={"profile"})
    if isinstance(value, SampledSection):
        parameters["delimiter"] = value.separator
        parameters["path"] = existing_file(path, f"{key}.file", parameters.pop("file"))
    try:
        return PROFILES[value.profile](**parameters)
    except (ValueError, OSError) as error:
        raise CaseFileError(f"{path}: {key}: {error}") from None
