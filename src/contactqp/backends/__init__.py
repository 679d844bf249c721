"""The table of backends: a name, and the class that realises it.

Other distributions add theirs by an entry point in the group ``contactqp.backends`` whose value is a subclass of
`contactqp.backends.base.Backend`.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING

from .._checks import nearest
from ..errors import UnknownBackendError

if TYPE_CHECKING:
    from importlib import metadata

    from ..problem import ContactQP
    from .base import Backend

TABLE = {
    "osqp": "contactqp.backends.osqp:Osqp",
    "clarabel": "contactqp.backends.clarabel:Clarabel",
    "mangasarian": "contactqp.backends.mangasarian:Mangasarian",
    "psor": "contactqp.backends.psor:Psor",
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


def choose_backend(problem: ContactQP) -> tuple[str, str]:
    """Return the name of the backend that ``"auto"`` stands for, and the reason for the choice.

    Measured on two cores (``benchmarks/backends.py``): Clarabel answers problems of up to some thousand unknowns
    within the time that the kernels of projected relaxation take to load; above, relaxation is faster on every
    two-dimensional M-matrix tried. Along a line its sweeps grow with the number of nodes, and Clarabel's do not.
    """
    if problem.size <= _FEW_UNKNOWNS:
        return "clarabel", f"auto: {problem.size} unknowns are few"
    if not problem.is_m_matrix:
        return "clarabel", "auto: G is no M-matrix"
    if problem.stiffness.nonzeros <= 3 * problem.size:
        return "clarabel", f"auto: {problem.size} unknowns along a line"
    return "psor", f"auto: an M-matrix with {problem.size} unknowns"


_FEW_UNKNOWNS = 4000


@cache
def _outsiders() -> dict[str, metadata.EntryPoint]:
    from importlib import metadata

    return {entry.name: entry for entry in metadata.entry_points(group=ENTRY_POINT_GROUP)}
