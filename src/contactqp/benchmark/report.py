"""The report of a benchmark: one page of HTML, with its pictures beside it."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path

from ..foundation.files import replaced_as_a_whole
from ..foundation.html import figure_of, line, page, table
from ..foundation.text import at_least, number
from .families import FAMILIES
from .pictures import plot_growth, plot_profiles
from .record import Record
from .results import Results
from .statistics import SHIFT, growths, summaries

_PICTURES = ("profiles.png", "growth.png")

LIMITATIONS = (
    "One machine, with whatever else it was doing: a factor of two between two times means little, and orders of "
    "solvers that are as near as that may change.",
    "The problems are contact problems of a few families, chosen by the authors of some of the solvers. They say "
    "nothing of other quadratic programs.",
    "Only answers that are proven to be within the tolerance count as solved; some solvers are asked again and again "
    "with tighter tolerances until they are, which costs them time that their own stopping rules would not.",
    "At the level 'default' libraries run once as their authors ship them, and are judged by 1e-6, which they were not "
    "told.",
    "Times are those of a first call in a fresh process, without loading and compiling, and with the judge's work. A "
    "warm start or a kept factorisation would change them.",
    "Memory is that of the whole process, beyond what it held before; what a library holds back counts, too.",
    "Not all solvers were asked about all problems: those that are practical at a size only, by their own measured "
    "limits.",
)
"""What the figures of a benchmark do not say."""


def write_report(results: Results) -> Path:
    """Write ``report.html``, its pictures and the tables into the folder of the results, and return the page's path."""
    results.write_tables()
    records = results.records
    path = results.folder / "report.html"
    with replaced_as_a_whole(path) as unfinished:
        unfinished.write_text(report_html(results), encoding="utf-8")
    for name, picture in zip(_PICTURES, (plot_profiles(records), plot_growth(records)), strict=True):
        if picture is not None:
            picture.savefig(results.folder / name, dpi=110)
    return path


def report_html(results: Results) -> str:
    """Return the page as text.

    Raises
    ------
    ValueError
        If there are no records.
    """
    if not results.records:
        raise ValueError(f"folder {results.folder} holds no records yet")
    headline = f"Benchmark of contact solvers: {results.suite.name}"
    sections = [
        _heading(results, headline),
        _summary(results),
        _wrong(results.records),
        _profiles(results),
        _growth(results.records),
        _failures(results.records),
        _every(results.records),
        "<h2>Limitations</h2>\n<ul>\n" + "".join(f"<li>{escape(text)}</li>\n" for text in LIMITATIONS) + "</ul>\n",
        _made_with(results),
    ]
    return page(headline, sections)


def _heading(results: Results, headline: str) -> str:
    families = "".join(
        f"<dt>{escape(name)}</dt><dd>{escape(FAMILIES[name].summary)}; {escape(FAMILIES[name].number)}: "
        f"{', '.join(map(str, numbers))}</dd>\n"
        for name, numbers in results.suite.problems.items()
    )
    return (
        f"<h1>{escape(headline)}</h1>\n<p>{escape(str(results.suite))}. Begun {escape(results.when)}. "
        "Each solver ran in a process of its own. An answer is proven if the true solution of the discrete problem is "
        f"certainly within the tolerance of it.</p>\n<dl>\n{families}</dl>\n"
    )


def _summary(results: Results) -> str:
    headings = [
        ("solver", False), ("level", False), ("asked", True), ("proven", True), ("refuted", True), ("unknown", True),
        ("claimed", True), ("claimed but wrong", True), ("mean seconds", True), ("over the best", True),
        ("MiB", True),
    ]  # fmt: skip
    body = [
        line(
            [
                (one.backend, False),
                (one.level, False),
                (str(one.asked), True),
                (str(one.proven), True),
                (str(one.refuted), True),
                (str(one.unknown), True),
                (str(one.claimed), True),
                (str(one.claimed_but_wrong), True),
                (f"{one.mean_seconds:.3g}", True),
                (f"{one.relative_mean:.2g}", True),
                (f"{one.peak_memory / 2**20:.0f}", True),
            ]
        )
        for one in summaries(results.records, results.suite.time_limit)
    ]
    caption = (
        f"Means of seconds are geometric ones, shifted by {SHIFT:g} s; what is not proven counts with the time limit"
    )
    return "<h2>Solvers</h2>\n" + table(caption, headings, body)


