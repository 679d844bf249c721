"""The terminal that tables are printed on, and whether there is one."""

from __future__ import annotations

import os
import sys
from shutil import get_terminal_size
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

WIDE = 160
"""Columns of a table that goes into a file or a pipe."""


def table_console() -> Console:
    """Return a console that does not fold tables where nobody sees them, unless COLUMNS is set."""
    from rich.console import Console

    found = Console(highlight=False)
    return (
        found if found.is_terminal or os.environ.get("COLUMNS", "").isdigit() else Console(highlight=False, width=WIDE)
    )


def line_width() -> int | None:
    """Return the columns of the terminal that is printed on, or what COLUMNS says; None in a file or a pipe."""
    columns = os.environ.get("COLUMNS", "")
    if columns.isdigit() and int(columns):
        return int(columns)
    stream = sys.stdout
    if stream is None or stream.closed or not stream.isatty():
        return None
    return get_terminal_size().columns


def on_terminal() -> bool:
    """Whether standard error is a terminal; a service may have none, or a closed one."""
    stream = sys.stderr
    return stream is not None and not stream.closed and stream.isatty()
