"""Libraries that have something to say while they work: their warnings, and what they print, are kept from the user.

The judge says what an answer is worth; a library's own words stand beside it, as the answer's termination.
"""

from __future__ import annotations

import ctypes
import os
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from .interrupts import flush_streams

_guard = threading.Lock()


class _Silence:
    """Warnings are ignored for all threads while one at least wants it so: their filters are the process's."""

    def __init__(self) -> None:
        self._inside, self._filters = 0, warnings.catch_warnings()

    def enter(self) -> None:
        with _guard:
            if not self._inside:
                self._filters = warnings.catch_warnings()
                self._filters.__enter__()
                warnings.simplefilter("ignore")
            self._inside += 1

    def leave(self) -> None:
        with _guard:
            self._inside -= 1
            if not self._inside:
                self._filters.__exit__(None, None, None)


_silence = _Silence()


@contextmanager
def warnings_ignored() -> Iterator[None]:
    """Ignore warnings while a library works; several threads may do so at once, in any order.

    Examples
    --------
    >>> with warnings_ignored():
    ...     warnings.warn("not found, exit flag -2", stacklevel=1)
    """
    _silence.enter()
    try:
        yield
    finally:
        _silence.leave()


@contextmanager
def output_discarded() -> Iterator[None]:
    """Discard what is printed, by compiled code too: it is for moments, since it holds for all threads."""
    with _guard:
        kept = {}
        flush_output()
        try:
            for number in (1, 2):
                with suppress(OSError):  # a service may have closed it
                    kept[number] = os.dup(number)
            nowhere = os.open(os.devnull, os.O_WRONLY)
            for number in kept:
                os.dup2(nowhere, number)
            os.close(nowhere)
            yield
        finally:
            flush_output()
            for number, copy in kept.items():
                os.dup2(copy, number)
                os.close(copy)


def flush_output() -> None:
    """Write out what Python and the C library still hold."""
    flush_streams()
    with suppress(AttributeError, OSError, TypeError):
        ctypes.CDLL(None).fflush(None)
