"""Pictures: what the gallery's programs draw, and a text for each that says what it shows.

Where nobody has written one it is the heading that the picture stands under.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from docutils import nodes
from matplotlib.figure import Figure
from sphinx.application import Sphinx
from sphinx_gallery.scrapers import figure_rst


def figures_of_example(block: Any, variables: dict[str, Any], settings: dict[str, Any]) -> str:
    """Save the figures that a block of a gallery's program has made, and return how they are shown.

    A model's own pictures are figures that pyplot does not know, so that they are found by their class.
    """
    saved = []
    for figure in {id(each): each for each in variables["example_globals"].values()}.values():
        if isinstance(figure, Figure) and not getattr(figure, "shown_by_gallery", False):
            figure.shown_by_gallery = True  # type: ignore[attr-defined]
            saved.append(next(variables["image_path_iterator"]))
            figure.savefig(saved[-1], dpi=110, facecolor="white")
    return figure_rst(saved, settings["src_dir"], fig_titles=_title_of(variables["src_file"]))


def _title_of(program: str) -> str:
    """Return the first line of a program's docstring."""
    return Path(program).read_text(encoding="utf-8").split("\n", 2)[1]


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
