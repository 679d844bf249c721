"""Commands about the gallery: its entries, and studies of them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..foundation.terminal import line_width
from ..foundation.text import at_most, counted, folded
from .application import EXIT_NOT_CERTIFIED, EXIT_OK, PICTURES, Plot, TimeLimit, Tol, app, check_output, tolerance


@app.command()
def study(
    name: Annotated[
        str | None, typer.Argument(help="A problem of the gallery; without one, all are listed.", show_default=False)
    ] = None,
    sizes: Annotated[
        str | None,
        typer.Option(
            help="Nodes along a side, separated by commas, as 15,31,63; by default four spacings, each half the one "
            "before."
        ),
    ] = None,
    backend: Annotated[str, typer.Option(help="Name of the backend, see 'contactqp backends'.")] = "auto",
    tol: Tol = "1e-9",
    time_limit: TimeLimit = None,
    out: Annotated[Path | None, typer.Option(help="Write the table (.json, .csv).", show_default=False)] = None,
    plot: Plot = None,
) -> None:
    """Compare answers with the closed form of a problem of the gallery over several spacings.

    Errors and observed orders of deflection, reaction, contact area and free boundary, as papers print them.

    Exit code 0: all answers certified; 1: not; 2: bad input; 130: interrupted.
    """
    from ..studies.study import SUFFIXES
    from ..studies.study import study as study_problem

    if name is None:
        _list_gallery()
        return
    check_output("--out", out, SUFFIXES)
    check_output("--plot", plot, PICTURES)
    found = study_problem(
        name,
        None if sizes is None else _sizes(sizes),
        backend=backend,
        tol=tolerance(tol),
        time_limit=time_limit,
        on_failure="ignore",
    )
    typer.echo(str(found))
    if out is not None:
        typer.echo(f"table: {found.write(out)}")
    if plot is not None:
        found.plot().savefig(plot, dpi=150)
        typer.echo(f"picture: {plot}")
    raise typer.Exit(EXIT_OK if found.certified else EXIT_NOT_CERTIFIED)


def _sizes(text: str) -> list[int]:
    """Return the sizes that were typed.

    Raises
    ------
    ValueError
        If they are no whole numbers.
    """
    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise ValueError(f"--sizes must be whole numbers separated by commas, as 15,31,63, got {text!r}") from None


def _list_gallery() -> None:
    from ..gallery.catalogue import entry_of, names

    widest = max(map(len, names())) + 2
    room = line_width()
    for name in names():
        line = f"{name:<{widest}}{entry_of(name).title}"
        typer.echo(line if room is None else folded(line, room, widest))


@app.command("export-dataset")
def export_dataset(
    folder: Annotated[Path, typer.Argument(help="Made if missing.", show_default=False)],
    sizes: Annotated[
        str | None, typer.Option(help="Nodes along a side, separated by commas; by default 31,63,127,255,511,1023.")
    ] = None,
    families: Annotated[
        str | None, typer.Option(help="Problems of the gallery, separated by commas; by default ten.")
    ] = None,
) -> None:
    """Write problems with proved answers into FOLDER: matrices, forces, bounds, and enclosures of the exact solutions.

    With an index, SHA-256 sums and a reader of ten lines that needs numpy and scipy only; dedicated to the public
    domain (CC0). An enclosure wider than 1e-12 of the scale is told of, and not written.

    Exit code 0: all written; 1: some enclosure is too wide; 2: bad input; 130: interrupted.
    """
    from ..collection.export import FAMILIES, SIZES
    from ..collection.export import export_dataset as export
    from ..collection.proved import Proved

    def told(found: Proved) -> None:
        what = f"{found.family:<20}{found.n:>5}{found.problem.size:>9} unknowns"
        typer.echo(f"{what}  enclosed to {at_most(found.relative_width)} of {found.scale:.3g}")

    chosen = FAMILIES if families is None else [name.strip() for name in families.split(",")]
    found = export(folder, SIZES if sizes is None else _sizes(sizes), chosen, told=told)
    for line in found.refused:
        typer.echo(f"contactqp: not written: {line}", err=True)
    typer.echo(f"{counted(len(found.written), 'problem')} with proved answers: {folder}")
    raise typer.Exit(EXIT_NOT_CERTIFIED if found.refused else EXIT_OK)
