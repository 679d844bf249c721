"""Case files: a contact problem described in TOML, validated before anything is computed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from ..errors import CaseFileError
from ..foundation.text import shortened
from ..geometry.lattice import Lattice
from ..models.cable import Cable
from ..models.membrane import Membrane
from .case_errors import explained
from .case_sections import PROFILES, CableCase, DataFile, MaskFile, MembraneCase, SampledSection, Section
from .data_files import Reading, existing_file, read_raster
from .on_nodes import on_lattice, upright, without_missing
from .rasters import Raster
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
    Membrane(45 nodes, spacing=0.5, tension=1, load=2, support=0.3)
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
        lattice = _masked(case, case.frame, path)
    else:
        lattice = case.frame.build().lattice(case.spacing, case.origin)
    return Membrane(
        lattice,
        tension=case.tension,
        load=_field(case.load, "load", lattice, path),
        support=_field(case.support, "support", lattice, path, upwards=case.upwards),
        frame_height=_field(case.frame_height, "frame_height", lattice, path, upwards=case.upwards),
        upwards=case.upwards,
    )


def _masked(case: MembraneCase, frame: MaskFile, path: Path) -> Lattice:
    """Return the lattice of a mask file; where a geo-transform places it, spacing and origin must be the file's."""
    raster = _upright(frame, "frame.file", path)
    mask, origin = raster.values > frame.threshold, case.origin
    if raster.places is not None:
        x, y = raster.places
        steps = [np.ptp(along) / (along.size - 1) for along in (x, y) if along.size > 1]
        placed = float(x[0]), float(y[0])
        fits = np.allclose(steps, case.spacing, rtol=1e-6, atol=0)
        if not fits or (origin is not None and np.abs(np.subtract(origin, placed)).max() > 1e-6 * case.spacing):
            told = " and ".join(f"{step:g}" for step in steps)
            raise CaseFileError(
                f"{path}: frame.file = {shortened(frame.file)!r}: its geo-transform has steps of {told} from {placed}, "
                f"the case spacing = {case.spacing:g}, origin = {origin}; bring them together, or set transform = false"
            )
        origin = placed
    return Lattice(mask, case.spacing, (0.0, 0.0) if origin is None else origin)


def _cable(case: CableCase, path: Path) -> Cable:
    lattice = Cable.lattice_of(case.span, spacing=case.spacing, start=case.start)
    return Cable(
        span=case.span,
        spacing=case.spacing,
        tension=case.tension,
        load=_field(case.load, "load", lattice, path),
        support=_field(case.support, "support", lattice, path, upwards=case.upwards),
        frame_height=_field(case.frame_height, "frame_height", lattice, path, upwards=case.upwards),
        start=case.start,
        upwards=case.upwards,
    )


_KINDS: dict[str, tuple[type[Section], Callable[[Any, Path], Membrane | Cable]]] = {
    "membrane": (MembraneCase, _membrane),
    "cable": (CableCase, _cable),
}
"""The section that describes a kind of model, and what makes the model of it, by the name in the file."""


def _upright(section: DataFile | MaskFile, key: str, path: Path) -> Raster:
    how = Reading(section.key, section.separator, section.decimal)
    raster = read_raster(path, key, section.file, how)
    try:
        return upright(raster, section.rows, section.no_data, transform=section.transform)
    except CaseFileError as error:
        raise CaseFileError(f"{path}: {key} = {shortened(section.file)!r}: {error}") from None


def _field(value: Any, key: str, lattice: Lattice, path: Path, *, upwards: bool = False) -> Any:
    if isinstance(value, float):
        return value
    if isinstance(value, DataFile):
        raster = _upright(value, f"{key}.file", path)
        absent = None
        if value.missing == "none":
            if key != "support":
                raise CaseFileError(f'{path}: {key}.missing = "none" goes with a support only; fill the values')
            # Where a value is missing, factor and offset have no say.
            absent = -np.inf if upwards else np.inf
        try:
            grid = on_lattice(raster, lattice, resample=value.resample)
            return without_missing(value.offset + value.factor * grid, lattice, absent, lattice.describe)
        except CaseFileError as error:
            raise CaseFileError(f"{path}: {key}.file = {shortened(value.file)!r}: {error}") from None
    parameters = value.model_dump(exclude={"profile"})
    if isinstance(value, SampledSection):
        parameters["upwards"] = upwards
        parameters["delimiter"] = value.separator
        parameters["path"] = existing_file(path, f"{key}.file", parameters.pop("file"))
    try:
        return PROFILES[value.profile](**parameters)
    except (ValueError, OSError) as error:
        raise CaseFileError(f"{path}: {key}: {error}") from None
