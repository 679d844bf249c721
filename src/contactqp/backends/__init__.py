"""The table of backends: a name, and the class that realises it.

Other distributions add theirs by an entry point in the group ``contactqp.backends`` whose value is a subclass of
`contactqp.backends.base.Backend`.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

from ..errors import ContactWarning, MissingBackendError, UnknownBackendError, UnsuitableProblemError
from ..foundation.checks import nearest
from ..methods.factors import DIRECT_SIZE

if TYPE_CHECKING:
    from importlib import metadata

    from ..problem.contact_problem import ContactProblem
    from .base import Backend

TABLE = {
    "osqp": "contactqp.backends.osqp:Osqp",
    "clarabel": "contactqp.backends.clarabel:Clarabel",
    "mangasarian": "contactqp.backends.mangasarian:Mangasarian",
    "psor": "contactqp.backends.psor:Psor",
    "multigrid": "contactqp.backends.multigrid:Multigrid",
    "active-set": "contactqp.backends.active_set:ActiveSetBackend",
    "mprgp": "contactqp.backends.mprgp:Mprgp",
    "qpsolvers:": "contactqp.backends.qpsolvers:QpSolvers",
    "cvxpy:": "contactqp.backends.cvxpy:Cvxpy",
}
"""Name of a backend to the module and class that realise it. A name that ends with a colon stands for a family: its
class is called with what follows the colon, and the instance is the backend (`contactqp.backends.families`)."""

BY_NAME = {"petsc": "contactqp.backends.petsc:Petsc"}
"""Backends that are asked where they are named, or all are, and by no default: their programs are installed by other
means than this package's own, and have to be started."""

ENTRY_POINT_GROUP = "contactqp.backends"

_PLACES = TABLE | BY_NAME


def backend_names() -> list[str]:
    """Return the names of all backends that are asked by default, those of other distributions last.

    Others are asked where they are named, see `names_besides`.

    Examples
    --------
    >>> import contactqp as cq
    >>> cq.backend_names()[:4]
    ['osqp', 'clarabel', 'mangasarian', 'psor']
    """
    return [*_own_names(), *(name for name in _outsiders() if name not in TABLE)]


def family_names() -> list[str]:
    """Return the names of all solvers that other packages call, installed or not.

    Examples
    --------
    >>> "qpsolvers:piqp" in family_names()
    True
    """
    return [key + solver for key in _families() for solver in _realised(TABLE[key]).names()]


def names_besides() -> list[str]:
    """Return the names of all backends that are asked only where they are named, or all are, installed or not.

    Examples
    --------
    >>> names_besides()[:2]
    ['petsc', 'qpsolvers:piqp']
    """
    return [*BY_NAME, *family_names()]


def kind_of(name: str) -> str:
    """Return what kind of backend a name stands for: own, library, a family's, or a plug-in.

    Examples
    --------
    >>> kind_of("psor"), kind_of("petsc"), kind_of("qpsolvers:piqp")
    ('own', 'library', 'qpsolvers family')
    """
    family = _family_of(name)
    if family is not None:
        return f"{family.removesuffix(':')} family"
    if name not in _PLACES:
        return "plug-in"
    return "library" if _realised(_PLACES[name]).has_own_defaults else "own"


