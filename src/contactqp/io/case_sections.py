"""The sections of a case file, as pydantic models: what each may hold, and what it builds."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias

import numpy as np
from pydantic import BaseModel, ConfigDict, Discriminator, Field, StrictBool, Tag, TypeAdapter

from ..geometry.frame import Frame
from ..models.beam import End
from ..models.plate import Edge
from ..profiles.along import Along
from ..profiles.analytic import Cone, Cylinder, Hemisphere, HillAndFloor, Paraboloid, Plane, Profile
from ..profiles.sampled import Sampled
from .surfaces import surface_of_file

Positive: TypeAlias = Annotated[float, Field(gt=0, allow_inf_nan=False, strict=True)]


NonNegative: TypeAlias = Annotated[float, Field(ge=0, allow_inf_nan=False, strict=True)]


Finite: TypeAlias = Annotated[float, Field(allow_inf_nan=False, strict=True)]


Ordinate: TypeAlias = Annotated[float, Field(strict=True)]


Point: TypeAlias = tuple[Finite, Finite]


Corners: TypeAlias = Annotated[list[Point], Field(min_length=3)]


Column: TypeAlias = str | Annotated[int, Field(ge=0, strict=True)]


Delimiter: TypeAlias = Annotated[str, Field(min_length=1, max_length=1)]


class Section(BaseModel):
    """A table of a case file; keys that it does not know are refused."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True)


class _TableSection(Section):
    file: str
    """Path from the case file's folder."""
    delimiter: Delimiter | None = None
    """What separates the columns of a .csv file: by default a comma, and a semicolon where that is the decimal sign."""
    decimal: Literal[".", ","] = "."
    """What begins the decimals of a number in a .csv file."""

    @property
    def separator(self) -> str:
        """The delimiter that holds where none is given."""
        return self.delimiter or _DELIMITER_BESIDE[self.decimal]


_DELIMITER_BESIDE = {".": ",", ",": ";"}
"""What separates columns whose numbers have such a decimal sign."""


class _FileSection(_TableSection):
    key: str | None = None
    """Which array of a .npz file that holds several."""


class Rectangle(Section):
    """``shape = "rectangle"``, centred at (0, 0) unless ``center`` is given: see `Frame.rectangle`."""

    shape: Literal["rectangle"]
    width: Positive
    height: Positive
    center: Point = (0.0, 0.0)

    def build(self) -> Frame:
        """Return the frame that the section describes."""
        return Frame.rectangle(self.width, self.height, self.center)


class Hexagon(Section):
    """``shape = "hexagon"``, centred at (0, 0) unless ``center`` is given: see `Frame.hexagon`."""

    shape: Literal["hexagon"]
    side: Positive
    center: Point = (0.0, 0.0)

    def build(self) -> Frame:
        """Return the frame that the section describes."""
        return Frame.hexagon(self.side, self.center)


class Disk(Section):
    """``shape = "disk"``, centred at (0, 0) unless ``center`` is given: see `Frame.disk`."""

    shape: Literal["disk"]
    radius: Positive
    center: Point = (0.0, 0.0)

    def build(self) -> Frame:
        """Return the frame that the section describes."""
        return Frame.disk(self.radius, self.center)


class Polygon(Section):
    """``shape = "polygon"``: see `Frame.polygon`."""

    shape: Literal["polygon"]
    corners: Corners
    holes: list[Corners] = []

    def build(self) -> Frame:
        """Return the frame that the section describes."""
        return Frame.polygon(self.corners, self.holes)


class MaskFile(_FileSection):
    """``shape = "mask"``: nodes from a file, everything above ``threshold``.

    ``rows``, ``no_data`` and ``transform`` as for `DataFile`. The case's origin is the point of the smallest x and y;
    of a file with a geo-transform it is where that puts it.
    """

    shape: Literal["mask"]
    threshold: Finite = 0.5
    rows: Literal["up", "down"] | None = None
    no_data: Ordinate | None = None
    transform: StrictBool = True


