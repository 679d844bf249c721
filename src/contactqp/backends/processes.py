"""Objects in processes of their own: a call of a library that listens to nobody is ended with its process.

Some libraries hold on to the interpreter while they work, so that neither Ctrl-C nor a time limit is looked at; others
take Ctrl-C for themselves; and what is left behind in a thread goes on to need memory and a core. A process ends when
it is told to. It is started as a fresh interpreter that imports what the object needs: nothing of the caller's program
runs again in it, on any system.
"""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import IO, Any, Protocol

from ..foundation.interrupts import run_interruptibly
from ..foundation.loading import apart

_PROGRAM = f"""
import pickle, sys
sys.path[:] = pickle.load(sys.stdin.buffer)
from {__name__} import serve
serve()
"""


class LostProcessError(Exception):
    """A process has ended before it answered."""


class Placed(Protocol):
    """An object, wherever it is."""

    def call(self, method: str, *given: Any, seconds: float | None = None) -> Any:
        """Return what a method returns, and raise what it raises.

        Parameters
        ----------
        method : str
        *given : object
        seconds : float, optional
            How long to wait at most, where the call can be ended.

        Raises
        ------
        contactqp.foundation.interrupts.OutOfTime
            If the call has been ended after that time.
        LostProcessError
            If the object's process has ended.
        """

    def end(self) -> None:
        """End the object's process, if it has one of its own; a call that waits for it raises a LostProcessError."""


class Here:
    """An object in this process.

    Parameters
    ----------
    make : callable
    *given : object
        What makes the object, and of what.

    Examples
    --------
    >>> Here(str.title, "gap").call("lower")
    'gap'
    """

    def __init__(self, make: Callable[..., Any], *given: Any) -> None:
        self._made = make(*given)

    def call(self, method: str, *given: Any, seconds: float | None = None) -> Any:
        """See `Placed.call`."""
        return getattr(self._made, method)(*given)

    def end(self) -> None:
        """See `Placed.end`: there is nothing to end."""


class Lost:
    """An object that could not be made: each call tells why.

    Parameters
    ----------
    error : LostProcessError
    """

    def __init__(self, error: LostProcessError) -> None:
        self._error = error

    def call(self, method: str, *given: Any, seconds: float | None = None) -> Any:
        """See `Placed.call`."""
        raise self._error

    def end(self) -> None:
        """See `Placed.end`: there is nothing to end."""


class Elsewhere:
    """An object in a process of its own, which ends with this one, after Ctrl-C, or when its time is over.

    Where Ctrl-C or a time limit leaves a call (`contactqp.foundation.interrupts`), the process is killed, and waited
    for: none remains. One that is no longer referred to is killed, too.

    Parameters
    ----------
    make : callable
    *given : object
        As for `Here`; all can be pickled, and ``make`` is found by its name in a module.

    Raises
    ------
    LostProcessError
        If no process could be started here.

    Examples
    --------
    >>> Elsewhere(str.title, "gap").call("lower")
    'gap'
    """

    def __init__(self, make: Callable[..., Any], *given: Any) -> None:
        if not _can_start():
            raise LostProcessError(f"{sys.executable!r} is no interpreter")
        apart(partial(self._start, make, given))

    def call(self, method: str, *given: Any, seconds: float | None = None) -> Any:
        """See `Placed.call`."""
        return run_interruptibly(partial(self._asked, (method, given)), abandon=self.end, seconds=seconds)

    def end(self) -> None:
        """See `Placed.end`."""
        self._end()

    def _start(self, make: Callable[..., Any], given: tuple[Any, ...]) -> None:
        try:
            with _interrupts_blocked():
                self._process = subprocess.Popen(
                    [sys.executable, "-P", "-c", _PROGRAM],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    creationflags=_flag("CREATE_NEW_PROCESS_GROUP") | _flag("CREATE_NO_WINDOW"),
                )
        except OSError as error:
            raise LostProcessError(str(error)) from error
        self._end = weakref.finalize(self, ended, self._process, os.getpid())
        with suppress(OSError):  # that it is gone is seen when it is asked
            pickle.dump(sys.path, self._input)
        run_interruptibly(partial(self._asked, (make, given)), abandon=self.end)

    @property
    def _input(self) -> IO[bytes]:
        assert self._process.stdin is not None
        return self._process.stdin

    def _asked(self, request: tuple[Any, tuple[Any, ...]]) -> Any:
        text = pickle.dumps(request)
        try:
            self._input.write(text)
            self._input.flush()
            assert self._process.stdout is not None
            done, found = pickle.load(self._process.stdout)
        except (EOFError, OSError, ValueError, pickle.UnpicklingError) as error:  # closed, or cut off
            self.end()
            code = self._process.wait()  # another thread may be ending it
            raise LostProcessError(f"its process ended with code {code}") from error
        if not done:
            raise found
        return found


def serve() -> None:
    """Make an object, and answer calls of its methods, until nobody can ask any more.

    What libraries print goes to standard error: standard output is for the answers.
    """
    answers = os.fdopen(os.dup(1), "wb")
    with suppress(OSError):
        os.dup2(2, 1)
    made: Any = None
    with suppress(EOFError, OSError):
        while True:
            asked, given = pickle.load(sys.stdin.buffer)
            try:
                if made is None:
                    made, found = asked(*given), None
                else:
                    found = getattr(made, asked)(*given)
                answer = True, found
            except Exception as error:
                answer = False, _portable(error)
            pickle.dump(answer, answers)
            answers.flush()


def can_be_sent(value: object) -> bool:
    """Whether a value can be handed to another process.

    Examples
    --------
    >>> can_be_sent({"max_iter": 5}), can_be_sent(lambda: None)
    (True, False)
    """
    try:
        pickle.dumps(value)
    except (AttributeError, TypeError, pickle.PicklingError):
        return False
    return True


def _can_start() -> bool:
    """Whether ``sys.executable`` is an interpreter: an application that embeds one would start itself."""
    frozen = getattr(sys, "frozen", False)
    return not frozen and Path(sys.executable or "").name.lower().startswith(("python", "pypy"))


def _portable(error: Exception) -> Exception:
    """Return an error, or what it says, where it cannot be handed on."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error


def _flag(name: str) -> int:
    """Return a flag of Windows, which elsewhere there is not."""
    return int(getattr(subprocess, name, 0))


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Start processes that Ctrl-C does not reach, even where a library in them listens to it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def ended(process: subprocess.Popen[bytes], owner: int) -> None:
    """End a process that the process ``owner`` has started, and wait for it."""
    if os.getpid() != owner:  # a copy of this process has a copy of the object
        return
    process.kill()
    process.wait()
    for pipe in (process.stdin, process.stdout):
        with suppress(OSError):
            if pipe is not None:
                pipe.close()
