"""Profiles: rigid surfaces f(x, y) to use as a support.

Every profile is a small callable that returns ordinates in the unit of its lengths, positive downwards from the plane
of the frame; infinite where there is no surface.
"""

from .analytic import Cone, Cylinder, Hemisphere, HillAndFloor, Paraboloid, Plane, Uppermost
from .sampled import Sampled

__all__ = [
    "Cone",
    "Cylinder",
    "Hemisphere",
    "HillAndFloor",
    "Paraboloid",
    "Plane",
    "Sampled",
    "Uppermost",
]
