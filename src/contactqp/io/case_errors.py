"""What is wrong with a case file, in one line: the key, what it should be, and what is there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pydantic import ValidationError

from ..foundation.checks import nearest
from ..foundation.text import shortened
from .case_sections import SECTIONS, DataFile, Section

_WAYS = {"number": "a number", "file": "a table with file", "profile": "a table with profile"}

_FIELDS = ("frame", "load", "support", "frame_height", "ceiling", "foundation", "tension")
"""Keys whose value may be of several kinds."""

_SHOWN = 3
"""Errors that are told; the others are counted."""


def explained(error: ValidationError, case: type[Section]) -> str:
    """Return what is wrong with a case in one line.

    Parameters
    ----------
    error : ValidationError
    case : type
        The section that the whole file was taken for.
    """
    shown: list[str] = []
    problems = error.errors(include_url=False)
    for told, problem in enumerate(problems):
        text = _explain(problem, case)
        if text in shown:
            continue
        if len(shown) == _SHOWN:
            return f"{'; '.join(shown)}; and {len(problems) - told} more"
        shown.append(text)
    return "; ".join(shown)


def _explain(problem: Any, case: type[Section]) -> str:
    names, section = _place(problem["loc"], case)
    key = "".join(f"[{name}]" if isinstance(name, int) else f".{name}" for name in names).lstrip(".")
    known, given, context = section.model_fields, problem["input"], problem.get("ctx", {})
    match problem["type"]:
        case "model_attributes_type" | "model_type":
            return f"{key}: must be a table, got {shortened(repr(given))}"
        case "missing":
            return f"{key}: field required"
        case "extra_forbidden":
            word = str(names[-1])
            likely = nearest(word, known) or f"; known: {', '.join(known)}"
            return f"{shortened(key)}: unknown key{likely}"
        case "union_tag_invalid" if context["discriminator"] == "_kind()":
            return f"{key}: must be {_ways(context)}, not {_WAYS[context['tag']]}"
        case "union_tag_invalid":
            word, chosen = context["tag"], context["expected_tags"].replace("'", "").split(", ")
            return f"{key}.{context['discriminator'].strip(chr(39))}: must be {_choice(chosen)}, got " + (
                f"{shortened(word)!r}{nearest(word, chosen)}"
            )
        case "union_tag_not_found" if context["discriminator"] == "_kind()":
            found = shortened(", ".join(map(str, given)), 60) or "nothing"
            likely = next(filter(None, (nearest(word, ("profile", "file")) for word in given)), "")
            return f"{key}: must be a number, or a table with profile or file, got a table with {found}{likely}"
        case "union_tag_not_found":
            return f"{key}: needs the key {context['discriminator'].strip(chr(39))}"
    return f"{key or 'file'}: {problem['msg'][0].lower()}{problem['msg'][1:]}, got {shortened(repr(given))}"


def _ways(context: Any) -> str:
    return " or ".join(_WAYS[tag.strip("' ")] for tag in context["expected_tags"].split(","))


def _choice(words: Sequence[str]) -> str:
    *others, last = map(repr, words)
    return f"{', '.join(others)} or {last}" if others else last


def _place(location: tuple[int | str, ...], case: type[Section]) -> tuple[list[int | str], type[Section]]:
    """Return the keys that lead to an error, without the kinds of value between them, and the section it is in."""
    names, section, parts = [], case, list(location)
    while parts:
        names.append(parts.pop(0))
        if names[0] not in _FIELDS:
            continue
        if len(names) == 1 and parts and parts[0] in ("one", "pair"):
            kind, *parts = parts
            names += parts[:1] if kind == "pair" else []
            parts = parts[1:] if kind == "pair" else parts
        if len(names) == 1 or (len(names) == 2 and isinstance(names[1], int)):
            while parts and (parts[0] in _WAYS or parts[0] in SECTIONS):
                kind = str(parts.pop(0))
                section = DataFile if kind == "file" else SECTIONS.get(kind, section)
                if kind != "profile":
                    break
    return names, section
