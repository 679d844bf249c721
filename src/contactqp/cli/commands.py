"""The command line: ``contactqp compare``, ``contactqp solve``, ``contactqp paper``, ``contactqp backends``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..foundation.interrupts import INTERRUPTED, ended_by_interrupts

app = typer.Typer(
    name="contactqp",
    help=(
        "Membranes and cables over rigid obstacles, solved by any backend by name.\n\n"
        "A case file (TOML) describes frame, spacing, tension, load and support; see the examples folder. "
        "Every answer is judged by the package itself and comes with a certified bound of its error."
    ),
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_show_locals=False,
)

EXIT_OK, EXIT_NOT_CERTIFIED, EXIT_BAD_INPUT = 0, 1, 2

Case = Annotated[Path, typer.Argument(help="Case file (TOML).", show_default=False)]
Tol = Annotated[
    str,
    typer.Option(
        help="Wanted bound of the gap's error, relative to the gap scale: a number in (0, 1), low (1e-3), mid (1e-6), "
        "high (1e-9), or default: each library as its authors ship it, judged by 1e-6.",
        metavar="NUMBER|LEVEL",
    ),
]
TimeLimit = Annotated[float | None, typer.Option(help="Seconds for each backend.", show_default=False)]
Plot = Annotated[Path | None, typer.Option(help="Write a picture (.png, .pdf, .svg).", show_default=False)]


@app.command()
def compare(
    case: Case,
    backends: Annotated[str | None, typer.Option(help="Names, separated by commas; by default all that suit.")] = None,
    tol: Tol = "1e-6",
    time_limit: TimeLimit = None,
    repeats: Annotated[int, typer.Option(help="Runs of each backend after the first, for its warm time.")] = 0,
    plot: Plot = None,
    json: Annotated[
        Path | None, typer.Option(help="Write the table and the verdict as JSON.", show_default=False)
    ] = None,
    report: Annotated[Path | None, typer.Option(help="Write everything as one HTML page.", show_default=False)] = None,
) -> None:
    """Solve CASE by several backends and cross-check the answers.

    Exit code 0: all certified and in agreement; 1: not; 2: bad input.
    """
    from ..comparison.compare import compare as compare_backends
    from ..io.cases import load_case
    from .tables import print_comparison

    with _bad_input():
        _check_folders(plot, json, report)
        model = load_case(case)
        names = None if backends is None else [name.strip() for name in backends.split(",") if name.strip()]
        comparison = compare_backends(model, names, tol=_tolerance(tol), time_limit=time_limit, repeats=repeats)
        print_comparison(comparison, title=case.name)
        if json is not None:
            json.write_text(comparison.to_json() + "\n", encoding="utf-8")
        if plot is not None and comparison.best is not None:
            comparison.plot().savefig(plot, dpi=150)
            typer.echo(f"picture: {plot}")
        if report is not None:
            typer.echo(f"report: {comparison.report(report, title=case.name)}")
    raise typer.Exit(EXIT_OK if comparison.agree else EXIT_NOT_CERTIFIED)


@app.command()
def solve(
    case: Case,
    backend: Annotated[str, typer.Option(help="Name of the backend, see 'contactqp backends'.")] = "auto",
    tol: Tol = "1e-6",
    time_limit: TimeLimit = None,
    out: Annotated[Path | None, typer.Option(help="Write all fields as NetCDF (.nc).", show_default=False)] = None,
    plot: Plot = None,
) -> None:
    """Solve CASE by one backend.

    Exit code 0: certified; 1: not; 2: bad input.
    """
    from ..io.cases import load_case
    from ..solving.solve import solve as solve_problem

    with _bad_input():
        _check_folders(out, plot)
        model = load_case(case)
        solution = solve_problem(model, backend, tol=_tolerance(tol), time_limit=time_limit, on_failure="ignore")
        typer.echo(repr(solution))
        if out is not None:
            solution.to_dataset().to_netcdf(out, engine="netcdf4")
            typer.echo(f"fields: {out}")
        if plot is not None and solution.residuals is not None:
            solution.plot().savefig(plot, dpi=150)
            typer.echo(f"picture: {plot}")
    raise typer.Exit(EXIT_OK if solution.status.ok else EXIT_NOT_CERTIFIED)


@app.command()
def paper(
    out: Annotated[
        Path, typer.Option(help="Folder for table, maps and pictures; made if missing.", metavar="FOLDER")
    ] = Path("paper"),
) -> None:
    """Solve the paper's hexagon at the ten loads of its Table 1, and write table and figures into a folder.

    The paper: Analysis of membranes stretched over a unilateral support, of the 1970s.
    The rigid surface is a surrogate consistent with Table 1, not a reproduction.

    Exit code 0: all certified, contact sets nested and the same by all backends; 1: not; 2: bad input.
    """
    from ..paper.folder import CAPTIONS, prepare_folder, write_folder

    with _bad_input():
        prepare_folder(out)
        from ..paper.reproduction import reproduce
        from ..paper.table import print_table

        found = reproduce()
        print_table(found)
        typer.echo("")
        for file in write_folder(found, out):
            typer.echo(f"{file}: {CAPTIONS.get(file.name, 'Each file and its caption.')}")
    raise typer.Exit(EXIT_OK if found.ok else EXIT_NOT_CERTIFIED)


@app.command()
def backends() -> None:
    """List the backends: method, version, what they need, and what to install where one is missing."""
    from .tables import print_backends

    print_backends()


class _bad_input:  # noqa: N801
    """Turn an error of the input into one line on standard error and exit code 2."""

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        if isinstance(error, (ValueError, TypeError, ImportError, OSError)):
            typer.echo(f"contactqp: {error}", err=True)
            raise typer.Exit(EXIT_BAD_INPUT) from None
        if isinstance(error, KeyboardInterrupt):
            typer.echo("contactqp: interrupted", err=True)
            raise typer.Exit(INTERRUPTED) from None


def _tolerance(text: str) -> float | str:
    """Return the number that was typed; what is none is taken for a level's name."""
    try:
        return float(text)
    except ValueError:
        return text


def _check_folders(*files: Path | None) -> None:
    """Refuse an output file whose folder does not exist, before any work."""
    for file in files:
        if file is not None and not file.parent.is_dir():
            raise ValueError(f"cannot write {file}: there is no folder {file.parent}")


def main() -> None:
    """Run the command line."""
    with ended_by_interrupts():
        app()