FrameSection: TypeAlias = Annotated[Rectangle | Hexagon | Disk | Polygon | MaskFile, Field(discriminator="shape")]


class DataFile(_FileSection):
    """Values from a .npy, .npz, .csv, .tif or picture file: ``offset + factor * value``.

    Heights are positive downwards, unless the case says ``upwards = true``. A .tif file's values are taken as they are
    stored; a picture (.png, .jpg, .bmp, of 8 bits) holds grey levels from 0 (black) to 1 (white).

    ``rows = "up"``: the first row is that of the smallest y, which is so for .npy, .npz and .csv if nothing is said;
    ``rows = "down"``: of the largest, which is so for pictures and .tif. A .tif file's geo-transform tells where each
    value lies, so that the file may be larger than the lattice; ``transform = false`` leaves it aside. Where the values
    do not lie on the nodes, ``resample = true`` interpolates them bilinearly; without a geo-transform they are laid
    over the lattice's extent.

    ``no_data`` is a value that stands for none, as those that are nan and the one that a .tif file names; a node
    without a value is an error, or, with ``missing = "none"``, has no support.
    """

    factor: Finite = 1.0
    offset: Finite = 0.0
    resample: StrictBool = False
    rows: Literal["up", "down"] | None = None
    no_data: Ordinate | None = None
    missing: Literal["error", "none"] = "error"
    transform: StrictBool = True


class PlaneSection(Section):
    """``profile = "plane"``."""

    profile: Literal["plane"]
    depth: Finite
    slope_x: Finite = 0.0
    slope_y: Finite = 0.0


class ParaboloidSection(Section):
    """``profile = "paraboloid"``."""

    profile: Literal["paraboloid"]
    depth: Finite
    radius: Finite
    center: Point = (0.0, 0.0)


class ConeSection(Section):
    """``profile = "cone"``."""

    profile: Literal["cone"]
    depth: Finite
    slope: Finite
    center: Point = (0.0, 0.0)


class CylinderSection(Section):
    """``profile = "cylinder"``."""

    profile: Literal["cylinder"]
    depth: Finite
    radius: Positive
    center: Point = (0.0, 0.0)
    axis: Literal["x", "y"] = "y"


class HemisphereSection(Section):
    """``profile = "hemisphere"``."""

    profile: Literal["hemisphere"]
    depth: Finite
    radius: Positive
    center: Point = (0.0, 0.0)


class HillAndFloorSection(Section):
    """``profile = "hill-and-floor"``."""

    profile: Literal["hill-and-floor"]
    floor: Finite = 1.25
    hill: Positive = 5.0
    scale: Positive = 1.0


class Line(NamedTuple):
    """The line that a cable or a beam lies along.

    Attributes
    ----------
    start : float
        Abscissa of its left end (length).
    span : float
        Distance of its ends (length).
    """

    start: float
    span: float


class ProfileFromFile(_TableSection, ABC):
    """A profile through what a file holds."""

    @abstractmethod
    def build(self, file: Path, line: Line | None, *, upwards: bool, by_rows: bool) -> Profile:
        """Return the profile.

        Parameters
        ----------
        file : Path
            The section's file.
        line : Line or None
            What the model lies along, if that is a line.
        upwards : bool
            Whether heights are elevations, positive upwards.
        by_rows : bool
            Whether the values of a grid stay in the file until they are needed.
        """


class SampledSection(ProfileFromFile):
    """``profile = "sampled"``: two columns of a CSV file, see `profiles.Sampled.from_csv`.

    Heights are positive downwards, unless the case says ``upwards = true``.
    """

    profile: Literal["sampled"]
    x: Column = "x"
    depth: Column = "depth"
    duplicates: Literal["error", "mean", "first", "last", "shallowest", "deepest"] = "error"
    interpolation: Literal["linear", "pchip"] = "linear"
    outside: Literal["error", "hold", "none"] = "error"

    def build(self, file: Path, line: Line | None, *, upwards: bool, by_rows: bool) -> Profile:
        """Return the profile through the samples of the file; abscissae are the file's, wherever a line starts."""
        given = self.model_dump(exclude={"profile", "file", "delimiter"})
        return Sampled.from_csv(file, **given, delimiter=self.separator, upwards=upwards)


