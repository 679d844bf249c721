"""Every picture says in words what it shows: where nobody has written it, by the heading that it stands under."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx


def _heading_above(picture: nodes.image) -> str:
    section = picture.parent
    while section is not None and not isinstance(section, nodes.section):
        section = section.parent
    title = section.next_node(nodes.title) if section is not None else None
    return "Figure" if title is None else f"Figure: {title.astext()}"


def _describe(app: Sphinx, document: nodes.document) -> None:
    for picture in document.findall(nodes.image):
        words = picture.get("alt", "")
        if not words or words.endswith(Path(picture["uri"]).suffix):  # what a notebook shows is named by its file
            picture["alt"] = _heading_above(picture)


def setup(app: Sphinx) -> dict[str, Any]:
    """Describe what a page shows once it is read."""
    app.connect("doctree-read", _describe)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
