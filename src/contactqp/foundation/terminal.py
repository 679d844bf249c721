"""The terminal that tables are printed on, and whether there is one."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console


def table_console() -> Console:
    """Return a console that does not fold tables where nobody sees them."""
    from rich.console import Console

    found = Console(highlight=False)
    return found if found.is_terminal else Console(highlight=False, width=160)


def on_terminal() -> bool:
    """Whether standard error is a terminal; a service may have none, or a closed one."""
    stream = sys.stderr
    return stream is not None and not stream.closed and stream.isatty()