def get_backend(backend: str | Backend) -> Backend:
    """Return the backend of a name; a backend itself is returned as it is.

    Raises
    ------
    TypeError
        If it is neither a name nor a backend, or the backend declares no name, or options that are no named keywords.
    UnknownBackendError
        If there is no such backend; the message lists the known ones.
    MissingBackendError
        If another distribution's backend cannot be loaded, or a package that calls solvers by name knows this one and
        does not find it; the message says why, and what to install.
    """
    from .base import Backend
    from .contract import check_declared

    if isinstance(backend, Backend):
        check_declared(backend)
        return backend
    if not isinstance(backend, str):
        raise TypeError(f"backend must be a name or a Backend, got {backend!r}")
    if backend in (*_own_names(), *BY_NAME):
        own: Backend = _realised(_PLACES[backend])()
        return own
    alone = f"{backend.removesuffix(':')}:"
    if alone in _families():
        members = _realised(TABLE[alone])
        raise UnknownBackendError(
            f"unknown backend {backend!r}: its solvers are named as '{alone}NAME'; installed: "
            f"{', '.join(alone + solver for solver in members.found_here()) or 'none'}; known: "
            f"{', '.join(alone + solver for solver in members.names())}"
        )
    family = _family_of(backend)
    if family is not None:
        members, solver = _realised(TABLE[family]), backend.removeprefix(family)
        if members.knows(solver):
            found: Backend = members(solver)
            return found
        missing = members.why_not_found(solver)
        if missing is not None:
            raise MissingBackendError(f"backend {backend!r} is missing: {missing}")
    if backend in _outsiders():
        return _loaded(backend, _outsiders()[backend])
    if family is None:
        known = ["auto", *backend_names(), *BY_NAME]
        members = [key + solver for key in _families() for solver in _realised(TABLE[key]).listed()]
        same = next((member for member in members if member.endswith(f":{backend}")), None)
        meant = f"; did you mean {same!r}?" if same else nearest(backend, [*known, *members])
    else:
        known = [family + solver for solver in _realised(TABLE[family]).names()]
        meant = nearest(backend, known)
    raise UnknownBackendError(f"unknown backend {backend!r}{meant}; known: {', '.join(known)}")


def suitable_backends(problem: ContactProblem) -> list[str]:
    """Return the names of the package's own backends whose methods suit the problem."""
    found = []
    for name in _own_names():
        try:
            get_backend(name).check_problem(problem)
        except UnsuitableProblemError:
            continue
        found.append(name)
    return found


def why_missing(name: str) -> str | None:
    """Return why a backend cannot be called here, or None if it can.

    Its library is not installed; or it is another distribution's, and what that runs when it is loaded may raise
    anything.
    """
    found = _callable_backend(name)
    return found if isinstance(found, str) else None


def installed_backends() -> list[str]:
    """Return the names of all backends that can be called here, those of other distributions last."""
    return [name for name in backend_names() if why_missing(name) is None]


def usual_backends(problem: ContactProblem) -> tuple[list[str], dict[str, str]]:
    """Return the names of the installed backends that suit a problem, and why others are left out.

    Those that are practical at its size are named, or all that suit it where none is. What is left out is what cannot
    be loaded, and what is not practical.

    Examples
    --------
    >>> import contactqp as cq
    >>> names, left_out = usual_backends(cq.gallery.bowl(127).problem)
    >>> names
    ['osqp', 'clarabel', 'psor', 'multigrid', 'active-set', 'mprgp']
    >>> left_out
    {'mangasarian': 'is practical up to 10000 unknowns'}
    """
    named: list[str] = []
    left_out: dict[str, str] = {}
    for name in backend_names():
        obstacle = _obstacle(name, problem)
        if obstacle is None:
            named.append(name)
        elif obstacle.size or (obstacle.missing and name not in TABLE):
            left_out[name] = obstacle.reason
    return (named, left_out) if named else (suitable_backends(problem), {})


def all_backends(problem: ContactProblem) -> tuple[list[str], dict[str, str]]:
    """Return the names of all backends that can be asked about a problem, families' too, and why others cannot.

    Examples
    --------
    >>> import contactqp as cq
    >>> names, left_out = all_backends(cq.ContactQP([[2.0]], [-1.0], lower=0.0, upper=1.0))
    >>> left_out["mangasarian"][:37]
    'needs a problem without an upper boun'
    """
    named: list[str] = []
    left_out: dict[str, str] = {}
    for name in [*backend_names(), *names_besides()]:
        obstacle = _obstacle(name, problem)
        if obstacle is None:
            named.append(name)
        else:
            left_out[name] = obstacle.reason
    return named, left_out


@dataclass(frozen=True)
class _Obstacle:
    """Why a backend is not asked: the reason in words, and whether it is that it is missing, or the problem's size."""

    reason: str
    missing: bool = False
    size: bool = False


def _obstacle(name: str, problem: ContactProblem) -> _Obstacle | None:
    """Return what stands against asking a backend, None if nothing does."""
    backend = _callable_backend(name)
    if isinstance(backend, str):
        told = backend.removeprefix(f"backend {name!r} ")
        return _Obstacle(f"cannot be called: {told}", missing=True)
    try:
        backend.check_problem(problem)
    except UnsuitableProblemError as error:
        return _Obstacle(str(error).removeprefix(f"backend {name!r} "))
    if backend.practical_size is not None and problem.size > backend.practical_size:
        return _Obstacle(f"is practical up to {backend.practical_size} unknowns", size=True)
    return None


