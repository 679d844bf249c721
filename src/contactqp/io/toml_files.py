"""TOML files, read so that none can take more than a moment."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from ..errors import CaseFileError
from ..foundation.text import shortened

_MOST_BYTES = 1_000_000
"""The reader of the standard library takes a second or so for as many."""

_MOST_PARTS = 16
"""Parts of a dotted key; that reader's work grows as their square."""

_QUOTES = re.compile(r"\"\"\"|'''|[\"'#]")

_CLOSING = {
    '"""': re.compile(r'(?:[^"\\]|\\.|"(?!""))*+"""', re.DOTALL),
    "'''": re.compile(r"(?:[^']|'(?!''))*+'''", re.DOTALL),
    '"': re.compile(r'(?:[^"\\\n]|\\.)*+"'),
    "'": re.compile(r"[^'\n]*+'"),
    "#": re.compile(r"[^\n]*+"),
}
"""What a string or a comment goes on to, by what opens it."""

_LONG_KEY = re.compile(rf"(?<![\w.-])(?:[\w-]++[ \t]*+\.[ \t]*+){{{_MOST_PARTS}}}", re.ASCII)


def read_toml(path: Path) -> dict[str, Any]:
    """Return what a TOML file holds.

    Parameters
    ----------
    path : Path
        In UTF-8, with a byte order mark or without.

    Raises
    ------
    CaseFileError
        If it cannot be read, is no TOML file, or is too large or too deeply nested; the message names the file.
    """
    try:
        with path.open("rb") as file:
            stored = file.read(_MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise CaseFileError(f"{shortened(path, 200)}: cannot read the case file: {reason}") from None
    if len(stored) > _MOST_BYTES:
        raise CaseFileError(
            f"{path}: more than {_MOST_BYTES:,} bytes: no case file; put long lists of numbers into files of their own"
        )
    try:
        text = stored.decode("utf-8-sig").replace("\r\n", "\n")
        _refuse_long_keys(text)
        return tomllib.loads(text)
    except ValueError as error:  # of the reader, of the decoder, and of numbers with thousands of digits
        raise CaseFileError(f"{path}: not a TOML file: {shortened(error, 200)}") from None
    except RecursionError:
        raise CaseFileError(f"{path}: not a case file: too deeply nested") from None


def _refuse_long_keys(text: str) -> None:
    """Raise a ValueError, if a key has more parts than any in a case file.

    Examples
    --------
    >>> _refuse_long_keys("title = 'a.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.q.r'  # and so on.on.on.on.on.on.on.on")
    >>> _refuse_long_keys("a.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.q.r = 1")
    Traceback (most recent call last):
    ...
    ValueError: a key of more than 16 parts, at a.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.
    """
    bare, place = [], 0
    while (opening := _QUOTES.search(text, place)) is not None:
        bare.append(text[place : opening.start()])
        closing = _CLOSING[opening[0]].match(text, opening.end())
        if closing is None:
            break  # the reader stops there
        bare.append("s" if opening[0] != "#" else "")
        place = closing.end()
    else:
        bare.append(text[place:])
    found = _LONG_KEY.search("".join(bare))
    if found is not None:
        raise ValueError(f"a key of more than {_MOST_PARTS} parts, at {shortened(found[0], 60)}")
