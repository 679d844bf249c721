"""Where a warning is to point: the first line of code outside the package."""

from __future__ import annotations

import sys
from pathlib import Path

_PACKAGE = str(Path(__file__).parents[1])


def stacklevel_outside() -> int:
    """Return the ``stacklevel`` with which the caller's `warnings.warn` points to the code that called the package."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_PACKAGE):
        frame, level = frame.f_back, level + 1
    return level
