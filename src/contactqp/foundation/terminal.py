"""The terminal that tables are printed on."""

from __future__ import annotations

from rich.console import Console


def table_console() -> Console:
    """Return a console that does not fold tables where nobody sees them."""
    found = Console(highlight=False)
    return found if found.is_terminal else Console(highlight=False, width=160)
