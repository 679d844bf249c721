"""Cards: what an object tells of itself in a notebook, as a small table of HTML that needs nothing else."""

from __future__ import annotations

import zlib
from base64 import b64encode
from collections.abc import Mapping
from html import escape
from struct import pack

import numpy as np
from numpy.typing import NDArray

_CELL = "text-align:left;padding:0.1rem 0.8rem 0.1rem 0;vertical-align:top"
_LARGEST = 300
"""Pixels along a side above which a picture keeps every second, third, ... only."""


def card(title: str, facts: Mapping[str, str], picture: str = "") -> str:
    """Return a table with a title and a line for each fact, as HTML; all text is escaped.

    Parameters
    ----------
    title : str
    facts : mapping of str to str
        By name; empty ones are left out.
    picture : str
        HTML that stands beside the facts, see `pixels`.

    Examples
    --------
    >>> "<b>a &lt; b</b>" in card("a < b", {"nodes": "3"})
    True
    """
    lines = "".join(
        f'<tr><th scope="row" style="{_CELL};font-weight:600">{escape(name)}</th>'
        f'<td style="{_CELL}">{escape(fact)}</td></tr>'
        for name, fact in facts.items()
        if fact
    )
    table = f'<table style="border-collapse:collapse">{lines}</table>'
    return (
        f'<div style="display:flex;gap:1.5rem;flex-wrap:wrap;align-items:flex-start">'
        f"<div><div><b>{escape(title)}</b></div>{table}</div>{picture}</div>"
    )


def pixels(colours: NDArray[np.uint8], alternative: str) -> str:
    """Return a picture of coloured squares as HTML with the picture in it.

    Parameters
    ----------
    colours : array of uint8, shape (rows, columns, 3)
        Red, green and blue; the first row is drawn at the top.
    alternative : str
        What the picture shows, for those who do not see it.
    """
    step = -(-max(colours.shape[:2]) // _LARGEST)
    kept = np.ascontiguousarray(colours[::step, ::step])
    rows, columns = kept.shape[:2]
    lines = np.concatenate([np.zeros((rows, 1), dtype=np.uint8), kept.reshape(rows, -1)], axis=1)
    file = b"\x89PNG\r\n\x1a\n" + b"".join(
        _chunk(name, data)
        for name, data in (
            (b"IHDR", pack(">IIBBBBB", columns, rows, 8, 2, 0, 0, 0)),
            (b"IDAT", zlib.compress(lines.tobytes())),
            (b"IEND", b""),
        )
    )
    width = round(220 * columns / max(rows, columns))
    return (
        f'<img alt="{escape(alternative)}" src="data:image/png;base64,{b64encode(file).decode()}" '
        f'style="width:{max(width, 8)}px;image-rendering:pixelated">'
    )


def _chunk(name: bytes, data: bytes) -> bytes:
    """Return a part of a PNG file (ISO/IEC 15948, section 5.3)."""
    return pack(">I", len(data)) + name + data + pack(">I", zlib.crc32(name + data))
