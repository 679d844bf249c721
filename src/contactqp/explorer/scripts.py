"""The page's own JavaScript: numerics that run anywhere, and what ties them to the page."""

from __future__ import annotations

from importlib.resources import files

NUMERICS = ("lattice", "multigrid", "relaxation", "certificate", "solve")
"""Files that know nothing of a page, each using those before it."""

PAGE = ("scene", "draw", "explore")
"""Files of the page."""


def script(*names: str) -> str:
    """Return the text of some of these files, one after the other.

    Examples
    --------
    >>> script("relaxation").count("function relaxationSweep")
    1
    """
    return "\n".join((files(__package__) / f"{name}.js").read_text(encoding="utf-8") for name in names)
