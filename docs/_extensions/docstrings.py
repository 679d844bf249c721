"""Docstrings are read in a terminal as well: bars are absolute values there, and no substitutions."""

from __future__ import annotations

import re
from typing import Any

from sphinx.application import Sphinx

_BAR_OUTSIDE_OF_CODE = re.compile(r"\\.|``.*?``|`[^`]*`|\|")


def escape(line: str) -> str:
    """Return a line of a docstring whose bars stand for themselves; examples and code are left as they are."""
    if line.lstrip().startswith((">>>", "...")):
        return line
    return _BAR_OUTSIDE_OF_CODE.sub(lambda found: r"\|" if found[0] == "|" else found[0], line)


def _process(app: Sphinx, what: str, name: str, thing: object, options: Any, lines: list[str]) -> None:
    lines[:] = map(escape, lines)


def setup(app: Sphinx) -> dict[str, Any]:
    """Escape what autodoc has read, before numpydoc reads it."""
    app.setup_extension("sphinx.ext.autodoc")
    app.connect("autodoc-process-docstring", _process, priority=100)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
