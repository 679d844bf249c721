"""Reports for the terminal, made with rich."""

from __future__ import annotations

from rich.table import Table
from rich.text import Text

from ..backends import backend_names, get_backend
from ..comparison.columns import printed_columns
from ..comparison.compared import Compared
from ..comparison.text import asked_for
from ..foundation.terminal import table_console

_COLOURS = {"certified": "green", "unproven": "yellow", "missing": "yellow", "unsuitable": "yellow"}


def print_comparison(compared: Compared, title: str = "") -> None:
    """Print the table of a comparison and its verdict."""
    console = table_console()
    head = " · ".join(part for part in (title, compared.subject) if part)
    console.print(Text(head, style="bold"))
    console.print(Text(asked_for(compared)), style="dim")
    table = Table(box=None, header_style="bold", pad_edge=False)
    columns = printed_columns(compared.answers.problem)
    for column in columns:
        table.add_column(column.printed, justify="left" if column.words else "right", no_wrap=True)
    for row in compared.rows:
        backend, status, *numbers = (column.text(row) for column in columns)
        table.add_row(backend, Text(status, style=_COLOURS.get(row.status, "red")), *numbers)
    console.print()
    console.print(table)
    console.print()
    conclusion = compared.conclusion
    for remark in conclusion.remarks:
        console.print(Text(remark, style="yellow"))
    console.print(Text(conclusion.sentence, style="bold green" if conclusion.agree else "bold red"))


def print_backends() -> None:
    """Print the table of backends."""
    table = Table(box=None, header_style="bold", pad_edge=False)
    for heading in ("name", "method", "needs", "reaches", "library", "available"):
        table.add_column(heading)
    broken = []
    for name in backend_names():
        try:
            backend = get_backend(name)
        except (Exception, SystemExit) as error:  # what another distribution runs when it is loaded may raise anything
            broken.append(str(error))
            table.add_row(name, "-", "-", "-", "-", Text("no, see below", style="red"))
            continue
        version = backend.version()
        needs = ", ".join(sorted(need.name for need in backend.needs)) or "-"
        available = Text("yes", style="green") if version else Text(f"pip install {backend.package}", style="yellow")
        reaches = "-" if backend.reachable_tol is None else f"tol {backend.reachable_tol:g}"
        table.add_row(name, backend.summary, needs, reaches, f"{backend.package} {version or ''}".strip(), available)
    console = table_console()
    console.print(table)
    for reason in broken:
        console.print(Text(reason, style="yellow"))
