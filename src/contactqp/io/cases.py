"""Case files: a contact problem described in TOML, validated before anything is computed."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from ..errors import CaseFileError
from ..geometry.lattice import Lattice
from ..models.cable import Cable
from ..models.membrane import Membrane
from .case_sections import PROFILES, CableCase, DataFile, MaskFile, MembraneCase, SampledSection
from .data_files import existing_file, read_array, resampled


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
    Membrane(45 nodes, spacing=0.5, tension=1, load=2, support=0.3)
    """
    path = Path(path)
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise CaseFileError(f"{path}: cannot read the case file: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise CaseFileError(f"{path}: not a TOML file: {error}") from None
    section, model_of = _KINDS.get(str(data.get("model")), _KINDS["membrane"])
    try:
        case = section.model_validate(data)
    except ValidationError as error:
        raise CaseFileError(f"{path}:\n" + "\n".join(_explain(error))) from None
    try:
        return model_of(case, path)
    except CaseFileError:
        raise
    except (ValueError, TypeError) as error:
        raise CaseFileError(f"{path}: {error}") from None


def _membrane(case: MembraneCase, path: Path) -> Membrane:
    if isinstance(case.frame, MaskFile):
        grid = read_array(path, "frame.file", case.frame.file, None)
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


_KINDS: dict[str, tuple[type[BaseModel], Callable[[Any, Path], Membrane | Cable]]] = {
    "membrane": (MembraneCase, _membrane),
    "cable": (CableCase, _cable),
}
"""The section that describes a kind of model, and what makes the model of it, by the name in the file."""


def _field(value: Any, key: str, lattice: Lattice, path: Path) -> Any:
    if isinstance(value, float):
        return value
    if isinstance(value, DataFile):
        grid = read_array(path, f"{key}.file", value.file, value.key)
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
        parameters["path"] = existing_file(path, f"{key}.file", parameters.pop("file"))
    try:
        return PROFILES[value.profile](**parameters)
    except (ValueError, OSError) as error:
        raise CaseFileError(f"{path}: {key}: {error}") from None


def _explain(error: ValidationError) -> list[str]:
    lines = []
    for problem in error.errors():
        tags = {*PROFILES, "rectangle", "hexagon", "disk", "polygon", "mask", "DataFile", "float", "function-after"}
        key = ".".join(str(part) for part in problem["loc"] if str(part) not in tags and "[" not in str(part))
        given = "" if problem["type"] == "missing" else f", got {problem['input']!r}"
        lines.append(f"  {key or 'file'}: {problem['msg'][0].lower()}{problem['msg'][1:]}{given}")
    return list(dict.fromkeys(lines))
