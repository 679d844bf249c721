"""Membranes and cables over rigid obstacles, solved by any backend by name, every answer with a certified error.

PYTEST_DONT_REWRITE: pytest marks all that a wheel with a plugin holds, and warns of what was imported too early.
"""

from . import gallery, profiles
from .backends import backend_names
from .cable import Cable
from .certificate import Certificate, certify
from .compare import Comparison, compare
from .errors import (
    CaseFileError,
    ContactWarning,
    MissingBackendError,
    NotCertifiedError,
    UnknownBackendError,
    UnsuitableProblemError,
)
from .frame import Frame
from .judge import Residuals, Status
from .lattice import Lattice
from .membrane import Membrane
from .problem import ContactQP
from .solution import Solution
from .solve import solve
from .stencil import Stencil

__version__ = "0.1.0"

__all__ = [
    "Cable",
    "CaseFileError",
    "Certificate",
    "Comparison",
    "ContactQP",
    "ContactWarning",
    "Frame",
    "Lattice",
    "Membrane",
    "MissingBackendError",
    "NotCertifiedError",
    "Residuals",
    "Solution",
    "Status",
    "Stencil",
    "UnknownBackendError",
    "UnsuitableProblemError",
    "backend_names",
    "certify",
    "compare",
    "gallery",
    "profiles",
    "solve",
]
