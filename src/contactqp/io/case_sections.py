"""The sections of a case file, as pydantic models: what each may hold, and what it builds."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field

from .. import profiles
from ..geometry.frame import Frame

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

PROFILES: dict[str, Any] = {
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
