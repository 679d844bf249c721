"""Gallery: named problems with known answers, for tests, benchmarks and lectures.

`names` lists the entries, `load` returns one in the shape of `Known`: model, exact deflection and reaction or published
numbers, and their source. The other functions return models, and closed forms beside them, with parameters of their
own.
"""

from . import cutest as _cutest  # noqa: F401  (entries are put into the catalogue where they are made)
from . import options as _options  # noqa: F401
from . import rough as _rough  # noqa: F401
from . import seepage as _seepage  # noqa: F401
from .beams import beam_between_floor_and_ceiling, beam_on_floor, beam_on_foundation
from .cables import (
    cable_between_floor_and_ceiling,
    cable_of_varying_tension,
    cable_on_floor,
    cable_on_foundation,
    cable_on_parabola,
    cable_on_posts,
)
from .catalogue import load, names
from .known import Known, Quoted
from .membranes import (
    PAPER_CORNERS,
    PAPER_LOADS,
    bowl,
    islands,
    l_shape_with_hole,
    orthotropic_ellipse,
    paper_hexagon,
    spiral,
)
from .plates import plate_under_load
from .radial import ball, disk_on_floor, meshed_disk_on_floor

__all__ = [
    "PAPER_CORNERS",
    "PAPER_LOADS",
    "Known",
    "Quoted",
    "ball",
    "beam_between_floor_and_ceiling",
    "beam_on_floor",
    "beam_on_foundation",
    "bowl",
    "cable_between_floor_and_ceiling",
    "cable_of_varying_tension",
    "cable_on_floor",
    "cable_on_foundation",
    "cable_on_parabola",
    "cable_on_posts",
    "disk_on_floor",
    "islands",
    "l_shape_with_hole",
    "load",
    "meshed_disk_on_floor",
    "names",
    "orthotropic_ellipse",
    "paper_hexagon",
    "plate_under_load",
    "spiral",
]
