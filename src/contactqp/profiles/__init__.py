"""Profiles: rigid surfaces f(x, y) to use as a support.

Every profile is a small callable that returns depths in the unit of its lengths: heights, positive downwards from the
plane of the frame; infinite where there is no surface. A model whose heights are positive upwards takes them as depths
all the same.
"""

from .along import Along
from .analytic import Cone, Cylinder, Hemisphere, HillAndFloor, Paraboloid, Plane, Profile, Uppermost
from .gridded import Gridded
from .sampled import Sampled
from .scattered import Scattered

__all__ = [
    "Along",
    "Cone",
    "Cylinder",
    "Gridded",
    "Hemisphere",
    "HillAndFloor",
    "Paraboloid",
    "Plane",
    "Profile",
    "Sampled",
    "Scattered",
    "Uppermost",
]
