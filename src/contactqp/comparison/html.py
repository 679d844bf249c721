"""A comparison as one HTML page that needs no network, no script and no other file."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..foundation.files import replaced_as_a_whole, require_writable
from ..foundation.text import at_upper_bound, number, shortened
from .columns import GROUPS, Column, columns_of, printed_columns
from .compared import Compared
from .disagreement import worst_nodes
from .legend import legend_of
from .pairs import Pair
from .pictures import plot_comparison, plot_disagreement
from .text import asked_for, closing_lines

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

_WORST_SHOWN = 10
"""Largest number of nodes in the table of those where answers lie farthest apart."""

# Even a browser that is online must not ask for anything.
_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"


def write_report(compared: Compared, path: Path, title: str = "") -> Path:
    """Write the page and return its path; an older page at that path is replaced once the new one is complete."""
    require_writable(path, (".html", ".htm"), "report")
    page = report_html(compared, title)
    with replaced_as_a_whole(path) as unfinished:
        unfinished.write_text(page, encoding="utf-8")
    return path


def report_html(compared: Compared, title: str = "") -> str:
    """Return the page as text."""
    headline = title or compared.subject
    sections = [
        _heading(compared, headline),
        _best_answer(compared),
        _metrics(compared),
        _truth(compared),
        _findings(compared),
        _pairs(compared),
        _disagreement(compared),
        _worst_nodes(compared),
        _settings(compared),
        _surroundings(compared),
    ]
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<link rel="icon" href="data:,">\n<title>{escape(headline)}</title>\n<style>{_STYLE}</style>\n</head>\n'
        f"<body>\n<main>\n{''.join(sections)}</main>\n</body>\n</html>\n"
    )


def _heading(compared: Compared, headline: str) -> str:
    state = "verdict good" if compared.conclusion.agree else "verdict"
    asked = f"{compared.subject}; {asked_for(compared)}"
    return (
        f"<h1>{escape(headline)}</h1>\n<p>{escape(asked)}; run on {_date(compared)}.</p>\n"
        f'<p class="{state}">{escape(compared.conclusion.sentence)}</p>\n'
        + "".join(f'<p class="verdict">Caution: {escape(caution)}.</p>\n' for caution in compared.conclusion.cautions)
    )


def _date(compared: Compared) -> str:
    return compared.provenance.when.strftime("%Y-%m-%d, %H:%M:%S %z").strip()


def _metrics(compared: Compared) -> str:
    problem = compared.answers.problem
    groups = [
        _table_of_rows(compared, group, {column.heading: column for column in columns_of(group, problem)})
        for group in GROUPS
    ]
    terms = legend_of(problem).items()
    legend = "".join(f"<dt>{escape(term)}</dt><dd>{escape(meaning)}</dd>\n" for term, meaning in terms)
    return f"<h2>What each backend reached</h2>\n{''.join(groups)}<dl>\n{legend}</dl>\n"


def notebook_table(compared: Compared) -> str:
    """Return the columns of the printed table as a table of HTML, with remarks and verdict below it."""
    columns = {column.printed: column for column in printed_columns(compared.answers.problem)[1:]}
    table = _table_of_rows(compared, f"{compared.subject}; {asked_for(compared)}", columns)
    return table + "".join(f"<p>{escape(line)}</p>\n" for line in closing_lines(compared))


_ROW_HEADING = "backend"


def _table_of_rows(compared: Compared, caption: str, columns: Mapping[str, Column]) -> str:
    """Return a table with a line for each backend; backends whose answer is not good enough are marked.

    Parameters
    ----------
    compared : Compared
    caption : str
    columns : mapping of str to Column
        By heading; the backends' names stand in front of them.
    """
    headings = [(_ROW_HEADING, False), *((heading, not column.words) for heading, column in columns.items())]
    body = []
    for row in compared.rows:
        cells = [f'<th scope="row"{"" if row.ok else _BAD}>{escape(row.backend)}</th>']
        cells += [_cell(column.text(row), not column.words) for column in columns.values()]
        body.append(f"<tr>{''.join(cells)}</tr>\n")
    return _table(caption, headings, body)


_BAD = ' class="bad"'


def _table(caption: str, headings: Iterable[tuple[str, bool]], body: Iterable[str]) -> str:
    head = "".join(
        f'<th scope="col"{_NUMBER if numeric else ""}>{escape(heading)}</th>' for heading, numeric in headings
    )
    return (
        f'<div class="wide"><table>\n<caption>{escape(caption)}</caption>\n'
        f"<thead><tr>{head}</tr></thead>\n<tbody>\n{''.join(body)}</tbody>\n</table></div>\n"
    )


_NUMBER = ' class="number"'


def _cell(text: str, numeric: bool) -> str:
    return f"<td{_NUMBER if numeric else ''}>{escape(text)}</td>"


def _line(cells: Iterable[tuple[str, bool]]) -> str:
    return f"<tr>{''.join(_cell(text, numeric) for text, numeric in cells)}</tr>\n"


def _facts(caption: str, facts: Mapping[str, str]) -> str:
    body = [f'<tr><th scope="row">{escape(name)}</th>{_cell(fact, False)}</tr>\n' for name, fact in facts.items()]
    return _table(caption, [("what", False), ("value", False)], body)


def _truth(compared: Compared) -> str:
    answers = compared.answers
    truth, scale, certified = answers.truth, answers.problem.gap_scale, len(answers.certificates)
    if truth is None:
        why = "they contradict each other" if certified else "there is none: no answer has a certificate"
        text = f"The exact solution is not enclosed by the answers' certificates: {why}."
    else:
        decided, upper = answers.decided, at_upper_bound(answers.decided.get("contact_upper"))
        of_scale = f" ({truth.width / scale:.2g} of the gap scale)" if scale > 0 else ""
        text = (
            f"The exact solution lies in the intersection of {certified} "
            f"enclosure{'' if certified == 1 else 's'}. At its widest node it is {truth.width:.2g} (length) "
            f"wide{of_scale}. Of {answers.problem.size} nodes {decided['contact']} are certainly in contact{upper}, "
            f"{decided['clear']} certainly clear, and {decided['undecided']} undecided."
        )
    return f"<h2>Where the truth lies</h2>\n<p>{escape(text)}</p>\n"


def _findings(compared: Compared) -> str:
    conclusion = compared.conclusion
    claims = [f"{name} {sentence}" for name, sentence in conclusion.false_claims.items()]
    unproven = [f"{name} {sentence}" for name, sentence in conclusion.unproven_claims.items()]
    return (
        "<h2>Findings and false claims</h2>\n"
        f"{_left_out(conclusion.left_out_together)}"
        f"<h3>Findings ({len(conclusion.findings)})</h3>\n{_list(conclusion.findings)}"
        f"<h3>Said to be solved, and is not ({len(claims)})</h3>\n{_list(claims)}"
        f"<h3>Said to be solved, which is not proven ({len(unproven)})</h3>\n{_list(unproven)}"
    )


def _left_out(sentences: Sequence[str]) -> str:
    """Return who was not asked, and why; nothing if there is nobody."""
    return "".join(f"<p>{escape(f'Left out: {sentence}.')}</p>\n" for sentence in sentences)


def _list(sentences: Sequence[str]) -> str:
    if not sentences:
        return "<p>None.</p>\n"
    return "<ul>\n" + "".join(f"<li>{escape(sentence)}</li>\n" for sentence in sentences) + "</ul>\n"


def _pairs(compared: Compared) -> str:
    if not compared.pairs:
        return "<h2>Pairs</h2>\n<p>There are no two answers to compare.</p>\n"
    headings = [
        ("first", False), ("second", False), ("largest difference of gaps", True), ("contact Jaccard distance", True),
        ("differing nodes", True), ("boundary distance", True), ("enclosures", False),
    ]  # fmt: skip
    body = [
        _line(
            [
                (pair.first, False),
                (pair.second, False),
                (number(pair.gap_difference), True),
                (number(pair.contact_jaccard), True),
                (str(pair.differing_nodes.size), True),
                (number(pair.boundary_distance), True),
                (_told_of_enclosures(pair), False),
            ]
        )
        for pair in compared.pairs
    ]
    return "<h2>Pairs</h2>\n" + _table("How every two answers differ", headings, body)


def _told_of_enclosures(pair: Pair) -> str:
    if not pair.enclosed:
        return "none"
    return "compatible" if pair.consistent else "exclude each other"


def _best_answer(compared: Compared) -> str:
    answers = compared.answers
    best = answers.best
    if best is None:
        return ""
    upper = at_upper_bound(None if answers.problem.one_sided else int(best.contact_upper.sum()))
    in_contact = f"{int(best.contact.sum())} of {best.problem.size} nodes in contact{upper}"
    return _figure(
        plot_comparison(compared),
        f"The best answer, by {best.backend}, with {in_contact}; "
        f"beside it bars of each backend's certified error and seconds. {compared.conclusion.sentence}",
        "The best answer, and what each backend reached in what time",
        "both",
    )


def _disagreement(compared: Compared) -> str:
    answers = compared.answers
    if len(answers.finite) < 2:
        return ""
    return "<h2>Where the answers lie apart</h2>\n" + _figure(
        plot_disagreement(compared),
        "Difference between the largest and the smallest gap of all answers at each node; "
        f"its maximum is {answers.spread.max():.2g}",
        "How far the answers lie apart; the numbers are the ranks in the next table",
        "map",
    )


def _figure(figure: Figure, alternative: str, caption: str, kind: str) -> str:
    buffer = BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    width, height = (round(110 * inches) for inches in figure.get_size_inches())
    data = base64.b64encode(buffer.getvalue()).decode("ascii")
    return (
        f'<figure class="{kind}"><img src="data:image/png;base64,{data}" width="{width}" height="{height}" '
        f'alt="{escape(alternative, quote=True)}">\n<figcaption>{escape(caption)}</figcaption></figure>\n'
    )


def _worst_nodes(compared: Compared) -> str:
    frame = worst_nodes(compared.answers, _WORST_SHOWN)
    if frame.empty:
        return ""
    headings = [
        ("rank", True), ("node", True), ("x", True), ("y", True), ("difference", True), ("largest gap", True),
        ("by", False), ("smallest gap", True), ("by", False), ("reactions", True), ("truth", True),
    ]  # fmt: skip
    body = [
        _line(
            (
                (str(rank), True),
                (str(node.node), True),
                (_known(node.x, 4), True),
                (_known(node.y, 4), True),
                (number(node.difference), True),
                (f"{node.larger_gap:.5g}", True),
                (node.larger, False),
                (f"{node.smaller_gap:.5g}", True),
                (node.smaller, False),
                (f"{node.larger_reaction:.2g}, {node.smaller_reaction:.2g}", True),
                (_interval(node.true_lower, node.true_upper), True),
            )
        )
        for rank, node in enumerate(frame.itertuples(), start=1)
    ]
    caption = f"The {len(frame)} nodes where the answers lie farthest apart (gaps and x, y: length; reactions: force)"
    return "<h2>Worst nodes</h2>\n" + _table(caption, headings, body)


def _interval(lower: float, upper: float) -> str:
    """Return a narrow interval by its middle and half its width, ``-`` where nothing is known."""
    if not np.isfinite([lower, upper]).all():
        return "-"
    return f"{(lower + upper) / 2:.5g} ± {(upper - lower) / 2:.1g}"


def _known(value: float, digits: int) -> str:
    return "-" if np.isnan(value) else f"{value:.{digits}g}"


def _settings(compared: Compared) -> str:
    provenance = compared.provenance
    limits = {
        "tolerance": f"{compared.tolerance} of the error scale",
        "iterations": "each backend's own limit" if provenance.max_iter is None else f"at most {provenance.max_iter}",
        "time": "no limit" if provenance.time_limit is None else f"at most {provenance.time_limit:g} s each",
        "runs": f"one, and {provenance.repeats} more for the warm time" if provenance.repeats else "one",
    }
    headings = [("backend", False), ("options in effect", False), ("its own words at the end", False)]
    body = []
    for row in compared.rows:
        chosen = provenance.options.get(row.backend, {})
        options = ", ".join(f"{name} = {shortened(value)}" for name, value in chosen.items())
        if row.backend in provenance.own_defaults:
            options = f"the library's own defaults{'; given: ' if options else ''}{options}"
        solution = compared.answers.solutions.get(row.backend)
        words = "; ".join(part for part in (row.message, "" if solution is None else solution.note) if part)
        body.append(_line([(row.backend, False), (options or "none", False), (words, False)]))
    return (
        "<h2>Settings</h2>\n"
        + _facts("What was asked for", limits)
        + _table("Options and last words of each backend", headings, body)
    )


def _surroundings(compared: Compared) -> str:
    provenance = compared.provenance
    return (
        "<h2>Versions and machine</h2>\n"
        + _facts("Versions", provenance.versions)
        + _facts("Machine", {**provenance.machine, "date and time": _date(compared)})
    )
