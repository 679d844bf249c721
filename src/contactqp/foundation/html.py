"""HTML pages that need no network, no script and no other file."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from html import escape
from io import BytesIO
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_STYLE = """
body { margin: 0; background: #fff; color: #22333b; font: 16px/1.5 system-ui, sans-serif; }
main { max-width: 64rem; margin: 0 auto; padding: 1rem; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 0.5rem 0; overflow-wrap: anywhere; }
h2 { font-size: 1.2rem; margin: 2rem 0 0.5rem; border-bottom: 1px solid #b8c4cb; break-after: avoid; }
h3 { font-size: 1rem; margin: 1rem 0 0.25rem; break-after: avoid; }
p, li, dd { overflow-wrap: anywhere; }
.verdict { padding: 0.7rem 1rem; border-left: 0.4rem solid #c8553d; background: #fbeeeb; font-weight: 600; }
.verdict.good { border-color: #3f7d58; background: #edf5f0; }
.wide { overflow-x: auto; margin: 0.75rem 0; }
table { border-collapse: collapse; font-size: 0.9rem; }
caption { text-align: left; font-weight: 600; padding: 0.25rem 0; }
th, td { padding: 0.25rem 0.7rem; border-bottom: 1px solid #dfe7ec; text-align: left; vertical-align: top; }
thead th { border-bottom: 2px solid #22333b; vertical-align: bottom; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; }
td.number { white-space: nowrap; }
.bad { color: #a33219; font-weight: 600; }
dl { display: grid; grid-template-columns: minmax(7rem, max-content) 1fr; gap: 0.2rem 1rem; font-size: 0.9rem; }
dt { font-weight: 600; }
dd { margin: 0; }
figure { margin: 1rem 0; break-inside: avoid; }
img { max-width: 100%; height: auto; display: block; }
.map img { max-width: min(100%, 42rem); }
figcaption { font-size: 0.9rem; color: #4a5b63; }
@media (max-width: 40rem) { main { padding: 0.6rem; } dl { display: block; } dd { margin: 0 0 0.4rem; } }
@media print {
  main { max-width: none; padding: 0; }
  body { font-size: 10pt; }
  .wide { overflow: visible; break-inside: avoid; }
  table, dl { font-size: 8pt; }
  th, td { padding: 0.15rem 0.35rem; }
  .map img { max-width: 12cm; }
}
"""

# Even a browser that is online must not ask for anything.
_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"

BAD = ' class="bad"'
"""What marks a cell whose answer is not good enough."""

_NUMBER = ' class="number"'


def page(headline: str, sections: Iterable[str]) -> str:
    """Return a page as text.

    Parameters
    ----------
    headline : str
        Its title, as plain text; the heading is one of the sections.
    sections : iterable of str
        HTML.
    """
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<link rel="icon" href="data:,">\n<title>{escape(headline)}</title>\n<style>{_STYLE}</style>\n</head>\n'
        f"<body>\n<main>\n{''.join(sections)}</main>\n</body>\n</html>\n"
    )


def table(caption: str, headings: Iterable[tuple[str, bool]], body: Iterable[str]) -> str:
    """Return a table that scrolls by itself where it is wider than the page.

    Parameters
    ----------
    caption : str
        Plain text.
    headings : iterable of (str, bool)
        Plain text, and whether numbers stand below it.
    body : iterable of str
        Lines, see `line`.
    """
    head = "".join(
        f'<th scope="col"{_NUMBER if numeric else ""}>{escape(heading)}</th>' for heading, numeric in headings
    )
    return (
        f'<div class="wide"><table>\n<caption>{escape(caption)}</caption>\n'
        f"<thead><tr>{head}</tr></thead>\n<tbody>\n{''.join(body)}</tbody>\n</table></div>\n"
    )


def cell(text: str, numeric: bool) -> str:
    """Return a cell of a table, for plain text.

    Examples
    --------
    >>> cell("< 1", numeric=True)
    '<td class="number">&lt; 1</td>'
    """
    return f"<td{_NUMBER if numeric else ''}>{escape(text)}</td>"


def line(cells: Iterable[tuple[str, bool]]) -> str:
    """Return a line of a table, for plain texts and whether they are numbers."""
    return f"<tr>{''.join(cell(text, numeric) for text, numeric in cells)}</tr>\n"


def figure_of(picture: Figure, alternative: str, caption: str, kind: str) -> str:
    """Return a picture with its caption and what stands for it where it cannot be seen; the kind is a class."""
    buffer = BytesIO()
    picture.savefig(buffer, format="png", dpi=110)
    width, height = (round(110 * inches) for inches in picture.get_size_inches())
    data = base64.b64encode(buffer.getvalue()).decode("ascii")
    return (
        f'<figure class="{kind}"><img src="data:image/png;base64,{data}" width="{width}" height="{height}" '
        f'alt="{escape(alternative, quote=True)}">\n<figcaption>{escape(caption)}</figcaption></figure>\n'
    )
