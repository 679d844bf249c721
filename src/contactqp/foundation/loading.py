"""Loading of libraries and compiling of kernels: where Ctrl-C cannot hit it, and with its time kept apart.

Both happen once in a process, and would otherwise count as time for whatever comes first.
"""

from __future__ import annotations

import importlib
import io
import sys
import time
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from importlib.util import find_spec
from threading import Timer
from typing import Any

from .interrupts import run_interruptibly
from .terminal import on_terminal

_PATIENCE = 1.0
"""Seconds of compiling before it is announced."""

_done: set[Hashable] = set()


class _Clock:
    """Seconds that loading and compiling take, in one line of work and the threads that it waits for."""

    def __init__(self) -> None:
        self._before, self._since = 0.0, 0.0
        self.running = False

    @property
    def seconds(self) -> float:
        """All so far, with what is under way: whoever waits no longer for it may ask, too."""
        return self._before + (time.perf_counter() - self._since if self.running else 0.0)

    def start(self) -> None:
        self._since, self.running = time.perf_counter(), True

    def stop(self) -> None:
        self._before, self.running = self.seconds, False


_clock: ContextVar[_Clock] = ContextVar("loading")


def loading_seconds() -> float:
    """Return the seconds that this thread has spent on loading and compiling so far."""
    return _own_clock().seconds


def is_loading() -> bool:
    """Whether this thread, or one that it has left behind, is at loading or compiling."""
    return _own_clock().running


def working_seconds() -> float:
    """Return a clock's time (seconds) that stands still while libraries are loaded and kernels compiled."""
    return time.perf_counter() - _own_clock().seconds


def load_modules(*modules: str, kernels: str = "") -> None:
    """Import modules whose loading takes long, before a statement that imports them is met.

    Parameters
    ----------
    *modules : str
        Full names.
    kernels : str
        Whose kernels the modules compile while they are loaded; on a terminal that is announced.

    Examples
    --------
    >>> load_modules("scipy.sparse")
    >>> from scipy import sparse
    """
    missing = [name for name in modules if not _loaded(name)]
    if missing:
        apart(lambda: [importlib.import_module(name) for name in missing], kernels)


def loaded(module: str) -> Any:
    """Return a module, for what has no statement that imports it.

    Parameters
    ----------
    module : str
        Full name.

    Examples
    --------
    >>> loaded("scipy.sparse").__name__
    'scipy.sparse'
    """
    load_modules(module)
    return importlib.import_module(module)


def needed(module: str, purpose: str, install: str = "") -> Any:
    """Return a module of a package that is not always installed.

    Parameters
    ----------
    module : str
        Full name.
    purpose : str
        What needs it, for the message.
    install : str
        What pip is to install; by default the module's package.

    Raises
    ------
    ImportError
        If it cannot be imported; the message says what needs it and what to type.

    Examples
    --------
    >>> needed("json", "reading").__name__
    'json'
    >>> needed("no_such_package", "to_nothing")
    Traceback (most recent call last):
    ...
    ImportError: to_nothing needs no_such_package: pip install 'no_such_package' (No module named 'no_such_package')
    """
    try:
        return loaded(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise ImportError(f"{purpose} needs {package}: pip install '{install or package}' ({error})") from None


def apart(work: Callable[[], object], kernels: str = "") -> None:
    """Do work that loads libraries or compiles kernels; its time does not count as that of whatever needs it.

    Parameters
    ----------
    work : callable
    kernels : str
        Whose kernels are compiled, if any; on a terminal that is announced.
    """
    clock = _own_clock()
    if clock.running:
        work()
        return
    clock.start()
    try:
        with _standard_error():
            run_interruptibly(lambda: _announced(work, kernels))
    finally:
        clock.stop()


def once(key: Hashable, work: Callable[[], object], kernels: str) -> None:
    """Do work that compiles kernels, unless it was done before under the same key."""
    if key not in _done:
        apart(work, kernels)
        _done.add(key)


@cache
def can_compile() -> bool:
    """Whether there is a compiler for kernels."""
    return find_spec("numba") is not None


def _loaded(name: str) -> bool:
    module = sys.modules.get(name)
    return module is not None and not getattr(getattr(module, "__spec__", None), "_initializing", False)


@contextmanager
def _standard_error() -> Iterator[None]:
    """Give libraries that ask for standard error while they are loaded one that goes nowhere, where there is none."""
    if sys.stderr is not None:
        yield
        return
    sys.stderr = io.StringIO()
    try:
        yield
    finally:
        sys.stderr = None


def _announced(work: Callable[[], object], kernels: str) -> None:
    if kernels:
        import numba  # noqa: F401  (its own loading is not compiling)

        with _announcing(kernels):
            work()
    else:
        work()


@contextmanager
def _announcing(kernels: str) -> Iterator[None]:
    """Say on a terminal that kernels are being compiled, if what is done inside takes over a second."""

    def announce() -> None:
        sys.stderr.write(f"contactqp: compiling the kernels of {kernels}, once on this machine\n")

    timer = Timer(_PATIENCE, announce)
    timer.daemon = True
    if on_terminal():
        timer.start()
    try:
        yield
    finally:
        timer.cancel()


def _own_clock() -> _Clock:
    clock = _clock.get(None)
    if clock is None:
        clock = _Clock()
        _clock.set(clock)
    return clock
