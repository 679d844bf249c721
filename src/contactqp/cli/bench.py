"""``contactqp bench``: solvers measured on suites of problems, two runs beside each other, and benchmarks of parts."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table
from rich.text import Text

from ..errors import ContactWarning
from ..foundation.terminal import table_console
from ..foundation.text import counted
from .application import EXIT_NOT_CERTIFIED, EXIT_OK, app

_SHOWN = 20
"""Lines of a difference that are shown."""

bench = typer.Typer(invoke_without_command=True, no_args_is_help=False)
app.add_typer(bench, name="bench")


def _names(text: str | None) -> list[str] | None:
    return None if text is None else [name.strip() for name in text.split(",") if name.strip()]


@bench.callback()
def run_suite(
    context: typer.Context,
    suite: Annotated[str, typer.Option(help="quick (some minutes), standard or large.")] = "quick",
    backends: Annotated[
        str | None, typer.Option(help="Names, separated by commas, or 'all'. By default those that are usual.")
    ] = None,
    levels: Annotated[str | None, typer.Option(help="low, mid, high, default; by default the suite's.")] = None,
    families: Annotated[str | None, typer.Option(help="Some of the suite's; by default all.")] = None,
    out: Annotated[Path, typer.Option(help="Where results are written.", metavar="FOLDER")] = Path("benchmark"),
) -> None:
    """Measure solvers on a suite of problems, each in a process of its own, every answer judged against the truth.

    Records, tables, pictures and report.html are written into the folder. A run that was stopped goes on from there;
    'contactqp bench diff A B' compares two folders.

    Exit code 0: all has run; 1: an answer was certified that is proven wrong; 2: bad input; 130: interrupted.
    """
    if context.invoked_subcommand is not None:
        return
    from ..benchmark import run, summaries, write_report

    listed = _names(backends)
    results = run(
        suite, out, backends="all" if listed == ["all"] else listed, levels=_names(levels), families=_names(families)
    )
    table = Table(box=None, header_style="bold", pad_edge=False, padding=(0, 1))
    for heading in ("solver", "level", "proven", "wrong claims", "mean s", "over best"):
        table.add_column(heading, justify="left" if heading in ("solver", "level") else "right", no_wrap=True)
    for one in summaries(results.records, results.suite.time_limit):
        style = "green" if one.proven == one.asked else "yellow" if not one.claimed_but_wrong else "red"
        table.add_row(
            one.backend,
            one.level,
            Text(f"{one.proven} of {one.asked}", style=style),
            f"{one.claimed_but_wrong} of {one.claimed}",
            f"{one.mean_seconds:.3g}",
            f"{one.relative_mean:.2g}",
        )
    console = table_console()
    console.print(Text(str(results.suite), style="bold"))
    console.print()
    console.print(table)
    console.print()
    if results.not_run:
        console.print(Text(results.told_not_run, style="yellow"))
    typer.echo(f"report: {write_report(results)}")
    false_proofs = [record for record in results.records if record.proven and record.refuted]
    for record in false_proofs:
        typer.echo(f"certified, and proven wrong: {record.backend} on {record.problem}", err=True)
    raise typer.Exit(EXIT_NOT_CERTIFIED if false_proofs else EXIT_OK)


@bench.command("diff")
def diff(
    first: Annotated[Path, typer.Argument(help="Folder of the run before.", show_default=False)],
    second: Annotated[Path, typer.Argument(help="Folder of the run after.", show_default=False)],
) -> None:
    """Compare two runs: answers with another status, and times that changed by a quarter or more.

    Exit code 0: nothing is worse in the second; 1: something is; 2: bad input.
    """
    from ..benchmark import Results, difference

    found = difference(Results.read(first), Results.read(second))
    common = counted(found.common, "answer")
    typer.echo(f"{common} in both; the second run takes {found.factor:.2f} x the first's time (mean)")
    for change in found.changes[:_SHOWN]:
        typer.echo(f"{'worse: ' if change.worse else ''}{change}")
    if len(found.changes) > _SHOWN:
        typer.echo(f"and {len(found.changes) - _SHOWN} more")
    raise typer.Exit(EXIT_NOT_CERTIFIED if found.worse else EXIT_OK)


@bench.command("run")
def run_parts(
    given: Annotated[
        list[str],
        typer.Argument(help="Python files that define SPECS, and names of some of them.", metavar="FILE.py… [NAME…]"),
    ],
    phases: Annotated[str | None, typer.Option(help="Some of their phases, separated by commas.")] = None,
    points: Annotated[str | None, typer.Option(help="Points instead of their sweeps, separated by commas.")] = None,
    repeat: Annotated[int | None, typer.Option(help="Times each phase is timed; the least counts.")] = None,
    largest: Annotated[float | None, typer.Option(help="Numbers above it are left out.")] = None,
    smoke: Annotated[bool, typer.Option("--smoke", help="Run each phase once at a small point.")] = False,
    out: Annotated[
        Path | None, typer.Option(help="Where timings.csv, about.json and pictures are written.", metavar="FOLDER")
    ] = None,
) -> None:
    """Time the parts that Python files describe, the phases of each in turn in one process.

    Exit code 0: all has run; 2: bad input; 130: interrupted.
    """
    from ..benchmark import load_specs, run_specs

    files = [Path(word) for word in given if word.endswith(".py")]
    if not files:
        raise ValueError(f"name a Python file that defines SPECS; got {', '.join(given)}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ContactWarning)  # answers are told with their status
        run_specs(
            [spec for file in files for spec in load_specs(file)],
            names=[word for word in given if not word.endswith(".py")],
            phases=_names(phases),
            points=None if points is None else [_point(word) for word in _names(points) or ()],
            repeat=repeat,
            largest=largest,
            smoke=smoke,
            out=out,
            show=typer.echo,
        )


def _point(word: str) -> int | float | str:
    """Return the number that a word is, or the word."""
    for kind in (int, float):
        try:
            return kind(word)
        except ValueError:
            continue
    return word
