"""Case files: a contact problem described in TOML, validated before anything is computed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np
from pydantic import ValidationError

from ..errors import CaseFileError
from ..foundation.checks import Mask
from ..foundation.text import shortened
from ..foundation.together import Together
from ..geometry.fields import Rows, upwards_rows
from ..geometry.lattice import Lattice
from ..geometry.lattice_by_rows import LatticeByRows, LatticeFacts
from ..models.beam import Beam
from ..models.cable import Cable
from ..models.membrane import Membrane
from ..models.mesh_membrane import MeshMembrane
from ..models.plate import Plate
from .case_errors import explained
from .case_sections import (
    PROFILES,
    BeamCase,
    CableCase,
    DataFile,
    Line,
    MaskFile,
    MembraneCase,
    MeshMembraneCase,
    PlateCase,
    ProfileFromFile,
    Section,
)
from .data_files import Reading, existing_file, read_raster
from .on_nodes import FieldOfFile, OnLattice, Upright, rows_of, upright
from .toml_files import read_toml

Model: TypeAlias = Membrane | Cable | MeshMembrane | Beam | Plate
"""What a case file may describe."""

_Section = TypeVar("_Section", bound=Section)
_Built = TypeVar("_Built")


class Case(NamedTuple):
    """What a case file describes.

    Attributes
    ----------
    model : Membrane, Cable, MeshMembrane, Beam or Plate
    title : str
        For pictures and pages; ``""`` where the file has none.
    """

    model: Model
    title: str


def load_case(path: str | Path) -> Model:
    """Return the model that a case file describes; `read_case` returns its title as well.

    Parameters
    ----------
    path : str or Path
        A TOML file; paths inside it are relative to its folder.

    Returns
    -------
    Membrane, Cable, MeshMembrane, Beam or Plate
        Where the rows of a data file go down, as those of pictures and .tif files, the model is one with
        ``rows="down"``: an array without coordinates that it is given later, such as an answer, must say its rows.

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
    Membrane(45 nodes, spacing=0.5, tension=1, load=2, support=0.3, frame up to 0.24 outside its contour)
    """
    return read_case(path).model


def read_case(path: str | Path, spacing: float | None = None) -> Case:
    """Return what a case file describes, see `load_case`; with another spacing than the file's where one is given."""
    path = Path(path)
    data = read_toml(path)
    if spacing is not None:
        data = {**data, "spacing": spacing}
    section, model_of = _KINDS[_kind_of(data)]

    def build(case: Section, path: Path) -> Case:
        model = model_of(case, path)
        _ = model.problem
        return Case(model, case.title)  # type: ignore[attr-defined]

    return _built(path, data, section, build)


def read_membrane_by_rows(path: str | Path, together: Together) -> dict[str, Any]:
    """Return what a case file of a membrane describes, as arguments of `Membrane` by name: nothing is laid out.

    The lattice is a `LatticeByRows`, and numbers of files are `FieldOfFile`, whose rows go up; ``rows`` tells which way
    they go in the files.

    Parameters
    ----------
    path : str or Path
    together : Together
        The processes, all of which call it and learn the same.

    Raises
    ------
    CaseFileError
        See `load_case`; or if it describes something else.
    """
    path = Path(path)
    data = together.agreed(lambda: read_toml(path))
    kind = _kind_of(data)
    if kind != "membrane":
        raise CaseFileError(f"{path}: model = {kind!r}: only a membrane is solved by several processes")

    def build(case: MembraneCase, path: Path) -> dict[str, Any]:
        if case.fitted:
            raise CaseFileError(f"{path}: fitted = true is not solved by several processes; start one")
        files = _Files(path, by_rows=True)
        lattice = _lattice_by_rows(case, files, together)
        fields = together.agreed(lambda: _fields_in_plan(case, files, lattice, "tension"))
        return {"lattice": lattice, **fields, "upwards": case.upwards, "rows": files.rows}

    return _built(path, data, MembraneCase, build)


def _kind_of(data: dict[str, Any]) -> str:
    kind = str(data.get("model"))
    return kind if kind in _KINDS else "membrane"


def _built(
    path: Path, data: dict[str, Any], section: type[_Section], build: Callable[[_Section, Path], _Built]
) -> _Built:
    """Return what is built of a case file's data, which are those of a kind of model; errors name the file."""
    try:
        case = section.model_validate(data)
        # Numbers that overflow on the way are no input, though each of them is one.
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            return build(case, path)
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


