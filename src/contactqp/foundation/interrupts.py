"""Ctrl-C is answered at once, and leaves an interpreter that still works.

The interpreter raises a KeyboardInterrupt in the main thread only, between two of its instructions. Within a long call
of a compiled library it comes late; within an import or a compilation it leaves halves behind, or is swallowed by a
callback. Such work is done in a thread of its own, which the main thread waits for and, after an interrupt, leaves.
"""

from __future__ import annotations

import atexit
import contextvars
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from types import FrameType
from typing import Any, NoReturn, Protocol, TypeVar

T = TypeVar("T")

INTERRUPTED = 130
"""The exit code of a command that Ctrl-C has ended: 128 and the number of the signal."""

_BETWEEN_UPDATES = 0.1
"""Seconds between two looks at a call that runs in a thread."""

_GRACE = 0.5
"""Seconds that work left behind has to come to an end before an interrupted process does."""

_PATIENCE_AT_THE_END = 5.0
"""Seconds that it has before any other process ends: a call that outlives its time limit may take hours."""

_left_behind: list[threading.Thread] = []


class Shown(Protocol):
    """What shows that work goes on, see `contactqp.foundation.progress.Progress`."""

    def update(self) -> None:
        """Show the time elapsed."""


class _Leaving:
    """Whom to ask to stop once a call is left behind; work within it, at whatever depth, adds itself."""

    def __init__(self) -> None:
        self._guard = threading.Lock()
        self._asked: list[Callable[[], None]] = []
        self._left = False

    @contextmanager
    def asking(self, abandon: Callable[[], None] | None) -> Iterator[None]:
        """Ask by ``abandon`` if the call is left while what is done inside goes on, or has been left before."""
        if abandon is None:
            yield
            return
        with self._guard:
            self._asked.append(abandon)
            left = self._left
        try:
            if left:
                abandon()
            yield
        finally:
            with self._guard:
                self._asked.remove(abandon)

    def leave(self) -> None:
        """Ask all that are at work."""
        with self._guard:
            self._left, asked = True, list(self._asked)
        for abandon in asked:
            abandon()


_enclosing: ContextVar[_Leaving] = ContextVar("enclosing")
"""The call that this thread's work is done for."""


class OutOfTime(Exception):  # noqa: N818  (a finding, not a fault)
    """A call took longer than it was allowed to."""


def run_interruptibly(
    call: Callable[[], T],
    progress: Shown | None = None,
    abandon: Callable[[], None] | None = None,
    seconds: float | None = None,
) -> T:
    """Run a call that Ctrl-C must not hit, or would be kept waiting by, so that Ctrl-C is answered at once.

    The call runs in a thread of its own, which the main thread waits for; libraries that release the
    interpreter lock (osqp, clarabel and HiGHS do) cannot hold the interrupt back. Threads other than the main one are
    not interrupted, and make the call themselves, unless its time is limited.

    Parameters
    ----------
    call : callable
        The work; what it returns or raises is passed on.
    progress : Progress, optional
        Kept up to date while waiting.
    abandon : callable, optional
        Asks the library to stop, after an interrupt or when its time is over: its own, or that of a call which this
        one is made within.
    seconds : float, optional
        How long to wait.

    Raises
    ------
    KeyboardInterrupt
        After Ctrl-C; the call may still be at work then. The process ends after it, see `end`.
    OutOfTime
        If the call is not over in time; it may still be at work then, too.
    """
    enclosing = _enclosing.get(None)
    if seconds is None and threading.current_thread() is not threading.main_thread():
        with nullcontext() if enclosing is None else enclosing.asking(abandon):
            return call()
    leaving = _Leaving()
    with nullcontext() if enclosing is None else enclosing.asking(leaving.leave), leaving.asking(abandon):
        return _waited_for(call, leaving, progress, seconds)


