"""A comparison as one HTML page that needs no network, no script and no other file."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import quote

import numpy as np

from ..foundation.files import replaced_as_a_whole, require_writable
from ..foundation.html import BAD, cell, figure_of, line, page, table
from ..foundation.text import at_upper_bound, number, shortened
from .columns import GROUPS, Column, columns_of, printed_columns
from .compared import Compared
from .disagreement import worst_nodes
from .legend import legend_of
from .pairs import Pair
from .pictures import plot_comparison, plot_disagreement
from .text import asked_for, closing_lines

if TYPE_CHECKING:
    from ..continuum.result import Continuum

_WORST_SHOWN = 10
"""Largest number of nodes in the table of those where answers lie farthest apart."""


def write_report(
    compared: Compared,
    path: Path,
    title: str = "",
    explorer: Path | None = None,
    continuum: Continuum | None = None,
) -> Path:
    """Write the page and return its path; an older page at that path is replaced once the new one is complete.

    Parameters
    ----------
    compared : Compared
    path : Path
    title : str
    explorer : Path, optional
        A page to link, see `contactqp.explorer`: by its place relative to the report's, so that both can be moved.
    continuum : Continuum, optional
        What the best answer proves of the membrane itself.
    """
    require_writable(path, (".html", ".htm"), "report")
    link = "" if explorer is None else quote(Path(os.path.relpath(explorer, path.parent)).as_posix())
    page = report_html(compared, title, link, continuum)
    with replaced_as_a_whole(path) as unfinished:
        unfinished.write_text(page, encoding="utf-8")
    return path


def report_html(compared: Compared, title: str = "", explorer: str = "", continuum: Continuum | None = None) -> str:
    """Return the page as text, with a link to an explorer of the problem if there is one."""
    headline = title or compared.subject
    sections = [
        _heading(compared, headline),
        f'<p><a href="{escape(explorer)}">Move this problem\'s load, tension and support</a></p>\n' if explorer else "",
        _best_answer(compared),
        _metrics(compared),
        _truth(compared),
        "" if continuum is None else _membrane_itself(compared, continuum),
        _findings(compared),
        _pairs(compared),
        _disagreement(compared),
        _worst_nodes(compared),
        _settings(compared),
        _surroundings(compared),
    ]
    return page(headline, sections)


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
    rows = _table_of_rows(compared, f"{compared.subject}; {asked_for(compared)}", columns)
    return rows + "".join(f"<p>{escape(remark)}</p>\n" for remark in closing_lines(compared))


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
        cells = [f'<th scope="row"{"" if row.ok else BAD}>{escape(row.backend)}</th>']
        cells += [cell(column.text(row), not column.words) for column in columns.values()]
        body.append(f"<tr>{''.join(cells)}</tr>\n")
    return table(caption, headings, body)


def _facts(caption: str, facts: Mapping[str, str]) -> str:
    body = [f'<tr><th scope="row">{escape(name)}</th>{cell(fact, False)}</tr>\n' for name, fact in facts.items()]
    return table(caption, [("what", False), ("value", False)], body)


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


def _membrane_itself(compared: Compared, continuum: Continuum) -> str:
    best = compared.answers.best
    by = "" if best is None else f"What the best answer, by {best.backend}, proves of what the lattice stands for"
    facts = _facts(by, continuum.facts())
    if continuum.pointwise is None:
        return f"<h2>The membrane itself</h2>\n{facts}"
    contact = continuum.contact
    counts = (
        f"{contact.contact.sum()} squares in contact, {contact.clear.sum()} clear, {contact.undecided.sum()} undecided"
    )
    return f"<h2>The membrane itself</h2>\n{facts}" + figure_of(
        continuum.plot(),
        f"Map of the squares between the lattice's points: {counts}, which are the strip that holds the free boundary",
        "Where the membrane certainly touches, and where it is certainly clear",
        "map",
    )


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
        line(
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
    return "<h2>Pairs</h2>\n" + table("How every two answers differ", headings, body)


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
    return figure_of(
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
    return "<h2>Where the answers lie apart</h2>\n" + figure_of(
        plot_disagreement(compared),
        "Difference between the largest and the smallest gap of all answers at each node; "
        f"its maximum is {answers.spread.max():.2g}",
        "How far the answers lie apart; the numbers are the ranks in the next table",
        "map",
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
        line(
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
    return "<h2>Worst nodes</h2>\n" + table(caption, headings, body)


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
        body.append(line([(row.backend, False), (options or "none", False), (words, False)]))
    return (
        "<h2>Settings</h2>\n"
        + _facts("What was asked for", limits)
        + table("Options and last words of each backend", headings, body)
    )


def _surroundings(compared: Compared) -> str:
    provenance = compared.provenance
    return (
        "<h2>Versions and machine</h2>\n"
        + _facts("Versions", provenance.versions)
        + _facts("Machine", {**provenance.machine, "date and time": _date(compared)})
    )
