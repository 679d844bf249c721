"""Reports for the terminal, made with rich."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rich.cells import cell_len
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ..backends import backend_names, get_backend, kind_of, names_besides
from ..backends.base import Backend, Need
from ..comparison.columns import cells_of, fitting, printed_columns, width_of
from ..comparison.compared import Compared
from ..comparison.text import asked_for
from ..errors import MissingBackendError
from ..foundation.terminal import table_console

_COLOURS = {"certified": "green", "unproven": "yellow", "missing": "yellow", "unsuitable": "yellow"}


def print_comparison(compared: Compared, title: str = "", *, wide: bool = False) -> None:
    """Print the table of a comparison and its verdict.

    Parameters
    ----------
    compared : Compared
    title : str
    wide : bool
        Whether to show all columns, also where the terminal folds them; otherwise those that it has room for.
    """
    console = table_console()
    head = " · ".join(part for part in (title, compared.subject) if part)
    console.print(Text(head, style="bold"))
    console.print(Text(asked_for(compared)), style="dim")
    columns = printed_columns(compared.answers.problem)
    cells = cells_of(columns, compared.rows)
    shown = columns if wide else fitting(cells, console.width, cell_len)
    table = Table(box=None, header_style="bold", pad_edge=False, padding=(0, 1))
    for column in shown:
        table.add_column(column.printed, justify="left" if column.words else "right", no_wrap=True)
    for k, row in enumerate(compared.rows, 1):
        backend, status, *numbers = (cells[column][k] for column in shown)
        table.add_row(backend, Text(status, style=_COLOURS.get(row.status, "red")), *numbers)
    console.print()
    room, console.width = console.width, max(console.width, width_of(cells, shown, cell_len))
    console.print(table)
    console.width = room
    console.print()
    conclusion = compared.conclusion
    for remark in conclusion.remarks:
        console.print(Text(remark, style="yellow"))
    console.print(Text(conclusion.sentence, style="bold green" if conclusion.agree else "bold red"))
    left_out = [column.printed for column in columns if column not in shown]
    if left_out:
        console.print(Text(f"Left out for want of room: {', '.join(left_out)}; --wide shows all.", style="dim"))


_UNLIMITED = 10_000
"""Columns that no table needs."""

_METHOD, _FACTS = ("name", "method", "needs"), ("name", "library", "licence", "reaches", "available")


def print_backends() -> None:
    """Print the tables of backends, by kind: methods, and what there is to know of their programs.

    Where one line has room for all, there is one table. What to type where something is missing stands below.
    """
    listed = [_listed(name) for name in (*backend_names(), *names_besides())]
    console = table_console()
    whole = _table_of((*_METHOD, *_FACTS[1:]), listed)
    if Console(width=_UNLIMITED).measure(whole).maximum <= console.width:
        console.print(whole)
    else:
        console.print(_table_of(_METHOD, listed))
        console.print()
        console.print(_table_of(_FACTS, listed))
    for entry in listed:
        if entry.obstacle:
            console.print(Text(entry.obstacle, style="yellow"))


@dataclass(frozen=True)
class _Listed:
    """What is listed of a backend: its kind, its cells by their headings, and why it cannot be called, if so."""

    kind: str
    cells: Mapping[str, str | Text]
    obstacle: str = ""


def _listed(name: str) -> _Listed:
    try:
        backend = get_backend(name)
    except (Exception, SystemExit) as error:  # what another distribution runs when it is loaded may raise anything
        return _Listed(kind_of(name), {"name": name, "available": _NO}, str(error))
    try:
        backend.require()
        obstacle = ""
    except MissingBackendError as error:
        obstacle = f"{name}: {backend.to_install()}" if backend.missing() else str(error)
    cells: dict[str, str | Text] = {
        "name": name,
        "method": backend.summary,
        "needs": ", ".join(_needs_of(backend)) or "-",
        "library": f"{backend.package} {backend.version() or ''}".strip(),
        "licence": backend.licence or "-",
        "reaches": "-" if backend.reachable_tol is None else f"{backend.reachable_tol:g}",
        "available": _NO if obstacle else Text("yes", style="green"),
    }
    return _Listed(kind_of(name), cells, obstacle)


def _needs_of(backend: Backend) -> list[str]:
    """Return the names of what a method relies on; what is definite is symmetric.

    A problem whose matrix need not be symmetric has an M-matrix, unless the method's own needs say more.
    """
    needs = backend.all_needs
    names = sorted(need.name for need in needs if not (need is Need.SYMMETRIC and Need.DEFINITE in needs))
    return names or ["definite or M-matrix"]


def _rank(kind: str) -> tuple[int, str]:
    """Return where a kind stands: the package's own methods first, plug-ins last."""
    first = ("own", "library")
    return (first.index(kind) if kind in first else len(first) + (kind == "plug-in"), kind)


_NO = Text("no, see below", style="red")


def _table_of(headings: Sequence[str], listed: Sequence[_Listed]) -> Table:
    table = Table(box=None, header_style="bold", pad_edge=False, padding=(0, 1))
    for heading in headings:
        table.add_column(heading, overflow="fold")
    for kind in sorted({entry.kind for entry in listed}, key=_rank):
        table.add_row()
        table.add_row(Text(f"{kind}:", style="bold"))
        for entry in listed:
            if entry.kind == kind:
                table.add_row(*(entry.cells.get(heading, "-") for heading in headings))
    return table
