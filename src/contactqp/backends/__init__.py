"""The table of backends: a name, and the class that realises it.

Other distributions add theirs by an entry point in the group ``contactqp.backends`` whose value is a subclass of
`contactqp.backends.base.Backend`.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING

from ..errors import UnknownBackendError, UnsuitableProblemError
from ..foundation.checks import nearest

if TYPE_CHECKING:
    from importlib import metadata

    from ..problem.contact_qp import ContactQP
    from .base import Backend

TABLE = {
    "osqp": "contactqp.backends.osqp:Osqp",
    "clarabel": "contactqp.backends.clarabel:Clarabel",
    "mangasarian": "contactqp.backends.mangasarian:Mangasarian",
    "psor": "contactqp.backends.psor:Psor",
    "multigrid": "contactqp.backends.multigrid:Multigrid",
    "active-set": "contactqp.backends.active_set:ActiveSetBackend",
}

ENTRY_POINT_GROUP = "contactqp.backends"


def backend_names() -> list[str]:
    """Return the names of all backends, those of other distributions last.

    Examples
    --------
    >>> import contactqp as cq
    >>> cq.backend_names()[:4]
    ['osqp', 'clarabel', 'mangasarian', 'psor']
    """
    return [*TABLE, *(name for name in _outsiders() if name not in TABLE)]


def get_backend(name: str) -> type[Backend]:
    """Return the class of the backend called ``name``.

    Raises
    ------
    TypeError
        If ``name`` is not a string.
    UnknownBackendError
        If there is no such backend; the message lists the known ones.
    """
    if not isinstance(name, str):
        raise TypeError(f"backend must be a name, got {name!r}")
    if name in TABLE:
        module, attribute = TABLE[name].split(":")
        found: type[Backend] = getattr(import_module(module), attribute)
        return found
    if name in _outsiders():
        loaded: type[Backend] = _outsiders()[name].load()
        return loaded
    known = ["auto", *backend_names()]
    raise UnknownBackendError(f"unknown backend {name!r}{nearest(name, known)}; known: {', '.join(known)}")


def suitable_backends(problem: ContactQP) -> list[str]:
    """Return the names of the package's own backends whose methods suit the problem."""
    found = []
    for name in TABLE:
        try:
            get_backend(name).check_problem(problem)
        except UnsuitableProblemError:
            continue
        found.append(name)
    return found


def choose_backend(problem: ContactQP) -> tuple[str, str]:
    """Return the name of the backend that ``"auto"`` stands for, and the reason for the choice.

    Measured on two cores (``benchmarks/speed.py``): up to some thousand unknowns active sets need no compiled kernels
    and are exact in milliseconds; on a lattice multigrid takes the time of a linear solve; for other M-matrices active
    sets are the fastest at any size. Interior points do not need an M-matrix.
    """
    from ..methods.active_set.primal_dual import DIRECT_SIZE

    if not problem.is_m_matrix:
        return "clarabel", "auto: G is no M-matrix"
    if problem.size <= DIRECT_SIZE:
        return "active-set", f"auto: {problem.size} unknowns are few"
    if problem.stencil is not None:
        return "multigrid", f"auto: a lattice with {problem.size} nodes"
    return "active-set", f"auto: an M-matrix with {problem.size} unknowns"


@cache
def _outsiders() -> dict[str, metadata.EntryPoint]:
    from importlib import metadata

    return {entry.name: entry for entry in metadata.entry_points(group=ENTRY_POINT_GROUP)}
