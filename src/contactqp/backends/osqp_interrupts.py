"""Ctrl-C within a call of OSQP: its C library catches it while it works, and remembers that it came."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

from ..foundation.loading import load_modules


def solved(solver: Any) -> Any:
    """Return the result of a solver of OSQP.

    Raises
    ------
    KeyboardInterrupt
        If Ctrl-C came meanwhile. The status does not say so where the library was past its last look for it; its memory
        does.
    """
    result = solver.solve(raise_error=False)
    if result.info.status == "interrupted" or _own_memory()():
        raise KeyboardInterrupt
    return result


@cache
def _own_memory() -> Callable[[], int]:
    """Return the library's function that tells whether Ctrl-C came in its last call, where it can be reached."""
    load_modules("osqp")
    from osqp import ext_builtin

    try:
        told: Callable[[], int] = ctypes.CDLL(str(ext_builtin.__file__)).osqp_is_interrupted
    except (AttributeError, OSError):
        return lambda: 0
    return told
