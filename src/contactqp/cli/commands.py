"""The command line: ``contactqp compare``, ``solve``, ``march``, ``certify``, ``new``, ``schema``, ``backends``, ..."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from ..foundation.checks import one_of
from ..foundation.files import made_folder
from ..foundation.terminal import line_width
from ..foundation.text import counted, folded, shortened
from .application import (
    EFFORTS,
    EXIT_NOT_CERTIFIED,
    EXIT_OK,
    PICTURES,
    Case,
    Continuum,
    Plot,
    TimeLimit,
    Tol,
    check_output,
    times_told,
    tolerance,
)
from .application import (
    app as app,
)
from .bench import bench as bench
from .distributed import processes_started, solve_together
from .gallery_commands import export_dataset, study  # noqa: F401  (commands register themselves)

if TYPE_CHECKING:
    from ..foundation.brackets import Bracket
    from ..io.cases import Model
    from ..refinement.solve_to import SolvedTo
    from ..solving.solution import Effort

_METHODS = "crank-nicolson", "euler"
_QUANTITIES = "gap", "deflection"
_ROWS = "up", "down"
"""Words that options take; others are refused with the one that was probably meant."""


@app.command()
def compare(
    case: Case,
    backends: Annotated[
        str | None,
        typer.Option(
            help="Names, separated by commas, or 'all': what qpsolvers and CVXPY find, too. By default the package's "
            "own and plug-ins that suit."
        ),
    ] = None,
    tol: Tol = "1e-6",
    time_limit: TimeLimit = None,
    repeats: Annotated[int, typer.Option(help="Runs of each backend after the first, for its warm time.")] = 0,
    wide: Annotated[bool, typer.Option("--wide", help="Show all columns, however narrow the terminal is.")] = False,
    plot: Plot = None,
    json: Annotated[
        Path | None, typer.Option(help="Write the table and the verdict as JSON.", show_default=False)
    ] = None,
    report: Annotated[Path | None, typer.Option(help="Write everything as one HTML page.", show_default=False)] = None,
    continuum: Continuum = None,
    explorer: Annotated[
        Path | None,
        typer.Option(
            help="Write a page with sliders, see 'contactqp explore'; the report links it.", show_default=False
        ),
    ] = None,
) -> None:
    """Solve CASE by several backends and cross-check the answers.

    Exit code 0: all certified and in agreement; 1: not; 2: bad input; 130: interrupted.
    """
    check_output("--plot", plot, PICTURES)
    check_output("--json", json, (".json",))
    check_output("--report", report, (".html", ".htm"))
    check_output("--explorer", explorer, (".html", ".htm"))
    effort = _effort(continuum)
    from ..comparison.compare import compare as compare_backends
    from .tables import print_comparison

    model, title = _read(case)
    if explorer is not None:
        _write_explorer(model, explorer, title or case.stem)
    listed = None if backends is None else [name.strip() for name in backends.split(",") if name.strip()]
    comparison = compare_backends(
        model, "all" if listed == ["all"] else listed, tol=tolerance(tol), time_limit=time_limit, repeats=repeats
    )
    print_comparison(comparison, title=case.name, wide=wide)
    if effort is not None and comparison.best is not None:
        typer.echo(f"\n{comparison.best.continuum(effort)}")
    if json is not None:
        json.write_text(comparison.to_json() + "\n", encoding="utf-8")
    if plot is not None and comparison.best is not None:
        from ..comparison.pictures import headline

        comparison.plot(title=_headed(title, headline(comparison))).savefig(plot, dpi=150)
        typer.echo(f"picture: {plot}")
    if report is not None:
        typer.echo(f"report: {comparison.report(report, title or case.name, explorer=explorer, continuum=effort)}")
    raise typer.Exit(EXIT_OK if comparison.agree else EXIT_NOT_CERTIFIED)


@app.command()
def solve(
    case: Case,
    backend: Annotated[str, typer.Option(help="Name of the backend, see 'contactqp backends'.")] = "auto",
    tol: Tol = "1e-6",
    time_limit: TimeLimit = None,
    out: Annotated[
        Path | None,
        typer.Option(
            help="Write all fields (.nc, .zarr, .csv, .vti, .vtu, .tif) or contact patches (.geojson).",
            show_default=False,
        ),
    ] = None,
    plot: Plot = None,
    continuum: Continuum = None,
    continuum_tol: Annotated[
        float | None,
        typer.Option(
            help="Halve the case's spacing until the membrane itself is enclosed to this, relative as --tol is.",
            show_default=False,
            min=1e-12,
        ),
    ] = None,
    warm_start: Annotated[
        Path | None,
        typer.Option(
            help="Start from an earlier answer on the same lattice: the fields that solve --out wrote (.nc, .zarr, "
            ".csv; of several processes .zarr).",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Solve CASE by one backend.

    Started by mpiexec, several processes share a membrane's rows, and write one .zarr store (the extra 'mpi').

    Exit code 0: certified, and with --continuum-tol reached; 1: not; 2: bad input; 130: interrupted.
    """
    if processes_started() > 1:
        for option, given in (("--continuum", continuum), ("--continuum-tol", continuum_tol)):
            if given is not None:
                raise ValueError(f"{option} works in one process only; start without mpiexec, or leave it out")
        raise typer.Exit(solve_together(case, backend, tolerance(tol), time_limit, out, plot, warm_start))
    from ..io.writers import WRITERS, holds_bounds, require_room, require_suitable
    from ..models.cable import Cable

    effort = _effort(continuum if continuum_tol is None else "pointwise")
    check_output("--out", out, tuple(WRITERS))
    check_output("--plot", plot, PICTURES)
    from ..solving.solve import solve as solve_problem

    model, title = _read(case)
    if out is not None:
        require_suitable(out, model)
        if continuum is not None:
            require_room(out, none_at_nodes=effort == "energy" and not isinstance(model, Cable))
    start = None
    if warm_start is not None:
        if continuum_tol is not None:
            raise ValueError("--warm-start is of one lattice, and --continuum-tol goes through several; leave one out")
        from ..io.answers import read_answer

        start = read_answer(warm_start, model, "gap")
    reached = True
    if continuum_tol is None:
        solution = solve_problem(
            model, backend, tol=tolerance(tol), time_limit=time_limit, warm_start=start, on_failure="ignore"
        )
    else:
        found = _solved_to(case, model, continuum_tol, backend, time_limit)
        solution, reached = found.solution, found.reached
        _echo_facts(str(found))
    _echo_facts(repr(solution))
    if solution.certificate is not None:
        _echo_facts(f"  reaction    {_told(solution.total_reaction)} in all ({model.units['reaction']})")
        if model.node_area is not None:
            area = f"{_AREAS[model.units['load']]} that its nodes stand for"
            _echo_facts(f"  contact     {_told(solution.contact_area)} ({area})")
    if effort is not None and solution.finite:
        typer.echo(str(solution.continuum(effort)))
    if out is not None:
        solution.save(out, continuum=effort if holds_bounds(out) else None)
        typer.echo(f"fields: {out}")
    if plot is not None and solution.finite:
        from ..plotting.answers import headline

        has_strip = effort == "pointwise" and solution.continuum(effort).pointwise is not None
        strip: Literal["pointwise"] | None = "pointwise" if has_strip else None
        solution.plot(title=_headed(title, headline(solution)), continuum=strip).savefig(plot, dpi=150)
        typer.echo(f"picture: {plot}")
    raise typer.Exit(EXIT_OK if solution.status.ok and reached else EXIT_NOT_CERTIFIED)


