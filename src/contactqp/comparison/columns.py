"""The columns of a comparison's table, and how each is written."""

from __future__ import annotations

from collections.abc import Callable

from ..foundation.text import count, number, seconds
from .rows import Row


def run_seconds(row: Row) -> float | None:
    """Return set-up and iterations of the first run together."""
    if row.setup_seconds is None or row.solve_seconds is None:
        return None
    return row.setup_seconds + row.solve_seconds


COLUMNS: dict[str, Callable[[Row], str]] = {
    "backend": lambda row: row.backend,
    "status": lambda row: row.status.replace("_", " "),
    "iterations": lambda row: count(row.iterations),
    "seconds": lambda row: seconds(run_seconds(row)),
    "bound/scale": lambda row: number(row.relative_bound),
    "true error": lambda row: number(row.relative_true_error),
    "min gap": lambda row: number(row.min_gap),
    "min R": lambda row: number(row.min_reaction),
    "gap·R": lambda row: number(row.complementarity),
    "contact": lambda row: count(row.contact),
    "undecided": lambda row: count(row.undecided),
}
"""The columns of a printed table; the true error is its upper bound, relative as the bound is."""