def _wrong(records: Sequence[Record]) -> str:
    wrong = [record for record in records if record.claimed_but_wrong]
    claimed = sum(record.claimed for record in records)
    told = f"<h2>Claimed but wrong</h2>\n<p>{len(wrong)} of {claimed} answers that were said to be solved.</p>\n"
    if not wrong:
        return told
    headings = [
        ("solver", False), ("level", False), ("problem", False), ("judged by", True), ("error, at least", True),
        ("its words", False),
    ]  # fmt: skip
    body = [
        line(
            [
                (record.backend, False),
                (record.level, False),
                (record.problem, False),
                (f"{record.tol:g}", True),
                (at_least(record.error_lower or 0.0), True),
                (record.message, False),
            ]
        )
        for record in wrong
    ]
    return told + table("Errors are over the error scale, and proven", headings, body)


def _profiles(results: Results) -> str:
    picture = plot_profiles(results.records)
    return "<h2>Performance profiles</h2>\n" + figure_of(
        picture,
        "Steps that rise with the factor of time: for each solver the part of the problems that it proves within that "
        "factor of the fastest solver's time",
        "Which part of the problems a solver proves within a factor of the time that the fastest one takes for each "
        "(Dolan and Moré 2002); where its line begins it is the fastest, where it ends is all that it proves",
        "both",
    )


def _growth(records: Sequence[Record]) -> str:
    picture = plot_growth(records)
    if picture is None:
        return ""
    told = "; ".join(f"{one.family} by {one.backend} ({one.level}): {one.exponent:.2f}" for one in growths(records))
    return "<h2>Time against size</h2>\n" + figure_of(
        picture,
        f"Seconds against unknowns for each family; exponents: {told}",
        "Seconds of proven answers; the number at the end of each line is the exponent of the growth",
        "both",
    )


def _failures(records: Sequence[Record]) -> str:
    failed = [record for record in records if not record.proven]
    if not failed:
        return ""
    headings = [("solver", False), ("level", False), ("problem", False), ("status", False), ("its words", False)]
    told = ((one.backend, one.level, one.problem, one.status, one.message) for one in failed)
    body = [line((text, False) for text in texts) for texts in told]
    return "<h2>What is not proven</h2>\n" + table("Every answer that is not proven, and why", headings, body)


def _every(records: Sequence[Record]) -> str:
    headings = [
        ("problem", False), ("unknowns", True), ("solver", False), ("level", False), ("status", False),
        ("iterations", True), ("set-up s", True), ("solve s", True), ("all s", True), ("bound", True),
        ("true error", True), ("MiB", True),
    ]  # fmt: skip
    body = [
        line(
            [
                (one.problem, False),
                (_or_dash(one.size), True),
                (one.backend, False),
                (one.level, False),
                (one.status, False),
                (_or_dash(one.iterations), True),
                (number(one.setup_seconds), True),
                (number(one.solve_seconds), True),
                (number(one.seconds), True),
                (number(one.relative_bound), True),
                (number(one.error_upper), True),
                (_or_dash(None if one.peak_memory is None else round(one.peak_memory / 2**20)), True),
            ]
        )
        for one in records
    ]
    return "<h2>All answers</h2>\n" + table("Bounds and errors are over the error scale", headings, body)


def _or_dash(count: int | None) -> str:
    return "-" if count is None else str(count)


def _made_with(results: Results) -> str:
    told = {**results.machine, **results.versions}
    body = [line([(name, False), (value, False)]) for name, value in told.items()]
    command = f"contactqp bench --suite {results.suite.name} --out FOLDER"
    return f"<h2>Machine and versions</h2>\n<p>Made by <code>{escape(command)}</code>.</p>\n" + table(
        "What it was measured with", [("what", False), ("value", False)], body
    )
