"""Membranes and cables over rigid obstacles, solved by any backend by name, every answer with a certified error.

PYTEST_DONT_REWRITE: pytest marks all that a wheel with a plugin holds, and warns of what was imported too early.
"""

from . import gallery, profiles
from .backends import backend_names
from .cable import Cable
from .cable_net import CableNet
from .certificate import Certificate, certify
from .compare import Comparison, compare
from .energy import complementary_energy, energy_bracket, feasible, potential_energy
from .errors import (
    CaseFileError,
    ContactWarning,
    MissingBackendError,
    NotCertifiedError,
    UnknownBackendError,
    UnsuitableProblemError,
)
from .events import Events, events
from .frame import Frame
from .judge import Residuals, Status
from .lattice import Lattice
from .membrane import Membrane
from .path import LoadPath, trace
from .problem import ContactQP
from .solution import Solution
from .solve import solve
from .stencil import Stencil
from .touchdown import Touchdown

__version__ = "0.1.0"

__all__ = [
    "Cable",
    "CableNet",
    "CaseFileError",
    "Certificate",
    "Comparison",
    "ContactQP",
    "ContactWarning",
    "Events",
    "Frame",
    "Lattice",
    "LoadPath",
    "Membrane",
    "MissingBackendError",
    "NotCertifiedError",
    "Residuals",
    "Solution",
    "Status",
    "Stencil",
    "Touchdown",
    "UnknownBackendError",
    "UnsuitableProblemError",
    "backend_names",
    "certify",
    "compare",
    "complementary_energy",
    "energy_bracket",
    "events",
    "feasible",
    "gallery",
    "potential_energy",
    "profiles",
    "solve",
    "trace",
]
