"""Membranes and cables over rigid obstacles, solved by any backend by name, every answer with a certified error.

A frame is covered by a lattice of nodes; load and support make it a model; a solution tells what it is worth::

    import contactqp as cq

    lattice = cq.Frame.rectangle(4, 4).lattice(spacing=0.25)
    membrane = cq.Membrane(lattice, tension=1.0, load=1.0, support=0.5)
    solution = cq.solve(membrane)
    solution.plot().savefig("membrane.png")

Heights, deflections and loads are positive downwards.

Models: `Membrane`, `MeshMembrane`, `Cable`, `CableNet`, `Beam`, `Plate`, and `ContactQP` for a matrix of your own,
`ContactLCP` for one that is not symmetric. Solving: `solve`, `solve_many`,
`Solver` (one model under many loads), `compare` (several backends), `trace` and `events` (a growing load), `refine`
(finer meshes), `study` (a problem of the gallery against its closed form). Proofs: `certify` encloses the true
solution, given any program's answer; `contactqp.testing` asserts it. `explore` writes a page with sliders that solves
and proves in the browser.

PYTEST_DONT_REWRITE: pytest marks all that a wheel with a plugin holds, and warns of what was imported too early.
"""

from importlib import import_module
from types import ModuleType

from . import gallery, profiles
from . import plotting as _plotting  # noqa: F401  (pictures are registered by it)
from ._version import __version__ as __version__
from .algebra.stencil import Stencil
from .backends import backend_names
from .comparison.compare import compare
from .comparison.comparison import Comparison
from .continuum.contact import ContactBounds
from .continuum.energy_estimate import EnergyEstimate
from .continuum.estimate import DiscretisationEstimate
from .continuum.membrane import MembraneBounds
from .continuum.result import Continuum, NodalBounds
from .errors import (
    CaseFileError,
    ContactWarning,
    MissingBackendError,
    NotCertifiedError,
    UnknownBackendError,
    UnsuitableProblemError,
)
from .explorer.page import explore
from .geometry.between import between
from .geometry.frame import Frame
from .geometry.lattice import Lattice
from .geometry.smooth import Smooth
from .io.read_fields import read_field, read_mask
from .io.surfaces import read_surface
from .models.beam import Beam
from .models.cable import Cable
from .models.cable_net import CableNet
from .models.membrane import Membrane
from .models.mesh_membrane import MeshMembrane
from .models.plate import Plate
from .paths.events import Events, events
from .paths.load_path import LoadPath
from .paths.march import march
from .paths.time_history import TimeHistory
from .paths.touchdown import Touchdown
from .paths.touchdown_between import touchdown_between
from .paths.trace import trace
from .problem.contact_lcp import ContactLCP
from .problem.contact_qp import ContactQP
from .problem.read import read
from .proof.certificate import Certificate
from .proof.certify import certify
from .proof.energy import complementary_energy, energy_bracket, feasible, potential_energy
from .proof.residuals import Residuals
from .proof.status import Status
from .refinement.refine import Refinement, refine
from .refinement.solve_to import SolvedTo, solve_to
from .solving.family import Family, solve_between
from .solving.loaded import load_solution
from .solving.many import solve_many
from .solving.solution import Solution
from .solving.solve import solve
from .solving.solver import Solver
from .studies.study import Study, study

__all__ = [
    "Beam",
    "Cable",
    "CableNet",
    "CaseFileError",
    "Certificate",
    "Comparison",
    "ContactBounds",
    "ContactLCP",
    "ContactQP",
    "ContactWarning",
    "Continuum",
    "DiscretisationEstimate",
    "EnergyEstimate",
    "Events",
    "Family",
    "Frame",
    "Lattice",
    "LoadPath",
    "Membrane",
    "MembraneBounds",
    "MeshMembrane",
    "MissingBackendError",
    "NodalBounds",
    "NotCertifiedError",
    "Plate",
    "Refinement",
    "Residuals",
    "Smooth",
    "Solution",
    "SolvedTo",
    "Solver",
    "Status",
    "Stencil",
    "Study",
    "TimeHistory",
    "Touchdown",
    "UnknownBackendError",
    "UnsuitableProblemError",
    "backend_names",
    "between",
    "certify",
    "compare",
    "complementary_energy",
    "energy_bracket",
    "events",
    "explore",
    "feasible",
    "gallery",
    "load_solution",
    "march",
    "potential_energy",
    "profiles",
    "read",
    "read_field",
    "read_mask",
    "read_surface",
    "refine",
    "solve",
    "solve_between",
    "solve_many",
    "solve_to",
    "study",
    "touchdown_between",
    "trace",
]

_MODULES = ("benchmark", "mpi", "testing", "xarray")
_PUBLIC = sorted([*__all__, *_MODULES, "__version__", "__doc__", "__all__", "__file__", "__name__", "__path__"])


def __dir__() -> list[str]:
    """Return what is public, for completion: the modules that the package is built of stand in folders of their own."""
    return _PUBLIC


def __getattr__(name: str) -> ModuleType:
    """Import the public modules where they are first asked for."""
    if name in _MODULES:
        return import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
