"""Gallery: named problems with known answers, for tests, benchmarks and lectures."""

from .beams import beam_on_floor
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
    islands,
    l_shape_with_hole,
    orthotropic_ellipse,
    paper_hexagon,
    spiral,
)
from .plates import plate_under_load

__all__ = [
    "PAPER_CORNERS",
    "PAPER_LOADS",
    "ball",
    "beam_on_floor",
    "bowl",
    "cable_between_floor_and_ceiling",
    "cable_of_varying_tension",
    "cable_on_floor",
    "cable_on_foundation",
    "cable_on_parabola",
    "cable_on_posts",
    "islands",
    "l_shape_with_hole",
    "orthotropic_ellipse",
    "paper_hexagon",
    "plate_under_load",
    "spiral",
]