class _Files:
    """The data files that a case names.

    Attributes
    ----------
    path : Path
        The case file, to whose folder their names are relative.
    rows : {"up", "down"}
        Down, if the rows of one of those that have been read go so.
    line : Line or None
        What the model lies along, if that is a line.
    by_rows : bool
        Whether numbers stay in the files until their rows are asked for.
    """

    def __init__(self, path: Path, line: Line | None = None, *, by_rows: bool = False) -> None:
        self.path = path
        self.line = line
        self.by_rows = by_rows
        self.rows: Rows = "up"

    def upright(self, section: DataFile | MaskFile, key: str) -> Upright:
        """Return the numbers of a file with y ascending from row to row."""
        how = Reading(section.key, section.separator, section.decimal, self.by_rows)
        raster = read_raster(self.path, key, section.file, how)
        if raster.values.shape[0] > 1 and rows_of(raster, section.rows, transform=section.transform) == "down":
            self.rows = "down"
        try:
            return upright(raster, section.rows, section.no_data, transform=section.transform)
        except CaseFileError as error:
            raise CaseFileError(f"{self.path}: {key} = {shortened(section.file)!r}: {error}") from None

    def field(self, value: Any, key: str, lattice: LatticeByRows | None, *, upwards: bool = False) -> Any:
        """Return a load, a height or a tension as a model takes it; numbers of a file as an array whose rows go up.

        That is a `FieldOfFile` where they stay in the file. Without a lattice there are no numbers of files.
        """
        if value is None or isinstance(value, float):
            return value
        if isinstance(value, tuple):
            return tuple(self.field(part, f"{key}[{k}]", lattice) for k, part in enumerate(value))
        if isinstance(value, DataFile) and lattice is not None:
            raster = self.upright(value, f"{key}.file")
            absent = None
            if value.missing == "none":
                if key not in ("support", "ceiling"):
                    raise CaseFileError(
                        f'{self.path}: {key}.missing = "none" goes with a support or a ceiling only; fill the values'
                    )
                # Where a value is missing, factor and offset have no say.
                absent = -np.inf if upwards == (key == "support") else np.inf
            told = f"{self.path}: {key}.file = {shortened(value.file)!r}: "
            try:
                numbers = OnLattice(raster, lattice, resample=value.resample)
            except CaseFileError as error:
                raise CaseFileError(f"{told}{error}") from None
            field = FieldOfFile(numbers, factor=value.factor, offset=value.offset, absent=absent, told=told)
            return field if self.by_rows else field[:]
        file = existing_file(self.path, f"{key}.file", value.file) if isinstance(value, ProfileFromFile) else None
        try:
            if file is not None:
                return value.build(file, self.line, upwards=upwards, by_rows=self.by_rows)
            return PROFILES[value.profile](**value.model_dump(exclude={"profile"}))
        except (ValueError, OSError) as error:
            raise CaseFileError(f"{self.path}: {key}: {error}") from None


def _in_plan(case: MembraneCase | PlateCase, path: Path, *more: str) -> dict[str, Any]:
    """Return the lattice of a membrane or a plate, and its fields: those of both, and more by name."""
    files = _Files(path)
    if isinstance(case.frame, MaskFile):
        if getattr(case, "fitted", False):
            raise CaseFileError(f"{path}: fitted = true needs a frame with a contour, and a mask has none")
        lattice = _masked(case, case.frame, files)
    else:
        lattice = (
            case.frame.build()
            .in_crs(case.crs)
            .lattice(case.spacing, case.origin, fitted=getattr(case, "fitted", False))
        )
    fields = _fields_in_plan(case, files, LatticeByRows.of(lattice), *more)
    if files.rows == "down":
        fields = {name: _turned(value) for name, value in fields.items()}
    return {"lattice": lattice, **fields, "upwards": case.upwards, "rows": files.rows}


def _fields_in_plan(
    case: MembraneCase | PlateCase, files: _Files, lattice: LatticeByRows, *more: str
) -> dict[str, Any]:
    heights = {
        name: files.field(getattr(case, name), name, lattice, upwards=case.upwards)
        for name in ("support", "frame_height", "ceiling")
    }
    return heights | {name: files.field(getattr(case, name), name, lattice) for name in ("load", "foundation", *more)}


def _lattice_by_rows(case: MembraneCase, files: _Files, together: Together) -> LatticeByRows:
    frame = case.frame
    if not isinstance(frame, MaskFile):
        return frame.build().in_crs(case.crs).lattice_by_rows(case.spacing, case.origin, together)
    numbers, origin, crs = together.agreed(lambda: _placed_mask(case, frame, files))

    def nodes(first: int, last: int) -> Mask:
        return np.asarray(numbers.rows(first, last) > frame.threshold)

    return LatticeByRows.read(numbers.shape, case.spacing, origin, nodes, together, LatticeFacts(crs=crs))


def _membrane(case: MembraneCase, path: Path) -> Membrane:
    return Membrane(**_in_plan(case, path, "tension"))


