"""Gallery: named problems with known answers, for tests, benchmarks and lectures."""

from .beams import beam_between_floor_and_ceiling, beam_on_floor, beam_on_foundation
from .cables import (
    cable_between_floor_and_ceiling,
    cable_of_varying_tension,
    cable_on_floor,
    cable_on_foundation,
    cable_on_parabola,
    cable_on_posts,
)
from .membranes import (
    PAPER_CORNERS,
    PAPER_LOADS,
    ball,
    bowl,
    disk_on_floor,
    islands,
    l_shape_with_hole,
    meshed_disk_on_floor,
    orthotropic_ellipse,
    paper_hexagon,
    spiral,
)
from .plates import plate_under_load

__all__ = [
    "PAPER_CORNERS",
    "PAPER_LOADS",
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
    "meshed_disk_on_floor",
    "orthotropic_ellipse",
    "paper_hexagon",
    "plate_under_load",
    "spiral",
]
