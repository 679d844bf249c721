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
    every = error.errors(include_url=False)
    missing = [problem for problem in every if _is_missing(problem)]
    shown = [_told_missing(missing, case)] if missing else []
    problems = [problem for problem in every if not _is_missing(problem)]
    for told, problem in enumerate(problems):
        text = _explain(problem, case)
        if text in shown:
            continue
        if len(shown) == _SHOWN:
            return f"{'; '.join(shown)}; and {len(problems) - told} more"
        shown.append(text)
    return "; ".join(shown)


def _is_missing(problem: Any) -> bool:
    """Whether a key is missing; of a list's entries there may be any number."""
    return problem["type"] == "missing" and isinstance(problem["loc"][-1], str)


def _told_missing(missing: Sequence[Any], case: type[Section]) -> str:
    """Return all keys that are missing, as one error."""
    *others, last = (_key(_place(problem["loc"], case)[0]) for problem in missing)
    return f"{', '.join(others)} and {last}: fields required" if others else f"{last}: field required"


def _key(names: Sequence[int | str]) -> str:
    return "".join(f"[{name}]" if isinstance(name, int) else f".{name}" for name in names).lstrip(".")


def _explain(problem: Any, case: type[Section]) -> str:
    names, section = _place(problem["loc"], case)
    key = _key(names)
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
    told = f"{key or 'file'}: {problem['msg'][0].lower()}{problem['msg'][1:]}, got {shortened(repr(given))}"
    return told + (_instead_of(given, str(names[0]), case) if problem["type"] == "float_type" else "")


def _instead_of(given: object, field: str, case: type[Section]) -> str:
    """Return how to write what stands in place of a number: one without quotation marks, or data of a file."""
    if not isinstance(given, str):
        return ""
    try:
        float(given)
    except ValueError:
        return f'; data of a file are {field} = {{file = "{shortened(given)}"}}' if _takes_files(field, case) else ""
    return f"; write {given.strip()} without quotation marks"


def _takes_files(field: str, case: type[Section]) -> bool:
    """Whether values of a field may come from a file."""
    try:
        case.model_validate({field: {"file": "values.npy"}})
    except ValidationError as error:
        return all(problem["loc"][0] != field for problem in error.errors(include_url=False))
    return True


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
