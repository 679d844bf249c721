"""The sections of a case file, as pydantic models: what each may hold, and what it builds."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, StrictBool

from ..geometry.frame import Frame
from ..profiles.analytic import Cone, Cylinder, Hemisphere, HillAndFloor, Paraboloid, Plane
from ..profiles.sampled import Sampled

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
    """``shape = "mask"``: nodes from a file, everything above ``threshold``.

    ``rows``, ``no_data`` and ``transform`` as for `DataFile`. The case's origin is the point of the smallest x and y;
    of a file with a geo-transform it is where that puts it.
    """

    shape: Literal["mask"]
    file: str
    threshold: Finite = 0.5
    rows: Literal["up", "down"] | None = None
    no_data: Ordinate | None = None
    transform: StrictBool = True


FrameSection: TypeAlias = Annotated[Rectangle | Hexagon | Disk | Polygon | MaskFile, Field(discriminator="shape")]


class DataFile(_Section):
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

    file: str
    key: str | None = None
    factor: Finite = 1.0
    offset: Finite = 0.0
    resample: StrictBool = False
    rows: Literal["up", "down"] | None = None
    no_data: Ordinate | None = None
    missing: Literal["error", "none"] = "error"
    transform: StrictBool = True


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
    """``profile = "sampled"``: two columns of a CSV file, see `profiles.Sampled.from_csv`.

    Heights are positive downwards, unless the case says ``upwards = true``.
    """

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

PROFILES: dict[str, Any] = {
    "plane": Plane,
    "paraboloid": Paraboloid,
    "cone": Cone,
    "cylinder": Cylinder,
    "hemisphere": Hemisphere,
    "hill-and-floor": HillAndFloor,
    "sampled": Sampled.from_csv,
}


class MembraneCase(_Section):
    """``model = "membrane"``, which is the default.

    Heights (support, frame height, and the deflection that comes out) are positive downwards, or with
    ``upwards = true`` elevations, positive upwards; a load is positive downwards and a profile's ``depth`` a depth in
    either case.
    """

    model: Literal["membrane"] = "membrane"
    title: str = ""
    frame: FrameSection
    spacing: Positive
    origin: Point | None = None
    upwards: StrictBool = False
    tension: Positive
    load: Finite | DataFile
    support: Ordinate | DataFile | ProfileSection
    frame_height: Finite | ProfileSection = 0.0


class CableCase(_Section):
    """``model = "cable"``; heights as for a membrane."""

    model: Literal["cable"]
    title: str = ""
    span: Positive
    start: Finite = 0.0
    upwards: StrictBool = False
    spacing: Positive
    tension: Positive
    load: Finite | DataFile
    support: Ordinate | DataFile | ProfileSection
    frame_height: Finite | ProfileSection = 0.0
