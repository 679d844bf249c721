"""Names of the settings of solvers that are called by name: a misspelt one is refused before anything is solved.

Some packages pass over a name that their solver does not know, so that nobody would notice.
"""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from functools import cache
from typing import Any

from ..foundation.checks import nearest
from ..foundation.loading import loaded
from ..foundation.quiet import output_discarded, warnings_ignored
from ..foundation.text import shortened
from .solvers import Facts

_MISSPELT = 0.8
"""Likeness above which a name is taken for another one misspelt: that of nine letters of ten is 0.9."""


def check_setting_names(backend: str, facts: Facts, through: str, given: Iterable[str]) -> None:
    """Raise a TypeError, if a solver has no setting of a name.

    Where a library does not tell all its names, a newer release may have more than are known: then only what looks like
    one of these misspelt is refused.

    Parameters
    ----------
    backend : str
        The solver's full name, for messages.
    facts : Facts
    through : str
        The package that calls it.
    given : iterable of str

    Examples
    --------
    >>> from contactqp.backends.solvers import facts_of
    >>> check_setting_names("qpsolvers:cvxopt", facts_of("cvxopt", "qpsolvers"), "qpsolvers", ["maxiter"])
    Traceback (most recent call last):
    ...
    TypeError: backend 'qpsolvers:cvxopt' has no setting 'maxiter'; did you mean 'maxiters'?
    """
    told = _attributes(facts.settings_at) if facts.settings_at else frozenset[str]()
    if not (told or (facts.setting_names and not facts.settings_at)):
        return
    caller, names = facts.through[through], told.union(facts.setting_names)
    own = {*facts.tolerances, facts.iterations, facts.seconds, *facts.settings, *caller.settings, *caller.also}
    known = sorted(names | own - {""})
    complete = bool(told) and not facts.setting_names
    for name in given:
        if name not in known and (complete or get_close_matches(name, known, n=1, cutoff=_MISSPELT)):
            meant = nearest(name, known) or f"; it has {shortened(', '.join(known), 400)}"
            raise TypeError(f"backend {backend!r} has no setting {name!r}{meant}")


@cache
def _attributes(place: str) -> frozenset[str]:
    """Return the public attributes of what stands at a place, none where another release has nothing there.

    Parameters
    ----------
    place : str
        ``module:path`` of names; what ends in ``()`` is called.
    """
    module, path = place.split(":")
    try:
        with warnings_ignored(), output_discarded():
            found: Any = loaded(module)
            for part in path.split("."):
                found = getattr(found, part.removesuffix("()"))
                found = found() if part.endswith("()") else found
    except Exception:
        return frozenset()
    return frozenset(name for name in dir(found) if not (name.startswith("_") or callable(getattr(found, name))))