def _effort(told: str | None) -> Effort | None:
    """Return how much is asked about the membrane itself, if anything is."""
    return None if told is None else one_of(told, EFFORTS, "--continuum")  # type: ignore[return-value]


def _solved_to(case: Path, model: Model, continuum_tol: float, backend: str, time_limit: float | None) -> SolvedTo:
    """Return a case's solutions on finer and finer lattices, from its own on."""
    from ..io.cases import read_case
    from ..models.membrane import Membrane
    from ..refinement.solve_to import solve_to

    if not isinstance(model, Membrane):
        raise ValueError(f"--continuum-tol encloses a Membrane, {case} describes {model!r}")
    if model.lattice.overshoot:
        raise ValueError(
            f"--continuum-tol needs a frame that lies on the lattice, or a lattice that is fitted to it (fitted = true "
            f"in {case}), not {model.lattice!r}"
        )

    def model_at(spacing: float) -> Membrane:
        finer = read_case(case, spacing).model
        assert isinstance(finer, Membrane)
        return finer

    return solve_to(model_at, continuum_tol, spacing=model.lattice.spacing, backend=backend, time_limit=time_limit)


@app.command()
def march(
    case: Case,
    times: Annotated[
        str,
        typer.Option(
            help="Times, that of the initial state first: numbers separated by commas, or START:STOP:STEPS.",
            show_default=False,
        ),
    ],
    damping: Annotated[
        float, typer.Option(help="Force per area (cable: per length) and velocity, > 0.", show_default=False)
    ],
    method: Annotated[str, typer.Option(help="How a step is made.", metavar="|".join(_METHODS))] = _METHODS[0],
    backend: Annotated[str, typer.Option(help="Name of the backend, see 'contactqp backends'.")] = "auto",
    tol: Tol = "1e-8",
    out: Annotated[Path | None, typer.Option(help="Write all times (.nc).", show_default=False)] = None,
    checkpoint: Annotated[
        Path | None,
        typer.Option(help="Keep every step in this file (.nc), and go on from it.", show_default=False),
    ] = None,
    film: Annotated[
        Path | None, typer.Option(help="Write a film (.gif, .html; .mp4 by ffmpeg).", show_default=False)
    ] = None,
    plot: Plot = None,
) -> None:
    """Let CASE move in time from its frame's plane, its nodes damped.

    Exit code 0: every step certified, given the one before; 1: not; 2: bad input; 130: interrupted.
    """
    check_output("--out", out, (".nc",))
    check_output("--plot", plot, PICTURES)
    one_of(method, _METHODS, "--method")
    from ..io.netcdf import write_netcdf
    from ..paths.march import march as march_model

    model, _ = _read(case)
    history = march_model(
        model,
        times=times_told(times),
        damping=damping,
        method=method,  # type: ignore[arg-type]
        backend=backend,
        tol=tolerance(tol),
        checkpoint=checkpoint,
        on_failure="ignore",
    )
    typer.echo(repr(history))
    if out is not None:
        write_netcdf(history.to_dataset(), out)
        typer.echo(f"fields: {out}")
    if film is not None:
        history.animate(film)
        typer.echo(f"film: {film}")
    if plot is not None:
        history.plot().savefig(plot, dpi=150)
        typer.echo(f"picture: {plot}")
    raise typer.Exit(EXIT_OK if history.certified else EXIT_NOT_CERTIFIED)