def check_suitable(backend: Backend, problem: ContactProblem) -> None:
    """Raise an UnsuitableProblemError, which names backends to take instead, unless a backend suits the problem."""
    try:
        backend.check_problem(problem)
    except UnsuitableProblemError as error:
        others = [repr(name) for name in suitable_backends(problem)]
        if not others:
            raise
        listed = " or ".join(part for part in (", ".join(others[:-1]), others[-1]) if part)
        raise UnsuitableProblemError(f"{error}; take {listed}") from None


def choose_backend(problem: ContactProblem) -> tuple[str, str]:
    """Return the name of the backend that ``"auto"`` stands for, and the reason for the choice.

    Measured on two cores (``benchmarks/backends.py``): up to some thousand unknowns active sets need no compiled
    kernels and are exact in milliseconds; on a lattice multigrid takes the time of a linear solve; for other matrices
    active sets are the fastest at any size (``benchmarks/matrices.py``).
    """
    if problem.kernel is not None:
        return "active-set", f"auto: a {problem.facts.kind}, which contact must hold"
    if problem.size <= DIRECT_SIZE and problem.is_z_matrix and not problem.is_m_matrix:
        # It is one, but for rounding, as it has passed for positive definite.
        return "active-set", f"auto: G is too ill-conditioned to be proven an M-matrix, {problem.told_condition}"
    if problem.size <= DIRECT_SIZE:
        few = "unknown is" if problem.size == 1 else "unknowns are"
        return "active-set", f"auto: {problem.size} {few} few"
    if problem.stencil is not None:
        return "multigrid", f"auto: a lattice with {problem.size} nodes"
    kind = "an M-matrix" if problem.is_m_matrix else "a matrix"
    return "active-set", f"auto: {kind} with {problem.size} unknowns"


def _callable_backend(name: str) -> Backend | str:
    """Return the backend of a name, loaded once, or why it cannot be called here."""
    try:
        backend = get_backend(name)
        backend.require()
    except (Exception, SystemExit) as error:
        return str(error)
    return backend


def _own_names() -> list[str]:
    """Return the names in the table, without its families."""
    return [name for name in TABLE if not name.endswith(":")]


def _families() -> list[str]:
    return [name for name in TABLE if name.endswith(":")]


def _family_of(name: str) -> str | None:
    """Return what the names of the family begin with that a backend belongs to, or None."""
    return next((key for key in _families() if name.startswith(key)), None)


@cache
def _realised(place: str) -> Any:
    module, attribute = place.split(":")
    return getattr(import_module(module), attribute)


def _loaded(name: str, entry: metadata.EntryPoint) -> Backend:
    """Return another distribution's backend, whatever its import raises turned into a MissingBackendError."""
    from .base import Backend
    from .contract import check_declared

    try:
        made = entry.load()()
    except Exception as error:
        reason = f"{type(error).__name__}: {error}"
        raise MissingBackendError(f"backend {name!r} ({entry.value}) cannot be loaded: {reason}") from error
    if not isinstance(made, Backend):
        raise MissingBackendError(f"backend {name!r} ({entry.value}) is no subclass of contactqp.backends.base.Backend")
    check_declared(made)
    if made.name != name:
        raise MissingBackendError(
            f"backend {name!r} ({entry.value}) calls itself {made.name!r}; its entry point must have the same name"
        )
    return made


@cache
def _outsiders() -> dict[str, metadata.EntryPoint]:
    """Return other distributions' entry points by name; of two with one name the first counts, with a warning."""
    from importlib import metadata

    found: dict[str, metadata.EntryPoint] = {}
    for entry in metadata.entry_points(group=ENTRY_POINT_GROUP):
        if entry.name in _PLACES or entry.name in found:
            taken = _PLACES.get(entry.name) or found[entry.name].value
            if taken != entry.value:
                message = f"two backends are called {entry.name!r}: {taken} is taken, {entry.value} is not"
                warnings.warn(message, ContactWarning, stacklevel=3)
            continue
        found[entry.name] = entry
    return found
