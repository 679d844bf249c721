"""Case files: a contact problem described in TOML, validated before anything is computed."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from . import profiles
from .cable import Cable
from .errors import CaseFileError
from .frame import Frame
from .lattice import Lattice
from .membrane import Membrane

Positive: TypeAlias = Annotated[float, Field(gt=0, allow_inf_nan=False, strict=True)]
Finite: TypeAlias = Annotated[float, Field(allow_inf_nan=False, strict=True)]
Ordinate: TypeAlias = Annotated[float, Field(strict=True)]
Point: TypeAlias = tuple[Finite, Finite]
Corners: TypeAlias = Annotated[list[Point], Field(min_length=3)]
Column: TypeAlias = str | Annotated[int, Field(ge=0, strict=True)]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid")


class Rectangle(_Section):
    """``shape = "rectangle"``: see `Frame.rectangle`."""

    shape: Literal["rectangle"]
    width: Positive
    height: Positive
    center: Point = (0.0, 0.0)

    def build(self) -> Frame:
        """Return the frame that the section describes."""
        return Frame.rectangle(self.width, self.height, self.center)


class Hexagon(_Section):
    """``shape = "hexagon"``: see `Frame.hexagon`."""

    shape: Literal["hexagon"]
    side: Positive
    center: Point = (0.0, 0.0)

    def build(self) -> Frame:
        """Return the frame that the section describes."""
        return Frame.hexagon(self.side, self.center)


class Disk(_Section):
    """``shape = "disk"``: see `Frame.disk`."""

    shape: Literal["disk"]
    radius: Positive
    center: Point = (0.0, 0.0)

    def build(self) -> Frame:
        """Return the frame that the section describes."""
        return Frame.disk(self.radius, self.center)


class Polygon(_Section):
    """``shape = "polygon"``: see `Frame.polygon`."""

    shape: Literal["polygon"]
    corners: Corners
    holes: list[Corners] = []

    def build(self) -> Frame:
        """Return the frame that the section describes."""
        return Frame.polygon(self.corners, self.holes)


class MaskFile(_Section):
    """``shape = "mask"``: nodes from a file, everything above ``threshold``; the case's origin is the first entry's."""

    shape: Literal["mask"]
    file: str
    threshold: Finite = 0.5


FrameSection: TypeAlias = Annotated[Rectangle | Hexagon | Disk | Polygon | MaskFile, Field(discriminator="shape")]


class DataFile(_Section):
    """Values from a .npy, .csv, .npz or image file: ``offset + factor * value``.

    An image's grey levels run from 0 (black) to 1 (white), and its first row is the one with the largest y. Where the
    file's shape is not the lattice's, ``resample = true`` interpolates it over the lattice's extent.
    """

    file: str
    key: str | None = None
    factor: Finite = 1.0
    offset: Finite = 0.0
    resample: bool = False


class PlaneSection(_Section):
    """``profile = "plane"``."""

    profile: Literal["plane"]
    depth: Finite
    slope_x: Finite = 0.0
    slope_y: Finite = 0.0


class ParaboloidSection(_Section):
    """``profile = "paraboloid"``."""

    profile: Literal["paraboloid"]
    depth: Finite
    radius: Finite
    center: Point = (0.0, 0.0)


class ConeSection(_Section):
    """``profile = "cone"``."""

    profile: Literal["cone"]
    depth: Finite
    slope: Finite
    center: Point = (0.0, 0.0)


class CylinderSection(_Section):
    """``profile = "cylinder"``."""

    profile: Literal["cylinder"]
    depth: Finite
    radius: Positive
    center: Point = (0.0, 0.0)
    axis: Literal["x", "y"] = "y"


class HemisphereSection(_Section):
    """``profile = "hemisphere"``."""

    profile: Literal["hemisphere"]
    depth: Finite
    radius: Positive
    center: Point = (0.0, 0.0)


class HillAndFloorSection(_Section):
    """``profile = "hill-and-floor"``."""

    profile: Literal["hill-and-floor"]
    floor: Finite = 1.25
    hill: Positive = 5.0
    scale: Positive = 1.0


class SampledSection(_Section):
    """``profile = "sampled"``: two columns of a CSV file, see `profiles.Sampled.from_csv`."""

    profile: Literal["sampled"]
    file: str
    x: Column = "x"
    depth: Column = "depth"
    delimiter: Annotated[str, Field(min_length=1, max_length=1)] = ","
    interpolation: Literal["linear", "pchip"] = "linear"
    outside: Literal["error", "hold", "none"] = "error"


ProfileSection: TypeAlias = Annotated[
    PlaneSection
    | ParaboloidSection
    | ConeSection
    | CylinderSection
    | HemisphereSection
    | HillAndFloorSection
    | SampledSection,
    Field(discriminator="profile"),
]

_PROFILES: dict[str, Any] = {
    "plane": profiles.Plane,
    "paraboloid": profiles.Paraboloid,
    "cone": profiles.Cone,
    "cylinder": profiles.Cylinder,
    "hemisphere": profiles.Hemisphere,
    "hill-and-floor": profiles.HillAndFloor,
    "sampled": profiles.Sampled.from_csv,
}


class MembraneCase(_Section):
    """``model = "membrane"``, which is the default."""

    model: Literal["membrane"] = "membrane"
    title: str = ""
    frame: FrameSection
    spacing: Positive
    origin: Point = (0.0, 0.0)
    tension: Positive
    load: Finite | DataFile
    support: Ordinate | DataFile | ProfileSection
    frame_height: Finite | ProfileSection = 0.0


class CableCase(_Section):
    """``model = "cable"``."""

    model: Literal["cable"]
    title: str = ""
    span: Positive
    start: Finite = 0.0
    spacing: Positive
    tension: Positive
    load: Finite | DataFile
    support: Ordinate | DataFile | ProfileSection
    frame_height: Finite | ProfileSection = 0.0


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
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise CaseFileError(f"{path}: cannot read the case file: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise CaseFileError(f"{path}: not a TOML file: {error}") from None
    kind: type[MembraneCase] | type[CableCase] = CableCase if data.get("model") == "cable" else MembraneCase
    try:
        case = kind.model_validate(data)
    except ValidationError as error:
        raise CaseFileError(f"{path}:\n" + "\n".join(_explain(error))) from None
    try:
        return _cable(case, path) if isinstance(case, CableCase) else _membrane(case, path)
    except CaseFileError:
        raise
    except (ValueError, TypeError) as error:
        raise CaseFileError(f"{path}: {error}") from None


def _membrane(case: MembraneCase, path: Path) -> Membrane:
    if isinstance(case.frame, MaskFile):
        grid = _read(path, "frame.file", case.frame.file, None)
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
    probe = Cable(span=case.span, spacing=case.spacing, tension=1.0, load=0.0, support=0.0, start=case.start)
    return Cable(
        span=case.span,
        spacing=case.spacing,
        tension=case.tension,
        load=_field(case.load, "load", probe.lattice, path),
        support=_field(case.support, "support", probe.lattice, path),
        frame_height=_field(case.frame_height, "frame_height", probe.lattice, path),
        start=case.start,
    )


def _field(value: Any, key: str, lattice: Lattice, path: Path) -> Any:
    if isinstance(value, float):
        return value
    if isinstance(value, DataFile):
        grid = _read(path, f"{key}.file", value.file, value.key)
        if lattice.shape[0] == 1:
            grid = grid.reshape(1, -1)
        if grid.shape != lattice.shape:
            if not value.resample:
                raise CaseFileError(
                    f"{path}: {key}.file = {value.file!r} has shape {grid.shape}, the lattice {lattice.shape}; "
                    "bring it to that shape or set resample = true"
                )
            grid = _resampled(grid, lattice)
        return value.offset + value.factor * grid
    parameters = value.model_dump(exclude={"profile"})
    if isinstance(value, SampledSection):
        parameters["path"] = _existing(path, f"{key}.file", parameters.pop("file"))
    try:
        return _PROFILES[value.profile](**parameters)
    except (ValueError, OSError) as error:
        raise CaseFileError(f"{path}: {key}: {error}") from None


def _existing(case_path: Path, key: str, name: str) -> Path:
    """Return the path of a file that a case names relative to its own folder."""
    file = case_path.parent / name
    if not file.is_file():
        raise CaseFileError(f"{case_path}: {key} = {name!r}: there is no file {file}")
    return file


def _read(case_path: Path, key: str, name: str, entry: str | None) -> NDArray[np.float64]:
    file = _existing(case_path, key, name)
    where = f"{case_path}: {key} = {name!r}"
    try:
        match file.suffix.lower():
            case ".npy":
                values = np.load(file)
            case ".npz":
                with np.load(file) as archive:
                    names = list(archive)
                    if entry is None and len(names) != 1:
                        raise CaseFileError(f"{where}: choose one of its arrays by key: {', '.join(names)}")
                    if entry is not None and entry not in names:
                        raise CaseFileError(f"{where}: no array {entry!r} in it; it has {', '.join(names)}")
                    values = archive[entry or names[0]]
            case ".csv":
                values = np.loadtxt(file, delimiter=",", ndmin=2)
            case ".png" | ".jpg" | ".jpeg" | ".tif" | ".tiff" | ".bmp":
                values = _grey(file)
            case suffix:
                raise CaseFileError(f"{where}: unknown kind {suffix!r}; known: .npy .npz .csv .png .jpg .tif .bmp")
    except CaseFileError:
        raise
    except (ValueError, OSError) as error:
        raise CaseFileError(f"{where}: cannot read it: {error}") from None
    array = np.atleast_2d(np.asarray(values))
    if array.ndim != 2 or array.dtype.kind not in "biuf":
        raise CaseFileError(
            f"{where}: expected a two-dimensional array of numbers, got {array.dtype} of shape {array.shape}"
        )
    return array.astype(np.float64)


def _grey(file: Path) -> NDArray[np.float64]:
    from matplotlib import image

    pixels = np.asarray(image.imread(file))
    if pixels.dtype.kind in "ui":
        pixels = pixels / np.iinfo(pixels.dtype).max
    if pixels.ndim == 3:
        pixels = pixels[..., :3].mean(axis=2) if pixels.shape[2] >= 3 else pixels[..., 0]
    return np.asarray(pixels[::-1], dtype=np.float64)


def _resampled(grid: NDArray[np.float64], lattice: Lattice) -> NDArray[np.float64]:
    """Interpolate bilinearly: the file's corners fall on the corners of the lattice's array."""
    from scipy.interpolate import RegularGridInterpolator

    axes = [np.linspace(0, 1, n) if n > 1 else np.array([0.0, 1.0]) for n in grid.shape]
    padded = np.repeat(grid, 2, axis=0) if grid.shape[0] == 1 else grid
    padded = np.repeat(padded, 2, axis=1) if grid.shape[1] == 1 else padded
    targets = [np.linspace(0, 1, n) if n > 1 else np.array([0.5]) for n in lattice.shape]
    points = np.stack(np.meshgrid(*targets, indexing="ij"), axis=-1)
    return np.asarray(RegularGridInterpolator(axes, padded)(points))


def _explain(error: ValidationError) -> list[str]:
    lines = []
    for problem in error.errors():
        tags = {*_PROFILES, "rectangle", "hexagon", "disk", "polygon", "mask", "DataFile", "float", "function-after"}
        key = ".".join(str(part) for part in problem["loc"] if str(part) not in tags and "[" not in str(part))
        given = "" if problem["type"] == "missing" else f", got {problem['input']!r}"
        lines.append(f"  {key or 'file'}: {problem['msg'][0].lower()}{problem['msg'][1:]}{given}")
    return list(dict.fromkeys(lines))
