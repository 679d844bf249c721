"""The catalogue: every entry of the gallery by its name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ..foundation.checks import integer_at_least, nearest
from .known import Known

Maker = Callable[[str, int], Known]
"""Makes an entry from its name and the number of its nodes along a side."""


@dataclass(frozen=True)
class Entry:
    """What the catalogue keeps of an entry: how it is made, how many nodes it has if nothing is said, what it is."""

    make: Maker
    nodes: int
    title: str


_ENTRIES: dict[str, Entry] = {}


def entry(*known_as: str, n: int) -> Callable[[Maker], Maker]:
    """Put what makes a problem into the catalogue, under one name or several.

    Parameters
    ----------
    *known_as : str
    n : int
        Nodes along a side, by default. What its docstring's first line says to be returned is the entry's title.
    """

    def put(make: Maker) -> Maker:
        title = (make.__doc__ or "").strip().splitlines()[0].removeprefix("Return ").rstrip(".")
        for name in known_as:
            _ENTRIES[name] = Entry(make, n, title)
        return make

    return put


def names() -> tuple[str, ...]:
    """Return the names of the gallery's entries, as `load` takes them.

    Examples
    --------
    >>> import contactqp as cq
    >>> len(cq.gallery.names()) > 40, "ball" in cq.gallery.names()
    (True, True)
    """
    return tuple(sorted(_ENTRIES, key=str.lower))


def entry_of(name: str) -> Entry:
    """Return an entry by its name.

    Raises
    ------
    ValueError
        If there is none of that name; the message has the nearest.
    """
    found = _ENTRIES.get(name) if isinstance(name, str) else None
    if found is None:
        near = nearest(name, _ENTRIES)
        raise ValueError(f"name must be one of contactqp.gallery.names(), got {name!r}{near}")
    return found


def load(name: str, n: int | None = None) -> Known:
    """Return a problem of the gallery, with what is known of its answer.

    Parameters
    ----------
    name : str
        One of `names`.
    n : int, optional
        Nodes along a side (of a cable or beam: between its ends; of a disk: about so many along its diameter). By
        default some thirty in plan, or a size for which a published number is known. A spacing follows from it: the
        domain stays the same.

    Returns
    -------
    Known

    Raises
    ------
    ValueError
        If the name is unknown, or the entry does not have that many nodes.
    ImportError
        If it is on a mesh of triangles, and scikit-fem is not installed.

    Examples
    --------
    >>> import contactqp as cq
    >>> known = cq.gallery.load("ball", n=31)
    >>> solution = cq.solve(known.model)
    >>> float(abs(solution.deflection - known.deflection).max().round(3))
    0.006
    >>> cq.gallery.load("bal")
    Traceback (most recent call last):
    ...
    ValueError: name must be one of contactqp.gallery.names(), got 'bal'; did you mean 'ball'?
    """
    found = entry_of(name)
    return found.make(name, found.nodes if n is None else integer_at_least(n, 1, "n"))