def _waited_for(call: Callable[[], T], leaving: _Leaving, progress: Shown | None, seconds: float | None) -> T:
    """Return what a call returns that a thread of its own makes; it is left after Ctrl-C and when its time is over."""
    future: Future[T] = Future()
    context = contextvars.copy_context()
    context.run(_enclosing.set, leaving)

    def work() -> None:
        try:
            future.set_result(context.run(call))
        except BaseException as error:
            future.set_exception(error)

    end_of_wait = None if seconds is None else time.perf_counter() + seconds
    thread = threading.Thread(target=work, daemon=True)
    try:
        thread.start()
        while True:
            try:
                left = _BETWEEN_UPDATES
                if end_of_wait is not None:
                    left = min(left, max(0.0, end_of_wait - time.perf_counter()))
                return future.result(timeout=left)
            except TimeoutError:
                if future.done():
                    raise
                if end_of_wait is not None and time.perf_counter() >= end_of_wait:
                    raise OutOfTime(f"not over after {seconds:g} s") from None
                if progress is not None:
                    progress.update()
    except (KeyboardInterrupt, OutOfTime):
        _leave(thread)
        leaving.leave()
        raise


def end(code: int) -> NoReturn:
    """End the process with an exit code, by force where a thread that was left behind does not come to an end.

    A library that is at work while the interpreter is taken down would abort the process.
    """
    if _settled():
        raise SystemExit(code)
    _end_by_force(code)


@contextmanager
def ended_by_interrupts() -> Iterator[None]:
    """Run a command whose process Ctrl-C ends within a second, with exit code 130.

    What is done inside is interrupted as ever, so that it can clear up; but should the interrupt be swallowed, by a
    destructor say, or be kept waiting by a library, the process ends all the same. One that is swallowed is not told
    of.
    """
    interrupted = threading.Event()

    def interrupt(number: int, frame: FrameType | None) -> None:
        if not interrupted.is_set():
            interrupted.set()
            watch = threading.Timer(_GRACE, _end_by_force, (INTERRUPTED,))
            watch.daemon = True
            watch.start()
        raise KeyboardInterrupt

    def told(unraisable: Any) -> None:
        if not (interrupted.is_set() and isinstance(unraisable.exc_value, KeyboardInterrupt)):
            hook(unraisable)

    before, hook = signal.signal(signal.SIGINT, interrupt), sys.unraisablehook
    sys.unraisablehook = told
    try:
        yield
    except BaseException:
        if interrupted.is_set():
            end(INTERRUPTED)
        raise
    else:
        if interrupted.is_set():
            end(INTERRUPTED)
    finally:
        signal.signal(signal.SIGINT, before)
        sys.unraisablehook = hook


def _leave(thread: threading.Thread) -> None:
    if not _left_behind:
        atexit.register(_before_the_end)
    _left_behind[:] = [other for other in _left_behind if other.is_alive()] + [thread]


def _settled(seconds: float = _GRACE) -> bool:
    """Whether no thread that was left behind is at work, or none after a while."""
    deadline = time.monotonic() + seconds
    for thread in _left_behind:
        if thread.is_alive():
            thread.join(max(0.0, deadline - time.monotonic()))
    return not any(thread.is_alive() for thread in _left_behind)


def _before_the_end() -> None:
    """Wait a while for threads that were left behind; after an interrupt that nobody caught, not for long."""
    if _settled():
        return
    if getattr(sys, "last_type", None) is KeyboardInterrupt:
        if os.name == "posix":  # as the interpreter itself ends after an interrupt that nobody caught
            flush_streams()
            signal.signal(signal.SIGINT, signal.SIG_DFL)
            os.kill(os.getpid(), signal.SIGINT)
        _end_by_force(INTERRUPTED)
    _settled(_PATIENCE_AT_THE_END)


def _end_by_force(code: int) -> NoReturn:
    flush_streams()
    os._exit(code)


def flush_streams() -> None:
    """Write out what Python's streams still hold; a service may have none, or closed ones."""
    for stream in (sys.stdout, sys.stderr):
        if stream is not None and not stream.closed:
            stream.flush()
