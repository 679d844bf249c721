"""Records as JSON."""

from __future__ import annotations

import json
import math
from typing import Any


def json_of(record: Any, indent: int | None = 2) -> str:
    """Return a record as JSON, with null for the numbers that JSON lacks.

    Examples
    --------
    >>> json_of({"bound": float("inf"), "nodes": (1, 2)}, indent=None)
    '{"bound": null, "nodes": [1, 2]}'
    """
    return json.dumps(_plain(record), indent=indent, allow_nan=False)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
