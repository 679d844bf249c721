"""Commented case files to begin one's own with: they solve as they are, but for a mesh, which is a file of its own."""

from __future__ import annotations

from importlib.resources import files

from ...foundation.checks import one_of


def template_names() -> tuple[str, ...]:
    """Return the names of the templates.

    Examples
    --------
    >>> template_names()
    ('beam', 'cable', 'dome', 'hexagon', 'membrane', 'mesh membrane', 'plate')
    """
    return tuple(sorted(file.name.removesuffix(_SUFFIX) for file in files(__name__).iterdir() if _is_one(file.name)))


def template(name: str) -> str:
    """Return the text of a template.

    Raises
    ------
    ValueError
        If there is none of that name.

    Examples
    --------
    >>> template("cable").splitlines()[0]
    '# A cable between two ends, sagging onto rigid ground.'
    """
    return (files(__name__) / f"{one_of(name, template_names(), 'kind')}{_SUFFIX}").read_text(encoding="utf-8")


_SUFFIX = ".toml"


def _is_one(name: str) -> bool:
    return name.endswith(_SUFFIX)
