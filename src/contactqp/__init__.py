"""Membranes and cables over rigid obstacles, solved by any backend by name, every answer with a certified error.

PYTEST_DONT_REWRITE: pytest marks all that a wheel with a plugin holds, and warns of what was imported too early.
"""

from . import gallery, profiles
from ._version import __version__ as __version__
from .algebra.stencil import Stencil
from .backends import backend_names
from .comparison.compare import compare
from .comparison.comparison import Comparison
from .errors import (
    CaseFileError,
    ContactWarning,
    MissingBackendError,
    NotCertifiedError,
    UnknownBackendError,
    UnsuitableProblemError,
)
from .geometry.frame import Frame
from .geometry.lattice import Lattice
from .models.cable import Cable
from .models.cable_net import CableNet
from .models.membrane import Membrane
from .paths.events import Events, events
from .paths.load_path import LoadPath
from .paths.touchdown import Touchdown
from .paths.trace import trace
from .problem.contact_qp import ContactQP
from .proof.certificate import Certificate
from .proof.certify import certify
from .proof.energy import complementary_energy, energy_bracket, feasible, potential_energy
from .proof.residuals import Residuals
from .proof.status import Status
from .solving.many import solve_many
from .solving.solution import Solution
from .solving.solve import solve
from .solving.solver import Solver

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
    "Solver",
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
    "solve_many",
    "trace",
]