class MapSection(ProfileFromFile):
    """``profile = "map"``: a surface over x and y from a file, ``offset + factor * value``, see `read_surface`.

    A .tif file as its geo-transform puts it, a variable of .nc or .zarr with coordinates, or x, y and a value in each
    line of .xyz, .csv and .txt. Heights are positive downwards, unless the case says ``upwards = true``. A cable and a
    beam lie over it from ``start`` to ``end``, which are points of the map and lie ``span`` apart; without these, along
    its x axis.
    """

    profile: Literal["map"]
    key: Column | None = None
    """Which band, variable or column holds the values, where there are several."""
    x: Column | None = None
    """Which column of a text file holds x: by default the one called so, without a header the first."""
    y: Column | None = None
    """Which column of a text file holds y: by default the one called so, without a header the second."""
    start: Point | None = None
    """Where a cable or a beam starts, x and y on the map (length)."""
    end: Point | None = None
    """Where a cable or a beam ends, x and y on the map (length)."""
    factor: Finite = 1.0
    offset: Finite = 0.0
    no_data: Ordinate | None = None
    """A value that stands for none, beside nan and the one that a .tif file names."""
    duplicates: Literal["error", "mean", "first", "last", "shallowest", "deepest"] = "error"
    interpolation: Literal["linear", "nearest", "cubic"] = "linear"
    outside: Literal["error", "hold", "none"] = "error"

    def build(self, file: Path, line: Line | None, *, upwards: bool, by_rows: bool) -> Profile:
        """Return the surface, or what lies of it under a line."""
        told = self.model_dump(exclude={"profile", "file", "start", "end"})
        surface = surface_of_file(file, **told, upwards=upwards, by_rows=by_rows)
        if self.start is None and self.end is None:
            return surface
        if line is None:
            raise ValueError("start and end are for a cable or a beam; leave them out")
        if self.start is None or self.end is None:
            raise ValueError("start and end go together")
        along = Along(surface, self.start, self.end, abscissa=line.start)
        if abs(along.span - line.span) > _SAME_SPAN * line.span:
            x, y = np.add(self.start, np.subtract(self.end, self.start) * (line.span / along.span))
            raise ValueError(
                f"start and end are {along.span:.10g} apart, but span = {line.span:.10g}; say so, or end = "
                f"[{x:.10g}, {y:.10g}]"
            )
        return along


_SAME_SPAN = 1e-6
"""By which part of it a span and the distance of a map's points may differ, which are written with few digits."""


ProfileSection: TypeAlias = Annotated[
    PlaneSection
    | ParaboloidSection
    | ConeSection
    | CylinderSection
    | HemisphereSection
    | HillAndFloorSection
    | SampledSection
    | MapSection,
    Field(discriminator="profile"),
]

PROFILES: dict[str, Any] = {
    "plane": Plane,
    "paraboloid": Paraboloid,
    "cone": Cone,
    "cylinder": Cylinder,
    "hemisphere": Hemisphere,
    "hill-and-floor": HillAndFloor,
}


SECTIONS: dict[str, type[Section]] = {
    "rectangle": Rectangle,
    "hexagon": Hexagon,
    "disk": Disk,
    "polygon": Polygon,
    "mask": MaskFile,
    "plane": PlaneSection,
    "paraboloid": ParaboloidSection,
    "cone": ConeSection,
    "cylinder": CylinderSection,
    "hemisphere": HemisphereSection,
    "hill-and-floor": HillAndFloorSection,
    "sampled": SampledSection,
    "map": MapSection,
}
"""Sections by the shape or the profile that they are of."""


