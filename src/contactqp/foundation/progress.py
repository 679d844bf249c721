"""Progress of long work: a line on a terminal after one second, nothing elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from threading import Thread, Timer
from types import TracebackType
from typing import TYPE_CHECKING, ClassVar, TypeVar

from .terminal import on_terminal

if TYPE_CHECKING:
    from rich.status import Status as RichStatus

T = TypeVar("T")

_PATIENCE = 1.0
"""Seconds of work before anything is shown."""

_LOOK_EVERY = 0.1
"""Seconds between two looks at a call that runs in a thread."""


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
            from rich.console import Console

            outermost._status = Console(stderr=True).status("")
            outermost._status.start()
        parts = [part for progress in chain for part in (progress.title, progress.detail)]
        outermost._status.update(" · ".join(part for part in (*parts, f"{elapsed:.0f} s") if part))


class OutOfTime(Exception):  # noqa: N818  (a finding, not a fault)
    """A call took longer than it was allowed to."""


def run_interruptibly(
    call: Callable[[], T],
    progress: Progress | None = None,
    abandon: Callable[[], None] | None = None,
    seconds: float | None = None,
) -> T:
    """Run a long call into a compiled library so that Ctrl-C is answered at once.

    The call runs in a thread of its own, which the main thread waits for; libraries that release the
    interpreter lock (osqp, clarabel and HiGHS do) cannot hold the interrupt back.

    Parameters
    ----------
    call : callable
        The work; what it returns or raises is passed on.
    progress : Progress, optional
        Kept up to date while waiting.
    abandon : callable, optional
        Asks the library to stop, after an interrupt or when its time is over.
    seconds : float, optional
        How long to wait. The call may run on in the background afterwards.

    Raises
    ------
    OutOfTime
        If the call is not over by then.
    """
    end = None if seconds is None else time.perf_counter() + seconds
    future: Future[T] = Future()

    def work() -> None:
        try:
            future.set_result(call())
        except BaseException as error:
            future.set_exception(error)

    Thread(target=work, daemon=True).start()
    try:
        while True:
            try:
                left = _LOOK_EVERY if end is None else min(_LOOK_EVERY, max(0.0, end - time.perf_counter()))
                return future.result(timeout=left)
            except TimeoutError:
                if future.done():
                    raise
                if end is not None and time.perf_counter() >= end:
                    raise OutOfTime(f"not over after {seconds:g} s") from None
                if progress is not None:
                    progress.update()
    except (KeyboardInterrupt, OutOfTime):
        if abandon is not None:
            abandon()
        raise


@contextmanager
def compiling(kernels: str) -> Iterator[None]:
    """Announce on a terminal that kernels are being compiled, if what is done inside takes over a second."""
    import numba  # noqa: F401  (its own loading is not compiling)

    def announce() -> None:
        sys.stderr.write(f"contactqp: compiling the kernels of {kernels}, once on this machine\n")

    timer = Timer(_PATIENCE, announce)
    if on_terminal():
        timer.start()
    try:
        yield
    finally:
        timer.cancel()


def silent() -> Progress:
    """Return a progress that shows nothing."""
    return Progress("", shown=False)
