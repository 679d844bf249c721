"""Reports for the terminal, made with rich."""

from __future__ import annotations

from rich.table import Table
from rich.text import Text

from ..backends import backend_names, get_backend
from ..comparison.comparison import Comparison
from ..comparison.text import table_cells
from ..foundation.terminal import table_console

_COLOURS = {"certified": "green", "solved": "green", "missing": "yellow", "unsuitable": "yellow"}


def print_comparison(comparison: Comparison, title: str = "") -> None:
    """Print the table of a comparison and its verdict."""
    console = table_console()
    head = " · ".join(part for part in (title, comparison.subject) if part)
    console.print(Text(head, style="bold"))
    console.print(Text(f"tol {comparison.tolerance} of the gap scale {comparison.problem.gap_scale:.3g}"), style="dim")
    headings, rows = table_cells(comparison)
    table = Table(box=None, header_style="bold", pad_edge=False)
    for k, heading in enumerate(headings):
        table.add_column(heading, justify="left" if k < 2 else "right", no_wrap=True)
    for row, cells in zip(comparison.rows, rows, strict=True):
        colour = _COLOURS.get(row.status, "red")
        table.add_row(cells[0], Text(cells[1], style=colour), *cells[2:])
    console.print()
    console.print(table)
    console.print()
    for remark in comparison.remarks():
        console.print(Text(remark, style="yellow"))
    console.print(Text(comparison.verdict(), style="bold green" if comparison.agree else "bold red"))


def print_backends() -> None:
    """Print the table of backends."""
    table = Table(box=None, header_style="bold", pad_edge=False)
    for heading in ("name", "method", "needs", "reaches", "library", "available"):
        table.add_column(heading)
    for name in backend_names():
        backend = get_backend(name)
        version = backend.version()
        needs = ", ".join(sorted(need.name for need in backend.needs)) or "-"
        available = Text("yes", style="green") if version else Text(f"pip install {backend.package}", style="yellow")
        reaches = "-" if backend.reachable_tol is None else f"tol {backend.reachable_tol:g}"
        table.add_row(name, backend.summary, needs, reaches, f"{backend.package} {version or ''}".strip(), available)
    table_console().print(table)