def _kind(value: Any) -> str | None:
    """Return which of the ways to give a field a value is meant to be; None if that cannot be told."""
    if not isinstance(value, (dict, BaseModel)):
        return "number"
    names = value if isinstance(value, dict) else type(value).model_fields
    return next((kind for kind in ("profile", "file") if kind in names), None)


_ByKind = Discriminator(_kind)

_Number: TypeAlias = Annotated[Finite, Tag("number")]
_File: TypeAlias = Annotated[DataFile, Tag("file")]
_Profile: TypeAlias = Annotated[ProfileSection, Tag("profile")]


def _kind_of_tension(value: Any) -> str:
    """Return whether a tension is given for all directions or for each."""
    return "pair" if isinstance(value, (list, tuple)) else "one"


Tension: TypeAlias = Annotated[Annotated[Positive, Tag("number")] | _File, _ByKind]
TensionOrPair: TypeAlias = Annotated[
    Annotated[Tension, Tag("one")] | Annotated[tuple[Tension, Tension], Tag("pair")], Discriminator(_kind_of_tension)
]
TensionOrNone: TypeAlias = Annotated[Annotated[NonNegative, Tag("number")] | _File, _ByKind]
Load: TypeAlias = Annotated[_Number | _File, _ByKind]
AnySupport: TypeAlias = Annotated[Annotated[Ordinate, Tag("number")] | _Profile, _ByKind]
"""A support where values of files would have no places."""
Support: TypeAlias = Annotated[Annotated[Ordinate, Tag("number")] | _File | _Profile, _ByKind]
FrameHeight: TypeAlias = Annotated[_Number | _Profile, _ByKind]


class _CaseInPlan(Section):
    title: str = ""
    frame: FrameSection
    """The contour that it is held at."""
    spacing: Positive
    """Distance of neighbouring nodes (length)."""
    origin: Point | None = None
    """A point of the lattice, x and y (length); by default one by which the frame fits, or (0, 0)."""
    fitted: StrictBool = False
    """Whether arms that the contour cuts end there, see `Frame.lattice`; not for a mask."""
    upwards: StrictBool = False
    """Whether heights are elevations, positive upwards."""
    crs: str = ""
    """Coordinate reference system of x and y, as "EPSG:25832"; a mask's .tif file may tell it, too."""
    load: Load
    """Active pressure, positive downwards (force per area)."""
    support: Support
    """Height of the rigid profile (length), positive downwards, or upwards with upwards = true; inf (-inf) for none."""
    frame_height: FrameHeight = 0.0
    """Height of the frame (length), positive as that of the support."""
    ceiling: Support | None = None
    """Height of a rigid surface above (length), positive as that of the support; -inf (inf) for none."""
    foundation: Load | None = None
    """Stiffness of an elastic foundation, which pulls to height zero, >= 0 (force per area and length)."""


class MembraneCase(_CaseInPlan):
    """``model = "membrane"``, which is the default.

    Heights (support, frame height, and the deflection that comes out) are positive downwards, or with
    ``upwards = true`` elevations, positive upwards; a load is positive downwards and a profile's ``depth`` a depth in
    either case.
    """

    model: Literal["membrane"] = "membrane"
    tension: TensionOrPair
    """Force per length: a number or a file; or two of these in brackets, along x and along y."""


class PlateCase(_CaseInPlan):
    """``model = "plate"``; heights as for a membrane. The frame must run along lattice lines."""

    model: Literal["plate"]
    bending_stiffness: Positive
    """D = Eh³/12(1 - ν²): force times length."""
    tension: NonNegative = 0.0
    """Force per length, 0 for none."""
    edge: Edge = "clamped"
    """How the edge is held: "clamped" or "simply supported"."""
    poisson_ratio: Finite = 0.3
    """ν, by which moments go."""


