"""The explorer: one page that holds problems, solver and proofs, and works from a file."""

from __future__ import annotations

import json
from collections.abc import Sequence
from importlib.resources import files
from os import PathLike
from pathlib import Path

from .._version import __version__
from ..foundation.files import replaced_as_a_whole, require_writable
from ..foundation.loading import load_modules, needed
from ..models.base import ContactModel
from ..plotting.style import CLEAR, CONTACT, UNDECIDED
from .presets import presets
from .scenes import Scene, shown
from .scripts import NUMERICS, PAGE, script


def explore(model: ContactModel | None = None, path: str | PathLike[str] = "explorer.html", *, title: str = "") -> Path:
    """Write a page with sliders for load, tension, lift and support, which solves and proves in the reader's browser.

    It needs no network and no other file: multigrid, over-relaxation and the fast certificate are in it, in JavaScript.
    It shows the contact map, a section, what is proven of each node, and how fast both methods come to it; a button
    lets the load grow until the nodes touch down. There are the paper's hexagon, a disk, a rectangle and a cable to
    choose from, and the model itself.

    Parameters
    ----------
    model : Membrane or Cable, optional
        What the page opens with: over one support, without foundation, of a tension that is the same everywhere (a pair
        may differ along x and y), on a lattice that is not fitted to its contour. By default it is the paper's hexagon.
    path : str or path
        File to write (.html); an older one is replaced.
    title : str
        Headline of the page, and the model's name on it.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    TypeError, ValueError
        If the model is of another kind, or the file cannot be written.
    ImportError
        If Bokeh is missing: ``pip install 'contactqp[explore]'``.

    Examples
    --------
    >>> import tempfile
    >>> import contactqp as cq
    >>> cable = cq.Cable(span=10.0, spacing=0.1, tension=5.0, load=1.0, support=2.0)
    >>> cq.explore(cable, tempfile.mkdtemp() + "/cable.html").name
    'cable.html'
    """
    file = Path(path)
    require_writable(file, (".html", ".htm"), "page")
    scenes = list(presets())
    if model is not None:
        name = title or "the case"
        taken = name in [scene.name for scene in scenes]
        scenes.insert(0, Scene(f"{name} (the case)" if taken else name, shown(model)))
    text = _page(scenes, title or "Contact explorer")
    with replaced_as_a_whole(file) as unfinished:
        unfinished.write_text(text, encoding="utf-8")
    return file


def _page(scenes: Sequence[Scene], title: str) -> str:
    """Return the page as text."""
    needed("bokeh.embed", "the explorer", "contactqp[explore]")
    load_modules("contactqp.explorer.document")
    from bokeh.embed import file_html
    from bokeh.resources import INLINE

    from .document import document_of

    names = [scene.name for scene in scenes]
    data = json.dumps([scene.record() for scene in scenes], ensure_ascii=False)
    variables = {
        "scenes": data.replace("<", "\\u003c"),  # what stands in a script must not end it
        "script": script(*NUMERICS, *PAGE),
        "version": __version__,
        "contact": CONTACT,
        "clear": CLEAR,
        "undecided": UNDECIDED,
    }
    template = (files(__package__) / "page.html").read_text(encoding="utf-8")
    return file_html(document_of(names), INLINE, title, template=template, template_variables=variables)