@app.command()
def certify(
    case: Case,
    answer: Annotated[
        Path,
        typer.Argument(
            help="What any program computed for CASE: .npy or .csv with a number for each node, in their order or as "
            "an array of the lattice's shape; or .nc, .zarr or .csv as solve --out writes it.",
            show_default=False,
        ),
    ],
    quantity: Annotated[
        str,
        typer.Option(
            help="What the numbers are: gaps to the support, or deflections, positive as the heights of the case.",
            metavar="|".join(_QUANTITIES),
        ),
    ] = _QUANTITIES[0],
    rows: Annotated[
        str | None,
        typer.Option(
            help="Which way y goes from row to row of an array: up, its first row has the smallest y (so it is if "
            "nothing is said), or down; to be said where the rows of the case's own files go down.",
            metavar="|".join(_ROWS),
            show_default=False,
        ),
    ] = None,
    tol: Tol = "1e-6",
    out: Annotated[
        Path | None,
        typer.Option(help="Write the enclosure (.json; all fields as solve --out does).", show_default=False),
    ] = None,
) -> None:
    """Enclose the exact solution of CASE, given the ANSWER of any program in any language.

    Exit code 0: certified to the tolerance; 1: not; 2: bad input; 130: interrupted.
    """
    from ..io.writers import WRITERS, require_suitable
    from .records import JSON, print_enclosure, write_enclosure

    check_output("--out", out, (JSON, *WRITERS))
    one_of(quantity, _QUANTITIES, "--quantity")
    if rows is not None:
        one_of(rows, _ROWS, "--rows")
    from ..io.answers import read_answer
    from ..solving.answered import judged_answer

    model, _ = _read(case)
    if out is not None:
        require_suitable(out, model)
    judged = judged_answer(
        model,
        read_answer(answer, model, quantity, rows=rows),  # type: ignore[arg-type]
        tolerance(tol),
        answer.name,
    )
    print_enclosure(judged, case, answer)
    if out is not None:
        write_enclosure(judged, case, answer, out)
        typer.echo(f"enclosure: {out}")
    raise typer.Exit(EXIT_OK if judged.status.ok else EXIT_NOT_CERTIFIED)


@app.command()
def new(
    kind: Annotated[
        str, typer.Argument(help="Which: membrane, hexagon, dome, plate, cable, beam or 'mesh membrane'.")
    ] = "membrane",
) -> None:
    """Write a commented case file: 'contactqp new cable > case.toml'.

    It solves as it is; that of a mesh membrane needs a mesh beside it, and says how to make one.
    """
    from ..io.templates import template

    typer.echo(template(kind), nl=False)


@app.command()
def schema() -> None:
    """Write the JSON schema of case files, for editors and programs that write them."""
    import json

    from ..io.case_sections import schema as schema_of_cases

    typer.echo(json.dumps(schema_of_cases(), indent=2, ensure_ascii=False))


