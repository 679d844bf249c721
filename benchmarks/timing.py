"""Seconds of calls that are compared in one run."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np


def seconds(call: Callable[[], object]) -> float:
    started = time.perf_counter()
    call()
    return time.perf_counter() - started


def in_turn(repeat: int, *calls: Callable[[], object]) -> list[float]:
    """Return the least time of each call, after one run of each to warm up."""
    for call in calls:
        call()
    times = np.array([[seconds(call) for call in calls] for _ in range(repeat)])
    return [float(least) for least in times.min(axis=0)]
