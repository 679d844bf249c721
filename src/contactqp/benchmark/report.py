"""The report of a benchmark: one page of HTML, with its pictures beside it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ..foundation.files import replaced_as_a_whole
from ..foundation.html import figure_of, line, page, table
from ..foundation.text import at_least, at_most, number
from ..gallery.families import FAMILIES
from .pictures import plot_growth, plot_profiles
from .record import Record
from .results import Results
from .statistics import SHIFT, growths, summaries

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
    "Times are those of a call that keeps nothing of an earlier one, without loading and compiling, and with the "
    "judge's work. A warm start or a kept factorisation would change them.",
    "Memory is that of the whole process, beyond what it held before; what a library holds back counts, too.",
    "Not all solvers were asked about all problems: unless they were named, those only that are practical at a size, "
    "by their own measured limits; and a run that was stopped, or narrowed to some families, has not come to all.",
)
"""What the figures of a benchmark do not say."""


def write_report(results: Results) -> Path:
    """Write ``report.html``, its pictures and the tables into the folder of the results, and return the page's path.

    Raises
    ------
    ValueError
        If there are no records.
    """
    if not results.records:
        raise ValueError(f"folder {results.folder} holds no records yet")
    results.write_tables()
    profiles, growth = plot_profiles(results.records), plot_growth(results.records)
    path = results.folder / "report.html"
    with replaced_as_a_whole(path) as unfinished:
        unfinished.write_text(_page(results, profiles, growth), encoding="utf-8")
    for name, picture in zip(_PICTURES, (profiles, growth), strict=True):
        if picture is not None:
            picture.savefig(results.folder / name, dpi=110)
    return path


def _page(results: Results, profiles: Figure, growth: Figure | None) -> str:
    headline = f"Benchmark of contact solvers: {results.suite.name}"
    sections = [
        _heading(results, headline),
        _summary(results),
        _wrong(results.records),
        _profiles(profiles),
        _growth(growth, results.records),
        _failures(results.records),
        _every(results.records),
        "<h2>Limitations</h2>\n<ul>\n" + "".join(f"<li>{escape(text)}</li>\n" for text in LIMITATIONS) + "</ul>\n",
        _made_with(results),
    ]
    return page(headline, sections)


class _Column(NamedTuple):
    """A column of a table: its heading, what stands in a line, and whether that is a number."""

    heading: str
    text: Callable[[Any], str]
    numeric: bool = True


def _table(caption: str, columns: Sequence[_Column], lines: Iterable[Any]) -> str:
    """Return a table with a line for each of some records."""
    body = [line((column.text(one), column.numeric) for column in columns) for one in lines]
    return table(caption, [(column.heading, column.numeric) for column in columns], body)


_SOLVER = _Column("solver", lambda one: one.backend, numeric=False)
_LEVEL = _Column("level", lambda one: one.level, numeric=False)
_PROBLEM = _Column("problem", lambda one: one.problem, numeric=False)
_STATUS = _Column("status", lambda one: one.status, numeric=False)
_WORDS = _Column("its words", lambda one: one.message, numeric=False)


def _heading(results: Results, headline: str) -> str:
    families = "".join(
        f"<dt>{escape(name)}</dt><dd>{escape(FAMILIES[name].summary)}; {escape(FAMILIES[name].number)}: "
        f"{', '.join(map(str, numbers))}</dd>\n"
        for name, numbers in results.suite.problems.items()
    )
    left = f"<p><strong>{escape(results.told_not_run)}.</strong></p>\n" if results.not_run else ""
    return (
        f"<h1>{escape(headline)}</h1>\n{left}<p>{escape(str(results.suite))}. Begun {escape(results.when)}. "
        "Each solver ran in a process of its own. An answer is proven if the true solution of the discrete problem is "
        f"certainly within the tolerance of it.</p>\n<dl>\n{families}</dl>\n"
    )


def _summary(results: Results) -> str:
    columns = (
        _SOLVER,
        _LEVEL,
        _Column("asked", lambda one: str(one.asked)),
        _Column("proven", lambda one: str(one.proven)),
        _Column("refuted", lambda one: str(one.refuted)),
        _Column("unknown", lambda one: str(one.unknown)),
        _Column("claimed", lambda one: str(one.claimed)),
        _Column("claimed but wrong", lambda one: str(one.claimed_but_wrong)),
        _Column("mean seconds", lambda one: f"{one.mean_seconds:.3g}"),
        _Column("over the best", lambda one: f"{one.relative_mean:.2g}"),
        _Column("MiB", lambda one: f"{one.peak_memory / 2**20:.0f}"),
    )
    caption = (
        f"Means of seconds are geometric ones, shifted by {SHIFT:g} s; what is not proven counts with the time limit"
    )
    lines = summaries(results.records, results.suite.time_limit)
    return "<h2>Solvers</h2>\n" + _table(caption, columns, lines)


def _wrong(records: Sequence[Record]) -> str:
    wrong = [record for record in records if record.claimed_but_wrong]
    claimed = sum(record.claimed for record in records)
    told = f"<h2>Claimed but wrong</h2>\n<p>{len(wrong)} of {claimed} answers that were said to be solved.</p>\n"
    if not wrong:
        return told
    columns = (
        _SOLVER,
        _LEVEL,
        _PROBLEM,
        _Column("judged by", lambda one: f"{one.tol:g}"),
        _Column("error, at least", lambda one: at_least(one.error_lower)),
        _WORDS,
    )
    return told + _table("Errors are over the error scale, and proven", columns, wrong)


def _profiles(picture: Figure) -> str:
    return "<h2>Performance profiles</h2>\n" + figure_of(
        picture,
        "Steps that rise with the factor of time: for each solver the part of the problems that it proves within that "
        "factor of the fastest solver's time",
        "Which part of the problems a solver proves within a factor of the time that the fastest one takes for each "
        "(Dolan and Moré 2002); where its line begins it is the fastest, where it ends is all that it proves. "
        "Of the problems that have run, what it was not asked counts as not proven, be it that its method cannot do "
        "it, that it is not practical at that size, or that the run was stopped before",
        "both",
    )


def _growth(picture: Figure | None, records: Sequence[Record]) -> str:
    if picture is None:
        return ""
    told = "; ".join(f"{one.family} by {one.backend} ({one.level}): {one.exponent:.2f}" for one in growths(records))
    return "<h2>Time against size</h2>\n" + figure_of(
        picture,
        f"Seconds against unknowns for each family; exponents: {told}",
        "Seconds of proven answers; the number at the end of each line is the exponent of the growth over the sizes "
        "that are shown, small where what every call costs is most of the time",
        "both",
    )


def _failures(records: Sequence[Record]) -> str:
    failed = [record for record in records if not record.proven]
    if not failed:
        return ""
    caption = "Every answer that is not proven, and why"
    return "<h2>What is not proven</h2>\n" + _table(caption, (_SOLVER, _LEVEL, _PROBLEM, _STATUS, _WORDS), failed)


def _every(records: Sequence[Record]) -> str:
    columns = (
        _PROBLEM,
        _Column("unknowns", lambda one: _or_dash(one.size)),
        _SOLVER,
        _LEVEL,
        _STATUS,
        _Column("iterations", lambda one: _or_dash(one.iterations)),
        _Column("set-up s", lambda one: number(one.setup_seconds)),
        _Column("solve s", lambda one: number(one.solve_seconds)),
        _Column("all s", lambda one: number(one.seconds)),
        _Column("error, at least", lambda one: "-" if one.error_lower is None else at_least(one.error_lower)),
        _Column("error, at most", lambda one: "-" if one.error_at_most is None else at_most(one.error_at_most)),
        _Column("MiB", lambda one: _or_dash(None if one.peak_memory is None else round(one.peak_memory / 2**20))),
    )
    return "<h2>All answers</h2>\n" + _table("Errors are over the error scale, and proven", columns, records)


def _or_dash(count: int | None) -> str:
    return "-" if count is None else str(count)


def _made_with(results: Results) -> str:
    told = {**results.machine, **results.versions}
    body = [line([(name, False), (value, False)]) for name, value in told.items()]
    run = [family for family in results.suite.problems if any(one.family == family for one in results.records)]
    narrowed = "" if len(run) == len(results.suite.problems) else f" --families {','.join(run)}"
    command = f"contactqp bench --suite {results.suite.name}{narrowed} --out FOLDER"
    return f"<h2>Machine and versions</h2>\n<p>Made by <code>{escape(command)}</code>.</p>\n" + table(
        "What it was measured with", [("what", False), ("value", False)], body
    )
