"""Progress of long work: a line on a terminal after one second, nothing elsewhere."""

from __future__ import annotations

import time
from types import TracebackType
from typing import TYPE_CHECKING, ClassVar

from .loading import load_modules
from .terminal import on_terminal

if TYPE_CHECKING:
    from rich.status import Status as RichStatus

_PATIENCE = 1.0
"""Seconds of work before anything is shown."""


class Progress:
    """Shows what is being done on a terminal's standard error, once it takes over a second.

    Parameters
    ----------
    title : str
        What is being done.
    shown : bool, optional
        Whether to show anything; by default only if standard error is a terminal.
    """

    _under_way: ClassVar[list[Progress]] = []
    """Outermost first: work within work shares one line."""

    def __init__(self, title: str, shown: bool | None = None) -> None:
        self.title = title
        self.detail = ""
        self._shown = on_terminal() if shown is None else shown
        self._start = time.perf_counter()
        self._status: RichStatus | None = None

    def __enter__(self) -> Progress:
        if self._shown:
            self._under_way.append(self)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self in self._under_way:
            self._under_way.remove(self)
        if self._status is not None:
            self._status.stop()
            self._status = None

    def update(self, detail: str | None = None) -> None:
        """Show ``detail`` and the time elapsed, after those of the work that this is part of; cheap to call often."""
        if detail is not None:
            self.detail = detail
        if not self._shown:
            return
        chain = self._under_way if self in self._under_way else [self]
        outermost = chain[0]
        elapsed = time.perf_counter() - outermost._start
        if elapsed < _PATIENCE:
            return
        if outermost._status is None:
            load_modules("rich.console", "rich.status")
            from rich.console import Console

            outermost._status = Console(stderr=True).status("")
            outermost._status.start()
        parts = [part for progress in chain for part in (progress.title, progress.detail)]
        outermost._status.update(" · ".join(part for part in (*parts, f"{elapsed:.0f} s") if part))


def silent() -> Progress:
    """Return a progress that shows nothing."""
    return Progress("", shown=False)