@app.command()
def paper(
    out: Annotated[
        Path, typer.Option(help="Folder for table, maps and pictures; made if missing.", metavar="FOLDER")
    ] = Path("paper"),
) -> None:
    """Solve the paper's hexagon at the ten loads of its Table 1, and write table and figures into a folder.

    The paper: Analysis of membranes stretched over a unilateral support, of the 1970s.
    The rigid surface is a surrogate consistent with Table 1, not a reproduction.

    Exit code 0: all certified, contact sets nested and the same by all backends; 1: not; 2: bad input;
    130: interrupted.
    """
    from ..paper.folder import CAPTIONS, write_folder

    made_folder(out)
    from ..paper.reproduction import reproduce
    from ..paper.table import print_table

    found = reproduce()
    print_table(found)
    typer.echo("")
    for file in write_folder(found, out):
        typer.echo(f"{file}: {CAPTIONS.get(file.name, 'Each file and its caption.')}")
    raise typer.Exit(EXIT_OK if found.ok else EXIT_NOT_CERTIFIED)


@app.command()
def export_qpbenchmark(
    folder: Annotated[Path, typer.Argument(help="Where to write; made if missing.", metavar="FOLDER")],
    largest: Annotated[int, typer.Option(help="Unknowns of the largest problem.", metavar="NUMBER")] = 20_000,
) -> None:
    """Write the gallery's problems, in several sizes, as a test set for qpbenchmark into FOLDER."""
    from ..comparison.qpbenchmark import MODULE, write_test_set

    names = write_test_set(folder, largest)
    typer.echo(f"{folder / MODULE}: {counted(len(names), 'problem')}; to run them: pip install qpbenchmark, then")
    typer.echo(f"qpbenchmark {folder / MODULE} run")


@app.command()
def explore(
    case: Annotated[
        Path | None, typer.Argument(help="Case file (TOML); without one, the paper's hexagon.", show_default=False)
    ] = None,
    out: Annotated[Path, typer.Option(help="Write the page (.html).")] = Path("explorer.html"),
) -> None:
    """Write a page with sliders, which solves CASE anew in the browser and proves each answer, without a network.

    Membranes and cables over one support, with a tension that is the same everywhere. The page also has the paper's
    hexagon, a disk, a rectangle and a cable, each over several supports. Bokeh makes it, of the extra 'explore'.

    Exit code 0: written; 2: bad input; 130: interrupted.
    """
    check_output("--out", out, (".html", ".htm"))
    model, title = (None, "") if case is None else _read(case)
    _write_explorer(model, out, title or ("" if case is None else case.stem))


@app.command()
def backends() -> None:
    """List the backends: method, version, what they need, and what to install where one is missing."""
    from .tables import print_backends

    print_backends()


_AREAS = {"force per area": "area", "force per length": "length"}


_BEFORE_FACTS = 14
"""Characters before what a line of a solution tells."""


def _echo_facts(text: str) -> None:
    """Print lines of names and facts; where a terminal is too narrow, a fact goes on below itself."""
    room = line_width()
    typer.echo(text if room is None else folded(text, room, _BEFORE_FACTS))


_NOTHING = 1e-300
"""Sums of less are told as 0."""


def _told(bracket: Bracket) -> str:
    """Return what is known of a quantity: a number, or the two that it lies between where they differ as written."""
    # Where doubles end, what is left of rounding a sum outwards is nothing.
    low, high = (f"{end if abs(end) > _NOTHING else 0.0:.6g}" for end in bracket)
    return low if low == high else f"{low} to {high}"


def _write_explorer(model: Model | None, page: Path, title: str) -> None:
    from ..explorer.page import explore as write_page

    size = write_page(model, page, title=title).stat().st_size
    typer.echo(f"explorer: {page} ({size / 1e6:.1f} MB)")


def _headed(title: str, own: str) -> str:
    """Return a picture's headline: the case's title, if it has one, above its own."""
    return f"{shortened(title, 100)}\n{own}" if title else own


def _read(case: Path) -> tuple[Model, str]:
    """Return model and title of a case file; what is strange about it is a line on standard error."""
    from ..errors import ContactWarning
    from ..io.cases import read_case

    with warnings.catch_warnings(record=True) as strange:
        warnings.simplefilter("always", ContactWarning)
        model, title = read_case(case)
    for warning in strange:
        typer.echo(f"contactqp: warning: {case}: {warning.message}", err=True)
    return model, title


def main() -> None:
    """Run the command line; `contactqp_command` does so, and answers Ctrl-C before this module is loaded, too."""
    app()