def _plate(case: PlateCase, path: Path) -> Plate:
    return Plate(
        bending_stiffness=case.bending_stiffness,
        tension=case.tension,
        edge=case.edge,
        poisson_ratio=case.poisson_ratio,
        **_in_plan(case, path),
    )


def _turned(field: Any) -> Any:
    """Return a field whose arrays have the row of the largest y first."""
    if isinstance(field, tuple):
        return tuple(map(_turned, field))
    return upwards_rows(field, "down") if isinstance(field, np.ndarray) and field.ndim else field


def _masked(case: MembraneCase | PlateCase, frame: MaskFile, files: _Files) -> Lattice:
    """Return the lattice of a mask file."""
    numbers, origin, crs = _placed_mask(case, frame, files)
    return Lattice(numbers.values > frame.threshold, case.spacing, origin, crs=crs)


def _placed_mask(
    case: MembraneCase | PlateCase, frame: MaskFile, files: _Files
) -> tuple[Upright, tuple[float, float], str]:
    """Return a mask file's numbers, origin and system; where a geo-transform places it, they must be the case's."""
    numbers, origin = files.upright(frame, "frame.file"), case.origin
    if numbers.places is not None:
        x, y = numbers.places
        steps = [np.ptp(along) / (along.size - 1) for along in (x, y) if along.size > 1]
        placed = float(x[0]), float(y[0])
        fits = np.allclose(steps, case.spacing, rtol=1e-6, atol=0)
        if not fits or (origin is not None and np.abs(np.subtract(origin, placed)).max() > 1e-6 * case.spacing):
            told = " and ".join(f"{step:g}" for step in steps)
            raise CaseFileError(
                f"{files.path}: frame.file = {shortened(frame.file)!r}: its geo-transform has steps of {told} from "
                f"{placed}, the case spacing = {case.spacing:g}, origin = {origin}; bring them together, or set "
                "transform = false"
            )
        origin = placed
    return numbers, (0.0, 0.0) if origin is None else origin, case.crs or numbers.crs


def _cable(case: CableCase, path: Path) -> Cable:
    files = _Files(path, Line(case.start, case.span))
    lattice = LatticeByRows.of(Cable.lattice_of(case.span, spacing=case.spacing, start=case.start))
    return Cable(
        span=case.span,
        spacing=case.spacing,
        tension=files.field(case.tension, "tension", lattice),
        load=files.field(case.load, "load", lattice),
        support=files.field(case.support, "support", lattice, upwards=case.upwards),
        frame_height=files.field(case.frame_height, "frame_height", lattice, upwards=case.upwards),
        start=case.start,
        upwards=case.upwards,
        ceiling=files.field(case.ceiling, "ceiling", lattice, upwards=case.upwards),
        foundation=files.field(case.foundation, "foundation", lattice),
    )


def _mesh_membrane(case: MeshMembraneCase, path: Path) -> MeshMembrane:
    files = _Files(path)
    heights = {
        name: files.field(getattr(case, name), name, None, upwards=case.upwards)
        for name in ("support", "frame_height", "ceiling")
    }
    mesh = existing_file(path, "file", case.file)
    given = {"load": case.load, "foundation": case.foundation, "fixed": case.fixed, "upwards": case.upwards}
    return MeshMembrane.from_meshio(mesh, case.tension, **heights, **given)


def _beam(case: BeamCase, path: Path) -> Beam:
    files = _Files(path, Line(case.start, case.span))
    between = LatticeByRows.of(Cable.lattice_of(case.span, spacing=case.spacing, start=case.start))
    lattice = LatticeByRows.of(Beam.lattice_of(case.span, spacing=case.spacing, ends=case.ends, start=case.start))
    return Beam(
        span=case.span,
        spacing=case.spacing,
        bending_stiffness=files.field(case.bending_stiffness, "bending_stiffness", between),
        tension=files.field(case.tension, "tension", between),
        load=files.field(case.load, "load", lattice),
        support=files.field(case.support, "support", lattice, upwards=case.upwards),
        ends=case.ends,
        frame_height=files.field(case.frame_height, "frame_height", lattice, upwards=case.upwards),
        start=case.start,
        upwards=case.upwards,
        ceiling=files.field(case.ceiling, "ceiling", lattice, upwards=case.upwards),
        foundation=files.field(case.foundation, "foundation", lattice),
    )


_KINDS: dict[str, tuple[type[Section], Callable[[Any, Path], Model]]] = {
    "membrane": (MembraneCase, _membrane),
    "cable": (CableCase, _cable),
    "beam": (BeamCase, _beam),
    "plate": (PlateCase, _plate),
    "mesh membrane": (MeshMembraneCase, _mesh_membrane),
}
"""The section that describes a kind of model, and what makes the model of it, by the name in the file."""