class CableCase(Section):
    """``model = "cable"``; heights as for a membrane."""

    model: Literal["cable"]
    title: str = ""
    span: Positive
    """Distance of the ends, a whole multiple of the spacing (length)."""
    start: Finite = 0.0
    """Abscissa of the left end (length)."""
    upwards: StrictBool = False
    """Whether heights are elevations, positive upwards."""
    spacing: Positive
    """Distance of neighbouring nodes (length)."""
    tension: Tension
    """Force: a number or a file."""
    load: Load
    """Active load, positive downwards (force per length)."""
    support: Support
    """Height of the ground (length), positive downwards, or upwards with upwards = true; inf (-inf) for none."""
    frame_height: FrameHeight = 0.0
    """Heights of the ends (length), positive as that of the ground."""
    ceiling: Support | None = None
    """Height of a rigid surface above the cable (length), positive as that of the ground; -inf (inf) for none."""
    foundation: Load | None = None
    """Stiffness of an elastic foundation, which pulls to height zero, >= 0 (force per length and length)."""


class MeshMembraneCase(Section):
    """``model = "mesh membrane"``; heights as for a membrane."""

    model: Literal["mesh membrane"]
    title: str = ""
    file: str
    """A mesh of triangles that meshio reads, as Gmsh's .msh; path from the case file's folder."""
    fixed: str | list[str] | None = None
    """Groups of the mesh whose points are fixed, by name; by default the boundary."""
    upwards: StrictBool = False
    """Whether heights are elevations, positive upwards."""
    tension: Positive
    """Force per length."""
    load: Finite
    """Active pressure, positive downwards (force per area)."""
    support: AnySupport
    """Height of the rigid profile (length), positive downwards, or upwards with upwards = true; inf (-inf) for none."""
    frame_height: FrameHeight = 0.0
    """Height of the fixed points (length), positive as that of the support."""
    ceiling: AnySupport | None = None
    """Height of a rigid surface above the membrane (length), positive as that of the support; -inf (inf) for none."""
    foundation: Finite | None = None
    """Stiffness of an elastic foundation, which pulls to height zero, >= 0 (force per area and length)."""


class BeamCase(Section):
    """``model = "beam"``; heights as for a membrane."""

    model: Literal["beam"]
    title: str = ""
    span: Positive
    """Distance of the ends, a whole multiple of the spacing (length)."""
    start: Finite = 0.0
    """Abscissa of the left end (length)."""
    ends: End | tuple[End, End] = ("pinned", "pinned")
    """How the left and the right end are held, "pinned", "clamped" or "free": one word for both, or two in brackets."""
    upwards: StrictBool = False
    """Whether heights are elevations, positive upwards."""
    spacing: Positive
    """Distance of neighbouring nodes (length)."""
    bending_stiffness: Tension
    """EI, force times length squared: a number, or a file with a value for each node between the ends."""
    tension: TensionOrNone = 0.0
    """Force: a number, 0 for none, or a file with a value for each node between the ends."""
    load: Load
    """Active load, positive downwards (force per length)."""
    support: Support
    """Height of the ground (length), positive downwards, or upwards with upwards = true; inf (-inf) for none."""
    frame_height: FrameHeight = 0.0
    """Heights of the ends that are held (length), positive as that of the ground."""
    ceiling: Support | None = None
    """Height of a rigid surface above the beam (length), positive as that of the ground; -inf (inf) for none."""
    foundation: Load | None = None
    """Stiffness of an elastic foundation, which pulls to height zero, >= 0 (force per length and length)."""


def schema() -> dict[str, Any]:
    """Return the JSON schema of case files.

    Examples
    --------
    >>> schema()["$schema"]
    'https://json-schema.org/draft/2020-12/schema'
    """
    found = TypeAdapter[Any](MembraneCase | CableCase | MeshMembraneCase | BeamCase | PlateCase).json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "contactqp case file"} | found
