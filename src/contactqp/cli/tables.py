"""Reports for the terminal, made with rich."""

from __future__ import annotations

from collections.abc import Sequence

from rich.cells import cell_len
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ..backends import backend_names, get_backend
from ..comparison.columns import cells_of, fitting, printed_columns, width_of
from ..comparison.compared import Compared
from ..comparison.text import asked_for
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

_FACTS = ("needs", "reaches", "library", "available")


def print_backends() -> None:
    """Print the table of backends; methods stand apart, where one line has no room for all."""
    methods: dict[str, str] = {}
    facts: dict[str, tuple[str | Text, ...]] = {}
    broken = []
    for name in backend_names():
        try:
            backend = get_backend(name)
        except (Exception, SystemExit) as error:  # what another distribution runs when it is loaded may raise anything
            broken.append(str(error))
            methods[name], facts[name] = "-", ("-", "-", "-", Text("no, see below", style="red"))
            continue
        version = backend.version()
        needs = ", ".join(sorted(need.name for need in backend.needs)) or "-"
        available = Text("yes", style="green") if version else Text(f"pip install {backend.package}", style="yellow")
        reaches = "-" if backend.reachable_tol is None else f"tol {backend.reachable_tol:g}"
        methods[name] = backend.summary
        facts[name] = needs, reaches, f"{backend.package} {version or ''}".strip(), available
    console = table_console()
    whole = _table_of(("name", "method", *_FACTS), [(name, methods[name], *facts[name]) for name in methods])
    if Console(width=_UNLIMITED).measure(whole).maximum <= console.width:
        console.print(whole)
    else:
        console.print(_table_of(("name", "method"), list(methods.items())))
        console.print()
        console.print(_table_of(("name", *_FACTS), [(name, *facts[name]) for name in facts]))
    for reason in broken:
        console.print(Text(reason, style="yellow"))


def _table_of(headings: Sequence[str], rows: Sequence[Sequence[str | Text]]) -> Table:
    table = Table(box=None, header_style="bold", pad_edge=False, padding=(0, 1))
    for heading in headings:
        table.add_column(heading, overflow="fold")
    for row in rows:
        table.add_row(*row)
    return table
